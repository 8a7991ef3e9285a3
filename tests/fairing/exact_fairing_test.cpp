#include "strak/fairing/exact_fairing.h"

#include <gtest/gtest.h>

#include <cmath>

#include "strak/base/error.h"
#include "strak/fairing/hull_rows.h"
#include "strak/fairing/shape_descent.h"
#include "strak/metrology/continuity.h"
#include "strak/metrology/deviation.h"
#include "strak/metrology/self_intersection.h"
#include "tests/energy/shape_surfaces.h"

namespace strak {
namespace {

using testing::bentSheet;
using testing::withRandomWeights;

Surface mapped(const Surface& s, const KnotVector& u, const KnotVector& v, double scale) {
  return {{u, v}, scale * s.net()};
}

// What every result promises.
void expectBetter(const Surface& input, const ExactFairing& result, double tolerance, const HeldPoints& held) {
  constexpr double kRounding = 1 + 1e-9;
  EXPECT_LE(result.after.plate, kRounding * result.before.plate);
  EXPECT_LE(result.after.curvatureVariation, kRounding * result.before.curvatureVariation);
  EXPECT_LE(result.after.isophoteRoughness, kRounding * result.before.isophoteRoughness);
  EXPECT_LE(certifyDeviation(input, result.spline).upper, tolerance * (1 + 1e-9));
  for (std::size_t r = 0; r < held.size(); ++r) {
    if (held[r] == 0) continue;
    EXPECT_EQ(input.net().row(static_cast<Index>(r)), result.spline.net().row(static_cast<Index>(r))) << r;
  }
}

TEST(ExactFairing, NoiseGoesAndTheShapeStays) {
  const Surface clean = bentSheet(3, 3, 8, 8), noisy = bentSheet(3, 3, 8, 8, 0.02);
  const HeldPoints held = holdStrips<2>(noisy, {2, 2, 2, 2});
  Surface input = noisy;
  for (std::size_t r = 0; r < held.size(); ++r) {
    if (held[r]) input.net().row(static_cast<Index>(r)) = clean.net().row(static_cast<Index>(r));
  }
  const ExactFairing result = fairExactly(input, held, {.tolerance = 0.04});
  expectBetter(input, result, 0.04, held);
  const SurfaceFairness ideal = surfaceFairness(clean);
  EXPECT_LT(result.after.isophoteRoughness, 1.05 * ideal.isophoteRoughness);
  EXPECT_LT(result.after.plate, 1.01 * ideal.plate);
  EXPECT_GT(result.before.isophoteRoughness, 5 * ideal.isophoteRoughness);
}

TEST(ExactFairing, EveryDegreeKeepsItsPromises) {
  for (int p = 2; p <= 5; ++p) {
    for (int q = 2; q <= 4; ++q) {
      const Surface input = bentSheet(p, q, 5, 4, 0.02, static_cast<unsigned>(10 * p + q));
      const HeldPoints held = holdStrips<2>(input, {1, 1, 2, 0});
      const ExactFairing result = fairExactly(input, held, {.tolerance = 0.02});
      expectBetter(input, result, 0.02, held);
      EXPECT_LT(result.after.isophoteRoughness, 0.98 * result.before.isophoteRoughness) << p << q;
    }
  }
}

TEST(ExactFairing, WeightsStay) {
  const Surface input = withRandomWeights(bentSheet(3, 2, 5, 5, 0.01));
  const HeldPoints held = holdStrips<2>(input, {2, 2, 2, 2});
  const ExactFairing result = fairExactly(input, held, {.tolerance = 0.02});
  expectBetter(input, result, 0.02, held);
  EXPECT_EQ(result.spline.net().col(3), input.net().col(3));
  EXPECT_LT(result.after.isophoteRoughness, 0.8 * result.before.isophoteRoughness);
}

TEST(ExactFairing, BallsOnPointsBoundThePoints) {
  const Surface input = bentSheet(3, 3, 6, 6, 0.01);
  const ExactFairing points = fairExactly(input, {}, {.tolerance = 0.002, .ballsOnPoints = true});
  const ExactFairing surface = fairExactly(input, {}, {.tolerance = 0.002});
  EXPECT_LE(points.summary.largestMove, 0.002 * (1 + 1e-12));
  EXPECT_GT(surface.summary.largestMove, 0.002) << "the surface may stay within while its points do not";
  EXPECT_LT(surface.after.isophoteRoughness, points.after.isophoteRoughness);
}

TEST(ExactFairing, DoesNotDependOnUnitsAndKnots) {
  const Surface input = bentSheet(3, 4, 5, 4, 0.01);
  const HeldPoints held = holdStrips<2>(input, {2, 2, 2, 2});
  const double tolerance = 0.01;
  const Net faired = fairExactly(input, held, {.tolerance = tolerance}).spline.net();
  const Surface knots = mapped(input, input.knots(0).rescaled(-2, 5.3), input.knots(1).rescaled(0, 0.11), 1);
  EXPECT_LT((fairExactly(knots, held, {.tolerance = tolerance}).spline.net() - faired).cwiseAbs().maxCoeff(),
            1e-9 * tolerance);
  const Surface large = mapped(input, input.knots(0), input.knots(1), 1000);
  EXPECT_LT(
      (fairExactly(large, held, {.tolerance = 1000 * tolerance}).spline.net() / 1000 - faired).cwiseAbs().maxCoeff(),
      1e-8 * tolerance);
}

TEST(ExactFairing, AFairSurfaceDoesNotGetWorse) {
  const Surface input = bentSheet(4, 4, 4, 4);
  for (const double tolerance : {1e-2, 1e-4, 1e-7}) {
    const HeldPoints held = holdStrips<2>(input, {2, 2, 2, 2});
    expectBetter(input, fairExactly(input, held, {.tolerance = tolerance}), tolerance, held);
  }
}

TEST(ExactFairing, APlaneComesBackAsItWas) {
  Surface plane = bentSheet(3, 3, 4, 4);
  plane.net().col(2).setZero();
  const ExactFairing result = fairExactly(plane, {}, {.tolerance = 0.1});
  EXPECT_EQ(result.spline, plane);
  EXPECT_EQ(result.summary.stopReason, StopReason::nothingFree);
}

// A C1 line: the quadrature inside the cells does not see the jump of the curvature there.
TEST(ExactFairing, TheJumpAtAKnotLineDoesNotGrow) {
  const KnotVector u(3, {0, 0, 0, 0, 0.25, 0.5, 0.5, 0.75, 1, 1, 1, 1}), v = KnotVector::uniformClamped(3, 3);
  Net net(u.size() * v.size(), 3);
  const auto gu = u.greville(), gv = v.greville();
  for (Index i = 0; i < u.size(); ++i) {
    for (Index j = 0; j < v.size(); ++j) {
      const double x = gu[static_cast<std::size_t>(i)], y = gv[static_cast<std::size_t>(j)];
      net.row(i * v.size() + j) << x, y, (x > 0.5 ? 2 : 0.5) * (x - 0.5) * (x - 0.5) + 0.1 * std::sin(9 * x * y);
    }
  }
  const Surface input{{u, v}, net};
  const auto jump = [](const Surface& s) { return innerContinuity(s).front().continuity.curvature.max; };
  const HeldPoints held = holdStrips<2>(input, {1, 1, 1, 1});
  const ExactFairing result = fairExactly(input, held, {.tolerance = 0.01});
  EXPECT_GT(jump(input), 0.1);
  EXPECT_LT(jump(result.spline), jump(input));
}

TEST(ExactFairing, FoldedInputUnfolds) {
  const Surface folded = bentSheet(3, 3, 8, 8, 0.08, 5);
  const HeldPoints held = holdStrips<2>(folded, {1, 1, 1, 1});
  Surface input = folded;
  const Surface clean = bentSheet(3, 3, 8, 8);
  for (std::size_t r = 0; r < held.size(); ++r) {
    if (held[r]) input.net().row(static_cast<Index>(r)) = clean.net().row(static_cast<Index>(r));
  }
  const ExactFairing result = fairExactly(input, held, {.tolerance = 0.15});
  EXPECT_GT(result.before.isophoteRoughness, 1e4);
  EXPECT_LT(result.after.isophoteRoughness, 2 * surfaceFairness(clean).isophoteRoughness);
}

TEST(ExactFairing, AStoppedRunReturnsTheBestSoFar) {
  const Surface input = bentSheet(3, 3, 6, 6, 0.01);
  int calls = 0;
  const Progress progress([&](double, std::string_view) { return ++calls < 3; });
  const ExactFairing result = fairExactly(input, {}, {.tolerance = 0.01, .progress = progress});
  EXPECT_EQ(result.summary.stopReason, StopReason::cancelled);
  EXPECT_LE(result.after.isophoteRoughness, result.before.isophoteRoughness);
}

TEST(ExactFairing, RefusesWhatMakesNoSense) {
  const Surface input = bentSheet(3, 3, 3, 3);
  EXPECT_THROW(fairExactly(input, {}), InvalidInput) << "no tolerance, nothing held";
  EXPECT_THROW(fairExactly(input, {}, {.tolerance = -1}), InvalidInput);
  EXPECT_THROW(fairExactly(input, {1, 0}, {.tolerance = 1}), InvalidInput);
  EXPECT_EQ(fairExactly(input, {}, {.tolerance = 0}).spline, input);
}

TEST(HullRows, BoundTheDifference) {
  const Surface input = withRandomWeights(bentSheet(3, 2, 4, 3, 0.02));
  const std::vector<int> unknownOf = testing::allFree(input);
  Eigen::VectorXd e(3 * input.net().rows());
  std::srand(3);
  e.setRandom();
  Surface moved = input;
  for (Index r = 0; r < input.net().rows(); ++r) {
    for (int c = 0; c < 3; ++c) moved.net()(r, c) += input.net()(r, 3) * e[3 * r + c];
  }
  const double deviation = certifyDeviation(input, moved).lower;
  double last = std::numeric_limits<double>::infinity();
  for (int level = 0; level < 4; ++level) {
    BallRows rows;
    appendHullRows(input, unknownOf, evenLevels(input, level), 1, rows);
    const double bound = rows.largestRatio(e);
    EXPECT_GE(bound, deviation * (1 - 1e-12)) << level;
    EXPECT_LE(bound, last * (1 + 1e-12)) << level;
    last = bound;
  }
  EXPECT_LT(last, 1.1 * deviation);
}

TEST(HullRows, AreRefinedWhereTheyAreActive) {
  const Surface input = bentSheet(3, 3, 8, 8);
  const std::vector<int> unknownOf = testing::allFree(input);
  Eigen::VectorXd e = Eigen::VectorXd::Zero(3 * input.net().rows());
  e[0] = 1;
  SpanLevels levels = evenLevels(input, 1);
  BallRows rows;
  appendHullRows(input, unknownOf, levels, 1, rows);
  EXPECT_TRUE(refineActive(input, unknownOf, rows, 0, e, 0.9, 3, levels));
  EXPECT_EQ(levels[0].front(), 2);
  EXPECT_EQ(levels[0].back(), 1);
  EXPECT_FALSE(
      refineActive(input, unknownOf, rows, 0, Eigen::VectorXd(0.1 * e), 0.9, 3, levels = evenLevels(input, 1)));
}

TEST(ExactFairing, RuledSurfacesGetFairerAlongTheirBorders) {
  const Surface input = bentSheet(1, 3, 1, 12, 0.01);
  const HeldPoints held = holdStrips<2>(input, {0, 0, 2, 2});
  const ExactFairing result = fairExactly(input, held, {.tolerance = 0.02});
  expectBetter(input, result, 0.02, held);
  EXPECT_LT(result.after.isophoteRoughness, 0.1 * result.before.isophoteRoughness);
}

// A cusp inside a knot cell, far larger than the tolerance: its integrals diverge, the rest is faired without it.
TEST(ExactFairing, WhatIsRoughBeyondMeasureIsHeld) {
  Surface input = bentSheet(3, 3, 12, 10, 0.002);
  for (Index j = 5; j < 9; ++j) {
    const Net row = input.net().row(input.row({6, j})), next = input.net().row(input.row({7, j}));
    input.net().row(input.row({6, j})) = next;
    input.net().row(input.row({7, j})) = row;
  }
  const ExactFairing result =
      fairExactly(input, holdStrips<2>(input, {1, 1, 1, 1}), {.tolerance = 0.002, .maxSteps = 10});
  EXPECT_LT(result.before.relativeError, 0.01);
  EXPECT_LT(result.after.isophoteRoughness, 0.9 * result.before.isophoteRoughness);
  expectBetter(input, result, 0.002, {});
  for (Index i = 6; i <= 7; ++i) {
    for (Index j = 5; j < 9; ++j) {
      EXPECT_EQ(result.spline.net().row(input.row({i, j})), input.net().row(input.row({i, j})));
    }
  }
}

// A sheet folded over itself; the upper half, held, hangs down into a dent of the lower one. Fairing wants to press the
// dent out, through the other half.
struct FoldedSheet {
  Surface surface;
  HeldPoints held;
};

FoldedSheet foldedSheet() {
  const std::vector<std::array<double, 2>> section{
      {0, 0},  {1, 0}, {2, 0},   {3, 0},   {4, 0},   {5, 0},   {6, 0},   {7, 0},   {8, 0},   {9, 0},   {10, 1},
      {10, 2}, {9, 1}, {8, 0.3}, {7, 0.2}, {6, 0.2}, {5, 0.2}, {4, 0.2}, {3, 0.2}, {2, 0.2}, {1, 0.2}, {0, 0.2}};
  const KnotVector u = KnotVector::uniformClamped(3, static_cast<Index>(section.size()) - 3),
                   v = KnotVector::uniformClamped(3, 8);
  Net net(u.size() * v.size(), 3);
  HeldPoints held(static_cast<std::size_t>(net.rows()), 0);
  for (Index i = 0; i < u.size(); ++i) {
    const auto [x, z] = section[static_cast<std::size_t>(i)];
    const bool upper = i > 10;
    for (Index j = 0; j < v.size(); ++j) {
      const double y = static_cast<double>(j), r = std::hypot(x - 4, y - 5);
      const double dent = upper ? 0.6 * std::exp(-r * r / 4) : 0.8 * std::exp(-r * r / 2);
      net.row(i * v.size() + j) << x, y, z - dent;
      if (upper || j < 2 || j >= v.size() - 2 || i < 2) held[static_cast<std::size_t>(i * v.size() + j)] = 1;
    }
  }
  return {Surface({u, v}, std::move(net)), held};
}

TEST(ExactFairing, AMoveThatMakesASheetMeetItselfIsTakenBack) {
  const FoldedSheet sheet = foldedSheet();
  ASSERT_EQ(findSelfIntersection(sheet.surface).answer, SelfMeeting::free);
  ShapePatch patch{sheet.surface, {}};
  int unknowns = 0;
  for (std::uint8_t held : sheet.held) patch.unknownOf.push_back(held ? -1 : unknowns++);
  const ShapeDescent unguarded = descendShape({patch}, {}, {.tolerance = 0.7});
  ASSERT_TRUE(meetingAfterMove(sheet.surface, unguarded.surfaces.front()).isNew) << "else this shows nothing";

  const ExactFairing result = fairExactly(sheet.surface, sheet.held, {.tolerance = 0.7});
  EXPECT_EQ(findSelfIntersection(result.spline).answer, SelfMeeting::free);
  expectBetter(sheet.surface, result, result.tolerance, sheet.held);
  EXPECT_LT(result.tolerance, 0.7);
  EXPECT_LT(result.after.isophoteRoughness, 0.99 * result.before.isophoteRoughness) << "a smaller move was possible";
}

}  // namespace
}  // namespace strak
