#include "strak/energy/curve_energy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "strak/base/error.h"

namespace strak {
namespace {

PointMap allFree(Index n) {
  PointMap map{n, {}};
  for (Index i = 0; i < n; ++i) map.rows.push_back({{i, 1.0}});
  return map;
}

Curve sample(int degree, Index spans, int dimension, bool rational, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  const KnotVector knots = KnotVector::uniformClamped(degree, spans, 0, 2);
  Net net(knots.size(), dimension + (rational ? 1 : 0));
  for (Index i = 0; i < net.rows(); ++i) {
    const double u = knots.greville()[static_cast<std::size_t>(i)];
    const double x[3] = {u, u * u / 2, std::sin(2 * u)};
    const double w = rational ? 1 + noise(random) : 1;
    for (Index c = 0; c < dimension; ++c) net(i, c) = w * (x[c] + noise(random));
    if (rational) net(i, dimension) = w;
  }
  return {{knots}, net, rational};
}

double total(const CurveEnergyValues& v, const CurveEnergyValues& w) {
  return w.bending * v.bending + w.variation * v.variation + w.sliding * v.sliding + w.wrongWay * v.wrongWay;
}

TEST(CurveEnergy, OfACircle) {
  const double w = std::sqrt(0.5), r = 2.5;
  Net net(9, 3);
  net << r, 0, 1, r * w, r * w, w, 0, r, 1, -r * w, r * w, w, -r, 0, 1, -r * w, -r * w, w, 0, -r, 1, r * w, -r * w, w,
      r, 0, 1;
  const Curve circle({KnotVector(2, {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4})}, net, true);
  const CurveEnergy energy(circle, allFree(9), false);
  const auto values = energy.values(Eigen::VectorXd::Zero(27));
  EXPECT_NEAR(energy.length(), 2 * std::numbers::pi * r, 1e-4);
  EXPECT_NEAR(values.bending, 2 * std::numbers::pi / r, 1e-4);
  EXPECT_NEAR(values.variation, 0, 1e-20);
  EXPECT_NEAR(values.sliding, 0, 1e-25);
}

// The gradient is that of the values, in the plane and in space, polynomial and rational, with jumps of curvature.
TEST(CurveEnergy, GradientFitsTheValues) {
  for (const int dimension : {2, 3}) {
    for (const bool rational : {false, true}) {
      for (const int degree : {2, 3, 4}) {
        const Curve curve = sample(degree, 6, dimension, rational, 3);
        const Index n = curve.net().rows();
        CurveEnergy energy(curve, allFree(n), false);
        std::vector<int> signs(energy.parameters().size());
        for (std::size_t i = 0; i < signs.size(); ++i) signs[i] = static_cast<int>(i % 3) - 1;
        energy.prescribe(signs);
        std::mt19937 random(11);
        std::uniform_real_distribution<double> uniform(-0.02, 0.02);
        const Eigen::VectorXd y = Eigen::VectorXd::NullaryExpr(3 * n, [&] { return uniform(random); });
        const CurveEnergyValues weights{0.7, 0.01, 1.3, 0.4};
        BlockMatrix h(std::make_shared<const BlockPattern>(patternOfCliques(n, energy.cliques())));
        Eigen::VectorXd gradient;
        energy.linearize(y, weights, h, gradient);
        for (int k = 0; k < 5; ++k) {
          const Eigen::VectorXd direction = Eigen::VectorXd::NullaryExpr(3 * n, [&] { return 50 * uniform(random); });
          constexpr double kStep = 1e-5;
          const double difference = (total(energy.values(y + kStep * direction), weights) -
                                     total(energy.values(y - kStep * direction), weights)) /
                                    (2 * kStep);
          const double slope = gradient.dot(direction);
          EXPECT_NEAR(slope, difference, 1e-5 * (std::abs(difference) + gradient.norm()));
          EXPECT_GE(direction.dot(h.times(direction)), 0);
        }
      }
    }
  }
}

// In the plane nothing couples the third coordinates with anything.
TEST(CurveEnergy, LeavesTheThirdCoordinateOfThePlaneAlone) {
  const Curve curve = sample(3, 6, 2, false, 5);
  const auto n = static_cast<int>(curve.net().rows());
  const CurveEnergy energy(curve, allFree(n), false);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(3 * n), lifted = y;
  for (int i = 0; i < n; ++i) lifted[3 * i + 2] = 0.1 * i;
  EXPECT_EQ(energy.values(lifted).variation, energy.values(y).variation);
  BlockMatrix h(std::make_shared<const BlockPattern>(patternOfCliques(n, energy.cliques())));
  Eigen::VectorXd gradient;
  energy.linearize(lifted, {1, 1, 1, 0}, h, gradient);
  const Eigen::VectorXd diagonal = h.pointDiagonal();
  const Eigen::VectorXd product = h.times(lifted);
  for (int i = 0; i < n; ++i) {
    EXPECT_EQ(gradient[3 * i + 2], 0);
    EXPECT_GT(diagonal[i], 0);
    EXPECT_EQ(product[3 * i], 0);
    EXPECT_EQ(product[3 * i + 1], 0);
    EXPECT_NEAR(product[3 * i + 2], diagonal[i] * lifted[3 * i + 2], 1e-12 * diagonal[i]);
  }
}

TEST(CurveEnergy, RefusesLinesOfDegreeOneAndFourDimensions) {
  EXPECT_THROW(CurveEnergy(sample(1, 6, 2, false, 1), allFree(7), false), InvalidInput);
  EXPECT_THROW(CurveEnergy(Curve({KnotVector::uniformClamped(3, 2)}, Net::Random(5, 4)), allFree(5), false),
               InvalidInput);
}

}  // namespace
}  // namespace strak
