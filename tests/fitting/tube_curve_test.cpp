#include "strak/fitting/tube_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "strak/base/error.h"
#include "strak/metrology/closest_points.h"
#include "strak/spline/evaluate.h"

namespace strak {
namespace {

using Eigen::Vector2d;

constexpr double kFree = std::numeric_limits<double>::infinity();

// Points of a wavy circle whose distances differ by a factor of a thousand.
Net unevenRound(unsigned seed, Index count) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> exponent(-3, 0);
  Eigen::VectorXd steps(count);
  for (Index i = 0; i < count; ++i) steps[i] = std::pow(10, exponent(random));
  steps *= 2 * std::numbers::pi / steps.sum();
  Net points(count, 2);
  double angle = 0;
  for (Index i = 0; i < count; ++i) {
    const double radius = 1 + 0.1 * std::sin(5 * angle + seed);
    points.row(i) << radius * std::cos(angle), radius * std::sin(angle);
    angle += steps[i];
  }
  return points;
}

double largestError(const Curve& curve, const Net& points) {
  return closestPoints<1>(curve, points).distances.maxCoeff();
}

// The integral of the squared second derivative, by a sum: only for comparisons.
double bending(const Curve& curve) {
  constexpr int kSteps = 2000;
  double sum = 0;
  for (int i = 0; i <= kSteps; ++i) {
    sum += derivatives<1>(curve, {static_cast<double>(i) / kSteps}, 2).row(2).squaredNorm() / kSteps;
  }
  return sum;
}

Eigen::AlignedBox2d boxOf(const Net& points) {
  return {Vector2d(points.colwise().minCoeff()), Vector2d(points.colwise().maxCoeff())};
}

TEST(TubeCurve, UnevenPointsAreKeptWithinAnyTolerance) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Net points = unevenRound(seed, 60);
    for (double tolerance : {0.05, 0.002, 1e-4}) {
      const Curve round = tubeAround(points, {tolerance, kFree}, {});
      EXPECT_LE(largestError(round, points), tolerance) << seed;
      const Net between = points.middleRows(1, 40);
      const Vector2d from = points.row(0).transpose(), to = points.row(41).transpose();
      const Curve open = tubeBetween(from, between, to, {tolerance, kFree}, {});
      EXPECT_LE(largestError(open, between), tolerance) << seed;
      EXPECT_EQ(open.net().row(0), from.transpose());
      EXPECT_EQ(open.net().row(open.net().rows() - 1), to.transpose());
    }
  }
}

TEST(TubeCurve, APointOnTheDomainsBorderIsReachedFromWithin) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Net points = unevenRound(seed, 60);
    const Eigen::AlignedBox2d domain = boxOf(points);
    const Curve curve = tubeAround(points, {0.002, kFree}, domain);
    EXPECT_LE(largestError(curve, points), 0.002) << seed;
    for (Index i = 0; i < curve.net().rows(); ++i) {
      EXPECT_TRUE(domain.contains(Vector2d(curve.net().row(i).transpose()))) << seed;
    }
  }
}

TEST(TubeCurve, ClosesWithContinuousCurvature) {
  const Curve curve = tubeAround(unevenRound(3, 80), {0.001, kFree}, {});
  const Net begin = derivatives<1>(curve, {0}, 2), end = derivatives<1>(curve, {1}, 2);
  EXPECT_EQ(curve.net().row(0), curve.net().row(curve.net().rows() - 1));
  for (Index order = 0; order <= 2; ++order) {
    EXPECT_LT((begin.row(order) - end.row(order)).norm(), 1e-8 * begin.row(order).norm()) << order;
  }
}

TEST(TubeCurve, TheMoreIsAllowedTheFairer) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 0.01);
  Net points(99, 2);
  for (Index i = 0; i < 99; ++i) points.row(i) << 0.01 * static_cast<double>(i + 1), noise(random);
  double last = std::numeric_limits<double>::infinity();
  for (double tolerance : {0.001, 0.01, 0.02, 0.04}) {
    const Curve curve = tubeBetween({0, 0}, points, {1, 0}, {tolerance, kFree}, {});
    EXPECT_LE(largestError(curve, points), tolerance);
    EXPECT_LT(bending(curve), last / 2) << tolerance;
    last = bending(curve);
  }
  EXPECT_LT(last, 10);
}

// One point aside: the curve bends there, and is as straight as before elsewhere.
TEST(TubeCurve, WhatOnePointAsksForIsNotPaidElsewhere) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> noise(-0.004, 0.004);
  Net points(199, 2);
  for (Index i = 0; i < 199; ++i) points.row(i) << 0.005 * static_cast<double>(i + 1), noise(random);
  points(150, 1) = 0.03;
  const Curve curve = tubeBetween({0, 0}, points, {1, 0}, {0.005, kFree}, {});
  EXPECT_LE(largestError(curve, points), 0.005);
  double largest = 0;
  for (int i = 0; i <= 100; ++i) {
    largest = std::max(largest, std::abs(derivatives<1>(curve, {0.005 * i}, 2)(2, 1)));
  }
  EXPECT_LT(largest, 2);
}

TEST(TubeCurve, TheNoiseAloneMayDecide) {
  std::mt19937 random(9);
  std::normal_distribution<double> noise(0, 0.01);
  Net points(199, 2);
  for (Index i = 0; i < 199; ++i) points.row(i) << 0.005 * static_cast<double>(i + 1), noise(random);
  const Curve curve = tubeBetween({0, 0}, points, {1, 0}, {kFree, 0.012}, {});
  const Eigen::VectorXd errors = closestPoints<1>(curve, points).distances;
  EXPECT_LE(std::sqrt(errors.squaredNorm() / 199), 0.012);
  EXPECT_LT(bending(curve), 1);
  const Curve near = tubeBetween({0, 0}, points, {1, 0}, {kFree, 1e-5}, {});
  EXPECT_LE(std::sqrt(closestPoints<1>(near, points).distances.squaredNorm() / 199), 1e-5);
}

// A point beside the domain cannot be reached: the curve comes as near as it may.
TEST(TubeCurve, LimitsThatCannotBeKeptLeaveTheNearestCurve) {
  Net points(9, 2);
  for (Index i = 0; i < 9; ++i) points.row(i) << 0.1 * static_cast<double>(i + 1), i == 4 ? 0.5 : 0.1;
  const Curve curve = tubeBetween({0, 0}, points, {1, 0}, {0.001, kFree}, {Vector2d(0, 0), Vector2d(1, 0.3)});
  EXPECT_NEAR(largestError(curve, points), 0.2, 0.02);
  for (Index i = 0; i < curve.net().rows(); ++i) EXPECT_LE(curve.net()(i, 1), 0.3);
}

TEST(TubeCurve, NoPointsBetweenMakeALine) {
  const Curve line = tubeBetween({1, 2}, Net(0, 2), {4, 6}, {0.1, kFree}, {});
  EXPECT_NEAR((evaluate<1>(line, {0.5}) - Eigen::RowVector2d(2.5, 4)).norm(), 0, 1e-15);
}

}  // namespace
}  // namespace strak
