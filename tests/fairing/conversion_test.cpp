#include "strak/fairing/conversion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "strak/base/error.h"
#include "strak/spline/degree_elevation.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/knot_insertion.h"
#include "tests/spline/random_splines.h"

namespace strak {
namespace {

using strak::testing::KnotKind;
using strak::testing::Random;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

ConversionOptions uniform(int degree, double tolerance = kInfinity) {
  return {degree, KnotSpacing::uniform, tolerance, 200'000};
}
ConversionOptions adapted(int degree, double tolerance = kInfinity) {
  return {degree, KnotSpacing::adapted, tolerance, 200'000};
}

// (cos, sin) of a quarter turn as a rational quadratic.
Net quarter() {
  return (Net(3, 3) << 1, 0, 1, std::numbers::sqrt2 / 2, std::numbers::sqrt2 / 2, std::numbers::sqrt2 / 2, 0, 1, 1)
      .finished();
}

// An eighth of the unit sphere, its pole the side v = 1.
Surface octant() {
  const Net round = quarter();
  Net net(9, 4);
  for (Index i = 0; i < 3; ++i) {
    for (Index j = 0; j < 3; ++j) {
      net.row(3 * i + j) << round(i, 0) * round(j, 0), round(i, 1) * round(j, 0), round(i, 2) * round(j, 1),
          round(i, 2) * round(j, 2);
    }
  }
  const KnotVector knots = KnotVector::uniformClamped(2, 1);
  return {{knots, knots}, net, true};
}

TEST(Conversion, UniformCubicsComeBackToTheBit) {
  Random random(301);
  for (const bool open : {false, true}) {
    std::array<KnotVector, 2> knots{KnotVector::uniformClamped(3, 7, -1, 2.5), KnotVector::uniformClamped(3, 5, 0, 1)};
    if (open) {
      for (auto& direction : knots) {
        std::vector<double> even;
        for (int i = 0; i < 12; ++i) even.push_back(0.1 * i);
        direction = KnotVector(3, even);
      }
    }
    const Surface surface = testing::randomSpline<2>(random, knots, 3, false);
    const auto result = convertSpline(surface, uniform(3, 1e-6));
    EXPECT_TRUE(result.unchanged);
    EXPECT_EQ(result.spline, surface);
    EXPECT_EQ(result.deviation.upper, 0);
  }
}

// The same spaces in another guise: the least squares themselves must find the net again.
template <int D>
void findsUniformSplines(int trials, int highest) {
  Random random(310 + D);
  for (int trial = 0; trial < trials; ++trial) {
    const int degree = random.integer(1, highest);
    std::array<KnotVector, static_cast<std::size_t>(D)> knots;
    for (auto& k : knots) k = KnotVector::uniformClamped(degree, random.integer(1, 6), -1, random.uniform(0, 3));
    const Spline<D> original = testing::randomSpline<D>(random, knots, 3, false);
    Spline<D> higher = original;
    for (int k = 0; k < D; ++k) higher = elevateDegree(higher, k, random.integer(1, 2));
    const auto result = convertSpline(higher, uniform(degree, 1e-6));
    ASSERT_FALSE(result.unchanged);
    ASSERT_EQ(result.spline.sizes(), original.sizes()) << "trial " << trial << " degree " << degree;
    ASSERT_LT((result.spline.net() - original.net()).cwiseAbs().maxCoeff(), 1e-12)
        << "trial " << trial << " degree " << degree;
  }
}
TEST(Conversion, LeastSquaresReproduceUniformCurves) { findsUniformSplines<1>(40, 5); }
TEST(Conversion, LeastSquaresReproduceUniformSurfaces) { findsUniformSplines<2>(15, 4); }
TEST(Conversion, LeastSquaresReproduceUniformVolumes) { findsUniformSplines<3>(3, 3); }

// (1), a direction: as many numbers as the old surface has. The errata's own figures.
TEST(Conversion, FirstNumberOfSpans) {
  Random random(320);
  for (const auto& [degree, u, v] : {std::array{3, 7, 5}, std::array{5, 11, 8}}) {
    const Surface surface = testing::randomSpline<2>(random,
                                                     {testing::randomKnots(random, KnotKind::nonUniform, degree, 7),
                                                      testing::randomKnots(random, KnotKind::nonUniform, degree, 5)},
                                                     3, false);
    const auto result = convertSpline(surface, uniform(3));
    EXPECT_EQ(result.spline.sizes(), (std::array<Index, 2>{u + 3, v + 3}));
    EXPECT_EQ(result.rounds, 1);
    EXPECT_TRUE(result.reached);
  }
}

TEST(Conversion, AnySplineComesWithinTheTolerance) {
  Random random(330);
  for (int trial = 0; trial < 30; ++trial) {
    const bool rational = trial % 3 == 2;
    const int degree = random.integer(2, 6), wished = random.integer(2, 5);
    const Surface surface = testing::randomSpline<2>(random,
                                                     {testing::randomKnots(random, KnotKind::nonUniform, degree, 4),
                                                      testing::randomKnots(random, KnotKind::unclamped, degree, 3)},
                                                     3, rational);
    for (const auto& options : {uniform(wished, 1e-2), adapted(wished, 1e-2)}) {
      const auto result = convertSpline(surface, options);
      ASSERT_TRUE(result.reached) << "trial " << trial;
      EXPECT_LE(result.deviation.upper, 1e-2);
      EXPECT_FALSE(result.spline.isRational());
      for (int k = 0; k < 2; ++k) {
        EXPECT_EQ(result.spline.degree(k), wished);
        EXPECT_EQ(result.spline.knots(k).from(), surface.knots(k).from());
        EXPECT_EQ(result.spline.knots(k).to(), surface.knots(k).to());
      }
      // The corners stay, the sides are a part of the whole, and no place is farther away than is said.
      for (double s : result.sides) EXPECT_LE(s, result.deviation.upper * (1 + 1e-3));
      for (int place = 0; place < 50; ++place) {
        std::array<double, 2> at{};
        for (int k = 0; k < 2; ++k) {
          const auto& knots = surface.knots(k);
          at[static_cast<std::size_t>(k)] = place == 0   ? knots.from()
                                            : place == 1 ? knots.to()
                                                         : random.uniform(knots.from(), knots.to());
        }
        const double apart = (evaluate(result.spline, at) - evaluate(surface, at)).norm();
        EXPECT_LE(apart, place < 2 ? 1e-12 : result.deviation.upper);
      }
    }
  }
}

TEST(Conversion, SphereOctant) {
  const Surface sphere = octant();
  const auto coarse = convertSpline(sphere, uniform(3, 1e-4)), fine = convertSpline(sphere, uniform(3, 1e-4 / 256));
  ASSERT_TRUE(fine.reached);
  EXPECT_FALSE(fine.spline.isRational());
  Random random(340);
  for (int i = 0; i < 200; ++i) {
    EXPECT_NEAR(evaluate(fine.spline, {random.uniform(), random.uniform()}).norm(), 1, 1e-4 / 256);
  }
  // The pole stays one point, and an error of the fourth order needs four times the spans for a 256th.
  for (Index i = 0; i < fine.spline.size(0); ++i) {
    const Point pole = fine.spline.net().row((i + 1) * fine.spline.size(1) - 1);
    EXPECT_LT((pole - Point(Eigen::RowVector3d(0, 0, 1))).norm(), 1e-14);
    EXPECT_EQ(pole, Point(fine.spline.net().row(fine.spline.size(1) - 1)));
  }
  const auto spans = [](const Surface& s) { return static_cast<double>(s.knots(1).spans().size()); };
  EXPECT_GT(spans(fine.spline) / spans(coarse.spline), 2.5);
  EXPECT_LT(spans(fine.spline) / spans(coarse.spline), 6);
}

// Two splines with one border keep one, to the bit, whatever they are inside.
TEST(Conversion, CommonBordersStayCommon) {
  Random random(350);
  const std::array<KnotVector, 2> knots{testing::randomKnots(random, KnotKind::nonUniform, 4, 5),
                                        KnotVector::uniformClamped(4, 3)};
  const Surface a = testing::randomSpline<2>(random, knots, 3, false);
  Surface b = testing::randomSpline<2>(random, knots, 3, false);
  Net net = b.net();
  for (Index i = 0; i < a.size(0); ++i) net.row(i * a.size(1)) = a.net().row(i * a.size(1) + a.size(1) - 1);
  b = Surface(knots, net);
  const Surface left = convertSpline(a, uniform(3)).spline, right = convertSpline(b, uniform(3)).spline;
  for (Index i = 0; i < left.size(0); ++i) {
    const Point onLeft = left.net().row(i * left.size(1) + left.size(1) - 1),
                onRight = right.net().row(i * right.size(1));
    EXPECT_LT((onLeft - onRight).norm(), 1e-13);
  }
}

// A roof of two planes that meet at right angles, as a cubic with its knots and a triple one.
Surface roof() {
  Net net(7 * 4, 3);
  for (Index i = 0; i < 7; ++i) {
    for (Index j = 0; j < 4; ++j) {
      const double x = static_cast<double>(i) / 3 - 1;
      net.row(4 * i + j) << x, static_cast<double>(j) / 3, -std::abs(x);
    }
  }
  return {{KnotVector(3, {0, 0, 0, 0, 0.5, 0.5, 0.5, 1, 1, 1, 1}), KnotVector::uniformClamped(3, 1)}, net};
}

TEST(Conversion, CreasesAreRoundedAndNamed) {
  const auto result = convertSpline(roof(), uniform(3, 0.01));
  EXPECT_TRUE(result.reached);
  ASSERT_EQ(result.creases.size(), 1U);
  EXPECT_EQ(result.creases[0], "90 degrees at u = 0.5");
  EXPECT_EQ(result.spline.size(1), 4);  // the other direction was right already
}

TEST(Conversion, AdaptedKnotsKeepCreases) {
  const auto kept = convertSpline(roof(), adapted(2, 0.01));
  EXPECT_LT(kept.deviation.upper, 1e-12);  // two planes
  EXPECT_TRUE(kept.creases.empty());
  EXPECT_EQ(kept.spline.knots(0).multiplicity(0.5), 2);
  const auto higher = convertSpline(roof(), adapted(5));
  EXPECT_LT(higher.deviation.upper, 1e-12);
  EXPECT_EQ(higher.spline.knots(0).multiplicity(0.5), 5);
}

TEST(Conversion, WhatCannotBeReachedSaysHowFarItCame) {
  ConversionOptions options = uniform(3, 1e-9);
  options.mostPoints = 2000;
  const auto result = convertSpline(roof(), options);
  EXPECT_FALSE(result.reached);
  EXPECT_LE(result.spline.size(0) * result.spline.size(1), 2000);
  EXPECT_GT(result.spline.size(0), 200);
  EXPECT_GT(result.deviation.lower, 1e-9);
  EXPECT_LT(result.deviation.upper, 0.01);
}

TEST(Conversion, RefusesWhatMakesNoSense) {
  const Surface sphere = octant();
  EXPECT_THROW(convertSpline(sphere, uniform(0)), InvalidInput);
  EXPECT_THROW(convertSpline(sphere, uniform(16)), InvalidInput);
  EXPECT_THROW(convertSpline(sphere, uniform(3, 0)), InvalidInput);
  EXPECT_THROW(convertSpline(sphere, uniform(3, std::nan(""))), InvalidInput);
  ConversionOptions few = uniform(3);
  few.mostPoints = 3;
  EXPECT_THROW(convertSpline(sphere, few), InvalidInput);
  const Curve jump({KnotVector(1, {0, 0, 0.5, 0.5, 1, 1})}, (Net(4, 1) << 0, 1, 3, 4).finished());
  EXPECT_THROW(convertSpline(jump, uniform(3, 0.1)), InvalidInput);
}

}  // namespace
}  // namespace strak
