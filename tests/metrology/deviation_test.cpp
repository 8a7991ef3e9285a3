#include "strak/metrology/deviation.h"

#include <tbb/global_control.h>

#include "strak/base/error.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/knot_insertion.h"
#include "tests/metrology/test_surfaces.h"

namespace strak {
namespace {

using testing::randomKnots;
using testing::randomSpline;

constexpr double kAccuracy = 1e-12;  // of the evaluation that the bounds are compared with

// The largest distance on a grid of the domain.
template <int D>
double sampledDistance(const Spline<D>& a, const Spline<D>& b, Index perDirection) {
  Index count = 1;
  for (int k = 0; k < D; ++k) count *= perDirection;
  Net parameters(count, D);
  for (Index r = 0; r < count; ++r) {
    Index rest = r;
    for (int k = D - 1; k >= 0; --k) {
      const double t = static_cast<double>(rest % perDirection) / static_cast<double>(perDirection - 1);
      parameters(r, k) = std::lerp(a.knots(k).from(), a.knots(k).to(), t);
      rest /= perDirection;
    }
  }
  return (derivativesAt<D>(a, parameters, 0) - derivativesAt<D>(b, parameters, 0)).rowwise().norm().maxCoeff();
}

template <int D>
void expectBounds(const Spline<D>& a, const Spline<D>& b, Index samples, const std::string& what) {
  SCOPED_TRACE(what);
  const DeviationOptions options{.relativeWidth = 1e-3};
  const Deviation<D> d = certifyDeviation(a, b, options);
  EXPECT_LE(sampledDistance(a, b, samples), d.upper + kAccuracy);
  EXPECT_LE(d.lower, d.upper);
  bool jumps = false;  // then the place may stand for a limit from one side
  for (int k = 0; k < D; ++k) jumps = jumps || a.degree(k) == 0 || b.degree(k) == 0;
  if (!jumps) {
    EXPECT_NEAR((evaluate<D>(a, d.place) - evaluate<D>(b, d.place)).norm(), d.lower, kAccuracy);
  }
  EXPECT_LE(d.upper - d.lower, options.relativeWidth * d.upper + kAccuracy);
}

TEST(Deviation, BoundsHoldForRandomCurves) {
  std::mt19937_64 random(11);
  for (int i = 0; i < 200; ++i) {
    const int p = i % 8, q = (i / 8) % 8;
    const auto a = randomSpline<1>(random, {randomKnots(random, p, 1 + i % 9)}, 1 + i % 4, i % 3 == 0);
    const auto b = randomSpline<1>(random, {randomKnots(random, q, 1 + i % 7)}, 1 + i % 4, i % 5 == 0);
    expectBounds<1>(a, b, 400, "case " + std::to_string(i));
  }
}

TEST(Deviation, BoundsHoldForRandomSurfacesOnTheSameKnots) {
  std::mt19937_64 random(12);
  for (int i = 0; i < 60; ++i) {
    const std::array<KnotVector, 2> knots{randomKnots(random, 1 + i % 6, 1 + i % 5, -2, 3),
                                          randomKnots(random, 1 + (i / 6) % 6, 4)};
    const auto a = randomSpline<2>(random, knots, 1 + i % 4, i % 4 == 0);
    auto b = randomSpline<2>(random, knots, 1 + i % 4, i % 4 == 0);
    if (i % 8 == 0) {  // the same weights
      const Index last = a.pointDimension();
      b.net().leftCols(last).array().colwise() *= a.net().col(last).array() / b.net().col(last).array();
      b.net().col(last) = a.net().col(last);
    }
    expectBounds<2>(a, b, 60, "case " + std::to_string(i));
  }
}

TEST(Deviation, BoundsHoldForSurfacesOnDifferentKnotsAndDegrees) {
  std::mt19937_64 random(13);
  for (int i = 0; i < 30; ++i) {
    const auto a =
        randomSpline<2>(random, {randomKnots(random, i % 5, 3), randomKnots(random, 1 + i % 3, 2)}, 3, i % 3 == 0);
    const auto b = randomSpline<2>(random, {randomKnots(random, 3, 2), randomKnots(random, i % 6, 3)}, 3, i % 4 == 0);
    expectBounds<2>(a, b, 60, "case " + std::to_string(i));
  }
}

TEST(Deviation, BoundsHoldForVolumes) {
  std::mt19937_64 random(14);
  for (int i = 0; i < 8; ++i) {
    const std::array<KnotVector, 3> knots{randomKnots(random, 1 + i % 3, 2), randomKnots(random, 2, 2),
                                          randomKnots(random, i % 4, 2)};
    const auto a = randomSpline<3>(random, knots, 3, i % 4 == 1);
    const auto b = randomSpline<3>(random, knots, 3, i % 4 == 2);
    expectBounds<3>(a, b, 17, "case " + std::to_string(i));
  }
}

TEST(Deviation, OfASplineWithItselfIsZero) {
  std::mt19937_64 random(15);
  const auto a = randomSpline<2>(random, {randomKnots(random, 3, 5), randomKnots(random, 4, 6)}, 3, true, 1e6);
  const auto d = certifyDeviation(a, a);
  EXPECT_EQ(d.lower, 0);
  EXPECT_EQ(d.upper, 0);
}

TEST(Deviation, OfARefinedSplineIsRounding) {
  std::mt19937_64 random(16);
  Surface a = randomSpline<2>(random, {randomKnots(random, 3, 5), randomKnots(random, 4, 6)}, 3);
  a.net().array() += 1e4;  // far from the origin nothing is lost
  const Surface b = insertKnots<2>(insertKnots<2>(a, 0, {0.31, 0.5, 0.5001}), 1, {0.777});
  const auto d = certifyDeviation(a, b);
  EXPECT_LE(d.lower, 1e-11);
  EXPECT_LE(d.upper, 1e-11);
}

TEST(Deviation, OfAShiftIsItsLength) {
  std::mt19937_64 random(17);
  for (const bool rational : {false, true}) {
    const Surface a = randomSpline<2>(random, {randomKnots(random, 3, 5), randomKnots(random, 2, 6)}, 3, rational);
    Surface b = a;
    const Eigen::RowVector3d shift(0.3, -0.4, 1.2);
    for (Index r = 0; r < b.net().rows(); ++r) b.net().row(r).head(3) += shift * (rational ? b.net()(r, 3) : 1.0);
    for (const Surface& moved : {b, insertKnots<2>(b, 0, {0.123})}) {
      const auto d = certifyDeviation(a, moved);
      EXPECT_NEAR(d.lower, 1.3, 1e-11);
      EXPECT_NEAR(d.upper, 1.3, 1e-11);
    }
  }
}

TEST(Deviation, OfExampleOneLiesAboveItsDenseSamples) {
  STRAK_SHARED_SURFACE(clean, "hadenfeld1/unperturbed.g2");
  STRAK_SHARED_SURFACE(perturbed, "hadenfeld1/perturbed.g2");
  const auto d = certifyDeviation(clean, perturbed);
  EXPECT_NEAR(sampledDistance(clean, perturbed, 200), 0.0135476223, 1e-10);
  EXPECT_GE(d.upper, 0.0135476223);
  EXPECT_NEAR(d.upper, 0.01356, 5e-6);
  EXPECT_LE(d.upper - d.lower, 1e-4 * d.upper);
}

TEST(Deviation, ReferenceFigureOfTheNoisySphere) {
  STRAK_SHARED_SURFACE(clean, "fairness24/clean.g2");
  STRAK_SHARED_SURFACE(noisy, "fairness24/noisy.g2");
  EXPECT_NEAR(certifyDeviation(clean, noisy).upper, 0.01443, 5e-6);
  EXPECT_NEAR(certifyDeviation(noisy, clean).lower, 0.01443, 5e-6);
}

TEST(Deviation, IsTheSameForAnyNumberOfThreads) {
  std::mt19937_64 random(18);
  const std::array<KnotVector, 2> knots{randomKnots(random, 3, 30), randomKnots(random, 4, 30)};
  const auto a = randomSpline<2>(random, knots, 3), b = randomSpline<2>(random, knots, 3);
  const auto many = certifyDeviation(a, b);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto single = certifyDeviation(a, b);
  EXPECT_EQ(many.lower, single.lower);
  EXPECT_EQ(many.upper, single.upper);
  EXPECT_EQ(many.place, single.place);
}

TEST(Deviation, StaysValidWhenStoppedEarly) {
  std::mt19937_64 random(19);
  const std::array<KnotVector, 2> knots{randomKnots(random, 5, 6), randomKnots(random, 5, 6)};
  const auto a = randomSpline<2>(random, knots, 3), b = randomSpline<2>(random, knots, 3);
  const double dense = sampledDistance(a, b, 200);
  for (const Index patches : {0, 1, 100}) {
    const auto d = certifyDeviation(a, b, {.relativeWidth = 0, .maxPatches = patches});
    EXPECT_GE(d.upper, dense);
    EXPECT_LE(d.lower, dense * 1.01);
  }
}

TEST(Deviation, RefusesWhatCannotBeCompared) {
  std::mt19937_64 random(20);
  const KnotVector knots = KnotVector::uniformClamped(2, 3);
  const auto a = randomSpline<1>(random, {knots}, 3);
  EXPECT_THROW(certifyDeviation(a, randomSpline<1>(random, {knots}, 2)), InvalidInput);
  EXPECT_THROW(certifyDeviation(a, randomSpline<1>(random, {knots.rescaled(0, 1.1)}, 3)), InvalidInput);
  EXPECT_THROW(certifyDeviation(a, a, {.relativeWidth = -1}), InvalidInput);
  EXPECT_NO_THROW(certifyDeviation(a, randomSpline<1>(random, {knots.rescaled(0, 1 + 1e-14)}, 3)));
}

}  // namespace
}  // namespace strak
