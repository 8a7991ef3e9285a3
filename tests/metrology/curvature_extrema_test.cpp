#include "strak/metrology/curvature_extrema.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "strak/base/error.h"
#include "strak/metrology/orthotomic.h"
#include "strak/metrology/plane_of_points.h"

namespace strak {
namespace {

// A whole ellipse as a rational quadratic of four pieces: exact.
Curve ellipse(double a, double b) {
  const double w = std::sqrt(0.5);
  Net net(9, 3);
  net << a, 0, 1, a * w, b * w, w, 0, b, 1, -a * w, b * w, w, -a, 0, 1, -a * w, -b * w, w, 0, -b, 1, a * w, -b * w, w,
      a, 0, 1;
  return {{KnotVector(2, {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4})}, net, true};
}

Curve cubic(std::vector<double> y) {
  const auto n = static_cast<Index>(y.size());
  const KnotVector knots = KnotVector::uniformClamped(3, n - 3, 0, static_cast<double>(n - 3));
  const auto greville = knots.greville();
  Net net(n, 2);
  for (Index i = 0; i < n; ++i) net.row(i) << greville[static_cast<std::size_t>(i)], y[static_cast<std::size_t>(i)];
  return {{knots}, net};
}

Curve inSpace(const Curve& curve) {
  Net net(curve.net().rows(), 3);
  const Eigen::RowVector3d a(0.6, 0, 0.8), b(0, 1, 0), o(3, -2, 5);
  for (Index i = 0; i < net.rows(); ++i) net.row(i) = o + curve.net()(i, 0) * a + curve.net()(i, 1) * b;
  return {curve.knots(), net};
}

TEST(CurvatureExtrema, EllipseHasFourAndCircleNone) {
  const auto profile = curvatureProfile(ellipse(3, 1));
  EXPECT_TRUE(profile.closed);
  ASSERT_EQ(profile.extrema(), 4);
  for (const auto& turn : profile.turns) {
    const bool sharp = std::abs(turn.curvature - 3) < 1e-9, flat = std::abs(turn.curvature - 1.0 / 9) < 1e-9;
    EXPECT_TRUE(sharp || flat) << turn.curvature;
  }
  EXPECT_EQ(countCurvatureExtrema(ellipse(2, 2)), 0);
}

TEST(CurvatureExtrema, WavesCountAlsoInSpaceAndInOtherUnits) {
  std::vector<double> y;
  for (int i = 0; i < 40; ++i) y.push_back(0.3 * std::sin(i * 0.5));
  const Curve wave = cubic(y);
  const Index count = countCurvatureExtrema(wave);
  EXPECT_GE(count, 5);
  EXPECT_LE(count, 8);
  EXPECT_EQ(countCurvatureExtrema(inSpace(wave)), count);
  EXPECT_EQ(countCurvatureExtrema(Curve(wave.knots(), 1000 * wave.net())), count);
  EXPECT_EQ(countCurvatureExtrema(Curve({wave.knots(0).rescaled(-5, 1e6)}, wave.net())), count);
  EXPECT_EQ(countCurvatureExtrema(cubic(std::vector<double>(20, 0.0))), 0);
}

TEST(CurvatureExtrema, TheMostSignificantStay) {
  std::vector<double> y;
  for (int i = 0; i < 60; ++i) y.push_back(2 * std::sin(i * 0.2) + 0.005 * std::sin(i * 1.9));
  const auto profile = curvatureProfile(cubic(y));
  ASSERT_GT(profile.extrema(), 8);
  for (Index wanted = 0; wanted < 8; ++wanted) {
    const auto fewer = mostSignificant(profile, wanted);
    EXPECT_LE(fewer.extrema(), wanted);
    EXPECT_GE(fewer.extrema(), wanted - 1);
    int changes = 0, before = 0;
    for (double u = 0.01; u < 57; u += 0.01) {
      const int now = direction(fewer, u);
      ASSERT_NE(now, 0);
      if (before != 0 && now != before) ++changes;
      before = now;
    }
    EXPECT_EQ(changes, fewer.extrema());
  }
  // The sharpest place is a turn that stays, or an end that took over the turn beside it.
  const auto sharpest = [](const CurvatureProfile& p) {
    double k = std::max(std::abs(p.begin.curvature), std::abs(p.end.curvature));
    for (const auto& turn : p.turns) k = std::max(k, std::abs(turn.curvature));
    return k;
  };
  EXPECT_EQ(sharpest(mostSignificant(profile, 4)), sharpest(profile));
}

TEST(CurvatureExtrema, RefusesWhatMakesNoSense) {
  EXPECT_THROW(curvatureProfile(Curve({KnotVector::uniformClamped(3, 2)}, Net::Random(5, 4))), InvalidInput);
  EXPECT_THROW(curvatureProfile(ellipse(2, 1), {0, 16}), InvalidInput);
  EXPECT_THROW(curvatureProfile(ellipse(2, 1), {0.01, 1}), InvalidInput);
}

TEST(PlaneOfPoints, FindsAPlaneAndRefusesATwist) {
  Net points = inSpace(cubic({0, 1, 3, 2, 1, 5})).net();
  const auto plane = planeOfPoints(points);
  ASSERT_TRUE(plane);
  EXPECT_NEAR(((points.rowwise() - plane->origin.transpose()) * plane->normal()).cwiseAbs().maxCoeff(), 0, 1e-12);
  points(2, 2) += 1e-3;
  EXPECT_FALSE(planeOfPoints(points));
  EXPECT_TRUE(planeOfPoints(points, 1e-2));
  EXPECT_THROW(planeOfPoints(Net::Zero(3, 2)), InvalidInput);
}

TEST(Orthotomic, OfACircleAroundThePoleIsACircle) {
  const auto shape = orthotomic(ellipse(2, 2), {0, 0}, 1.5);
  for (const auto& p : shape.points) EXPECT_NEAR(p.norm(), 3, 1e-12);
  EXPECT_TRUE(shape.cusps.empty());
}

TEST(Orthotomic, MarksInflections) {
  const Curve wave = cubic({0, 1, -1, 1, -1, 1, 0});
  const auto shape = orthotomic(wave, suggestedPole(wave));
  EXPECT_EQ(shape.cusps.size(), 4U);
  EXPECT_THROW(orthotomic(inSpace(wave), {0, 0}), InvalidInput);
  EXPECT_THROW(orthotomic(wave, {0, 0}, 0), InvalidInput);
}

}  // namespace
}  // namespace strak
