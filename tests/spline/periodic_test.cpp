#include "strak/spline/periodic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "strak/base/error.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/rational.h"

namespace strak {
namespace {

// A closed tube in periodic form by hand: degree p in u with uneven knots, the first p points repeated.
Surface tube(int p, Index independent, unsigned seed, bool rational = false) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(0.2, 1);
  std::vector<double> steps(static_cast<std::size_t>(independent));
  for (double& step : steps) step = number(random);
  double period = 0;
  for (double step : steps) period += step;
  std::vector<double> once{0};
  for (double step : steps) once.push_back(once.back() + step);
  once.back() = period;
  const auto at = [&](Index i) {  // the knot sequence without ends
    const Index q = (i % independent + independent) % independent;
    return once[static_cast<std::size_t>(q)] + period * static_cast<double>((i - q) / independent);
  };
  std::vector<double> u;
  for (Index i = -p; i <= independent + p; ++i) u.push_back(i == independent ? period : at(i));
  const KnotVector v(2, {0, 0, 0, 1, 2, 2, 2});
  const Index n = independent + p;
  Net net(n * 4, rational ? 4 : 3);
  for (Index i = 0; i < independent; ++i) {
    for (Index j = 0; j < 4; ++j) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(independent);
      const double r = 2 + number(random), w = rational ? number(random) : 1;
      net.row(i * 4 + j).head(3) << w * r * std::cos(angle), w * r * std::sin(angle), w * static_cast<double>(j);
      if (rational) net(i * 4 + j, 3) = w;
    }
  }
  for (Index i = 0; i < 4 * p; ++i) net.row(independent * 4 + i) = net.row(i);
  return Surface({KnotVector(p, u), v}, std::move(net), rational);
}

TEST(Periodic, ThereAndBackIsTheSameSpline) {
  for (int p = 1; p <= 5; ++p) {
    for (Index independent : {Index{p + 1}, Index{9}, Index{20}}) {
      for (bool rational : {false, true}) {
        const Surface periodic = tube(p, independent, 3, rational);
        const Surface closed = toClamped(periodic, 0);
        ASSERT_TRUE(closed.knots(0).isClamped());
        EXPECT_EQ(closed.size(0), periodic.size(0));
        EXPECT_EQ(closed.net().topRows(4), closed.net().bottomRows(4));
        EXPECT_EQ(seamSmoothness(closed, 0), p - 1) << p << " " << independent;
        const auto again = toPeriodic(closed, 0, p - 1);
        ASSERT_TRUE(again);
        for (std::size_t k = 0; k < periodic.knots(0).knots().size(); ++k) {
          EXPECT_NEAR(again->knots(0).knots()[k], periodic.knots(0).knots()[k], 1e-13);
        }
        EXPECT_LT((again->net() - periodic.net()).cwiseAbs().maxCoeff(), 1e-11);
        const auto repeated = again->net().bottomRows(4 * p);
        EXPECT_EQ(again->net().topRows(4 * p), repeated);
        const Surface twice = toClamped(*again, 0);
        EXPECT_EQ(twice.knots(), closed.knots());
        EXPECT_LT((twice.net() - closed.net()).cwiseAbs().maxCoeff(), 1e-12);
      }
    }
  }
}

TEST(Periodic, ControlPointsAwayFromTheSeamKeepTheirBits) {
  const Surface closed = toClamped(tube(3, 12, 5), 0);
  const auto periodic = toPeriodic(closed, 0, 2);
  ASSERT_TRUE(periodic);
  EXPECT_EQ(periodic->net().middleRows(2 * 4, (closed.size(0) - 4) * 4),
            closed.net().middleRows(2 * 4, (closed.size(0) - 4) * 4));
}

TEST(Periodic, TheSeamStaysSmoothWhateverIsDoneToTheNet) {
  for (bool rational : {false, true}) {
    const auto periodic = toPeriodic(toClamped(tube(4, 11, 7, rational), 0), 0, 3);
    ASSERT_TRUE(periodic);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> move(-0.3, 0.3);
    Surface moved = *periodic;
    const Index independent = moved.net().rows() - 16;
    for (Index r = 0; r < independent; ++r) {
      for (Index c = 0; c < 3; ++c) moved.net()(r, c) += move(random);
      if (r < 16) moved.net().row(independent + r) = moved.net().row(r);
    }
    const Surface closed = toClamped(moved, 0);
    const double b = closed.knots(0).to();
    const Net low = derivatives<2>(closed, {0.0, 0.7}, 3), high = derivatives<2>(closed, {b, 0.7}, 3);
    EXPECT_LT((low - high).cwiseAbs().maxCoeff(), 1e-9 * low.cwiseAbs().maxCoeff());
  }
}

TEST(Periodic, LessSmoothSeamsAreKnown) {
  Surface closed = toClamped(tube(3, 10, 9), 0);
  const auto bend = [&](Index row) {
    for (Index j = 0; j < 4; ++j) closed.net()(row * 4 + j, 2) += 0.1;
  };
  bend(2);
  EXPECT_EQ(seamSmoothness(closed, 0), 1);
  EXPECT_FALSE(toPeriodic(closed, 0, 2));
  ASSERT_TRUE(toPeriodic(closed, 0, 1));
  EXPECT_EQ(toPeriodic(closed, 0, 1)->knots(0).multiplicity(0), 2);
  bend(1);
  EXPECT_EQ(seamSmoothness(closed, 0), 0);
  EXPECT_EQ(toPeriodic(closed, 0, 0)->net(), closed.net());
  bend(0);
  EXPECT_EQ(seamSmoothness(closed, 0), -1);
  EXPECT_FALSE(toPeriodic(closed, 0, 0));
  EXPECT_EQ(seamSmoothness(closed, 1), -1);
  EXPECT_THROW(toPeriodic(closed, 0, 3), InvalidInput);
  EXPECT_THROW(toPeriodic(closed, 0, -1), InvalidInput);
}

// The usual circle of four quadratic arcs: its tangents agree at the seam, its homogeneous derivatives do not.
TEST(Periodic, TheRationalCircle) {
  const double w = std::numbers::sqrt2 / 2;
  Net net(9, 3);
  net << 1, 0, 1, w, w, w, 0, 1, 1, -w, w, w, -1, 0, 1, -w, -w, w, 0, -1, 1, w, -w, w, 1, 0, 1;
  const Curve circle({KnotVector(2, {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4})}, net, true);
  EXPECT_EQ(seamSmoothness(circle, 0), 0);
  const auto periodic = toPeriodic(circle, 0, 0);
  ASSERT_TRUE(periodic);
  for (double u : {0.0, 0.3, 1.7, 3.999}) EXPECT_NEAR((evaluate<1>(*periodic, {u})).norm(), 1, 1e-15);
}

}  // namespace
}  // namespace strak
