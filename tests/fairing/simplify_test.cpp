#include "strak/fairing/simplify.h"

#include <gtest/gtest.h>

#include <cmath>

#include "strak/base/error.h"
#include "strak/metrology/fairness.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/knot_insertion.h"
#include "strak/spline/rational.h"
#include "tests/spline/random_splines.h"

namespace strak {
namespace {

using strak::testing::Random;

// A smooth surface about 10 x 8 large.
Surface calmSurface(int degree, Index nu, Index nv) {
  const auto u = KnotVector::uniformClamped(degree, nu - degree, 0, 1);
  const auto v = KnotVector::uniformClamped(degree, nv - degree, 0, 2);
  const auto gu = u.greville(), gv = v.greville();
  Net net(nu * nv, 3);
  Index r = 0;
  for (double x : gu) {
    for (double y : gv) net.row(r++) << 10 * x, 4 * y, std::sin(2 * x + y) + 0.3 * x * y * y;
  }
  return Surface({u, v}, net);
}

template <int D>
void undoesInsertion(int trials) {
  Random random(80 + D);
  for (int trial = 0; trial < trials; ++trial) {
    std::array<KnotVector, static_cast<std::size_t>(D)> knots;
    for (auto& k : knots) {
      k = testing::randomKnots(random, testing::KnotKind::nonUniform, random.integer(1, D == 3 ? 3 : 5),
                               random.integer(1, 4));
    }
    const Spline<D> spline = testing::randomSpline<D>(random, knots, 3, random.coin());
    Spline<D> fine = spline;
    Index inserted = 0;
    for (int i = 0; i < 4; ++i) {
      const int k = random.integer(0, D - 1);
      fine = insertKnots(fine, k, {testing::innerParameter(random, fine.knots(k))});
      ++inserted;
    }
    const Simplified<D> result = simplify(fine, SimplifyOptions<D>{});
    ASSERT_GE(result.knotsRemoved, inserted) << "trial " << trial;
    ASSERT_LT(result.deviation.upper, 1e-11) << "trial " << trial;
  }
}

TEST(Simplify, ToleranceZeroUndoesInsertionInCurves) { undoesInsertion<1>(40); }
TEST(Simplify, ToleranceZeroUndoesInsertionInSurfaces) { undoesInsertion<2>(20); }
TEST(Simplify, ToleranceZeroUndoesInsertionInVolumes) { undoesInsertion<3>(5); }

TEST(Simplify, KeepsToleranceAndFairness) {
  const Surface surface = calmSurface(3, 30, 26);
  SimplifyOptions<2> options;
  options.tolerance = 1e-3;
  options.rows = SimplifyOptions<2>::heldRows(0);
  const auto result = simplify(surface, options);
  EXPECT_LE(result.deviation.upper, options.tolerance);
  EXPECT_EQ(result.deviation.upper, certifyDeviation(result.spline, surface).upper);
  EXPECT_LT(result.spline.net().rows(), surface.net().rows() / 2);
  EXPECT_EQ(result.knotsRemoved, surface.size(0) + surface.size(1) - result.spline.size(0) - result.spline.size(1));
  const SurfaceFairness before = surfaceFairness(surface), after = surfaceFairness(result.spline);
  EXPECT_LE(after.plate, 1.014 * before.plate);
  EXPECT_LE(after.curvatureVariation, 1.014 * before.curvatureVariation);
  EXPECT_LE(after.isophoteRoughness, 1.014 * before.isophoteRoughness);
}

TEST(Simplify, MoreToleranceNeedsFewerPoints) {
  const Surface surface = calmSurface(4, 24, 20);
  SimplifyOptions<2> options;
  options.rows = SimplifyOptions<2>::heldRows(0);
  options.fairnessGrowth = 1.05;
  Index last = surface.net().rows();
  for (double tolerance : {1e-5, 1e-4, 1e-3, 1e-2}) {
    options.tolerance = tolerance;
    const auto result = simplify(surface, options);
    EXPECT_LE(result.deviation.upper, tolerance);
    EXPECT_LE(result.spline.net().rows(), last);
    last = result.spline.net().rows();
  }
  EXPECT_LT(last, 120);
}

// Held strips: value, first and second derivative along all sides stay to rounding; only what they do not need goes.
TEST(Simplify, HeldStripsKeepTheirDerivatives) {
  const Surface coarse = calmSurface(3, 10, 9);
  Surface surface = insertKnots(coarse, 0, {0.11, 0.23, 0.37, 0.52, 0.68, 0.81});
  surface = insertKnots(surface, 1, {0.21, 0.45, 0.9, 1.3, 1.71});
  for (Index i = 4; i + 4 < surface.size(0); ++i) {
    for (Index j = 4; j + 4 < surface.size(1); ++j)
      surface.net()(surface.row({i, j}), 2) += 1e-4 * std::cos(3.0 * static_cast<double>(i + 2 * j));
  }
  SimplifyOptions<2> options;
  options.tolerance = 1e-2;
  const auto result = simplify(surface, options);
  EXPECT_EQ(result.knotsRemoved, 11);
  EXPECT_EQ(result.spline.knots(), coarse.knots());
  for (int i = 0; i <= 20; ++i) {
    const double t = i / 20.0;
    for (const auto& at : {Surface::Parameter{t, 0}, Surface::Parameter{t, 2}}) {
      const Net had = derivatives(surface, at, 2), has = derivatives(result.spline, at, 2);
      for (int row : {0, 1, 2, 4, 5}) ASSERT_LT((had.row(row) - has.row(row)).norm(), 1e-9) << t << " row " << row;
    }
    for (const auto& at : {Surface::Parameter{0, 2 * t}, Surface::Parameter{1, 2 * t}}) {
      const Net had = derivatives(surface, at, 2), has = derivatives(result.spline, at, 2);
      for (int row : {0, 1, 2, 3, 4}) ASSERT_LT((had.row(row) - has.row(row)).norm(), 1e-9) << t << " row " << row;
    }
  }
}

TEST(Simplify, NeedyStripsKeepTheirKnots) {
  const Surface surface = calmSurface(3, 16, 14);  // every side's curve needs all knots
  SimplifyOptions<2> options;
  options.tolerance = 1;
  const auto result = simplify(surface, options);
  EXPECT_EQ(result.knotsRemoved, 0);
  EXPECT_EQ(result.spline, surface);
  EXPECT_EQ(result.deviation.upper, 0);
}

TEST(Simplify, ClosedCurvesStayClosed) {
  const auto knots = KnotVector::uniformClamped(3, 40, 0, 1);
  const auto greville = knots.greville();
  Net net(knots.size(), 2);
  for (Index i = 0; i < knots.size(); ++i) {
    const double a = 2 * M_PI * greville[static_cast<std::size_t>(i)];
    net.row(i) << 3 * std::cos(a), 2 * std::sin(a);
  }
  net.row(knots.size() - 1) = net.row(0);
  SimplifyOptions<1> options;
  options.tolerance = 1e-3;
  options.rows = {2, 0};
  const Curve curve({knots}, net);
  const auto result = simplify(curve, options);
  EXPECT_LT(result.spline.size(0), 30);
  EXPECT_LE(result.deviation.upper, 1e-3);
  const Net had = derivatives(curve, {0.0}, 1), has = derivatives(result.spline, {0.0}, 1);
  EXPECT_LT((had - has).norm(), 1e-10);
  EXPECT_LT((derivatives(curve, {1.0}, 1) - derivatives(result.spline, {1.0}, 1)).norm(), 1e-10);
}

TEST(Simplify, CreasesStay) {
  const KnotVector knots(3, {0, 0, 0, 0, 0.2, 0.4, 0.4, 0.4, 0.6, 0.8, 1, 1, 1, 1});
  Net net(10, 2);
  const auto greville = knots.greville();
  for (Index i = 0; i < 10; ++i) {
    const double x = greville[static_cast<std::size_t>(i)];
    net.row(i) << x, 1e-3 * std::abs(x - 0.4);
  }
  SimplifyOptions<1> options;
  options.tolerance = 0.1;
  options.fairnessGrowth = 1e3;
  const auto result = simplify(Curve({knots}, net), options);
  EXPECT_EQ(result.spline.knots(0).multiplicity(0.4), 3);
}

TEST(Simplify, RationalKeepsTheTolerance) {
  // A quarter of a torus-like surface of revolution on many knots.
  Surface surface = calmSurface(3, 20, 20);
  Eigen::VectorXd weights(surface.net().rows());
  for (Index r = 0; r < weights.size(); ++r) weights(r) = 1 + 0.2 * std::sin(0.01 * static_cast<double>(r));
  const Surface rational = withWeights(makeRational(surface), weights);
  SimplifyOptions<2> options;
  options.tolerance = 5e-3;
  options.rows = SimplifyOptions<2>::heldRows(0);
  options.fairnessGrowth = 1.2;
  const auto result = simplify(rational, options);
  EXPECT_TRUE(result.spline.isRational());
  EXPECT_GT(result.knotsRemoved, 10);
  EXPECT_LE(certifyDeviation(result.spline, rational).upper, options.tolerance);
}

TEST(Simplify, TheReferenceCounts) {
  const Surface reference = calmSurface(3, 20, 18);
  Surface moved = reference;
  for (Index r = 0; r < moved.net().rows(); ++r) moved.net()(r, 2) += 9e-4;
  SimplifyOptions<2> options;
  options.tolerance = 1e-3;
  options.rows = SimplifyOptions<2>::heldRows(0);
  options.fairnessGrowth = 10;
  const auto free = simplify(moved, options);
  const auto bound = simplify(moved, reference, options);
  EXPECT_LE(certifyDeviation(bound.spline, reference).upper, 1e-3);
  EXPECT_LT(free.spline.net().rows(), bound.spline.net().rows());
  EXPECT_GT(bound.knotsRemoved, 0);
}

TEST(Simplify, SaysWhatIsWrong) {
  const Surface surface = calmSurface(3, 8, 8);
  SimplifyOptions<2> options;
  options.tolerance = -1;
  EXPECT_THROW(simplify(surface, options), InvalidInput);
  options.tolerance = std::nan("");
  EXPECT_THROW(simplify(surface, options), InvalidInput);
  options.tolerance = 1;
  options.fairnessGrowth = 0.5;
  EXPECT_THROW(simplify(surface, options), InvalidInput);
  options.fairnessGrowth = 1;
  options.rows[2] = -1;
  EXPECT_THROW(simplify(surface, options), InvalidInput);
}

}  // namespace
}  // namespace strak
