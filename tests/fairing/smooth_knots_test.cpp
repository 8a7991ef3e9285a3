#include "strak/fairing/smooth_knots.h"

#include <gtest/gtest.h>

#include <cmath>

#include "strak/base/error.h"
#include "strak/metrology/continuity.h"
#include "strak/spline/bezier.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/knot_insertion.h"
#include "tests/spline/random_splines.h"

namespace strak {
namespace {

using strak::testing::Random;

constexpr double kDegree = M_PI / 180;

// Two straight legs of a cubic that meet at t = 0.5 with the angle `bend`.
Curve bentCurve(double bend) {
  const KnotVector knots(3, {0, 0, 0, 0, 0.25, 0.5, 0.5, 0.5, 0.75, 1, 1, 1, 1});
  Net net(9, 2);
  const auto greville = knots.greville();
  for (Index i = 0; i < 9; ++i) {
    const double x = greville[static_cast<std::size_t>(i)] - 0.5;
    net.row(i) << x, std::max(0.0, x) * std::tan(bend);
  }
  return Curve({knots}, net);
}

// A sheet over [0, 1]^2 with such a bend along u = 0.5.
Surface bentSurface(double bend) {
  const Curve profile = bentCurve(bend);
  const auto v = KnotVector::uniformClamped(3, 4);
  Net net(9 * v.size(), 3);
  Index r = 0;
  for (Index i = 0; i < 9; ++i) {
    for (double y : v.greville()) net.row(r++) << profile.net()(i, 0), y, profile.net()(i, 1);
  }
  return Surface({profile.knots(0), v}, net);
}

TEST(SmoothKnots, BezierPiecesOfASmoothSurfaceBecomeOneAgain) {
  Random random(5);
  for (int trial = 0; trial < 10; ++trial) {
    const int degree = random.integer(3, 5);
    const Surface smooth = testing::randomSpline<2>(
        random, {KnotVector::uniformClamped(degree, 4), KnotVector::uniformClamped(degree, 3)}, 3, random.coin());
    SmoothKnotsOptions<2> options;
    options.continuity = degree - 1;
    options.creaseAngle = 1e-3;
    const auto result = smoothKnots(bezierForm(smooth), options);
    ASSERT_EQ(result.spline.knots(), smooth.knots());
    ASSERT_LT(result.deviation.upper, 1e-11);
    ASSERT_EQ(result.lines.size(), 5U);
    for (const auto& line : result.lines) ASSERT_TRUE(line.kept.empty());
  }
}

TEST(SmoothKnots, SmallBendsGoWithinTheTolerance) {
  const Surface surface = bentSurface(1 * kDegree);
  SmoothKnotsOptions<2> options;
  options.tolerance = 0.01;
  const auto result = smoothKnots(surface, options);
  ASSERT_EQ(result.lines.size(), 1U);
  EXPECT_EQ(result.lines[0].multiplicityBefore, 3);
  EXPECT_EQ(result.lines[0].multiplicityAfter, 1);
  EXPECT_NEAR(result.lines[0].angle, 1 * kDegree, 1e-9);
  EXPECT_LE(result.deviation.upper, 0.01);
  EXPECT_GT(result.deviation.lower, 1e-5);
  EXPECT_TRUE(innerContinuity(result.spline).empty());
  ASSERT_EQ(result.notes.size(), 1U);
  EXPECT_NE(result.notes[0].find("1 inner knot line made smooth"), std::string::npos) << result.notes[0];
}

TEST(SmoothKnots, CreasesStay) {
  SmoothKnotsOptions<2> options;
  options.tolerance = 10;
  const Surface surface = bentSurface(6 * kDegree);
  const auto kept = smoothKnots(surface, options);
  EXPECT_EQ(kept.spline, surface);
  EXPECT_EQ(kept.deviation.upper, 0);
  ASSERT_EQ(kept.notes.size(), 1U);
  EXPECT_NE(kept.notes[0].find("crease"), std::string::npos) << kept.notes[0];
  options.creaseAngle = 7 * kDegree;
  EXPECT_EQ(smoothKnots(surface, options).spline.knots(0).multiplicity(0.5), 1);
}

TEST(SmoothKnots, TheToleranceLimits) {
  const Curve curve = bentCurve(4 * kDegree);
  SmoothKnotsOptions<1> options;
  options.tolerance = 1e-6;
  const auto kept = smoothKnots(curve, options);
  EXPECT_EQ(kept.spline, curve);
  EXPECT_NEAR(kept.lines.at(0).angle, 4 * kDegree, 1e-9);
  EXPECT_NE(kept.lines.at(0).kept.find("tolerance"), std::string::npos);
  int last = 3;
  for (double tolerance : {1e-6, 1e-3, 3e-3, 1e-2, 3e-2}) {
    options.tolerance = tolerance;
    const auto result = smoothKnots(curve, options);
    EXPECT_LE(result.deviation.upper, tolerance);
    EXPECT_LE(result.spline.knots(0).multiplicity(0.5), last);
    last = result.spline.knots(0).multiplicity(0.5);
  }
  EXPECT_EQ(last, 1);
}

TEST(SmoothKnots, HeldEndsStay) {
  const Curve curve = bentCurve(2 * kDegree);
  SmoothKnotsOptions<1> options;
  options.tolerance = 0.05;
  options.rows = {2, 3};
  const auto result = smoothKnots(curve, options);
  EXPECT_EQ(result.spline.knots(0).multiplicity(0.5), 1);
  EXPECT_LT((derivatives(curve, {0.0}, 1) - derivatives(result.spline, {0.0}, 1)).norm(), 1e-11);
  EXPECT_LT((derivatives(curve, {1.0}, 2) - derivatives(result.spline, {1.0}, 2)).norm(), 1e-9);
}

TEST(SmoothKnots, ExactBordersKeepWhatTheyNeed) {
  SmoothKnotsOptions<2> options;
  options.tolerance = 0.05;
  options.rows = {1, 1, 1, 1};
  options.exactStrips = true;
  const Surface surface = bentSurface(1 * kDegree);
  const auto result = smoothKnots(surface, options);
  EXPECT_EQ(result.spline, surface);
  EXPECT_NE(result.lines.at(0).kept.find("borders"), std::string::npos);
}

TEST(SmoothKnots, SharedBordersStayShared) {
  Surface left = bentSurface(1 * kDegree), right = left;
  for (Index r = 0; r < left.net().rows(); ++r) right.net()(r, 1) = 2 - right.net()(r, 1);
  right.net().col(2).array() += right.net().col(1).array().square() * 0.1 - 0.1;
  SmoothKnotsOptions<2> options;
  options.tolerance = 0.05;
  const auto a = smoothKnots(left, options), b = smoothKnots(right, options);
  ASSERT_EQ(a.spline.knots(0), b.spline.knots(0));
  for (int i = 0; i <= 20; ++i) {
    EXPECT_LT((evaluate(a.spline, {i / 20.0, 1.0}) - evaluate(b.spline, {i / 20.0, 1.0})).norm(), 1e-10);
  }
}

TEST(SmoothKnots, VolumesAndOtherDimensions) {
  Random random(8);
  const auto smooth = testing::randomSpline<3>(
      random, {KnotVector::uniformClamped(3, 2), KnotVector::uniformClamped(2, 2), KnotVector::uniformClamped(3, 1)}, 4,
      false);
  const auto result = smoothKnots(bezierForm(smooth), SmoothKnotsOptions<3>{});
  EXPECT_EQ(result.spline.knots(), smooth.knots());
  EXPECT_LT(result.deviation.upper, 1e-11);
}

TEST(SmoothKnots, SaysWhatIsWrong) {
  SmoothKnotsOptions<1> options;
  options.creaseAngle = -1;
  EXPECT_THROW(smoothKnots(bentCurve(0.1), options), InvalidInput);
  options.creaseAngle = 1;
  options.tolerance = std::nan("");
  EXPECT_THROW(smoothKnots(bentCurve(0.1), options), InvalidInput);
  options.tolerance = 1;
  options.continuity = -1;
  EXPECT_THROW(smoothKnots(bentCurve(0.1), options), InvalidInput);
}

}  // namespace
}  // namespace strak
