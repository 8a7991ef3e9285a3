#include "strak/metrology/closest_point.h"

#include <tbb/global_control.h>

#include <limits>

#include "strak/base/error.h"
#include "strak/metrology/hausdorff.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/knot_insertion.h"
#include "tests/metrology/test_surfaces.h"

namespace strak {
namespace {

template <int D>
double sampledMinimum(const Spline<D>& s, const Point& p, Index perDirection) {
  Index count = 1;
  for (int k = 0; k < D; ++k) count *= perDirection;
  Net parameters(count, D);
  for (Index r = 0; r < count; ++r) {
    Index rest = r;
    for (int k = D - 1; k >= 0; --k) {
      parameters(r, k) = std::lerp(s.knots(k).from(), s.knots(k).to(),
                                   static_cast<double>(rest % perDirection) / static_cast<double>(perDirection - 1));
      rest /= perDirection;
    }
  }
  return (derivativesAt<D>(s, parameters, 0).rowwise() - p).rowwise().norm().minCoeff();
}

template <int D>
void expectMinimum(const Spline<D>& s, const Point& p, Index samples) {
  const ClosestPoint<D> found = closestPoint<D>(s, p);
  EXPECT_TRUE(found.converged);
  EXPECT_LE(found.distance, sampledMinimum<D>(s, p, samples) + 1e-12);
  EXPECT_NEAR((evaluate<D>(s, found.parameters) - found.point).norm(), 0, 1e-12);
  // The sign conditions: no derivative of the distance points inwards and down, away from creases none is left at all.
  const Net d = derivatives<D>(s, found.parameters, 1);
  for (int k = 0; k < D; ++k) {
    const double u = found.parameters[static_cast<std::size_t>(k)];
    const double slope = (found.point - p).dot(d.row(1 + k)) / (1e-30 + d.row(1 + k).norm());
    bool onKnot = false;
    for (const auto& knot : s.knots(k).innerKnots()) {
      onKnot = onKnot || (std::abs(u - knot.value) < 1e-9 && knot.multiplicity >= s.degree(k));
    }
    if (onKnot) continue;
    if (u > s.knots(k).from()) {
      EXPECT_LT(slope, 1e-6);
    }
    if (u < s.knots(k).to()) {
      EXPECT_GT(slope, -1e-6);
    }
  }
}

TEST(ClosestPoint, OnRandomCurvesIsBelowAllSamples) {
  std::mt19937_64 random(31);
  for (int i = 0; i < 100; ++i) {
    const Index dimension = 2 + i % 2;
    const Curve c =
        testing::randomSpline<1>(random, {testing::randomKnots(random, 1 + i % 5, 1 + i % 6)}, dimension, i % 3 == 0);
    expectMinimum<1>(c, 1.5 * Point::Random(dimension), 2000);
  }
}

TEST(ClosestPoint, OnRandomSurfacesIsBelowAllSamples) {
  std::mt19937_64 random(32);
  for (int i = 0; i < 40; ++i) {
    const Surface s = testing::randomSpline<2>(
        random, {testing::randomKnots(random, 1 + i % 5, 1 + i % 4), testing::randomKnots(random, 1 + i % 3, 3)}, 3,
        i % 3 == 0);
    expectMinimum<2>(s, 1.5 * Point::Random(3), 120);
  }
}

TEST(ClosestPoint, ComesBackToPointsOfTheSurface) {
  const Surface ring = testing::torus(3, 1);
  const ClosestPointFinder<2> finder(ring);
  std::mt19937_64 random(33);
  std::uniform_real_distribution<double> unit(0, 4);
  for (int i = 0; i < 50; ++i) {
    const Point on = evaluate<2>(ring, {unit(random), unit(random)});
    EXPECT_NEAR(finder.find(on).distance, 0, 1e-10);
    // Half a tube radius inwards the distance is half: Newton's method near the centre of curvature.
    const Point ringCentre = 3 * Eigen::RowVector3d(on[0], on[1], 0).normalized();
    EXPECT_NEAR(finder.find(0.95 * ringCentre + 0.05 * on).distance, 0.95, 1e-10);
  }
}

TEST(ClosestPoint, OnTheEdgeOfTheDomainTheSignDecides) {
  const Surface flat = testing::paraboloid(0, 0, 0);  // [-1, 1]^2
  const auto corner = closestPoint<2>(flat, Eigen::RowVector3d(2, 3, 1));
  EXPECT_EQ(corner.parameters, (std::array<double, 2>{1, 1}));
  EXPECT_NEAR(corner.distance, std::sqrt(1 + 4 + 1), 1e-14);
  const auto edge = closestPoint<2>(flat, Eigen::RowVector3d(0.25, -7, 0));
  EXPECT_NEAR(edge.parameters[0], 0.25, 1e-12);
  EXPECT_EQ(edge.parameters[1], -1);
}

TEST(ClosestPoint, EndsWhereAllPointsAreEquallyFar) {
  const auto found = closestPoint<2>(testing::sphere(2), Eigen::RowVector3d(0, 0, 0));
  EXPECT_NEAR(found.distance, 2, 1e-12);
}

TEST(ClosestPoint, StartedFromGivenParametersStaysOnItsSide) {
  const Surface ring = testing::torus(3, 1);
  const ClosestPointFinder<2> finder(ring);
  const auto found = finder.findFrom(evaluate<2>(ring, {1.3, 0.4}), {1.25, 0.5});
  EXPECT_NEAR(found.parameters[0], 1.3, 1e-8);
  EXPECT_NEAR(found.parameters[1], 0.4, 1e-8);
}

TEST(ClosestPoint, RefusesBadInput) {
  const Surface flat = testing::paraboloid(0, 0, 0);
  EXPECT_THROW(closestPoint<2>(flat, Eigen::RowVector2d(1, 1)), InvalidInput);
  EXPECT_THROW(closestPoint<2>(flat, Eigen::RowVector3d(1, std::numeric_limits<double>::quiet_NaN(), 0)), InvalidInput);
  EXPECT_THROW(ClosestPointFinder<2>(flat, {.cellsPerDirection = 0}), InvalidInput);
}

TEST(Hausdorff, OfConcentricSpheresIsTheDifferenceOfTheRadii) {
  const auto d = hausdorffDistance(testing::sphere(2), testing::sphere(2.25));
  EXPECT_NEAR(d.distance, 0.25, 1e-9);
  EXPECT_NEAR(d.fromA.rms, 0.25, 1e-9);
  EXPECT_NEAR(d.fromB.max, 0.25, 1e-9);
}

TEST(Hausdorff, DoesNotSeeParameters) {
  const Surface s = testing::paraboloid(0.3, 0.2, -0.4);
  Surface other({s.knots(0).rescaled(0, 5), s.knots(1).rescaled(2, 3)}, s.net());
  other = insertKnots<2>(other, 0, {1.0, 2.0});
  EXPECT_NEAR(hausdorffDistance(s, other).distance, 0, 1e-9);
}

TEST(Hausdorff, IsTwoSidedAndFindsTheWorstPlace) {
  // A part of a plane, and that plane with a narrow bump: the bump is far from the plane, not the other way round.
  const KnotVector knots = KnotVector::uniformClamped(3, 20, 0, 1);
  Net net(knots.size() * knots.size(), 3);
  const auto greville = knots.greville();
  for (Index i = 0; i < knots.size(); ++i) {
    for (Index j = 0; j < knots.size(); ++j) {
      net.row(i * knots.size() + j) << greville[static_cast<std::size_t>(i)], greville[static_cast<std::size_t>(j)],
          i == 11 && j == 9 ? 0.1 : 0.0;
    }
  }
  const Surface bump({knots, knots}, net);
  net.col(2).setZero();
  const Surface flat({knots, knots}, net);
  const auto d = hausdorffDistance(bump, flat, {.samplesPerSpan = 2, .minSamples = 2});
  EXPECT_NEAR(d.fromA.max, 0.1 * 4 / 9, 1e-7);  // cubic B-splines peak at 2/3
  EXPECT_NEAR(d.fromA.place[0], greville[11], 1e-3);
  EXPECT_LT(d.fromB.max, d.fromA.max);
  EXPECT_EQ(d.distance, d.fromA.max);
  const auto cut = hausdorffDistance(bump, flat, {.insideA = [](double u, double) { return u < 0.3; }});
  EXPECT_NEAR(cut.fromA.max, 0, 1e-9);
}

TEST(Hausdorff, IsTheSameForAnyNumberOfThreadsAndCanBeCancelled) {
  const Surface a = testing::torus(3, 1), b = testing::torus(3.1, 0.95);
  const auto many = hausdorffDistance(a, b, {.samplesPerSpan = 2, .minSamples = 8});
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto single = hausdorffDistance(a, b, {.samplesPerSpan = 2, .minSamples = 8});
  EXPECT_EQ(many.distance, single.distance);
  EXPECT_EQ(many.fromA.rms, single.fromA.rms);
  EXPECT_NEAR(many.distance, 0.15, 1e-7);
  const auto stopped = hausdorffDistance(a, b, {.progress = Progress([](double, std::string_view) { return false; })});
  EXPECT_FALSE(stopped.complete);
}

}  // namespace
}  // namespace strak
