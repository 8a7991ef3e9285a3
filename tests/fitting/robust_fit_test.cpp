#include "strak/fitting/robust_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "strak/base/error.h"
#include "strak/energy/energy_operator.h"
#include "strak/spline/evaluate.h"
#include "tests/fitting/franke.h"

namespace strak {
namespace {

constexpr double kNoise = 0.02;

// 200 noisy points of a curve; five of them far off.
struct Measured {
  Net parameters{200, 1}, clean{200, 1}, dirty{200, 1};
};

Measured measured() {
  Measured result;
  std::mt19937_64 random(12);
  std::normal_distribution<double> noise(0, kNoise);
  for (Index r = 0; r < 200; ++r) {
    const double t = static_cast<double>(r) / 199;
    result.parameters(r, 0) = t;
    result.clean(r, 0) = std::sin(6 * t) + noise(random);
  }
  result.dirty = result.clean;
  for (Index r : {20, 61, 62, 130, 180}) result.dirty(r, 0) += r % 2 == 0 ? 3 : -5;
  return result;
}

double largestDifference(const Curve& a, const Curve& b) {
  double largest = 0;
  for (int k = 0; k <= 400; ++k) {
    largest = std::max(largest, std::abs((evaluate<1>(a, {k / 400.0}) - evaluate<1>(b, {k / 400.0}))[0]));
  }
  return largest;
}

TEST(RobustFit, FiveOutliersDoNotMoveItByMoreThanTheNoise) {
  const auto data = measured();
  const std::array<KnotVector, 1> knots{KnotVector::uniformClamped(3, 20)};
  for (const Loss loss : {Loss::absolute, Loss::huber, Loss::tukey}) {
    RobustFitOptions<1> options;
    options.loss = loss;
    const auto clean = fitRobustly<1>(knots, {data.parameters, data.clean}, options);
    const auto dirty = fitRobustly<1>(knots, {data.parameters, data.dirty}, options);
    EXPECT_LT(largestDifference(clean.fit.spline, dirty.fit.spline), kNoise) << static_cast<int>(loss);
    EXPECT_TRUE(dirty.converged);
    EXPECT_NEAR(dirty.scale, kNoise, 0.3 * kNoise);
    EXPECT_EQ(dirty.outliers, 5);
    EXPECT_EQ(clean.outliers, 0);
    EXPECT_LT(dirty.weights[61], 0.02);
  }
  // Least squares do not stand it.
  const auto clean = fitLeastSquares<1>(knots, {data.parameters, data.clean});
  const auto dirty = fitLeastSquares<1>(knots, {data.parameters, data.dirty});
  EXPECT_GT(largestDifference(clean.spline, dirty.spline), 5 * kNoise);
}

TEST(RobustFit, TheL1GapIsCertified) {
  const auto data = measured();
  const std::array<KnotVector, 1> knots{KnotVector::uniformClamped(3, 8)};
  RobustFitOptions<1> options;
  options.loss = Loss::absolute;
  options.scale = kNoise;
  options.gap = 1e-4;
  options.fit.smoothing = Smoothing::fixed(1e-6);
  const auto result = fitRobustly<1>(knots, {data.parameters, data.dirty}, options);
  ASSERT_TRUE(result.converged);
  EXPECT_LE(result.gap, 1e-4);
  const double lambda = result.lambda;
  const EnergyOperator<1> energy(thirdDerivatives<1>(), knots);
  const auto objective = [&](const Net& net) {
    const Net errors = derivativesAt<1>(Curve(knots, net), data.parameters, 0) - data.dirty;
    return 2 * kNoise * errors.cwiseAbs().mean() + lambda * energy.value(net);
  };
  EXPECT_NEAR(objective(result.fit.spline.net()), result.objective, 1e-9 * result.objective);
  // No net around it is better by more than the gap.
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0, 1);
  for (const double size : {1e-5, 1e-3, 1e-1}) {
    for (int i = 0; i < 50; ++i) {
      Net other = result.fit.spline.net();
      for (Index r = 0; r < other.rows(); ++r) other(r, 0) += size * normal(random);
      EXPECT_GE(objective(other), (1 - result.gap) * result.objective);
    }
  }
}

// The l1 fit of a constant is the median: known exactly.
TEST(RobustFit, TheL1FitOfAConstantIsTheMedian) {
  Net parameters(101, 1), values(101, 1);
  std::vector<double> sorted;
  std::mt19937_64 random(2);
  for (Index r = 0; r < 101; ++r) {
    parameters(r, 0) = static_cast<double>(r) / 100;
    values(r, 0) = static_cast<double>(random() >> 11) * 0x1p-53;
    values(r, 0) *= values(r, 0);
    sorted.push_back(values(r, 0));
  }
  std::nth_element(sorted.begin(), sorted.begin() + 50, sorted.end());
  RobustFitOptions<1> options;
  options.loss = Loss::absolute;
  options.gap = 1e-5;
  options.rounds = 500;
  options.fit.energy = {"gradient", {{1, {1}, {1}}}};
  options.fit.smoothing = Smoothing::fixed(1e3);  // stiff: only constants are left
  const auto result = fitRobustly<1>({KnotVector::uniformClamped(1, 1)}, {parameters, values}, options);
  EXPECT_NEAR(result.fit.spline.net()(0, 0), sorted[50], 2e-3);
  EXPECT_NEAR(result.fit.spline.net()(1, 0), sorted[50], 2e-3);
  EXPECT_GT(std::abs(values.mean() - sorted[50]), 0.05);
}

TEST(RobustFit, SurfacesInSpaceToo) {
  const Net points = test::frankePoints(4000);
  Net sheet = points;
  for (Index r = 0; r < 4000; r += 37) sheet(r, 2) += 2;
  const std::array<KnotVector, 2> knots{KnotVector::uniformClamped(3, 12), KnotVector::uniformClamped(3, 12)};
  RobustFitOptions<2> options;
  options.loss = Loss::tukey;
  const auto result = fitRobustly<2>(knots, {points.leftCols(2), sheet}, options);
  EXPECT_EQ(result.outliers, 109);
  EXPECT_LT(test::frankeError(Surface(knots, result.fit.spline.net().rightCols(1))), 4e-3);
}

TEST(RobustFit, RefusesNonsenseAndTakesExactPoints) {
  const Net points = test::frankePoints(300);
  const std::array<KnotVector, 2> knots{KnotVector::uniformClamped(3, 4), KnotVector::uniformClamped(3, 4)};
  RobustFitOptions<2> options;
  options.scale = -1;
  EXPECT_THROW(fitRobustly<2>(knots, {points.leftCols(2), points.rightCols(1)}, options), InvalidInput);
  EXPECT_THROW(lossNamed("l3"), InvalidInput);
  EXPECT_EQ(lossNamed("l1"), Loss::absolute);
  options.scale = 0;
  const Net zero = Net::Zero(300, 1);
  const auto exact = fitRobustly<2>(knots, {points.leftCols(2), zero}, options);
  EXPECT_TRUE(exact.converged);
  EXPECT_EQ(exact.fit.summary.max, 0);
}

}  // namespace
}  // namespace strak
