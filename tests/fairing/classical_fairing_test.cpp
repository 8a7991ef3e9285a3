#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "strak/base/error.h"
#include "strak/energy/gram.h"
#include "strak/fairing/eck_hadenfeld.h"
#include "strak/fairing/farin_sapidis.h"
#include "strak/fairing/kjellander.h"
#include "strak/metrology/deviation.h"
#include "strak/spline/evaluate.h"

namespace strak {
namespace {

Curve noisy(Index n, double noise, int dimension = 2, int degree = 3) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-noise, noise);
  std::vector<double> knots(static_cast<std::size_t>(degree), 0);
  for (Index i = 0; i <= n - degree; ++i)
    knots.push_back(static_cast<double>(i) + 0.2 * std::sin(static_cast<double>(i)));
  knots.insert(knots.end(), static_cast<std::size_t>(degree), knots.back());
  const KnotVector k(degree, knots);
  const auto greville = k.greville();
  Net net(n, dimension);
  for (Index i = 0; i < n; ++i) {
    const double u = greville[static_cast<std::size_t>(i)];
    const double x[3] = {u, 3 * std::sin(0.3 * u), std::cos(0.2 * u)};
    for (Index c = 0; c < dimension; ++c) net(i, c) = x[c] + (i > 2 && i < n - 3 ? uniform(random) : 0);
  }
  return {{k}, net};
}

HeldPoints ends(const Curve& curve, Index rows) { return holdStrips<1>(curve, {rows, rows}); }

// Without a tolerance one point after the other leads to the minimum of the whole energy.
TEST(EckHadenfeld, ConvergesToTheMinimum) {
  for (const int derivative : {2, 3}) {
    const Curve curve = noisy(14, 0.3, 3, 4);
    EckHadenfeldOptions options;
    options.derivative = derivative;
    options.held = ends(curve, derivative);
    options.maxSteps = 2'000'000;
    options.gain = 1e-17;
    const auto faired = fairByEckHadenfeld(curve, options);
    EXPECT_EQ(faired.summary.stopReason, StopReason::gain);
    const Eigen::MatrixXd gram = gramMatrix(curve.knots(0), derivative, derivative).dense();
    const Index first = derivative, count = 14 - 2 * derivative;
    Net expected = curve.net();
    Net fixed = curve.net();
    fixed.middleRows(first, count).setZero();
    expected.middleRows(first, count) =
        -gram.block(first, first, count, count).partialPivLu().solve((gram * fixed).middleRows(first, count));
    EXPECT_LE((faired.spline.net() - expected).cwiseAbs().maxCoeff(), 1e-4);
    EXPECT_NEAR(faired.summary.energyAfter, (gram * expected).cwiseProduct(expected).sum(),
                1e-9 * faired.summary.energyBefore);
  }
}

// On uniform knots the target of a cubic's point is 9/16 of its neighbours, 0 of the next and -1/16 of the third.
TEST(EckHadenfeld, FirstStepHasTheClosedForm) {
  Curve curve({KnotVector::uniformClamped(3, 20)}, Net::Zero(23, 2));
  for (Index i = 0; i < 23; ++i) curve.net().row(i) << static_cast<double>(i), 0;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (Index i = 8; i < 15; ++i) curve.net()(i, 1) = uniform(random);
  HeldPoints held(23, 1);
  held[11] = 0;
  EckHadenfeldOptions options;
  options.held = held;
  const auto faired = fairByEckHadenfeld(curve, options);
  EXPECT_EQ(faired.summary.steps, 1);
  const Net& d = curve.net();
  const Point target = 9.0 / 16 * (d.row(10) + d.row(12)) - 1.0 / 16 * (d.row(8) + d.row(14));
  EXPECT_LE((faired.spline.net().row(11) - target).norm(), 1e-12);
}

// Taking the knot out and putting it back makes the curve C3 there.
TEST(FarinSapidis, OneStepMakesOneKnotSmoother) {
  const Curve curve = noisy(12, 0.3);
  CubicFairingOptions options;
  options.maxSteps = 1;
  const auto faired = fairByKnotRemoval(curve, options);
  ASSERT_EQ(faired.summary.steps, 1);
  int moved = 0, smooth = 0;
  for (Index i = 0; i < 12; ++i) moved += faired.spline.net().row(i) != curve.net().row(i) ? 1 : 0;
  for (const auto& knot : curve.knots(0).innerKnots()) {
    const Net left = derivatives<1>(faired.spline, {knot.value - 1e-9}, 3);
    const Net right = derivatives<1>(faired.spline, {knot.value + 1e-9}, 3);
    smooth += (left.row(3) - right.row(3)).norm() < 1e-6 ? 1 : 0;
  }
  EXPECT_EQ(moved, 1);
  EXPECT_EQ(smooth, 1);
}

TEST(FarinDegreeReduction, AParabolaIsLeftAloneAndNoiseFalls) {
  Curve parabola = noisy(12, 0);
  const auto greville = parabola.knots(0).greville();
  const auto& u = parabola.knots(0);
  for (Index i = 0; i < 12; ++i) {
    // The control points of x^2 are the mean products of the knots.
    const double square = (u[i + 1] * u[i + 2] + u[i + 2] * u[i + 3] + u[i + 1] * u[i + 3]) / 3;
    parabola.net().row(i) << greville[static_cast<std::size_t>(i)], square;
  }
  const auto same = fairByDegreeReduction(parabola);
  EXPECT_LE((same.spline.net() - parabola.net()).cwiseAbs().maxCoeff(), 1e-9);
  const Curve curve = noisy(40, 0.1);
  const auto faired = fairByDegreeReduction(curve);
  EXPECT_LT(faired.summary.energyAfter, 0.2 * faired.summary.energyBefore);
}

TEST(ClassicalMethods, KeepToleranceAndHeldPoints) {
  for (const int dimension : {2, 3}) {
    const Curve curve = noisy(40, 0.1, dimension);
    for (const double tolerance : {0.01, 0.1, kUnlimited}) {
      CubicFairingOptions cubic;
      cubic.tolerance = tolerance;
      cubic.held = ends(curve, 3);
      EckHadenfeldOptions eck;
      eck.tolerance = tolerance;
      eck.held = cubic.held;
      KjellanderOptions kjellander;
      kjellander.tolerance = tolerance;
      kjellander.held = cubic.held;
      for (const auto& faired : {fairByKnotRemoval(curve, cubic), fairByDegreeReduction(curve, cubic),
                                 fairByEckHadenfeld(curve, eck), fairByKjellander<1>(curve, kjellander)}) {
        EXPECT_GT(faired.summary.steps, 0);
        EXPECT_LT(faired.summary.energyAfter, faired.summary.energyBefore);
        EXPECT_LE(certifyDeviation(curve, faired.spline).upper, tolerance * (1 + 1e-9));
        for (const Index i : {0, 1, 2, 37, 38, 39}) EXPECT_EQ(faired.spline.net().row(i), curve.net().row(i));
      }
    }
  }
}

// The moved point lies on the Hermite cubic of its neighbours; all other points at knots stay.
TEST(Kjellander, OneStepMovesOneKnotPoint) {
  const Curve curve = noisy(14, 0.2);
  KjellanderOptions options;
  options.maxSteps = 1;
  const auto faired = fairByKjellander<1>(curve, options);
  const auto spans = curve.knots(0).spans();
  std::vector<double> at;
  for (const Index s : spans) at.push_back(curve.knots(0)[s]);
  at.push_back(curve.knots(0).to());
  int moved = 0;
  for (std::size_t i = 1; i + 1 < at.size(); ++i) {
    const Point now = evaluate(faired.spline, {at[i]});
    if ((now - evaluate(curve, {at[i]})).norm() < 1e-9) continue;
    ++moved;
    const Net a = derivatives<1>(curve, {at[i - 1]}, 1), b = derivatives<1>(curve, {at[i + 1]}, 1);
    const double h = at[i + 1] - at[i - 1], t = (at[i] - at[i - 1]) / h;
    const Point hermite = (1 + 2 * t) * (1 - t) * (1 - t) * a.row(0) + t * t * (3 - 2 * t) * b.row(0) +
                          h * t * (1 - t) * (1 - t) * a.row(1) - h * t * t * (1 - t) * b.row(1);
    EXPECT_LE((now - hermite).norm(), 1e-9);
  }
  EXPECT_EQ(moved, 1);
}

TEST(Kjellander, SmoothsSurfaces) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> uniform(-0.05, 0.05);
  const KnotVector u = KnotVector::uniformClamped(3, 9, 0, 9), v = KnotVector::uniformClamped(3, 7, 0, 7);
  Net net(120, 3);
  for (Index i = 0; i < 12; ++i) {
    for (Index j = 0; j < 10; ++j) {
      const double x = u.greville()[static_cast<std::size_t>(i)], y = v.greville()[static_cast<std::size_t>(j)];
      const bool inner = i > 1 && i < 10 && j > 1 && j < 8;
      net.row(i * 10 + j) << x, y, 0.02 * x * y + (inner ? uniform(random) : 0);
    }
  }
  const Surface surface({u, v}, net);
  KjellanderOptions options;
  options.tolerance = 0.05;
  options.held = holdStrips<2>(surface, {2, 2, 2, 2});
  const auto faired = fairByKjellander<2>(surface, options);
  EXPECT_LT(faired.summary.energyAfter, 0.5 * faired.summary.energyBefore);
  EXPECT_LE(certifyDeviation(surface, faired.spline).upper, 0.05);
  for (Index r = 0; r < 120; ++r) {
    if (options.held[static_cast<std::size_t>(r)] == 0) continue;
    EXPECT_EQ(faired.spline.net().row(r), net.row(r));
  }
}

TEST(ClassicalMethods, RefuseWhatTheyAreNotFor) {
  const Curve quartic = noisy(14, 0.1, 2, 4), cubic = noisy(14, 0.1);
  EXPECT_THROW(fairByKnotRemoval(quartic), InvalidInput);
  EXPECT_THROW(fairByDegreeReduction(quartic), InvalidInput);
  EXPECT_THROW(fairByKjellander<1>(quartic), InvalidInput);
  Net weighted(14, 3);
  weighted << cubic.net(), Eigen::VectorXd::Ones(14);
  EXPECT_THROW(fairByEckHadenfeld(Curve(cubic.knots(), weighted, true)), InvalidInput);
  EckHadenfeldOptions fourth;
  fourth.derivative = 4;
  EXPECT_THROW(fairByEckHadenfeld(cubic, fourth), InvalidInput);
  CubicFairingOptions options;
  options.held = {1, 1};
  EXPECT_THROW(fairByKnotRemoval(cubic, options), InvalidInput);
  options = {};
  options.tolerance = -1;
  EXPECT_THROW(fairByDegreeReduction(cubic, options), InvalidInput);
}

}  // namespace
}  // namespace strak
