#include "strak/spline/knot_removal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "strak/base/error.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/knot_insertion.h"
#include "strak/spline/rational.h"
#include "tests/spline/random_splines.h"

namespace strak {
namespace {

using strak::testing::Random;

template <int D>
void removeWhatWasInserted(int trials) {
  Random random(60 + D);
  for (int trial = 0; trial < trials; ++trial) {
    const auto spline = testing::randomSpline<D>(random, D == 3 ? 4 : 7);
    const int direction = random.integer(0, D - 1);
    const KnotVector& knots = spline.knots(direction);
    std::vector<double> added;
    KnotVector fine = knots;
    for (int i = 0; i < 3; ++i) {
      const double u = random.coin() ? testing::innerParameter(random, knots) : testing::randomParameter(random, knots);
      if (u <= knots.from() || u >= knots.to() || fine.multiplicity(u) > knots.degree()) continue;
      fine = withKnots(fine, {u});
      added.push_back(u);
    }
    const auto removal = removeKnots(insertKnots(spline, direction, added), direction, added);
    ASSERT_EQ(removal.spline.knots(direction), knots);
    ASSERT_LT((removal.spline.net() - spline.net()).cwiseAbs().maxCoeff(), 1e-12);
    ASSERT_LT(removal.bound, 1e-13);
  }
}

TEST(KnotRemoval, UndoesInsertionInCurves) { removeWhatWasInserted<1>(200); }
TEST(KnotRemoval, UndoesInsertionInSurfaces) { removeWhatWasInserted<2>(80); }
TEST(KnotRemoval, UndoesInsertionInVolumes) { removeWhatWasInserted<3>(20); }

template <int D>
void boundHolds(int trials) {
  Random random(65 + D);
  int sharp = 0;
  int removals = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const auto spline = testing::randomSpline<D>(random, D == 3 ? 3 : 5);
    const int direction = random.integer(0, D - 1);
    const auto inner = spline.knots(direction).innerKnots();
    if (inner.empty()) continue;
    const double knot = inner[static_cast<std::size_t>(random.integer(0, static_cast<int>(inner.size()) - 1))].value;
    KnotRemoval<D> removal;
    try {
      removal = removeKnots(spline, direction, {knot});
    } catch (const Failure&) {
      ASSERT_TRUE(spline.isRational());  // a weight would have gone: a clear refusal
      continue;
    }
    ++removals;
    double worst = 0;
    for (int i = 0; i < 200; ++i) {
      const auto u = testing::innerParameter(random, spline);
      worst = std::max(worst, (evaluate(spline, u) - evaluate(removal.spline, u)).norm());
    }
    ASSERT_LE(worst, removal.bound * (1 + 1e-12) + 1e-14);
    sharp += worst > removal.bound / 10 ? 1 : 0;
    // A clamped end keeps its points to the bit.
    const KnotVector& knots = spline.knots(direction);
    if (knots.isClamped() && knots.degree() > 0) {
      auto at = [&](const Spline<D>& of, bool end) {
        typename Spline<D>::Sizes index{};
        if (end) index[static_cast<std::size_t>(direction)] = of.size(direction) - 1;
        return Point(of.net().row(of.row(index)));
      };
      ASSERT_EQ(at(spline, false), at(removal.spline, false));
      ASSERT_EQ(at(spline, true), at(removal.spline, true));
    }
  }
  EXPECT_GT(sharp, removals / 3);
}

TEST(KnotRemoval, BoundHoldsForCurves) { boundHolds<1>(200); }
TEST(KnotRemoval, BoundHoldsForSurfaces) { boundHolds<2>(60); }
TEST(KnotRemoval, BoundHoldsForVolumes) { boundHolds<3>(15); }

TEST(KnotRemoval, RemovesAKinkWithItsKnownError) {
  // The roof 0, 1, 0 over [0, 2]: without its ridge only the straight line between the fixed ends is left.
  Net net(3, 1);
  net << 0, 1, 0;
  const auto removal = removeKnots(Curve({KnotVector(1, {0, 0, 1, 2, 2})}, net), 0, {1});
  EXPECT_EQ(removal.spline.net(), Net::Zero(2, 1));
  EXPECT_EQ(removal.bound, 1);
}

TEST(KnotRemoval, FindsWhatCostsNothing) {
  Random random(70);
  for (int trial = 0; trial < 30; ++trial) {
    std::array<KnotVector, 2> knots;
    for (auto& direction : knots) {
      direction = testing::randomKnots(random, testing::kKnotKinds[random.integer(0, 5)], random.integer(1, 5), 4);
    }
    const auto surface = testing::randomSpline<2>(random, knots, 3, random.coin());
    std::vector<double> added;
    for (int i = 0; i < 5; ++i) added.push_back(testing::innerParameter(random, knots[1]));
    const auto removal = removeKnotsWithin(insertKnots(surface, 1, added), 1, 1e-11);
    std::sort(added.begin(), added.end());
    ASSERT_EQ(removal.removed, added);
    ASSERT_EQ(removal.spline.knots(1), knots[1]);
    ASSERT_LE(removal.bound, 1e-11);
  }
}

TEST(KnotRemoval, ThinsOutADenseCurveWithinItsTolerance) {
  // A circle of 200 spans needs far fewer of them for a thousandth.
  const auto knots = KnotVector::uniformClamped(3, 200, 0, 6);
  const auto greville = knots.greville();
  Net net(knots.size(), 2);
  for (Index i = 0; i < net.rows(); ++i) {
    const double u = greville[static_cast<std::size_t>(i)];
    net.row(i) << std::cos(u), std::sin(u);
  }
  const Curve curve({knots}, net);
  Index last = knots.size();
  for (const double tolerance : {1e-6, 1e-4, 1e-2}) {
    const auto removal = removeKnotsWithin(curve, 0, tolerance);
    EXPECT_LE(removal.bound, tolerance);
    EXPECT_LT(removal.spline.size(0), last);
    EXPECT_EQ(removal.spline.size(0) + static_cast<Index>(removal.removed.size()), knots.size());
    last = removal.spline.size(0);
    for (int i = 0; i <= 100; ++i) {
      const double u = 6 * i / 100.0;
      ASSERT_LE((evaluate(curve, {u}) - evaluate(removal.spline, {u})).norm(), tolerance);
    }
  }
  EXPECT_LT(last, 20);
}

TEST(KnotRemoval, DoesNotDependOnTheUnitOrThePlace) {
  Random random(71);
  const auto curve = testing::randomSpline<1>(random, {KnotVector::uniformClamped(3, 10)}, 3, true);
  const auto moved = [&](double scale, double shift) {
    Net net = curve.euclideanNet() * scale;
    net.array() += shift;
    return withWeights(Curve(curve.knots(), net), weights(curve));
  };
  const double bound = removeKnots(curve, 0, {0.5}).bound;
  EXPECT_NEAR(removeKnots(moved(1e6, 0), 0, {0.5}).bound, bound * 1e6, bound * 1e-4);
  EXPECT_NEAR(removeKnots(moved(1, 1000), 0, {0.5}).bound, bound, bound * 1e-9);
}

TEST(KnotRemoval, RefusesBadRequests) {
  Random random(72);
  const auto curve = testing::randomSpline<1>(random, {KnotVector(2, {0, 0, 0, 0.5, 1, 1, 1})}, 3, false);
  EXPECT_THROW(removeKnots(curve, 0, {0.25}), InvalidInput);
  EXPECT_THROW(removeKnots(curve, 0, {0.0}), InvalidInput);
  EXPECT_THROW(removeKnots(curve, 0, {1.0}), InvalidInput);
  EXPECT_THROW(removeKnots(curve, 0, {2.0}), InvalidInput);
  EXPECT_THROW(removeKnots(curve, 0, {0.5, 0.5}), InvalidInput);
  EXPECT_THROW(removeKnots(curve, 0, {std::numeric_limits<double>::quiet_NaN()}), InvalidInput);
  EXPECT_THROW(removeKnotsWithin(curve, 0, -1), InvalidInput);
  EXPECT_THROW(removeKnotsWithin(curve, 0, std::numeric_limits<double>::quiet_NaN()), InvalidInput);
  EXPECT_EQ(removeKnots(curve, 0, {}).spline, curve);
}

TEST(KnotRemoval, RefusesToLoseAWeight) {
  // Weights 1, 0.01, 1 with a kink: without the knot the middle one would have to be far below zero.
  Net net(5, 2);
  net << 0, 1, 0.001, 0.001, 0, 0.001, 0.001, 0.001, 0, 1;
  const Curve curve({KnotVector(2, {0, 0, 0, 1, 2, 3, 3, 3})}, net, true);
  EXPECT_THROW(removeKnots(curve, 0, {1, 2}), Failure);
  EXPECT_LE(removeKnotsWithin(curve, 0, 1e-6).bound, 1e-6);
}

}  // namespace
}  // namespace strak
