#include "strak/energy/parameter_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "strak/base/error.h"
#include "tests/spline/random_splines.h"

namespace strak {
namespace {

using testing::Random;

TEST(ParameterScale, HasThreeNames) {
  EXPECT_EQ(parameterScaleNamed("lengths"), ParameterScale::lengths);
  EXPECT_EQ(parameterScaleNamed("domain"), ParameterScale::domain);
  EXPECT_EQ(parameterScaleNamed("unit"), ParameterScale::unit);
  EXPECT_THROW(parameterScaleNamed("length"), InvalidInput);
}

TEST(ParameterScale, DomainKeepsTheKnotsAndUnitMapsThemToZeroOne) {
  Random random(1);
  const auto surface = testing::randomSpline<2>(random, 5);
  EXPECT_EQ(scaledKnots(surface, ParameterScale::domain), surface.knots());
  for (const auto& knots : scaledKnots(surface, ParameterScale::unit)) {
    EXPECT_EQ(knots.from(), 0);
    EXPECT_EQ(knots.to(), 1);
  }
}

// The rectangle of 3 x 5 is as long as its sides, whatever its knots.
TEST(ParameterScale, LengthsOfARectangleAreItsSides) {
  const KnotVector u(2, {0, 0, 0, 0.1, 0.7, 2, 2, 2});
  const KnotVector v = KnotVector::uniformClamped(3, 4, -7, 11);
  Net net(u.size() * v.size(), 3);
  for (Index i = 0; i < u.size(); ++i) {
    for (Index j = 0; j < v.size(); ++j) {
      net.row(i * v.size() + j) << 3 * u.greville()[static_cast<std::size_t>(i)] / 2,
          5 * (v.greville()[static_cast<std::size_t>(j)] + 7) / 18, 1e3;
    }
  }
  const auto knots = scaledKnots(Surface({u, v}, net), ParameterScale::lengths);
  EXPECT_EQ(knots[0].from(), 0);
  EXPECT_NEAR(knots[0].to(), 3, 1e-11);
  EXPECT_NEAR(knots[1].to(), 5, 1e-11);
}

TEST(ParameterScale, LengthOfAQuarterCircleIsItsArc) {
  Net net(3, 4);
  const double w = std::sqrt(0.5);
  net << 2, 0, 0, 1, 2 * w, 2 * w, 0, w, 0, 2, 0, 1;
  const Curve curve({KnotVector::uniformClamped(2, 1)}, net, true);
  EXPECT_NEAR(scaledKnots(curve, ParameterScale::lengths)[0].to(), std::numbers::pi, 2e-5);
}

template <int D>
void expectInvariance(std::uint64_t seed) {
  Random random(seed);
  const auto spline = testing::randomSpline<D>(random, 4);
  auto knots = spline.knots();
  for (auto& direction : knots) {
    const double from = random.uniform(-10, 10);
    direction = direction.rescaled(from, from + random.uniform(0.01, 100));
  }
  const Spline<D> other(knots, spline.net(), spline.isRational());
  const auto a = scaledKnots(spline, ParameterScale::lengths);
  const auto b = scaledKnots(other, ParameterScale::lengths);
  for (std::size_t k = 0; k < D; ++k) {
    if (spline.pointDimension() == 1) {
      EXPECT_EQ(a[k], spline.knots(static_cast<int>(k)));
      continue;
    }
    EXPECT_NEAR(a[k].length(), b[k].length(), 1e-11 * a[k].length()) << "seed " << seed;
    EXPECT_TRUE(a[k].length() > 0);
  }
  // Twice the size is twice the length.
  const Spline<D> large(spline.knots(), spline.isRational() ? spline.net() : Net(2 * spline.net()),
                        spline.isRational());
  if (spline.pointDimension() > 1 && !spline.isRational() && spline.degree(0) > 0) {
    EXPECT_NEAR(scaledKnots(large, ParameterScale::lengths)[0].length(), 2 * a[0].length(), 1e-12 * a[0].length());
  }
}

TEST(ParameterScale, LengthsDoNotDependOnAffineChangesOfTheKnots) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    expectInvariance<1>(seed);
    expectInvariance<2>(seed);
    if (seed <= 8) expectInvariance<3>(seed);
  }
}

TEST(ParameterScale, ADirectionOfNoLengthIsAsLongAsTheOtherOrOne) {
  const KnotVector knots = KnotVector::uniformClamped(2, 3, 4, 9);
  const auto point = scaledKnots(Surface({knots, knots}, Net::Constant(25, 3, 0.3)), ParameterScale::lengths);
  EXPECT_EQ(point[0].length(), 1);
  EXPECT_EQ(point[1].length(), 1);
  Net net(25, 2);
  for (Index r = 0; r < 25; ++r) net.row(r) << 0.7, knots.greville()[static_cast<std::size_t>(r / 5)];
  const auto line = scaledKnots(Surface({knots, knots}, net), ParameterScale::lengths);
  EXPECT_NEAR(line[0].length(), 5, 1e-13);
  EXPECT_EQ(line[1].length(), line[0].length());
}

}  // namespace
}  // namespace strak
