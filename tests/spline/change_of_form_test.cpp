// Degree elevation, Bezier form, reparametrization and weights: other forms of the same geometry.

#include <gtest/gtest.h>

#include <limits>
#include <numeric>

#include "strak/base/error.h"
#include "strak/spline/bezier.h"
#include "strak/spline/degree_elevation.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/knot_insertion.h"
#include "strak/spline/rational.h"
#include "strak/spline/reparametrize.h"
#include "tests/spline/random_splines.h"

namespace strak {
namespace {

using strak::testing::Random;

template <class T>
class ChangeOfForm : public ::testing::Test {};

template <int D>
struct Directions {
  static constexpr int kCount = D;
};
using AllDirections = ::testing::Types<Directions<1>, Directions<2>, Directions<3>>;
TYPED_TEST_SUITE(ChangeOfForm, AllDirections);

constexpr int trials(int directions) { return directions == 3 ? 20 : 120; }

// Both splines at the same inner parameters of `b`.
template <int D>
void expectSame(Random& random, const Spline<D>& a, const Spline<D>& b, double tolerance = 1e-13) {
  ASSERT_EQ(a.pointDimension(), b.pointDimension());
  for (int i = 0; i < 8; ++i) {
    const auto u = testing::innerParameter(random, b);
    ASSERT_LT((evaluate(a, u) - evaluate(b, u)).cwiseAbs().maxCoeff(), tolerance);
  }
}

TYPED_TEST(ChangeOfForm, DegreeElevationChangesNoPoint) {
  constexpr int D = TypeParam::kCount;
  Random random(80 + D);
  for (int trial = 0; trial < trials(D); ++trial) {
    const auto spline = testing::randomSpline<D>(random, D == 3 ? 3 : 6);
    const int direction = random.integer(0, D - 1);
    const int steps = random.integer(0, 3);
    const auto raised = elevateDegree(spline, direction, steps);
    ASSERT_EQ(raised.degree(direction), spline.degree(direction) + steps);
    expectSame(random, spline, raised);
    // Continuity stays: every inner knot gains one a step.
    const auto before = spline.knots(direction).innerKnots();
    const auto after = raised.knots(direction).innerKnots();
    ASSERT_EQ(before.size(), after.size());
    for (std::size_t i = 0; i < before.size(); ++i) {
      ASSERT_EQ(after[i].value, before[i].value);
      ASSERT_EQ(after[i].multiplicity, before[i].multiplicity + steps);
    }
    ASSERT_EQ(raised.knots(direction).from(), spline.knots(direction).from());
    ASSERT_EQ(raised.knots(direction).to(), spline.knots(direction).to());
  }
}

TEST(DegreeElevation, GivesTheKnownPointsOfABezierQuadratic) {
  Net net(3, 1);
  net << 0, 6, 3;
  const Curve raised = elevateDegree(Curve({KnotVector::uniformClamped(2, 1)}, net), 0);
  EXPECT_LT((raised.net() - (Net(4, 1) << 0, 4, 5, 3).finished()).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_EQ(raised.knots(0), KnotVector::uniformClamped(3, 1));
}

TEST(DegreeElevation, MatrixIsStochasticForClampedKnots) {
  Random random(84);
  for (int trial = 0; trial < 100; ++trial) {
    const KnotVector knots = testing::randomKnots(random, 6);
    const Eigen::MatrixXd matrix = elevationMatrix(knots);
    ASSERT_GE(matrix.minCoeff(), 0);
    ASSERT_EQ(matrix.rows(), elevatedKnots(knots).size());
    if (knots.isClamped()) {
      ASSERT_LT((matrix.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-14);
    }
  }
}

TEST(DegreeElevation, RefusesNegativeSteps) { EXPECT_THROW(elevateDegree(Curve(), 0, -1), InvalidInput); }

TYPED_TEST(ChangeOfForm, BezierFormChangesNoPointAndItsPiecesAreBezier) {
  constexpr int D = TypeParam::kCount;
  Random random(90 + D);
  for (int trial = 0; trial < trials(D); ++trial) {
    const auto spline = testing::randomSpline<D>(random, D == 3 ? 3 : 6);
    const auto form = bezierForm(spline);
    expectSame(random, spline, form);
    std::size_t cells = 1;
    for (int k = 0; k < D; ++k) {
      const KnotVector& knots = form.knots(k);
      ASSERT_TRUE(knots.isClamped());
      ASSERT_EQ(knots.spans().size(), spline.knots(k).spans().size());
      for (const auto& knot : knots.innerKnots()) {
        ASSERT_EQ(knot.multiplicity, std::max(knots.degree(), spline.knots(k).multiplicity(knot.value)));
      }
      cells *= knots.spans().size();
    }
    ASSERT_EQ(bezierForm(form), form);

    const auto pieces = bezierPieces(spline);
    ASSERT_EQ(pieces.size(), cells);
    for (const auto& piece : pieces) {
      std::array<KnotVector, D> knots;
      typename Spline<D>::Parameter u;
      for (std::size_t k = 0; k < D; ++k) {
        knots[k] = KnotVector::uniformClamped(form.degree(static_cast<int>(k)), 1, piece.from[k], piece.to[k]);
        u[k] = random.uniform(piece.from[k], piece.to[k]);
      }
      const Spline<D> alone(knots, piece.points, spline.isRational());
      ASSERT_LT((evaluate(alone, u) - evaluate(spline, u)).cwiseAbs().maxCoeff(), 1e-13);
    }
  }
}

TEST(BezierForm, KeepsDiscontinuities) {
  const KnotVector knots(2, {0, 0, 0, 1, 1, 1, 2, 3, 3, 3});
  EXPECT_EQ(bezierKnots(knots).knots(), (std::vector<double>{0, 0, 0, 1, 1, 1, 2, 2, 3, 3, 3}));
  EXPECT_EQ(bezierKnots(KnotVector(0, {0, 1, 2})).knots(), (std::vector<double>{0, 1, 2}));
  EXPECT_EQ(bezierKnots(KnotVector(2, {-2, -1, 0, 1, 2, 3})).knots(), (std::vector<double>{0, 0, 0, 1, 1, 1}));
}

TYPED_TEST(ChangeOfForm, SubPatchIsThePart) {
  constexpr int D = TypeParam::kCount;
  Random random(100 + D);
  for (int trial = 0; trial < trials(D); ++trial) {
    const auto spline = testing::randomSpline<D>(random, D == 3 ? 3 : 6);
    typename Spline<D>::Parameter from, to;
    for (int k = 0; k < D; ++k) {
      const auto at = static_cast<std::size_t>(k);
      do {
        from[at] = testing::randomParameter(random, spline.knots(k));
        to[at] = testing::randomParameter(random, spline.knots(k));
      } while (!(from[at] < to[at]));
    }
    const auto part = subPatch(spline, from, to);
    for (int k = 0; k < D; ++k) {
      ASSERT_TRUE(part.knots(k).isClamped());
      ASSERT_EQ(part.knots(k).from(), from[static_cast<std::size_t>(k)]);
      ASSERT_EQ(part.knots(k).to(), to[static_cast<std::size_t>(k)]);
    }
    expectSame(random, spline, part);
    const auto whole = clamped(spline);
    expectSame(random, spline, whole);
    ASSERT_EQ(clamped(whole), whole);
  }
}

TEST(SubPatch, RefusesWhatIsNoPart) {
  Random random(104);
  const auto curve = testing::randomSpline<1>(random, {KnotVector::uniformClamped(2, 3)}, 2, false);
  EXPECT_THROW(subPatch(curve, 0, 0.5, 0.5), InvalidInput);
  EXPECT_THROW(subPatch(curve, 0, 0.7, 0.2), InvalidInput);
  EXPECT_THROW(subPatch(curve, 0, -0.1, 0.5), InvalidInput);
  EXPECT_THROW(subPatch(curve, 0, 0.5, 1.1), InvalidInput);
  EXPECT_THROW(subPatch(curve, 0, std::numeric_limits<double>::quiet_NaN(), 1), InvalidInput);
}

TYPED_TEST(ChangeOfForm, ReversalRunsBackwards) {
  constexpr int D = TypeParam::kCount;
  Random random(110 + D);
  for (int trial = 0; trial < trials(D); ++trial) {
    const auto spline = testing::randomSpline<D>(random, D == 3 ? 3 : 6);
    const int direction = random.integer(0, D - 1);
    const KnotVector& knots = spline.knots(direction);
    const auto back = reversed(spline, direction);
    ASSERT_EQ(back.knots(direction).from(), knots.from());
    ASSERT_EQ(back.knots(direction).to(), knots.to());
    for (int i = 0; i < 5; ++i) {
      const auto u = testing::innerParameter(random, spline);
      auto mirrored = u;
      auto& changed = mirrored[static_cast<std::size_t>(direction)];
      changed = knots.from() + knots.to() - changed;
      ASSERT_LT((evaluate(spline, u) - evaluate(back, mirrored)).cwiseAbs().maxCoeff(), 1e-12);
    }
    ASSERT_EQ(reversed(back, direction).net(), spline.net());
  }
}

TYPED_TEST(ChangeOfForm, PermutationExchangesTheParameters) {
  constexpr int D = TypeParam::kCount;
  Random random(120 + D);
  for (int trial = 0; trial < trials(D); ++trial) {
    const auto spline = testing::randomSpline<D>(random, 4);
    typename Spline<D>::Directions order;
    std::iota(order.begin(), order.end(), 0);
    for (int times = random.integer(0, 5); times > 0; --times) std::next_permutation(order.begin(), order.end());
    const auto changed = permuted(spline, order);
    const auto u = testing::innerParameter(random, spline);
    typename Spline<D>::Parameter v;
    for (std::size_t k = 0; k < D; ++k) v[k] = u[static_cast<std::size_t>(order[k])];
    ASSERT_LT((evaluate(spline, u) - evaluate(changed, v)).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(Permutation, TransposesSurfacesTwiceToTheSame) {
  Random random(124);
  const auto surface = testing::randomSpline<2>(random, 5);
  EXPECT_EQ(transposed(transposed(surface)), surface);
  EXPECT_EQ(transposed(surface).knots(0), surface.knots(1));
  EXPECT_THROW(permuted(surface, {0, 0}), InvalidInput);
  EXPECT_THROW(permuted(surface, {0, 2}), InvalidInput);
  EXPECT_THROW(permuted(surface, {-1, 0}), InvalidInput);
}

TYPED_TEST(ChangeOfForm, AffineDomainMapMovesNoPoint) {
  constexpr int D = TypeParam::kCount;
  Random random(130 + D);
  for (int trial = 0; trial < trials(D); ++trial) {
    const auto spline = testing::randomSpline<D>(random, D == 3 ? 3 : 6);
    const int direction = random.integer(0, D - 1);
    const double from = random.uniform(-5, 5);
    const double to = from + random.uniform(0.1, 10);
    const auto mapped = withDomain(spline, direction, from, to);
    ASSERT_EQ(mapped.net(), spline.net());
    const auto u = testing::innerParameter(random, spline);
    auto v = u;
    const KnotVector& knots = spline.knots(direction);
    auto& changed = v[static_cast<std::size_t>(direction)];
    changed = from + (changed - knots.from()) * ((to - from) / knots.length());
    ASSERT_LT((evaluate(spline, u) - evaluate(mapped, v)).cwiseAbs().maxCoeff(), 1e-12);
  }
  EXPECT_THROW(withDomain(Spline<D>(), 0, 1, 1), InvalidInput);
}

TYPED_TEST(ChangeOfForm, WeightsComeAndGo) {
  constexpr int D = TypeParam::kCount;
  Random random(140 + D);
  for (int trial = 0; trial < 20; ++trial) {
    const auto spline = testing::randomSpline<D>(random, 3, false);
    const auto rational = makeRational(spline);
    ASSERT_TRUE(rational.isRational());
    ASSERT_EQ(rational.pointDimension(), spline.pointDimension());
    ASSERT_EQ(weights(rational), Eigen::VectorXd::Ones(spline.net().rows()));
    ASSERT_EQ(makeRational(rational), rational);
    ASSERT_EQ(makePolynomial(rational), spline);
    ASSERT_EQ(makePolynomial(spline), spline);
    expectSame(random, spline, rational);
    // A common factor of the weights changes nothing.
    const auto doubled = withWeights(spline, Eigen::VectorXd::Constant(spline.net().rows(), 2));
    expectSame(random, spline, doubled);
    ASSERT_EQ(makePolynomial(doubled).net(), spline.net());
  }
}

TEST(Rational, RefusesWeightsThatDoNotFit) {
  Random random(144);
  const auto curve = testing::randomSpline<1>(random, {KnotVector::uniformClamped(2, 1)}, 2, false);
  EXPECT_THROW(withWeights(curve, Eigen::VectorXd::Ones(2)), InvalidInput);
  EXPECT_THROW(withWeights(curve, Eigen::Vector3d(1, 0, 1)), InvalidInput);
  EXPECT_THROW(withWeights(curve, Eigen::Vector3d(1, std::numeric_limits<double>::quiet_NaN(), 1)), InvalidInput);
  EXPECT_THROW(makePolynomial(withWeights(curve, Eigen::Vector3d(1, 2, 1))), InvalidInput);
}

}  // namespace
}  // namespace strak
