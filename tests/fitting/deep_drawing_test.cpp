#include "strak/fitting/deep_drawing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "strak/base/error.h"
#include "strak/fitting/parametrization.h"
#include "strak/spline/evaluate.h"

namespace strak {
namespace {

constexpr double kNoise = 1e-3;

// `at` maps (s, t) in [-1, 1]^2 to the ideal point.
template <class Map>
Net cloud(Index count, const Map& at) {
  std::mt19937_64 random(8);
  std::normal_distribution<double> noise(0, kNoise);
  std::uniform_real_distribution<double> unit(-1, 1);
  Net points(count, 3);
  for (Index r = 0; r < count; ++r) {
    const double s = unit(random), t = unit(random);
    points.row(r) = at(s, t).transpose();
    for (Index c = 0; c < 3; ++c) points(r, c) += noise(random);
  }
  return points;
}

// A cylinder of radius 1 over an angle of 2 * half.
Net cylinder(double half) {
  return cloud(6000,
               [half](double s, double t) { return Eigen::Vector3d(std::sin(half * s), 2.5 * t, std::cos(half * s)); });
}

DeepDrawingOptions size(Index n) {
  DeepDrawingOptions options;
  options.size = {n, n};
  return options;
}

class BentSheets : public ::testing::TestWithParam<double> {};

TEST_P(BentSheets, AreDrawnToTheirNoise) {
  // Degrees: 90 is a half cylinder, whose rims stand upright on the plane; beyond it the projection overlaps.
  const double half = GetParam() * std::numbers::pi / 180;
  const Net points = cylinder(half);
  const DrawnSheet sheet = drawSheet({planeParameters(points), points}, size(14));
  EXPECT_NEAR(sheet.fit.summary.rms, kNoise, 0.1 * kNoise);
  EXPECT_LT(sheet.fit.summary.max, 6 * kNoise);
  EXPECT_GT(sheet.rms.front(), 50 * kNoise);
  EXPECT_EQ(sheet.check.folded, 0);
  EXPECT_EQ(sheet.check.astray, 0);
  EXPECT_LT(sheet.check.layered, 0.05);
  EXPECT_FALSE(sheet.folded);
  EXPECT_GT(sheet.stretch, half < 1 ? 1.0 : 1.2);  // the domain has grown with the sheet
  // The parametrization is near to isometric across, too: the angle is a linear function of its parameter.
  const Index across = 1;
  const auto parameter = sheet.parameters.col(across);
  const double scale = 2 * half / (parameter.maxCoeff() - parameter.minCoeff());
  double worst = 0;
  for (Index r = 0; r < points.rows(); ++r) {
    const double angle = std::atan2(points(r, 0), points(r, 2));
    const double linear = scale * (parameter[r] - (parameter.maxCoeff() + parameter.minCoeff()) / 2);
    worst = std::max(worst, std::abs(std::abs(angle) - std::abs(linear)));
  }
  EXPECT_LT(worst, 0.25 * half);
}

INSTANTIATE_TEST_SUITE_P(DeepDrawing, BentSheets, ::testing::Values(45.0, 90.0, 130.0));

TEST(DeepDrawing, SaysThatAHeapIsNoSheet) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> unit(0, 1);
  Net heap(2000, 3);
  for (double& c : heap.reshaped()) c = unit(random);
  EXPECT_GT(drawCloud(heap, {}, size(10)).sheet.check.thickness, kThick);
  EXPECT_LT(drawCloud(cylinder(1), {}, size(14)).sheet.check.thickness, 0.001);
}

TEST(DeepDrawing, SaysThatNothingJoinsTheParts) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> unit(0, 1);
  // Two squares one above the other, farther apart than they are wide: a sheet runs around both.
  Net points(1000, 3);
  for (Index r = 0; r < points.rows(); ++r) points.row(r) << unit(random), unit(random), r % 2 == 0 ? 0 : 2;
  EXPECT_EQ(drawCloud(points, {}, size(10)).sheet.check.parts, 2);
  EXPECT_EQ(drawCloud(cylinder(1), {}, size(14)).sheet.check.parts, 1);
}

TEST(DeepDrawing, IsNotBentByOutliers) {
  const double half = std::numbers::pi / 2;
  Net points = cylinder(half);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-0.4, 0.4);
  for (Index r = 0; r < points.rows(); r += 12) {
    for (Index c = 0; c < 3; ++c) points(r, c) += unit(random);
  }
  DeepDrawingOptions options = size(14);
  const auto errorOf = [&] {
    const DrawnSheet sheet = drawSheet({planeParameters(points), points}, options);
    double worst = 0;
    for (Index r = 0; r < points.rows(); ++r) {
      if (r % 12 == 0) continue;
      const Point foot = evaluate<2>(sheet.fit.spline, {sheet.parameters(r, 0), sheet.parameters(r, 1)});
      worst = std::max(worst, std::abs(std::hypot(foot[0], foot[2]) - 1));
    }
    return worst;
  };
  const double bent = errorOf();
  options.robust = true;
  const double straight = errorOf();
  EXPECT_GT(bent, 30 * kNoise);
  EXPECT_LT(straight, 10 * kNoise);
}

TEST(DeepDrawing, TakesHemispheresAndHoles) {
  Net points = cloud(8000, [](double s, double t) {
    const double radius = std::hypot(s, t);
    const double shrink = radius > 1 ? 1 / radius : 1;
    const double x = s * shrink, y = t * shrink;
    return Eigen::Vector3d(x, y, std::sqrt(std::max(0.0, 1 - x * x - y * y)));
  });
  Index kept = 0;
  for (Index r = 0; r < points.rows(); ++r) {
    if ((points.row(r) - Eigen::RowVector3d(0.4, 0.2, 0.89)).norm() > 0.25) points.row(kept++) = points.row(r);
  }
  points.conservativeResize(kept, Eigen::NoChange);
  const DrawnSheet sheet = drawSheet({planeParameters(points), points}, size(14));
  EXPECT_LT(sheet.fit.summary.rms, 1.3 * kNoise);
  EXPECT_EQ(sheet.check.folded, 0);
  // The hole is closed by the energy: no crumple there.
  double worst = 0;
  for (Index r = 0; r < sheet.fit.spline.net().rows(); ++r) {
    worst = std::max(worst, sheet.fit.spline.net().row(r).norm());
  }
  EXPECT_LT(worst, 3);
}

TEST(DeepDrawing, TriesTheOtherPlanes) {
  // A sheet bent like an omega stands on its narrow side: its plane of least squares crosses it three times.
  const Net points = cloud(6000, [](double s, double t) {
    double x = 0, z = 0;
    constexpr int kParts = 100;
    for (int i = 0; i < kParts; ++i) {
      const double angle = 1.8 * std::sin(2.4 * s * (i + 0.5) / kParts);
      x += std::cos(angle) * 1.2 * s / kParts;
      z += std::sin(angle) * 1.2 * s / kParts;
    }
    return Eigen::Vector3d(x, t, z);
  });
  const DrawnCloud drawn = drawCloud(points, {}, size(14));
  EXPECT_NE(drawn.plane, 0);
  EXPECT_NEAR(drawn.sheet.fit.summary.rms, kNoise, 0.1 * kNoise);
  EXPECT_EQ(drawn.sheet.check.layered, 0);
}

TEST(DeepDrawing, SeesStripsThatWaveHigherThanTheyAreWide) {
  // Their plane of least squares shows them from the side.
  const Net strip =
      cloud(6000, [](double s, double t) { return Eigen::Vector3d(25 * s, t / 2, std::sin(25 * s / 3)); });
  DrawnCloud drawn = drawCloud(strip, {}, size(20));
  EXPECT_NE(drawn.plane, 0);
  EXPECT_LT(drawn.sheet.fit.summary.rms, 1.6 * kNoise);
  // A steep saddle without a quadrant: from the side its empty corner would fold.
  Net saddle = cloud(5000, [](double s, double t) { return Eigen::Vector3d(s, t, 1.2 * (s * s - t * t)); });
  Index kept = 0;
  for (Index r = 0; r < saddle.rows(); ++r) {
    if (saddle(r, 0) < 0 || saddle(r, 1) < 0) saddle.row(kept++) = saddle.row(r);
  }
  saddle.conservativeResize(kept, Eigen::NoChange);
  drawn = drawCloud(saddle, {}, size(20));
  EXPECT_LT(drawn.sheet.fit.summary.rms, 1.3 * kNoise);
}

TEST(DeepDrawing, SaysWhenACloudIsNotOneSheet) {
  int number = 0;
  const Net two = cloud(6000, [&number](double s, double t) {
    return Eigen::Vector3d(s, t, 0.3 * s * s + (++number % 2 == 0 ? 0.4 : 0));
  });
  const DrawnCloud drawn = drawCloud(two, {}, size(14));
  EXPECT_GT(drawn.sheet.check.doubt(), kNotOneSheet);
  EXPECT_EQ(drawn.sheet.check.folded, 0);  // not crumpled, whatever it is
}

TEST(DeepDrawing, WrapsClosedSheetsAsFarAsOnePatchCan) {
  const Net sphere = cloud(6000, [](double s, double t) {
    const double z = s, a = std::numbers::pi * t, r = std::sqrt(1 - z * z);
    return Eigen::Vector3d(r * std::cos(a), r * std::sin(a), z);
  });
  const DrawnSheet sheet = drawCloud(sphere, {}, size(14)).sheet;
  EXPECT_EQ(sheet.check.folded, 0);
  EXPECT_TRUE(sheet.folded);  // it would have to, to close
  EXPECT_LT(sheet.fit.summary.rms, 0.1);
}

TEST(DeepDrawing, DrawsOnWhereNothingFolds) {
  // Waves with a hole in the middle, and a ball of points above it that no sheet can follow.
  int number = 0;
  const Net points = cloud(8000, [&number](double s, double t) {
    if (++number % 80 == 0) {
      const double angle = std::numbers::pi * s, height = std::fmod(0.618 * number, 2) - 1;
      const double radius = 0.15 * std::sqrt(std::abs(t) * (1 - height * height));
      return Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), 0.15 + 0.15 * height);
    }
    const double x = std::hypot(s, t) < 0.12 ? s + 0.3 : s;
    return Eigen::Vector3d(x, t, 0.03 * std::sin(9 * x) * std::sin(9 * t));
  });
  const DrawnSheet sheet = drawSheet({planeParameters(points), points}, size(24));
  EXPECT_TRUE(sheet.folded);
  EXPECT_EQ(sheet.check.folded, 0);
  EXPECT_FALSE(sheet.held.empty());
  EXPECT_LT(sheet.held.size(), 24 * 24 / 4);
  EXPECT_LT(sheet.fit.summary.lambda, 2e-8);
  double squares = 0;
  Index count = 0;
  for (Index r = 0; r < points.rows(); ++r) {
    if (points.row(r).head<2>().norm() < 0.5) continue;
    const Point at = evaluate<2>(sheet.fit.spline, {sheet.parameters(r, 0), sheet.parameters(r, 1)});
    squares += (at - points.row(r)).squaredNorm();
    ++count;
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(count)), 1.5 * kNoise);
}

TEST(DeepDrawing, RefusesWhatCannotBeASheetAndStopsWhenAsked) {
  const Net points = cylinder(1);
  EXPECT_THROW(drawSheet({planeParameters(points), points.leftCols(2)}), InvalidInput);
  EXPECT_THROW(drawSheet({planeParameters(points), points}, size(3)), InvalidInput);
  EXPECT_THROW(drawSheet({Net::Zero(points.rows(), 2), points}), InvalidInput);
  EXPECT_THROW(drawSheet({Net(0, 2), Net(0, 3)}), InvalidInput);
  DeepDrawingOptions options = size(8);
  options.progress = Progress([](double, std::string_view) { return false; });
  const DrawnSheet stopped = drawSheet({planeParameters(points), points}, options);
  EXPECT_TRUE(stopped.fit.summary.stopped);
  EXPECT_EQ(stopped.rms.size(), 1);
}

TEST(SheetCheck, FindsFoldsAndPointsThatWentAstray) {
  // A cylinder that is bent into itself: the second half lies a little above the first.
  Net net(8, 3);
  const std::array<KnotVector, 2> knots{KnotVector::uniformClamped(1, 3), KnotVector::uniformClamped(1, 1)};
  const double x[4] = {0, 1, 1, 0}, z[4] = {0, 0, 0.1, 0.1};
  for (Index i = 0; i < 4; ++i) {
    for (Index j = 0; j < 2; ++j) net.row(2 * i + j) << x[i], static_cast<double>(j), z[i];
  }
  const Surface surface(knots, net);
  // Points of the upper sheet that believe to be on the lower one.
  Net parameters(400, 2), points(400, 3);
  for (Index r = 0; r < 400; ++r) {
    const double s = static_cast<double>(r % 20) / 19, t = static_cast<double>(r) / 400;
    parameters.row(r) << s * knots[0].to() / 3, t;
    points.row(r) << s, t, 0.1;
  }
  const SheetCheck check = checkSheet(surface, {parameters, points});
  EXPECT_GT(check.folded, 0);
  EXPECT_GT(check.astrayShare(), 0.8);
  EXPECT_EQ(check.looked, 400);
  const Surface flat(knots, [&] {
    Net straight = net;
    for (Index i = 0; i < 8; ++i) straight.row(i) << static_cast<double>(i / 2), static_cast<double>(i % 2), 0;
    return straight;
  }());
  Net on = parameters;
  on.conservativeResize(400, 3);
  on.col(0) *= 3 / knots[0].to();
  on.col(2).setZero();
  const SheetCheck clean = checkSheet(flat, {parameters, on});
  EXPECT_EQ(clean.folded, 0);
  EXPECT_EQ(clean.cells, 1);
  EXPECT_EQ(clean.astray, 0);
  EXPECT_EQ(clean.layered, 0);
  EXPECT_THROW(checkSheet(flat, {parameters, on.leftCols(2)}), InvalidInput);
}

}  // namespace
}  // namespace strak
