#include "strak/fairing/rebuild.h"

#include <gtest/gtest.h>

#include <cmath>

#include "strak/base/error.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/reparametrize.h"
#include "tests/spline/random_splines.h"

namespace strak {
namespace {

using strak::testing::Random;

template <int D>
RebuildOptions<D> uniform(int degree, Index spans) {
  RebuildOptions<D> options;
  options.degree.fill(degree);
  options.spans.fill(spans);
  return options;
}

// What has the degree and the knots already comes back.
template <int D>
void reproduces(int trials) {
  Random random(90 + D);
  for (int trial = 0; trial < trials; ++trial) {
    const int degree = random.integer(1, D == 3 ? 3 : 7);
    const int spans = random.integer(1, 3);
    std::array<KnotVector, static_cast<std::size_t>(D)> knots;
    const double from = random.uniform(-3, 3);
    for (auto& k : knots) k = KnotVector::uniformClamped(degree, spans, from, from + random.uniform(0.5, 4));
    const Spline<D> spline = testing::randomSpline<D>(random, knots, 3, false);
    const auto result = rebuild(spline, uniform<D>(degree, spans));
    ASSERT_EQ(result.spline.knots(), spline.knots());
    ASSERT_LT((result.spline.net() - spline.net()).cwiseAbs().maxCoeff(), 1e-9) << "trial " << trial;
  }
}

TEST(Rebuild, ReproducesCurves) { reproduces<1>(40); }
TEST(Rebuild, ReproducesSurfaces) { reproduces<2>(12); }
TEST(Rebuild, ReproducesVolumes) { reproduces<3>(4); }

// The best straight line to t^2 on [0, 1] with both ends kept is t, 1/4 off in the middle. The best parabola to t^3 in
// the largest deviation, both ends kept: t^3 - (a t^2 + (1 - a) t) with a such that both extrema are equally large, a =
// 3/2: t^3 - 3/2 t^2 + t/2 = t (t - 1/2) (t - 1), whose extremum is sqrt(3)/36.
TEST(Rebuild, KnownBestApproximations) {
  const Curve parabola({KnotVector::uniformClamped(2, 1)}, (Net(3, 1) << 0, 0, 1).finished());
  EXPECT_NEAR(rebuild(parabola, uniform<1>(1, 1)).deviation.upper, 0.25, 1e-4);
  const Curve cubic({KnotVector::uniformClamped(3, 1)}, (Net(4, 1) << 0, 0, 0, 1).finished());
  const auto result = rebuild(cubic, uniform<1>(2, 1));
  EXPECT_NEAR(result.deviation.lower, std::sqrt(3) / 36, 1e-4);
}

// An example where the mean square is not the best in the largest deviation: t^5 by a cubic.
TEST(Rebuild, ReweightingLowersTheLargestDeviation) {
  const Curve quintic({KnotVector::uniformClamped(5, 1)}, (Net(6, 1) << 0, 0, 0, 0, 0, 1).finished());
  auto options = uniform<1>(3, 1);
  const auto better = rebuild(quintic, options);
  options.reweightings = 0;
  const auto meanSquare = rebuild(quintic, options);
  EXPECT_LT(better.deviation.upper, 0.9 * meanSquare.deviation.upper);
  EXPECT_EQ(better.meanSquare.upper, meanSquare.deviation.upper);
  // All extrema of the error are equally large, as Chebyshev asks for; the cubic has two inner coefficients: 3 extrema.
  double extrema[3] = {0, 0, 0};
  int found = -1;
  double sign = 0;
  for (int i = 1; i < 2000; ++i) {
    const double t = i / 2000.0;
    const double e = evaluate(better.spline, {t})(0) - std::pow(t, 5);
    if (e * sign <= 0 && ++found > 2) break;
    sign = e;
    extrema[found] = std::max(extrema[found], std::abs(e));
  }
  ASSERT_EQ(found, 2);
  EXPECT_NEAR(extrema[0] / extrema[1], 1, 0.1);
  EXPECT_NEAR(extrema[2] / extrema[1], 1, 0.1);
}

Surface wave(Index nu, Index nv, double fromU, double toU) {
  const auto u = KnotVector::uniformClamped(3, nu - 3, fromU, toU);
  const auto v = KnotVector::uniformClamped(3, nv - 3, 0, 1);
  Net net(nu * nv, 3);
  Index r = 0;
  for (double x : u.greville()) {
    for (double y : v.greville()) net.row(r++) << 10 * x, 8 * y, std::sin(2 * x) * std::cos(3 * y);
  }
  return Surface({u, v}, net);
}

TEST(Rebuild, CornersStayAndMoreDegreesAreNearer) {
  const Surface surface = wave(20, 17, 0, 1);
  double last = 1e9;
  for (int degree : {3, 5, 7}) {
    const auto result = rebuild(surface, uniform<2>(degree, 1));
    EXPECT_EQ(result.spline.net().rows(), (degree + 1) * (degree + 1));
    EXPECT_LT(result.deviation.upper, last);
    EXPECT_LE(result.deviation.upper, result.meanSquare.upper);
    last = result.deviation.upper;
    for (double u : {0.0, 1.0}) {
      for (double v : {0.0, 1.0}) {
        EXPECT_LT((evaluate(result.spline, {u, v}) - evaluate(surface, {u, v})).norm(), 1e-13);
      }
    }
  }
  EXPECT_LT(last, 1e-3);
}

// Two patches of one surface share a border to rounding after both were rebuilt, each for itself.
TEST(Rebuild, NeighboursStillMeet) {
  const Surface whole = wave(30, 17, 0, 2);
  const Surface left = subPatch(whole, 0, 0, 0.9), right = subPatch(whole, 0, 0.9, 2);
  const auto a = rebuild(left, uniform<2>(5, 1)), b = rebuild(right, uniform<2>(5, 1));
  for (int i = 0; i <= 50; ++i) {
    const double v = i / 50.0;
    EXPECT_LT((evaluate(a.spline, {0.9, v}) - evaluate(b.spline, {0.9, v})).norm(), 1e-10);
  }
}

TEST(Rebuild, RationalBecomesPolynomial) {
  const double h = std::sqrt(0.5);
  Net net(3, 3);
  net << 1, 0, 1, h, h, h, 0, 1, 1;  // a quarter of the unit circle
  const Curve circle({KnotVector::uniformClamped(2, 1)}, net, true);
  // The nearest pole of the parametrization lies outside the ellipse of Bernstein with sum of half axes 5: every degree
  // more gains that factor.
  double last = 1e-3;
  for (int degree : {5, 7, 9}) {
    const auto result = rebuild(circle, uniform<1>(degree, 1));
    EXPECT_FALSE(result.spline.isRational());
    EXPECT_LT(result.deviation.upper, last);
    for (int i = 0; i <= 20; ++i) EXPECT_NEAR(evaluate(result.spline, {i / 20.0}).norm(), 1, last);
    last = result.deviation.upper / 15;
  }
}

TEST(Rebuild, DoesNotDependOnThePlace) {
  const Surface surface = wave(12, 11, 0, 1);
  Surface far = surface;
  far.net().rowwise() += Point(Eigen::RowVector3d(1e6, -2e6, 3e6));
  const auto near = rebuild(surface, uniform<2>(5, 1)), there = rebuild(far, uniform<2>(5, 1));
  EXPECT_NEAR(near.deviation.upper, there.deviation.upper, 1e-7);
}

TEST(Rebuild, PolesStayPoles) {
  Surface surface = wave(12, 11, 0, 1);
  for (Index i = 0; i < 12; ++i) surface.net().row(surface.row({i, 0})) << 1, 2, 3;
  const auto result = rebuild(surface, uniform<2>(6, 1));
  for (Index i = 0; i < result.spline.size(0); ++i) {
    EXPECT_LT((result.spline.net().row(result.spline.row({i, 0})) - Eigen::RowVector3d(1, 2, 3)).norm(), 1e-12);
  }
}

TEST(Rebuild, SaysWhatIsWrong) {
  const Surface surface = wave(8, 8, 0, 1);
  EXPECT_THROW(rebuild(surface, uniform<2>(0, 1)), InvalidInput);
  EXPECT_THROW(rebuild(surface, uniform<2>(16, 1)), InvalidInput);
  EXPECT_THROW(rebuild(surface, uniform<2>(5, 0)), InvalidInput);
  EXPECT_THROW(rebuild(surface, uniform<2>(5, 1'000'000'000)), InvalidInput);
}

}  // namespace
}  // namespace strak
