#include "strak/solve/hull_minimizer.h"

#include <gtest/gtest.h>

#include <random>

namespace strak {
namespace {

using Eigen::Index;

// A chain of points, each coupled with its neighbours; the stiffness of a beam in every coordinate.
struct Chain {
  std::shared_ptr<const BlockPattern> pattern;
  BlockMatrix matrix;
  NestedCholesky factor;
  Eigen::VectorXd linear;
  BallRows rows;

  explicit Chain(Index n, unsigned seed = 1)
      : pattern(patternOf(n)), matrix(pattern), factor(pattern, places(n)), linear(3 * n) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> number(-1, 1);
    for (Index i = 0; i < n; ++i) {
      const auto put = [&](Index row, Index column, double value) {
        for (int c : {0, 4, 8}) matrix.block(static_cast<int>(row), static_cast<int>(column))[c] = value;
      };
      put(i, i, 6.2);
      if (i > 0) put(i, i - 1, -4);
      if (i > 1) put(i, i - 2, 1);
      for (int c = 0; c < 3; ++c) linear[3 * i + c] = number(engine);
    }
  }
  // Means of two neighbours in balls.
  void addRows(double radius) {
    for (Index i = 0; i + 1 < pattern->size(); ++i) {
      rows.point.insert(rows.point.end(), {static_cast<int>(i), static_cast<int>(i + 1)});
      rows.weight.insert(rows.weight.end(), {0.25, 0.75});
      rows.start.push_back(static_cast<Index>(rows.point.size()));
      rows.radius.push_back(radius);
    }
  }
  double value(const Eigen::VectorXd& x) const { return x.dot(0.5 * matrix.times(x) + linear); }
  HullResult minimize(Eigen::VectorXd& x, double accuracy = 1e-8) {
    return minimizeInHull({&matrix, linear, &rows}, factor, x, {.accuracy = accuracy, .maxFactors = 60});
  }

  static std::shared_ptr<const BlockPattern> patternOf(Index n) {
    std::vector<std::vector<int>> cliques;
    for (int i = 0; i + 2 < n; ++i) cliques.push_back({i, i + 1, i + 2});
    return std::make_shared<const BlockPattern>(patternOfCliques(n, cliques));
  }
  static Eigen::MatrixX3d places(Index n) {
    Eigen::MatrixX3d p = Eigen::MatrixX3d::Zero(n, 3);
    for (Index i = 0; i < n; ++i) p(i, 0) = static_cast<double>(i);
    return p;
  }
};

TEST(HullMinimizer, OneBallHasAClosedForm) {
  Chain chain(1);
  chain.rows.point = {0};
  chain.rows.weight = {2};
  chain.rows.start = {0, 1};
  chain.rows.radius = {1e-3};
  Eigen::VectorXd x = Eigen::VectorXd::Zero(3);
  const HullResult result = chain.minimize(x, 1e-12);
  EXPECT_TRUE(result.solved);
  const Eigen::VectorXd expected = -0.5e-3 * chain.linear.normalized();
  EXPECT_LT((x - expected).norm(), 1e-7 * expected.norm());
}

TEST(HullMinimizer, FreeMinimumWhereNoBallIsInTheWay) {
  Chain chain(30);
  chain.addRows(1e9);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(90);
  const HullResult result = chain.minimize(x);
  EXPECT_TRUE(result.solved);
  EXPECT_EQ(result.factors, 1);
  EXPECT_LT((chain.matrix.times(x) + chain.linear).norm(), 1e-10);
}

TEST(HullMinimizer, WithoutRowsItSolvesTheEquations) {
  Chain chain(30);
  Eigen::VectorXd x = Eigen::VectorXd::Ones(90);
  const HullResult result = minimizeInHull({&chain.matrix, chain.linear, nullptr}, chain.factor, x);
  EXPECT_TRUE(result.solved);
  EXPECT_NEAR(result.value, chain.value(x), 1e-9);
  EXPECT_LT((chain.matrix.times(x) + chain.linear).norm(), 1e-10);
}

// Points of a plane, with a third coordinate on its own, stay in it to the bit.
TEST(HullMinimizer, ThePlaneStaysThePlane) {
  Chain chain(60, 2);
  chain.addRows(0.05);
  for (Index i = 0; i < 60; ++i) chain.linear[3 * i + 2] = 0;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(180);
  const HullResult result = chain.minimize(x);
  EXPECT_TRUE(result.solved);
  EXPECT_GT(result.factors, 1);
  EXPECT_GT(x.cwiseAbs().maxCoeff(), 0.01);
  for (Index i = 0; i < 60; ++i) EXPECT_EQ(x[3 * i + 2], 0);
}

// The first-order conditions, checked from outside: no feasible point that random search and projection of the gradient
// find is better than the stated gap allows.
TEST(HullMinimizer, NothingFeasibleIsBetter) {
  for (const double radius : {1.0, 0.1, 0.01}) {
    Chain chain(40, 7);
    chain.addRows(radius);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(120);
    const HullResult result = chain.minimize(x);
    ASSERT_TRUE(result.solved) << radius;
    EXPECT_LE(chain.rows.largestRatio(x), 1) << radius;
    EXPECT_NEAR(result.value, chain.value(x), 1e-9);
    EXPECT_LT(result.factors, 40);
    EXPECT_GT(chain.rows.largestRatio(x), 0.999) << "some ball is touched";
    std::mt19937 engine(3);
    std::normal_distribution<double> number;
    const double scale = x.norm();
    for (int k = 0; k < 2000; ++k) {
      Eigen::VectorXd y = x;
      for (double& c : y) c += std::pow(10, -(k % 6)) * scale / 10 * number(engine);
      const double ratio = chain.rows.largestRatio(y);
      if (ratio > 1) y /= ratio;
      EXPECT_GE(chain.value(y), result.value - 1e-7);
    }
  }
}

TEST(HullMinimizer, StartsAnywhereInside) {
  Chain chain(25, 5);
  chain.addRows(0.05);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(75), y = Eigen::VectorXd::Constant(75, 0.0288);
  ASSERT_LE(chain.rows.largestRatio(y), 1);
  EXPECT_TRUE(chain.minimize(x).solved);
  EXPECT_TRUE(chain.minimize(y).solved);
  EXPECT_LT((x - y).norm(), 1e-3 * x.norm());
}

// What an offset adds is what a point that is held would have given.
TEST(HullMinimizer, OffsetsStandForPointsThatAreHeld) {
  Chain all(40, 9);
  all.addRows(0.05);
  Eigen::VectorXd whole = Eigen::VectorXd::Zero(120);
  ASSERT_TRUE(all.minimize(whole).solved);
  // The first point held where the solution has it.
  const Eigen::Vector3d held = whole.head<3>();
  Chain rest(39);
  rest.rows = {};
  rest.addRows(0.05);
  rest.rows.start.insert(rest.rows.start.begin() + 1, 1);
  for (std::size_t i = 2; i < rest.rows.start.size(); ++i) ++rest.rows.start[i];
  rest.rows.point.insert(rest.rows.point.begin(), 0);
  rest.rows.weight.insert(rest.rows.weight.begin(), 0.75);
  rest.rows.radius.push_back(0.05);
  rest.linear = all.linear.tail(117);
  rest.linear.head<3>() += -4 * held;
  rest.linear.segment<3>(3) += held;
  Eigen::VectorXd offset = Eigen::VectorXd::Zero(3 * rest.rows.count());
  offset.head<3>() = 0.25 * held;
  Eigen::VectorXd x = 0.9 * whole.tail(117);
  const HullProblem problem{&rest.matrix, rest.linear, &rest.rows, &offset};
  const HullResult result = minimizeInHull(problem, rest.factor, x, {.accuracy = 1e-9});
  EXPECT_TRUE(result.solved);
  EXPECT_LE(problem.largestRatio(x), 1 + 1e-6);
  EXPECT_LT((x - whole.tail(117)).norm(), 1e-3 * whole.norm());
}

TEST(BallRows, AreDrawnInOneByOne) {
  Chain chain(40);
  chain.addRows(1);
  Eigen::VectorXd x = Eigen::VectorXd::Constant(120, 0.1);
  EXPECT_EQ(chain.rows.drawnIn(x), x);
  x.segment<3>(30) << 5, -3, 2;
  const Eigen::VectorXd inside = chain.rows.drawnIn(x);
  EXPECT_LE(chain.rows.largestRatio(inside), 1);
  EXPECT_GT(chain.rows.largestRatio(inside), 0.9);
  EXPECT_EQ(inside.tail(60), x.tail(60)) << "what is far away stays";
}

TEST(HullMinimizer, SaysWhatIsNotConvex) {
  Chain chain(10);
  chain.addRows(1);
  for (int c : {0, 4, 8}) chain.matrix.block(4, 4)[c] = -50;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(30);
  EXPECT_FALSE(chain.minimize(x).solved);
  EXPECT_TRUE(x.isZero(0));
}

}  // namespace
}  // namespace strak
