#include "strak/solve/tube_minimizer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace strak {
namespace {

using Eigen::Index;

TEST(PointMatrix, AddsBlocksOnBothSides) {
  PointMatrix matrix(3, 2, {{0, 2}, {1, 2}});
  Eigen::Matrix2d block;
  block << 1, 2, 3, 4;
  matrix.add(0, 2, block);
  Eigen::Matrix2d diagonal;
  diagonal << 5, 6, 6, 7;
  matrix.add(1, 1, diagonal);
  Eigen::VectorXd x(6);
  x << 1, 0, 0, 1, 0, 0;
  Eigen::VectorXd expected(6);
  expected << 0, 0, 6, 7, 1, 2;
  EXPECT_EQ(matrix.product(x), expected);
  x << 0, 0, 0, 0, 1, 1;
  expected << 3, 7, 0, 0, 0, 0;
  EXPECT_EQ(matrix.product(x), expected);
  EXPECT_EQ(matrix.meanDiagonal(), Eigen::Vector3d(0, 6, 0));
}

TEST(TubeMinimizer, OnePointGoesToItsBall) {
  PointMatrix h(1, 3, {{0}});
  h.add(0, 0, Eigen::Matrix3d::Identity());
  TubeMinimizer tube({{{0}, {1.0}}}, 2, h);
  Points g(1, 3);
  g << -6, 0, -8;
  const auto result = tube.minimize(h, g, Points::Zero(1, 3), 1e-10);
  ASSERT_TRUE(result.solved);
  EXPECT_NEAR((result.y - 2 * Eigen::RowVector3d(0.6, 0, 0.8)).norm(), 0, 1e-6);
  const auto inside = tube.minimize(h, 0.1 * g, Points::Zero(1, 3), 1e-10);
  EXPECT_NEAR((inside.y + 0.1 * g).norm(), 0, 1e-5);
}

// Optimal: no feasible point nearby is better, and the result is feasible.
TEST(TubeMinimizer, NothingFeasibleIsBetter) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  constexpr Index kPoints = 12;
  std::vector<TubeRow> rows;
  std::vector<std::vector<Index>> cliques;
  for (Index i = 0; i + 1 < kPoints; ++i) {
    rows.push_back({{i, i + 1}, {0.5, 0.5}});
    rows.push_back({{i}, {1.0}});
    cliques.push_back({i, i + 1});
  }
  rows.push_back({{kPoints - 1}, {1.0}});
  PointMatrix h(kPoints, 2, cliques);
  for (Index i = 0; i < kPoints; ++i) {
    h.add(i, i, (2.1 + 0.3 * static_cast<double>(i)) * Eigen::Matrix2d::Identity());
    if (i > 0) h.add(i, i - 1, -Eigen::Matrix2d::Identity());
  }
  const Points g = Points::NullaryExpr(kPoints, 2, [&] { return normal(random); });
  constexpr double kRadius = 0.2;
  TubeMinimizer tube(rows, kRadius, h);
  const auto result = tube.minimize(h, g, Points::Zero(kPoints, 2), 1e-11);
  ASSERT_TRUE(result.solved);
  EXPECT_LE(largestRow(rows, result.y), kRadius * (1 + 1e-12));
  EXPECT_LT(result.factorizations, 30);
  const auto value = [&](const Points& y) {
    const Eigen::VectorXd flat = Eigen::Map<const Eigen::VectorXd>(y.data(), y.size());
    return flat.dot(h.product(flat)) / 2 + g.cwiseProduct(y).sum();
  };
  const double best = value(result.y);
  for (int k = 0; k < 2000; ++k) {
    Points other =
        result.y + std::pow(10.0, -1 - k % 5) * Points::NullaryExpr(kPoints, 2, [&] { return normal(random); });
    other *= std::min(1.0, kRadius / largestRow(rows, other));
    EXPECT_GE(value(other), best - 1e-9);
  }
}

TEST(TubeMinimizer, WithoutRadiusItSolvesTheEquations) {
  PointMatrix h(2, 2, {{0, 1}});
  h.add(0, 0, 2 * Eigen::Matrix2d::Identity());
  h.add(1, 1, 3 * Eigen::Matrix2d::Identity());
  h.add(0, 1, Eigen::Matrix2d::Identity());
  TubeMinimizer tube({{{0}, {1.0}}}, std::numeric_limits<double>::infinity(), h);
  Points g(2, 2);
  g << 1, 2, 3, 4;
  const auto result = tube.minimize(h, g, Points::Ones(2, 2), 1e-8);
  Points expected(2, 2);
  expected << 0, -0.4, -1, -1.2;  // of H x = -g
  EXPECT_NEAR((result.y - Points::Ones(2, 2) - expected).norm(), 0, 1e-12);
}

}  // namespace
}  // namespace strak
