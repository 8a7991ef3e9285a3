#include "strak/spline/evaluate.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "strak/base/error.h"
#include "strak/spline/basis.h"
#include "strak/spline/evaluator.h"
#include "tests/spline/random_splines.h"

namespace strak {
namespace {

using strak::testing::Random;

template <class T>
class EvaluateIn : public ::testing::Test {};

template <int D>
struct Directions {
  static constexpr int kCount = D;
};
using AllDirections = ::testing::Types<Directions<1>, Directions<2>, Directions<3>>;
TYPED_TEST_SUITE(EvaluateIn, AllDirections);

double distance(const Net& a, const Net& b) { return (a - b).cwiseAbs().maxCoeff(); }

// A row of a batch as a matrix like that of derivatives().
Net unfolded(const Net& batch, Index row, Index columns) {
  return Eigen::Map<const Net>(batch.data() + row * batch.cols(), batch.cols() / columns, columns);
}

// d/du of a polynomial spline, by differences of its control points.
template <int D>
Spline<D> differentiated(const Spline<D>& spline, int direction) {
  const KnotVector& old = spline.knots(direction);
  const int p = old.degree();
  auto knots = spline.knots();
  auto& lower = knots[static_cast<std::size_t>(direction)];
  lower = KnotVector(p - 1, {old.knots().begin() + 1, old.knots().end() - 1});
  auto sizes = spline.sizes();
  --sizes[static_cast<std::size_t>(direction)];
  Index rows = 1;
  for (const Index size : sizes) rows *= size;
  Net net(rows, spline.net().cols());
  typename Spline<D>::Sizes at{};
  for (Index r = 0; r < rows; ++r) {
    auto next = at;
    const Index i = ++next[static_cast<std::size_t>(direction)];
    const double length = old[i + p] - old[i];
    net.row(r).setZero();
    if (length > 0) net.row(r) = p / length * (spline.net().row(spline.row(next)) - spline.net().row(spline.row(at)));
    for (std::size_t k = D; k-- > 0;) {
      if (++at[k] < sizes[k]) break;
      at[k] = 0;
    }
  }
  return {std::move(knots), std::move(net), false};
}

TYPED_TEST(EvaluateIn, DerivativesAreTheValuesOfDifferentiatedSplines) {
  constexpr int D = TypeParam::kCount;
  Random random(31);
  for (int trial = 0; trial < (D == 3 ? 15 : 60); ++trial) {
    std::array<KnotVector, D> knots;
    for (auto& direction : knots) {
      const int degree = random.integer(3, 6);
      // Single inner knots, so that three differentiations leave a valid knot vector.
      constexpr testing::KnotKind kKinds[] = {testing::KnotKind::uniformClamped, testing::KnotKind::nonUniform,
                                              testing::KnotKind::unclamped};
      direction = testing::randomKnots(random, kKinds[random.integer(0, 2)], degree, random.integer(1, 4));
    }
    const auto spline = testing::randomSpline<D>(random, knots, random.integer(1, 5), false);
    const auto u = testing::innerParameter(random, spline);
    const Net all = derivatives(spline, u, 3);
    const auto orders = partialOrders<D>(3);
    for (std::size_t r = 0; r < orders.size(); ++r) {
      Spline<D> lower = spline;
      for (int k = 0; k < D; ++k) {
        for (int times = 0; times < orders[r][static_cast<std::size_t>(k)]; ++times) lower = differentiated(lower, k);
      }
      const Point expected = evaluate(lower, u);
      const double scale = 1 + lower.net().cwiseAbs().maxCoeff();
      ASSERT_LT((all.row(static_cast<Index>(r)) - expected).cwiseAbs().maxCoeff(), 1e-12 * scale);
    }
  }
}

TYPED_TEST(EvaluateIn, AllRoutesAgree) {
  constexpr int D = TypeParam::kCount;
  Random random(32);
  for (int trial = 0; trial < (D == 3 ? 40 : 150); ++trial) {
    const auto spline = testing::randomSpline<D>(random, D == 3 ? 5 : 11);
    const int order = random.integer(0, 3);
    const Evaluator<D> evaluator(spline);
    typename Spline<D>::Grid parameters;
    Index rows = 1;
    for (int k = 0; k < D; ++k) {
      auto& values = parameters[static_cast<std::size_t>(k)];
      const int count = random.integer(1, 6);
      for (int i = 0; i < count; ++i) values.push_back(testing::randomParameter(random, spline.knots(k)));
      rows *= count;
    }
    const Net grid = evaluator.derivativesOnGrid(parameters, order);
    ASSERT_EQ(grid.rows(), rows);
    Net list(rows, D);
    for (Index r = 0; r < rows; ++r) {
      Index rest = r;
      for (int k = D - 1; k >= 0; --k) {
        const auto& values = parameters[static_cast<std::size_t>(k)];
        const auto count = static_cast<Index>(values.size());
        list(r, k) = values[static_cast<std::size_t>(rest % count)];
        rest /= count;
      }
    }
    const Net batch = evaluator.derivativesAt(list, order);
    const Net free = derivativesAt(spline, list, order);
    const Net freeGrid = derivativesOnGrid(spline, parameters, order);
    ASSERT_EQ(grid, freeGrid);
    for (Index r = 0; r < rows; ++r) {
      typename Spline<D>::Parameter u;
      for (int k = 0; k < D; ++k) u[static_cast<std::size_t>(k)] = list(r, k);
      const Net expected = derivatives(spline, u, order);
      const Index columns = spline.pointDimension();
      Net single(expected.rows(), columns);
      evaluator.derivatives(u, order, single.data());
      // Each order by its own size: third derivatives may be thousands of times the points.
      const auto orders = partialOrders<D>(order);
      for (const auto* result : {&grid, &batch, &free}) {
        const Net other = unfolded(*result, r, columns);
        ASSERT_LT(distance(other, expected), 1e-12 * (1 + expected.cwiseAbs().maxCoeff()));
        ASSERT_LT((other.row(0) - expected.row(0)).cwiseAbs().maxCoeff(), 1e-13);
      }
      ASSERT_EQ(orders.size(), static_cast<std::size_t>(expected.rows()));
      ASSERT_LT(distance(single, unfolded(batch, r, columns)), 1e-15 * (1 + expected.cwiseAbs().maxCoeff()));
      ASSERT_LT((evaluate(spline, u) - expected.row(0)).cwiseAbs().maxCoeff(), 1e-15 * 8);
    }
  }
}

TYPED_TEST(EvaluateIn, ThreadsDoNotChangeABit) {
  constexpr int D = TypeParam::kCount;
  Random random(33);
  for (const bool rational : {false, true}) {
    std::array<KnotVector, D> knots;
    for (auto& direction : knots) direction = KnotVector::uniformClamped(3, 6);
    const auto spline = testing::randomSpline<D>(random, knots, 3, rational);
    Net list(5000, D);
    for (Index r = 0; r < list.size(); ++r) list.data()[r] = random.uniform();
    typename Spline<D>::Grid parameters;
    for (auto& values : parameters) {
      for (int i = 0; i < (D == 1 ? 3000 : D == 2 ? 70 : 17); ++i) values.push_back(random.uniform());
    }
    std::vector<Net> batches, grids;
    for (const std::size_t threads : {1U, 2U, 5U}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      batches.push_back(derivativesAt(spline, list, 2));
      grids.push_back(derivativesOnGrid(spline, parameters, 2));
    }
    EXPECT_EQ(batches[0], batches[1]);
    EXPECT_EQ(batches[0], batches[2]);
    EXPECT_EQ(grids[0], grids[1]);
    EXPECT_EQ(grids[0], grids[2]);
  }
}

TYPED_TEST(EvaluateIn, RationalDerivativesAgreeWithDifferenceQuotients) {
  constexpr int D = TypeParam::kCount;
  Random random(34);
  for (int trial = 0; trial < 20; ++trial) {
    std::array<KnotVector, D> knots;
    for (auto& direction : knots) direction = KnotVector::uniformClamped(random.integer(2, 4), 2, 0, 2);
    const auto spline = testing::randomSpline<D>(random, knots, 3, true);
    const auto u = testing::innerParameter(random, spline);
    const Net all = derivatives(spline, u, 3);
    const auto orders = partialOrders<D>(3);
    for (std::size_t r = 1; r < orders.size(); ++r) {
      // One derivative less, differentiated numerically.
      auto lower = orders[r];
      std::size_t k = 0;
      while (lower[k] == 0) ++k;
      --lower[k];
      const auto row = static_cast<Index>(std::find(orders.begin(), orders.end(), lower) - orders.begin());
      constexpr double h = 1e-3;
      const auto at = [&](double step) -> Point {
        auto moved = u;
        moved[k] += step;
        return derivatives(spline, moved, 3).row(row);
      };
      const Point quotient = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
      ASSERT_LT((quotient - all.row(static_cast<Index>(r))).norm(), 1e-6 * (1 + all.norm())) << "derivative " << r;
    }
  }
}

TYPED_TEST(EvaluateIn, GrevilleAbscissaeReproduceTheParameter) {
  constexpr int D = TypeParam::kCount;
  Random random(35);
  for (int trial = 0; trial < 40; ++trial) {
    std::array<KnotVector, D> knots;
    for (auto& direction : knots) {
      const auto kind = testing::kKnotKinds[random.integer(0, 5)];
      direction = testing::randomKnots(random, kind, random.integer(1, 6), random.integer(1, 4));
    }
    auto spline = testing::randomSpline<D>(random, knots, D, false);
    typename Spline<D>::Sizes at{};
    Net net = spline.net();
    for (Index r = 0; r < net.rows(); ++r) {
      for (std::size_t k = 0; k < D; ++k)
        net(r, static_cast<Index>(k)) = knots[k].greville()[static_cast<std::size_t>(at[k])];
      for (std::size_t k = D; k-- > 0;) {
        if (++at[k] < knots[k].size()) break;
        at[k] = 0;
      }
    }
    spline = Spline<D>(knots, net);
    const auto u = testing::randomParameter(random, spline);
    const Net result = derivatives(spline, u, 2);
    for (int k = 0; k < D; ++k) {
      ASSERT_NEAR(result(0, k), u[static_cast<std::size_t>(k)], 1e-13);
      for (int j = 0; j < D; ++j) ASSERT_NEAR(result(1 + j, k), j == k ? 1 : 0, 1e-12);
    }
    ASSERT_LT(result.bottomRows(result.rows() - 1 - D).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TYPED_TEST(EvaluateIn, RefusesOtherOrdersAndShapes) {
  constexpr int D = TypeParam::kCount;
  Random random(36);
  const auto spline = testing::randomSpline<D>(random, 3);
  const Evaluator<D> evaluator(spline);
  const auto u = testing::randomParameter(random, spline);
  for (const int order : {-1, 4}) {
    EXPECT_THROW(derivatives(spline, u, order), InvalidInput);
    EXPECT_THROW(derivativesAt(spline, Net::Zero(2, D), order), InvalidInput);
    EXPECT_THROW(derivativesAt(spline, Net::Zero(2000, D), order), InvalidInput);
    EXPECT_THROW(derivativesOnGrid(spline, {}, order), InvalidInput);
  }
  EXPECT_THROW(derivativesAt(spline, Net::Zero(2, D + 1), 1), InvalidInput);
  Net out(3, 1);
  EXPECT_THROW(evaluator.derivativesAt(Net::Zero(2, D), 1, out), InvalidInput);
  EXPECT_EQ(derivativesAt(spline, Net::Zero(0, D), 1).rows(), 0);
  EXPECT_EQ(derivativesOnGrid(spline, {}, 1).rows(), 0);
}

TYPED_TEST(EvaluateIn, NotANumberStaysNotANumber) {
  constexpr int D = TypeParam::kCount;
  std::array<KnotVector, D> knots;
  for (auto& direction : knots) direction = KnotVector::uniformClamped(3, 4);
  Random random(37);
  const auto spline = testing::randomSpline<D>(random, knots, 3, false);
  const Net list = Net::Constant(1000, D, std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(derivativesAt(spline, list, 2).array().isNaN().all());
  EXPECT_TRUE(derivativesAt(spline, list.topRows(1), 0).array().isNaN().all());
}

TEST(Evaluate, QuarterCircleIsExact) {
  Net net(3, 3);
  const double half = std::numbers::sqrt2 / 2;
  net << 1, 0, 1, half, half, half, 0, 1, 1;
  const Curve circle({KnotVector::uniformClamped(2, 1)}, net, true);
  for (int i = 0; i <= 20; ++i) {
    const Net x = derivatives(circle, {i / 20.0}, 3);
    EXPECT_NEAR(x.row(0).norm(), 1, 1e-15 * 4);
    const double speed = x.row(1).norm();
    EXPECT_NEAR((x(1, 0) * x(2, 1) - x(1, 1) * x(2, 0)) / (speed * speed * speed), 1, 1e-14 * 4);
    // X.X = 1 differentiated once and three times.
    EXPECT_NEAR(x.row(0).dot(x.row(1)), 0, 1e-14);
    EXPECT_NEAR(x.row(0).dot(x.row(3)) + 3 * x.row(1).dot(x.row(2)), 0, 1e-12);
  }
}

TEST(Evaluate, DerivativesStandInGradedOrder) {
  // X(u, v, w) = (1, u, v, w, uu, uv, uw, vv, vw, ww) on one quadratic Bezier cell, by its blossom.
  const double a[3] = {0, 0.5, 1};
  const double b[3] = {0, 0, 1};
  Net net(27, 10);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      for (int k = 0; k < 3; ++k) {
        net.row(9 * i + 3 * j + k) << 1, a[i], a[j], a[k], b[i], a[i] * a[j], a[i] * a[k], b[j], a[j] * a[k], b[k];
      }
    }
  }
  const auto q = KnotVector::uniformClamped(2, 1);
  const Net x = derivatives(Volume({q, q, q}, net), {0.25, 0.5, 0.75}, 2);
  Net expected = Net::Zero(10, 10);
  expected.row(0) << 1, 0.25, 0.5, 0.75, 0.0625, 0.125, 0.1875, 0.25, 0.375, 0.5625;
  expected.row(1) << 0, 1, 0, 0, 0.5, 0.5, 0.75, 0, 0, 0;
  expected.row(2) << 0, 0, 1, 0, 0, 0.25, 0, 1, 0.75, 0;
  expected.row(3) << 0, 0, 0, 1, 0, 0, 0.25, 0, 0.5, 1.5;
  for (int r = 0; r < 3; ++r) expected(4, 4) = expected(7, 7) = expected(9, 9) = 2;
  expected(5, 5) = expected(6, 6) = expected(8, 8) = 1;
  EXPECT_LT(distance(x, expected), 1e-15);
}

TEST(Evaluate, InnerKnotsTakeThePieceToTheRight) {
  Net net(4, 1);
  net << 0, 1, 5, 7;
  const Curve jump({KnotVector(1, {0, 0, 1, 1, 2, 2})}, net);
  const Evaluator<1> evaluator(jump);
  for (const auto& [u, value, slope] :
       {std::tuple{1.0, 5.0, 2.0}, {0.5, 0.5, 1.0}, {2.0, 7.0, 2.0}, {3.0, 9.0, 2.0}, {-1.0, -1.0, 1.0}}) {
    const Net x = derivatives(jump, {u}, 1);
    EXPECT_EQ(x(0, 0), value);
    EXPECT_EQ(x(1, 0), slope);
    Net prepared(2, 1);
    evaluator.derivatives({u}, 1, prepared.data());
    EXPECT_LT(distance(x, prepared), 1e-15 * 10);
  }
}

TEST(Evaluate, ContinuesThePolynomialOutsideTheDomain) {
  // One cubic polynomial on knots with inner breaks: the continuation is the polynomial itself.
  const KnotVector knots(3, {0, 0, 0, 0, 0.3, 0.7, 1, 1, 1, 1});
  Net net(6, 1);
  for (Index i = 0; i < 6; ++i) net(i, 0) = knots[i + 1] * knots[i + 2] * knots[i + 3];
  const Curve cube({knots}, net);
  for (const double u : {-0.5, 1.5, 2.0}) {
    const Net x = derivatives(cube, {u}, 3);
    EXPECT_NEAR(x(0, 0), u * u * u, 1e-13);
    EXPECT_NEAR(x(3, 0), 6, 1e-11);
    EXPECT_NEAR(Evaluator<1>(cube).derivativesAt(Net::Constant(1, 1, u), 0)(0, 0), u * u * u, 1e-13);
  }
}

TEST(Evaluate, WorksForHighDegreesAndManyColumns) {
  Random random(38);
  for (const int degree : {15, 20, 33}) {
    const std::array<KnotVector, 2> knots{KnotVector::uniformClamped(degree, 2), KnotVector::uniformClamped(2, 3)};
    const auto surface = testing::randomSpline<2>(random, knots, 11, true);
    const Evaluator<2> evaluator(surface);
    const auto u = testing::randomParameter(random, surface);
    const Net expected = derivatives(surface, u, 2);
    Net x(6, 11);
    evaluator.derivatives(u, 2, x.data());
    EXPECT_LT(distance(x, expected), 1e-12 * expected.cwiseAbs().maxCoeff());
    const Net grid = evaluator.derivativesOnGrid({{{u[0]}, {u[1]}}}, 2);
    EXPECT_LT(distance(unfolded(grid, 0, 11), expected), 1e-12 * expected.cwiseAbs().maxCoeff());
  }
}

}  // namespace
}  // namespace strak
