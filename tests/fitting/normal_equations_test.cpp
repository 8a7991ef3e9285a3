#include "strak/fitting/normal_equations.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <limits>
#include <random>

#include "strak/base/error.h"
#include "strak/spline/basis.h"
#include "strak/spline/evaluate.h"

namespace strak {
namespace {

std::array<KnotVector, 2> unevenKnots(int p, int q) {
  std::vector<double> u(static_cast<std::size_t>(p) + 1, -1.0), v(static_cast<std::size_t>(q) + 1, 2.0);
  for (double x : {-0.9, 0.1, 0.1, 0.7}) {
    if (p > 1 || x != 0.1 || u.back() != 0.1) u.push_back(x);
  }
  v.push_back(3.5);
  u.insert(u.end(), static_cast<std::size_t>(p) + 1, 1.0);
  v.insert(v.end(), static_cast<std::size_t>(q) + 1, 6.0);
  return {KnotVector(p, u), KnotVector(q, v)};
}

struct Cloud {
  Net parameters, values;
  Eigen::VectorXd weights;
};

Cloud randomCloud(const std::array<KnotVector, 2>& knots, Index count, Index columns) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  Cloud cloud{Net(count, 2), Net(count, columns), Eigen::VectorXd(count)};
  for (Index r = 0; r < count; ++r) {
    for (Index k = 0; k < 2; ++k) {
      const KnotVector& u = knots[static_cast<std::size_t>(k)];
      cloud.parameters(r, k) = std::lerp(u.from(), u.to(), unit(random));
    }
    for (Index c = 0; c < columns; ++c) cloud.values(r, c) = unit(random) - 0.3;
    cloud.weights[r] = unit(random);
  }
  // The ends and a knot belong to the domain.
  cloud.parameters.row(0) << knots[0].to(), knots[1].to();
  cloud.parameters.row(1) << 0.1, knots[1].from();
  return cloud;
}

Eigen::MatrixXd denseBasis(const std::array<KnotVector, 2>& knots, const Net& parameters) {
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(parameters.rows(), knots[0].size() * knots[1].size());
  for (Index r = 0; r < parameters.rows(); ++r) {
    const Index s = knots[0].findSpan(parameters(r, 0)), t = knots[1].findSpan(parameters(r, 1));
    const auto u = basisDerivatives(knots[0], s, parameters(r, 0), 0);
    const auto v = basisDerivatives(knots[1], t, parameters(r, 1), 0);
    for (int a = 0; a <= knots[0].degree(); ++a) {
      for (int b = 0; b <= knots[1].degree(); ++b) {
        basis(r, (s - knots[0].degree() + a) * knots[1].size() + t - knots[1].degree() + b) = u(0, a) * v(0, b);
      }
    }
  }
  return basis;
}

Eigen::MatrixXd dense(const NetMatrix& matrix) {
  Eigen::MatrixXd result(matrix.size(), matrix.size());
  for (Index c = 0; c < matrix.size(); ++c) {
    Net unit = Net::Zero(matrix.size(), 1);
    unit(c, 0) = 1;
    result.col(c) = matrix.times(unit);
  }
  return result;
}

TEST(NormalEquations, AreTheDenseOnesForManyDegrees) {
  for (const auto& [p, q] : std::vector<std::pair<int, int>>{{1, 1}, {2, 3}, {3, 3}, {5, 1}, {1, 4}, {7, 9}, {4, 11}}) {
    const auto knots = unevenKnots(p, q);
    const Cloud cloud = randomCloud(knots, 500, 3);
    NormalEquations<2> equations(knots, 3);
    equations.add({cloud.parameters, cloud.values, cloud.weights});
    const auto sums = equations.sums();
    const Eigen::MatrixXd basis = denseBasis(knots, cloud.parameters);
    const Eigen::MatrixXd matrix = basis.transpose() * cloud.weights.asDiagonal() * basis;
    const Eigen::MatrixXd right = basis.transpose() * cloud.weights.asDiagonal() * cloud.values;
    EXPECT_EQ(equations.count(), 500);
    EXPECT_NEAR(sums.weight, cloud.weights.sum(), 1e-10);
    EXPECT_NEAR(sums.squares, cloud.weights.dot(cloud.values.rowwise().squaredNorm()), 1e-10);
    EXPECT_LT((dense(sums.matrix) - matrix).norm(), 1e-13 * matrix.norm()) << p << ' ' << q;
    EXPECT_LT((sums.right - right).norm(), 1e-13 * right.norm()) << p << ' ' << q;
  }
}

TEST(NormalEquations, OfCurvesAreTheDenseOnes) {
  const KnotVector knots = unevenKnots(3, 1)[0];
  Net parameters(40, 1), values(40, 2);
  for (Index r = 0; r < 40; ++r) {
    parameters(r, 0) = -1 + static_cast<double>(r) / 20;
    values.row(r) << std::sin(parameters(r, 0)), 2.0;
  }
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(40, knots.size());
  for (Index r = 0; r < 40; ++r) {
    const Index s = knots.findSpan(parameters(r, 0));
    basis.row(r).segment(s - 3, 4) = basisDerivatives(knots, s, parameters(r, 0), 0);
  }
  NormalEquations<1> equations({knots}, 2);
  equations.add({parameters, values});
  const auto sums = equations.sums();
  EXPECT_LT((dense(sums.matrix) - basis.transpose() * basis).norm(), 1e-13 * 40);
  EXPECT_LT((sums.right - basis.transpose() * values).norm(), 1e-13 * 40);
}

TEST(NormalEquations, DoNotDependOnThreadsOrBlocks) {
  const auto knots = unevenKnots(3, 3);
  const Cloud cloud = randomCloud(knots, 300000, 1);
  const auto sumsOf = [&](std::size_t threads, Index block) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    NormalEquations<2> equations(knots, 1);
    for (Index begin = 0; begin < cloud.parameters.rows(); begin += block) {
      const Index count = std::min(block, cloud.parameters.rows() - begin);
      equations.add({cloud.parameters.middleRows(begin, count), cloud.values.middleRows(begin, count),
                     cloud.weights.segment(begin, count)});
    }
    return equations.sums();
  };
  const auto one = sumsOf(1, 300000), many = sumsOf(4, 300000), blocks = sumsOf(4, 1234);
  EXPECT_EQ(one.matrix.values, many.matrix.values);
  EXPECT_EQ(one.right, many.right);
  EXPECT_EQ(one.matrix.values, blocks.matrix.values);
  EXPECT_EQ(one.right, blocks.right);
}

TEST(NormalEquations, LeaveOutWhatLiesOutsideAndRefuseWhatIsNoNumber) {
  const auto knots = unevenKnots(2, 2);
  Net parameters(3, 2), values = Net::Ones(3, 1);
  parameters << 0, 3, 0, 7, 0.5, 2;
  NormalEquations<2> equations(knots, 1);
  equations.add({parameters, values});
  EXPECT_EQ(equations.count(), 2);
  EXPECT_EQ(equations.outside(), 1);
  EXPECT_NEAR(equations.sums().weight, 2, 1e-15);
  values(2, 0) = std::numeric_limits<double>::quiet_NaN();
  try {
    equations.add({parameters, values});
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_STREQ(error.what(), "point 6 has a coordinate that is not finite: correct or remove it");
  }
  values(2, 0) = 0;
  EXPECT_THROW(equations.add({parameters, values, Eigen::Vector3d(1, 1, -1)}), InvalidInput);
  EXPECT_THROW(equations.add({parameters, values, Eigen::Vector2d(1, 1)}), InvalidInput);
  parameters(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(equations.add({parameters, values}), InvalidInput);
}

TEST(FitErrors, AreTheDistancesAtTheParameters) {
  const auto knots = unevenKnots(3, 2);
  const Cloud cloud = randomCloud(knots, 400, 2);
  Net net(knots[0].size() * knots[1].size(), 2);
  for (Index r = 0; r < net.rows(); ++r) net.row(r) << std::cos(static_cast<double>(r)), static_cast<double>(r % 5);
  const Surface surface(knots, net);
  const Net residuals = cloud.values - derivativesAt<2>(surface, cloud.parameters, 0);
  const Eigen::VectorXd errors = residuals.rowwise().norm();
  const double tolerance = 1.5;
  FitErrors<2> sums(surface, tolerance);
  sums.add({cloud.parameters.topRows(150), cloud.values.topRows(150), cloud.weights.head(150)});
  sums.add({cloud.parameters.bottomRows(250), cloud.values.bottomRows(250), cloud.weights.tail(250)});
  Index worst = 0;
  EXPECT_NEAR(sums.max(), errors.maxCoeff(&worst), 1e-13);
  EXPECT_EQ(sums.worst().point, worst);
  EXPECT_EQ(sums.worst().parameters[1], cloud.parameters(worst, 1));
  EXPECT_EQ(sums.count(), 400);
  EXPECT_EQ(sums.outsideTolerance(), (errors.array() > tolerance).count());
  EXPECT_NEAR(sums.squares(), errors.cwiseAbs2().dot(cloud.weights), 1e-10);
  const Eigen::MatrixXd right =
      denseBasis(knots, cloud.parameters).transpose() * cloud.weights.asDiagonal() * residuals;
  EXPECT_LT((sums.right() - right).norm(), 1e-12 * right.norm());
}

}  // namespace
}  // namespace strak
