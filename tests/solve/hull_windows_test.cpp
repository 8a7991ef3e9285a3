#include "strak/solve/hull_windows.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <random>

namespace strak {
namespace {

using Eigen::Index;

// A square net whose points are coupled with the eight around them: a membrane on springs, pulled at random; means of
// two neighbours in balls.
struct Membrane {
  Index side;
  std::shared_ptr<const BlockPattern> pattern;
  BlockMatrix matrix;
  Eigen::VectorXd linear;
  BallRows rows;

  Membrane(Index n, double radius, double spring = 0.2)
      : side(n), pattern(patternOf(n)), matrix(pattern), linear(3 * n * n) {
    std::mt19937 engine(4);
    std::uniform_real_distribution<double> number(-1, 1);
    for (double& value : linear) value = number(engine);
    const auto add = [&](int i, int j, double value) {
      for (int c : {0, 4, 8}) matrix.block(std::max(i, j), std::min(i, j))[c] += value;
    };
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j < n; ++j) {
        const int p = at(i, j);
        add(p, p, spring);
        for (const int q : {i + 1 < n ? at(i + 1, j) : -1, j + 1 < n ? at(i, j + 1) : -1}) {
          if (q < 0) continue;
          add(p, p, 1);
          add(q, q, 1);
          add(p, q, -1);
          rows.point.insert(rows.point.end(), {p, q});
          rows.weight.insert(rows.weight.end(), {0.5, 0.5});
          rows.start.push_back(static_cast<Index>(rows.point.size()));
          rows.radius.push_back(radius);
        }
      }
    }
  }
  int at(Index i, Index j) const { return static_cast<int>(i * side + j); }
  Eigen::MatrixX3d places() const {
    Eigen::MatrixX3d places(side * side, 3);
    for (Index i = 0; i < side; ++i) {
      for (Index j = 0; j < side; ++j) places.row(at(i, j)) << static_cast<double>(i), static_cast<double>(j), 0;
    }
    return places;
  }
  HullProblem problem() const { return {&matrix, linear, &rows}; }

  static std::shared_ptr<const BlockPattern> patternOf(Index n) {
    std::vector<std::vector<int>> cliques;
    for (Index i = 0; i + 1 < n; ++i) {
      for (Index j = 0; j + 1 < n; ++j) {
        const int p = static_cast<int>(i * n + j), m = static_cast<int>(n);
        cliques.push_back({p, p + 1, p + m, p + m + 1});
      }
    }
    return std::make_shared<const BlockPattern>(patternOfCliques(n * n, cliques));
  }
};

TEST(HullWindows, SweepsReachWhatOneFactorOfEverythingReaches) {
  for (const double radius : {0.3, 0.03, 1e6}) {
    const Membrane membrane(30, radius);
    const HullProblem problem = membrane.problem();
    NestedCholesky factor(membrane.pattern, membrane.places());
    Eigen::VectorXd whole = Eigen::VectorXd::Zero(3 * 900);
    ASSERT_TRUE(minimizeInHull(problem, factor, whole, {.accuracy = 1e-8}).solved);
    const double least = whole.dot(0.5 * membrane.matrix.times(whole) + membrane.linear);

    const HullWindows windows(membrane.pattern, membrane.places(), {.points = 100, .overlap = 2});
    EXPECT_GE(windows.windows(), 9);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(3 * 900);
    double last = 0;
    for (int k = 0; k < 8; ++k) {
      const HullResult result = windows.sweep(problem, x, {.accuracy = 1e-8});
      EXPECT_TRUE(result.solved);
      EXPECT_LE(problem.largestRatio(x), 1 + 2e-6);
      EXPECT_LE(result.value, last + 1e-6) << "a sweep makes nothing worse";
      last = result.value;
    }
    EXPECT_LT(last - least, 1e-4 * std::abs(least)) << radius;
  }
}

TEST(HullWindows, OneWindowIsTheWholeProblem) {
  const Membrane membrane(12, 0.1);
  NestedCholesky factor(membrane.pattern, membrane.places());
  Eigen::VectorXd x = Eigen::VectorXd::Zero(3 * 144), y = x;
  const HullWindows windows(membrane.pattern, membrane.places(), {.points = 1000});
  EXPECT_EQ(windows.windows(), 1);
  const HullResult one = windows.sweep(membrane.problem(), x), whole = minimizeInHull(membrane.problem(), factor, y);
  EXPECT_EQ(one.factors, whole.factors);
  EXPECT_LT((x - y).norm(), 1e-9 * y.norm());
}

TEST(HullWindows, OfSomePointsMoveTheseAndTheirOverlapOnly) {
  const Membrane membrane(20, 0.1);
  std::vector<int> some;
  for (Index i = 3; i < 8; ++i) {
    for (Index j = 3; j < 8; ++j) some.push_back(membrane.at(i, j));
  }
  const HullWindows windows(membrane.pattern, membrane.places(), {.points = 10, .overlap = 1}, some);
  EXPECT_GT(windows.windows(), 1);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(3 * 400);
  EXPECT_LT(windows.sweep(membrane.problem(), x).value, 0);
  for (Index i = 0; i < 20; ++i) {
    for (Index j = 0; j < 20; ++j) {
      const bool near = i >= 2 && i < 9 && j >= 2 && j < 9;
      EXPECT_EQ(x.segment<3>(3 * membrane.at(i, j)).isZero(0), !near) << i << ' ' << j;
    }
  }
}

TEST(HullWindows, TheNumberOfThreadsChangesNothing) {
  const Membrane membrane(40, 0.05);
  const HullWindows windows(membrane.pattern, membrane.places(), {.points = 60, .overlap = 1});
  Eigen::VectorXd x = Eigen::VectorXd::Zero(3 * 1600), y = x;
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    windows.sweep(membrane.problem(), x);
  }
  windows.sweep(membrane.problem(), y);
  EXPECT_EQ(x, y);
}

// Where a window's matrix is not positive definite, its points stay.
TEST(HullWindows, WhatCannotBeSolvedStays) {
  Membrane membrane(20, 0.1);
  for (int c : {0, 4, 8}) membrane.matrix.block(0, 0)[c] = -5;
  const HullWindows windows(membrane.pattern, membrane.places(), {.points = 60, .overlap = 1});
  Eigen::VectorXd x = Eigen::VectorXd::Zero(3 * 400);
  EXPECT_FALSE(windows.sweep(membrane.problem(), x).solved);
  EXPECT_TRUE(x.head<3>().isZero(0));
  EXPECT_FALSE(x.tail<3>().isZero(0));
  EXPECT_LE(membrane.problem().largestRatio(x), 1 + 1e-6);
}

}  // namespace
}  // namespace strak
