#include "strak/fairing/exact_curve_fairing.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "strak/base/error.h"
#include "strak/fairing/hull_rows.h"
#include "strak/fairing/plan_curve.h"
#include "strak/metrology/fairness.h"
#include "strak/metrology/self_intersection.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/knot_insertion.h"

namespace strak {
namespace {

// A shallow arch with noise on its inner points.
Curve noisyArch(Index n, double noise, int dimension = 2, unsigned seed = 5) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-noise, noise);
  const KnotVector knots = KnotVector::uniformClamped(3, n - 3);
  const auto greville = knots.greville();
  Net net(n, dimension);
  for (Index i = 0; i < n; ++i) {
    const double u = greville[static_cast<std::size_t>(i)];
    net(i, 0) = 10 * u;
    net(i, 1) = 8 * u * (1 - u);
    if (dimension == 3) net(i, 2) = 3 * u * u * u;
    if (i > 2 && i < n - 3) {
      for (Index c = 0; c < dimension; ++c) net(i, c) += uniform(random);
    }
  }
  return {{knots}, net};
}

// A closed C2 cubic: periodic control points on clamped knots by knot insertion would cost bits; here the knots go on.
Curve noisyRing(Index n, double noise) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> uniform(-noise, noise);
  std::vector<double> knots;
  for (Index i = 0; i < n + 7; ++i) knots.push_back(static_cast<double>(i - 3));
  Net net(n + 3, 2);
  for (Index i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
    net.row(i) << 3 * std::cos(angle) + uniform(random), 2 * std::sin(angle) + uniform(random);
  }
  net.bottomRows(3) = net.topRows(3);
  return {{KnotVector(3, knots)}, net};
}

ExactCurveFairingOptions within(double tolerance, const Curve& curve, Index rows = 3) {
  ExactCurveFairingOptions options;
  options.tolerance = tolerance;
  options.held = holdStrips<1>(curve, {rows, rows});
  return options;
}

// The rows are the control points of the difference after knot insertion: on each quarter of a span every point of the
// difference is a mean of them.
TEST(ExactCurveFairing, RowsAreTheControlPointsOfTheRefinedDifference) {
  const Curve curve = noisyArch(12, 0.1, 3);
  PointMap map{12, {}};
  for (Index i = 0; i < 12; ++i) map.rows.push_back({{i, 1.0}});
  const Eigen::VectorXd y = Eigen::VectorXd::Random(36);
  const Curve difference(curve.knots(), map.apply(y));
  for (const int level : {0, 2}) {
    BallRows rows;
    appendHullRows(curve, map, level, 0.5, rows);
    std::vector<double> more;
    for (const Index s : curve.knots(0).spans()) {
      for (int k = 1; k < 1 << level; ++k) {
        more.push_back(std::lerp(curve.knots(0)[s], curve.knots(0)[s + 1], k / 4.0));
      }
    }
    const Net expected = insertKnots(difference, 0, more).net();
    ASSERT_EQ(rows.count(), expected.rows());
    const Eigen::VectorXd sums = rows.times(y);
    for (Index i = 0; i < rows.count(); ++i) {
      EXPECT_LE((sums.segment<3>(3 * i).transpose() - expected.row(i)).norm(), 1e-12);
      EXPECT_EQ(rows.radius[static_cast<std::size_t>(i)], 0.5);
    }
  }
}

TEST(ExactCurveFairing, NoisyArchBecomesFairInsideTheTolerance) {
  for (const int dimension : {2, 3}) {
    const Curve curve = noisyArch(40, 0.02, dimension);
    const auto faired = fairCurveExactly(curve, within(0.04, curve));
    EXPECT_LE(faired.deviation.upper, 0.04);
    EXPECT_GT(faired.before.extrema, 20);
    EXPECT_LE(faired.after.extrema, 5);
    EXPECT_LT(faired.after.bending, 0.5 * faired.before.bending);
    EXPECT_LT(faired.after.curvatureVariation, 1e-3 * faired.before.curvatureVariation);
    EXPECT_EQ(faired.summary.stopReason, StopReason::gain);
    for (const Index i : {0, 1, 2, 37, 38, 39}) EXPECT_EQ(faired.spline.net().row(i), curve.net().row(i));
    EXPECT_EQ(faired.spline.knots(), curve.knots());
    // The figures are those of the spline that comes back.
    EXPECT_NEAR(curveFairness(faired.spline).bending, faired.after.bending, 1e-5 * faired.after.bending);
    EXPECT_EQ(countCurvatureExtrema(faired.spline), faired.after.extrema);
  }
}

TEST(ExactCurveFairing, NeverWorse) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    const Curve curve = noisyArch(16, 0.05, seed % 2 == 0 ? 2 : 3, seed);
    for (const double tolerance : {1e-4, 1e-2, 0.3}) {
      auto options = within(tolerance, curve, 1);
      options.leaveFair = false;
      const auto faired = fairCurveExactly(curve, options);
      const auto before = curveFairness(curve, {1e-6}), after = curveFairness(faired.spline, {1e-6});
      EXPECT_LE(after.bending, before.bending * (1 + 1e-6));
      EXPECT_LE(after.curvatureVariation, before.curvatureVariation * (1 + 1e-6));
      EXPECT_LE(countCurvatureExtrema(faired.spline), countCurvatureExtrema(curve));
      EXPECT_LE(certifyDeviation(curve, faired.spline).upper, tolerance);
    }
  }
}

TEST(ExactCurveFairing, DoesNotDependOnKnotsUnitsOrPlace) {
  const Curve curve = noisyArch(30, 0.02);
  const Net expected = fairCurveExactly(curve, within(0.03, curve)).spline.net();
  const Curve knots({curve.knots(0).rescaled(-3, 70)}, curve.net());
  EXPECT_LE((fairCurveExactly(knots, within(0.03, knots)).spline.net() - expected).cwiseAbs().maxCoeff(), 1e-6);
  const Curve large(curve.knots(), 1000 * curve.net());
  EXPECT_LE((fairCurveExactly(large, within(30, large)).spline.net() / 1000 - expected).cwiseAbs().maxCoeff(), 1e-6);
  const double c = std::cos(0.7), s = std::sin(0.7);
  Eigen::Matrix2d turn;
  turn << c, s, -s, c;
  Net moved = curve.net() * turn;
  moved.rowwise() += Eigen::RowVector2d(1000, -300);
  const Curve elsewhere(curve.knots(), moved);
  Net back = fairCurveExactly(elsewhere, within(0.03, elsewhere)).spline.net();
  back.rowwise() -= Eigen::RowVector2d(1000, -300);
  EXPECT_LE((back * turn.transpose() - expected).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(ExactCurveFairing, PlanarCurvesInSpaceStayPlanar) {
  const Curve flat = noisyArch(30, 0.02);
  Net net(30, 3);
  const Eigen::RowVector3d a(0.6, 0, 0.8), b(0, 1, 0), o(3, -2, 5);
  for (Index i = 0; i < 30; ++i) net.row(i) = o + flat.net()(i, 0) * a + flat.net()(i, 1) * b;
  const Curve curve(flat.knots(), net);
  const auto faired = fairCurveExactly(curve, within(0.03, curve));
  const Eigen::RowVector3d normal = a.cross(b);
  EXPECT_LE(((faired.spline.net().rowwise() - o) * normal.transpose()).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(faired.after.extrema, fairCurveExactly(flat, within(0.03, flat)).after.extrema);
}

TEST(ExactCurveFairing, ClosedCurvesKeepTheirSeam) {
  const Curve ring = noisyRing(40, 0.02);
  EXPECT_EQ(seamContinuity(ring), 2);
  const CurvePlan plan = planCurve(ring, {3, 3});
  EXPECT_EQ(plan.seamContinuity, 2);
  EXPECT_TRUE(plan.held.empty());
  ExactCurveFairingOptions options;
  options.tolerance = 0.04;
  options.seamContinuity = 2;
  const auto faired = fairCurveExactly(plan.spline, options);
  EXPECT_EQ(seamContinuity(faired.spline), 2);
  EXPECT_LE(faired.deviation.upper, 0.04);
  EXPECT_GT(faired.before.extrema, 20);
  EXPECT_EQ(faired.after.extrema, 4);  // an oval's
  EXPECT_GT((evaluate(faired.spline, {0.0}) - evaluate(ring, {0.0})).norm(), 1e-6);
}

TEST(ExactCurveFairing, RationalCurvesKeepTheirWeights) {
  const Curve flat = noisyArch(24, 0.02);
  Net net(24, 3);
  for (Index i = 0; i < 24; ++i) {
    const double w = 1 + 0.1 * std::sin(static_cast<double>(i));
    net.row(i) << w * flat.net()(i, 0), w * flat.net()(i, 1), w;
  }
  const Curve curve(flat.knots(), net, true);
  const auto faired = fairCurveExactly(curve, within(0.05, curve));
  EXPECT_EQ(faired.spline.net().col(2), net.col(2));
  EXPECT_LE(faired.deviation.upper, 0.05);
  EXPECT_LT(faired.after.curvatureVariation, 0.1 * faired.before.curvatureVariation);
  EXPECT_LT(faired.after.extrema, faired.before.extrema);
}

TEST(ExactCurveFairing, FewerExtremaOnRequest) {
  const Curve curve = noisyArch(40, 0.02);
  auto options = within(0.06, curve, 1);
  options.maxExtrema = 1;
  const auto faired = fairCurveExactly(curve, options);
  EXPECT_TRUE(faired.extremaReached);
  EXPECT_LE(countCurvatureExtrema(faired.spline), 1);
  EXPECT_LE(faired.deviation.upper, 0.06);
  // A tolerance far below the noise cannot: said, and the fewest are given.
  options.tolerance = 1e-4;
  const auto tight = fairCurveExactly(curve, options);
  EXPECT_FALSE(tight.extremaReached);
  EXPECT_GT(tight.after.extrema, 1);
  EXPECT_LE(tight.after.extrema, tight.before.extrema);
  EXPECT_LE(tight.deviation.upper, 1e-4);
}

TEST(ExactCurveFairing, BallsOnControlPointsOnRequest) {
  const Curve curve = noisyArch(40, 0.02);
  auto options = within(0.01, curve);
  const auto curveBound = fairCurveExactly(curve, options);
  options.ballsOnPoints = true;
  const auto pointBound = fairCurveExactly(curve, options);
  EXPECT_LE(pointBound.summary.largestMove, 0.01);
  EXPECT_GT(curveBound.summary.largestMove, 0.01);
  EXPECT_LT(curveBound.after.curvatureVariation, pointBound.after.curvatureVariation);
}

TEST(ExactCurveFairing, FairCurvesStayAsTheyAre) {
  const Curve curve = noisyArch(30, 0);
  const auto faired = fairCurveExactly(curve, within(0.001, curve, 1));
  EXPECT_TRUE(faired.alreadyFair);
  EXPECT_EQ(faired.spline, curve);
  Curve line = curve;
  line.net().col(1).setZero();
  const auto straight = fairCurveExactly(line, within(0.1, line));
  EXPECT_TRUE(straight.alreadyFair);
  EXPECT_EQ(straight.spline, line);
}

TEST(ExactCurveFairing, RefusesWithASentence) {
  const Curve curve = noisyArch(20, 0.01);
  EXPECT_THROW(fairCurveExactly(curve, {}), InvalidInput);  // nothing would keep it in its place
  EXPECT_THROW(fairCurveExactly(curve, within(-1, curve)), InvalidInput);
  EXPECT_THROW(fairCurveExactly(curve, within(std::nan(""), curve)), InvalidInput);
  auto options = within(0.1, curve);
  options.held.pop_back();
  EXPECT_THROW(fairCurveExactly(curve, options), InvalidInput);
  const Curve still(curve.knots(), Net::Zero(20, 2));
  EXPECT_THROW(fairCurveExactly(still, within(0.1, still)), InvalidInput);
  const Curve polygon({KnotVector::uniformClamped(1, 5)}, Net::Random(6, 2));
  EXPECT_THROW(fairCurveExactly(polygon, within(0.1, polygon)), InvalidInput);
  const auto zero = fairCurveExactly(curve, within(0, curve));
  EXPECT_EQ(zero.summary.stopReason, StopReason::nothingFree);
  EXPECT_EQ(zero.spline, curve);
}

TEST(ExactCurveFairing, CanBeCancelled) {
  const Curve curve = noisyArch(40, 0.02);
  auto options = within(0.04, curve);
  int calls = 0;
  options.progress = Progress([&](double, std::string_view) { return ++calls < 2; });
  const auto faired = fairCurveExactly(curve, options);
  EXPECT_EQ(faired.summary.stopReason, StopReason::cancelled);
  EXPECT_LE(faired.deviation.upper, 0.04);
}

// Bezier pieces that join with one tangent but other speeds.
TEST(PlanCurve, SmoothJoinsOfPiecesStaySmooth) {
  Net net(10, 2);
  net << 0, 0, 1, 1, 2, 1.5, 3, 1.5, 3.4, 1.5, 4, 1.4, 5, 1.1, 5.5, 0.95, 6, 0.8, 7, 0;
  const Curve curve({KnotVector(3, {0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3, 3})}, net);
  const CurvePlan plan = planCurve(curve, {1, 1}, false);
  EXPECT_TRUE(plan.leftAlone.empty());
  EXPECT_EQ(plan.spline.net().rows(), 8);  // a knot less at each join
  const Curve same = plan.onInput(plan.spline);
  EXPECT_EQ(same, curve);
  ExactCurveFairingOptions options;
  options.tolerance = 0.05;
  options.held = plan.held;
  options.leaveFair = false;
  const auto faired = fairCurveExactly(plan.spline, options);
  const Curve result = plan.onInput(faired.spline);
  EXPECT_EQ(result.knots(), curve.knots());
  EXPECT_LE(certifyDeviation(curve, result).upper, 0.05);
  EXPECT_GT((result.net() - curve.net()).norm(), 1e-4);
  for (const Index corner : {3, 6}) {
    const Eigen::RowVector2d in = (result.net().row(corner) - result.net().row(corner - 1)).normalized();
    const Eigen::RowVector2d out = (result.net().row(corner + 1) - result.net().row(corner)).normalized();
    EXPECT_LE((in - out).norm(), 1e-12);
  }
  // A corner is held.
  net(4, 1) = 3;
  const CurvePlan sharp = planCurve(Curve(curve.knots(), net), {1, 1}, false);
  EXPECT_NE(sharp.held[3], 0);
}

// The upper, held half of a hairpin hangs down into a dent of the lower one.
TEST(ExactCurveFairing, AMoveThatMakesACurveCrossItselfIsTakenBack) {
  Net net(22, 2);
  net << 0, 0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 7, 0, 8, 0, 9, 0, 10, 1, 10, 2, 9, 1, 8, 0.3, 7, 0.2, 6, 0.2, 5, 0.2,
      4, 0.2, 3, 0.2, 2, 0.2, 1, 0.2, 0, 0.2;
  ExactCurveFairingOptions options;
  options.tolerance = 0.9;
  options.leaveFair = false;
  options.held.assign(22, 0);
  for (Index i = 0; i < 22; ++i) {
    const double r = net(i, 0) - 4;
    net(i, 1) -= i > 10 ? 0.6 * std::exp(-r * r / 4) : 0.8 * std::exp(-r * r / 2);
    if (i > 10 || i < 2) options.held[static_cast<std::size_t>(i)] = 1;
  }
  const Curve curve({KnotVector::uniformClamped(3, 19)}, net);
  ASSERT_EQ(findSelfIntersection(curve).answer, SelfMeeting::free);
  const auto refused = fairCurveExactly(curve, options);
  EXPECT_EQ(refused.summary.stopReason, StopReason::meetsItself);
  EXPECT_EQ(refused.spline, curve);
  EXPECT_EQ(refused.after.curvatureVariation, refused.before.curvatureVariation);
  // Less is possible.
  options.tolerance = 0.05;
  const auto result = fairCurveExactly(curve, options);
  EXPECT_EQ(findSelfIntersection(result.spline).answer, SelfMeeting::free);
  EXPECT_LT(result.after.curvatureVariation, result.before.curvatureVariation);
}

}  // namespace
}  // namespace strak
