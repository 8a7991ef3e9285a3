#include "strak/fitting/border_curves.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "strak/base/error.h"
#include "strak/spline/evaluate.h"
#include "tests/fitting/sheet_with_holes.h"

namespace strak {
namespace {

using namespace test;

std::vector<FairLoop> loopsOf(const std::vector<FairPart>& parts) {
  std::vector<FairLoop> loops;
  for (const FairPart& part : parts) {
    loops.push_back(part.outer);
    loops.insert(loops.end(), part.holes.begin(), part.holes.end());
  }
  return loops;
}

void expectClosed(const FairLoop& loop) {
  for (std::size_t i = 0; i < loop.pieces.size(); ++i) {
    const Net &own = loop.pieces[i].net(), &next = loop.pieces[(i + 1) % loop.pieces.size()].net();
    EXPECT_EQ(own.row(own.rows() - 1), next.row(0));
    EXPECT_TRUE(loop.pieces[i].knots(0).isClamped());
  }
}

const FairLoop& holeNear(const FairPart& part, double area) {
  return *std::min_element(part.holes.begin(), part.holes.end(), [&](const FairLoop& a, const FairLoop& b) {
    return std::abs(a.area + area) < std::abs(b.area + area);
  });
}

TEST(BorderCurves, AGridsSheetKeepsItsCornersAndRoundsItsHole) {
  const Net points = gridPoints(80, onSheet);
  const auto parts = fairBorders(points, findBorders(points));
  ASSERT_EQ(parts.size(), 1U);
  ASSERT_EQ(parts[0].holes.size(), 2U);
  for (const FairLoop& loop : loopsOf(parts)) {
    expectClosed(loop);
    EXPECT_EQ(loop.pinned, 0);
    EXPECT_LE(loop.deviation, loop.tolerance);
  }
  EXPECT_EQ(parts[0].outer.corners, 4);
  EXPECT_NEAR(parts[0].outer.area, 1, 1e-9);
  const FairLoop& square = holeNear(parts[0], kSquareArea);
  EXPECT_EQ(square.corners, 4);
  EXPECT_NEAR(square.area, -kSquareArea, 1e-9);  // its corners too, which the triangles cut off
  const FairLoop& round = holeNear(parts[0], kRoundArea);
  EXPECT_EQ(round.corners, 0);
  EXPECT_NEAR(round.area, -kRoundArea, 2 * 3.1416 * kRoundRadius / 80);
  EXPECT_NEAR(round.length, 2 * 3.1416 * kRoundRadius, 0.05);
  EXPECT_LT(round.deviation, 1.0 / 80);
}

TEST(BorderCurves, ARoundLoopClosesWithItsCurvature) {
  const Net points = gridPoints(80, onSheet);
  const auto parts = fairBorders(points, findBorders(points));
  const FairLoop& round = holeNear(parts[0], kRoundArea);
  ASSERT_EQ(round.pieces.size(), 1U);
  const KnotVector& knots = round.pieces[0].knots(0);
  const Net begin = derivatives<1>(round.pieces[0], {knots.from()}, 2);
  const Net end = derivatives<1>(round.pieces[0], {knots.to()}, 2);
  for (Index order = 0; order <= 2; ++order) {
    EXPECT_LT((begin.row(order) - end.row(order)).norm(), 1e-9 * (1 + begin.row(order).norm())) << order;
  }
}

TEST(BorderCurves, ARaggedBorderIsSmoothed) {
  const Net points = randomPoints(8000, 2, onSheet);
  const Borders borders = findBorders(points);
  const auto parts = fairBorders(points, borders);
  const double spacing = 1 / std::sqrt(8000 / (1 - kRoundArea - kSquareArea));
  ASSERT_EQ(parts[0].holes.size(), 2U);
  EXPECT_LT(parts[0].outer.length, 4);
  EXPECT_NEAR(parts[0].outer.area, 1, 4 * spacing);
  EXPECT_EQ(parts[0].outer.corners, 4);
  EXPECT_NEAR(holeNear(parts[0], kRoundArea).area, -kRoundArea, 2 * 3.1416 * kRoundRadius * spacing);
  EXPECT_NEAR(holeNear(parts[0], kSquareArea).area, -kSquareArea, 0.9 * spacing);
  for (const FairLoop& loop : loopsOf(parts)) {
    EXPECT_LE(loop.rms, spacing);
    EXPECT_LE(loop.deviation, loop.tolerance);
  }
}

TEST(BorderCurves, AnExactBorderIsKept) {
  // A disk whose border points lie on the circle.
  std::vector<std::array<double, 2>> points;
  for (int ring = 0; ring <= 20; ++ring) {
    const int count = ring == 0 ? 1 : 6 * ring;
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * 3.14159265358979 * i / count;
      points.push_back({ring / 20.0 * std::cos(angle), ring / 20.0 * std::sin(angle)});
    }
  }
  const Net net = netOf(points);
  const auto parts = fairBorders(net, findBorders(net));
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_TRUE(parts[0].holes.empty());
  EXPECT_EQ(parts[0].outer.corners, 0);
  EXPECT_EQ(parts[0].outer.points, 120);
  EXPECT_LT(parts[0].outer.deviation, 1e-3);
  EXPECT_NEAR(parts[0].outer.area, 3.14159265, 5e-3);
}

TEST(BorderCurves, AToleranceIsKept) {
  const Net points = randomPoints(3000, 6, onSheet);
  const Borders borders = findBorders(points);
  BorderCurveOptions options;
  double length = 0;
  for (double tolerance : {0.004, 0.02}) {
    options.tolerance = tolerance;
    const auto parts = fairBorders(points, borders, options);
    for (const FairLoop& loop : loopsOf(parts)) EXPECT_LE(loop.deviation, tolerance);
    EXPECT_TRUE(length == 0 || parts[0].outer.length < length);  // the more is allowed the fairer
    length = parts[0].outer.length;
  }
}

// Borders with spikes, at a fiftieth of the spacing.
TEST(BorderCurves, ATightToleranceIsKeptOnRaggedBordersWithoutStraightLines) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const Net points =
        randomPoints(500, seed, [](double x, double y) { return std::fmod(5 * x * x + 3 * y, 1) < 0.7; });
    BorderCurveOptions options;
    options.domain = {Eigen::Vector2d(points.colwise().minCoeff()), Eigen::Vector2d(points.colwise().maxCoeff())};
    options.tolerance = 0.001;
    BorderOptions gaps;
    gaps.gap = 0.13;
    for (const FairLoop& loop : loopsOf(fairBorders(points, findBorders(points, gaps), options))) {
      EXPECT_LE(loop.deviation, options.tolerance) << seed;
      EXPECT_EQ(loop.pinned, 0) << seed;
    }
  }
}

// A tolerance wider than the cloud does not let its curve collapse.
TEST(BorderCurves, AHugeToleranceLeavesTheShape) {
  const Net points = randomPoints(2000, 3, onSheet);
  BorderCurveOptions options;
  options.tolerance = 1e6;
  const auto parts = fairBorders(points, findBorders(points), options);
  EXPECT_GT(parts[0].outer.area, 0.8);
  EXPECT_EQ(parts[0].outer.pinned, 0);
}

TEST(BorderCurves, NoCurveCrossesAnotherNorLeavesTheDomain) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Net points =
        randomPoints(500, seed, [](double x, double y) { return std::fmod(5 * x * x + 3 * y, 1) < 0.7; });
    BorderCurveOptions options;
    options.domain = {Eigen::Vector2d(points.colwise().minCoeff()), Eigen::Vector2d(points.colwise().maxCoeff())};
    BorderOptions gaps;
    gaps.gap = 0.13;
    const auto loops = loopsOf(fairBorders(points, findBorders(points, gaps), options));
    std::vector<CurveLoop> curves;
    for (const FairLoop& loop : loops) {
      expectClosed(loop);
      curves.push_back(loop.pieces);
      for (const Curve& piece : loop.pieces) {
        for (Index i = 0; i < piece.net().rows(); ++i) {
          EXPECT_TRUE(options.domain.contains(Eigen::Vector2d(piece.net().row(i).transpose())));
        }
      }
    }
    for (const auto& places : placesNotClear(curves, 1e-7)) EXPECT_TRUE(places.empty()) << seed;
  }
}

TEST(BorderCurves, RefusesANegativeTolerance) {
  const Net points = gridPoints(10, [](double, double) { return true; });
  BorderCurveOptions options;
  options.tolerance = -1;
  EXPECT_THROW(fairBorders(points, findBorders(points), options), InvalidInput);
}

}  // namespace
}  // namespace strak
