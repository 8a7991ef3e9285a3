#include "strak/spline/knot_insertion.h"

#include <gtest/gtest.h>

#include <limits>

#include "strak/base/error.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/net_product.h"
#include "tests/spline/random_splines.h"

namespace strak {
namespace {

using strak::testing::Random;

// Some new knots that fit: anywhere inside, on knots that are there, at the ends.
std::vector<double> someNewKnots(Random& random, const KnotVector& knots, int count) {
  std::vector<double> result;
  KnotVector current = knots;
  for (int i = 0; i < count; ++i) {
    const double u = testing::randomParameter(random, knots);
    if (current.multiplicity(u) > knots.degree()) continue;
    current = withKnots(current, {u});
    result.push_back(u);
  }
  return result;
}

template <int D>
void expectSame(Random& random, const Spline<D>& a, const Spline<D>& b) {
  ASSERT_EQ(a.isRational(), b.isRational());
  for (int i = 0; i < 10; ++i) {
    const auto u = testing::innerParameter(random, b);
    ASSERT_LT((evaluate(a, u) - evaluate(b, u)).cwiseAbs().maxCoeff(), 1e-13);
  }
}

template <int D>
void insertIntoRandomSplines(int trials) {
  Random random(50 + D);
  for (int trial = 0; trial < trials; ++trial) {
    const auto spline = testing::randomSpline<D>(random, D == 3 ? 4 : 7);
    Spline<D> fine = spline;
    for (int k = 0; k < D; ++k) fine = insertKnots(fine, k, someNewKnots(random, spline.knots(k), 4));
    expectSame(random, spline, fine);
    // At once it is the same as one direction after the other, and the missing knots are those inserted.
    ASSERT_EQ(refine(spline, fine.knots()), fine);
    ASSERT_EQ(refine(spline, spline.knots()), spline);
  }
}

TEST(KnotInsertion, ChangesNoPointOfCurves) { insertIntoRandomSplines<1>(300); }
TEST(KnotInsertion, ChangesNoPointOfSurfaces) { insertIntoRandomSplines<2>(100); }
TEST(KnotInsertion, ChangesNoPointOfVolumes) { insertIntoRandomSplines<3>(20); }

TEST(KnotInsertion, GivesTheKnownPointsOfACubic) {
  // Cutting a Bezier cubic in the middle is de Casteljau's scheme.
  Net net(4, 1);
  net << 0, 8, 16, 0;
  const Curve curve({KnotVector::uniformClamped(3, 1)}, net);
  const Curve cut = insertKnots(curve, 0, {0.5, 0.5, 0.5});
  EXPECT_EQ(cut.net(), (Net(7, 1) << 0, 4, 8, 9, 10, 8, 0).finished());
}

TEST(KnotInsertion, LeavesFarControlPointsToTheBit) {
  Random random(54);
  const auto curve = testing::randomSpline<1>(random, {KnotVector::uniformClamped(3, 12)}, 3, false);
  const Curve fine = insertKnots(curve, 0, {0.46});
  EXPECT_EQ(fine.net().topRows(6), curve.net().topRows(6));
  EXPECT_EQ(fine.net().bottomRows(7), curve.net().bottomRows(7));
}

TEST(RefinementMatrix, IsStochasticAndBanded) {
  Random random(55);
  for (int trial = 0; trial < 300; ++trial) {
    const KnotVector coarse = testing::randomKnots(random, 7);
    const KnotVector fine = withKnots(coarse, someNewKnots(random, coarse, 6));
    const Eigen::SparseMatrix<double> matrix = refinementMatrix(coarse, fine);
    ASSERT_EQ(matrix.rows(), fine.size());
    ASSERT_EQ(matrix.cols(), coarse.size());
    const Eigen::MatrixXd dense = matrix;
    ASSERT_GE(dense.minCoeff(), 0);
    for (Index j = 0; j < dense.rows(); ++j) ASSERT_LE((dense.row(j).array() != 0).count(), coarse.degree() + 1);
    if (coarse.isClamped()) {
      ASSERT_LT((dense.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-14);
    }
    // Refining twice is refining once.
    const KnotVector finest = withKnots(fine, someNewKnots(random, fine, 6));
    const Eigen::MatrixXd twice = Eigen::MatrixXd(refinementMatrix(fine, finest)) * dense;
    ASSERT_LT((twice - Eigen::MatrixXd(refinementMatrix(coarse, finest))).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(RefinementMatrix, OfTheSameKnotsIsTheIdentity) {
  Random random(56);
  for (int trial = 0; trial < 100; ++trial) {
    const KnotVector knots = testing::randomKnots(random, 7);
    const Eigen::MatrixXd matrix = refinementMatrix(knots, knots);
    ASSERT_EQ(matrix, Eigen::MatrixXd::Identity(knots.size(), knots.size()));
  }
}

TEST(RefinementMatrix, HalvesUniformCubicsLikeTheBook) {
  const KnotVector coarse(3, {-3, -2, -1, 0, 1, 2, 3, 4, 5});
  const KnotVector fine = withKnots(coarse, {0.5, 1.5});
  // Unclamped ends keep their knots, so only the middle rows are the binomial mask.
  const Eigen::MatrixXd matrix = refinementMatrix(coarse, fine);
  const KnotVector halved(3, {-1.5, -1, -0.5, 0, 0.5, 1, 1.5, 2, 2.5, 3, 3.5});
  EXPECT_EQ(matrix.row(3), (Eigen::RowVectorXd(5) << 0, 1.0 / 8, 6.0 / 8, 1.0 / 8, 0).finished());
  EXPECT_THROW(refinementMatrix(coarse, halved), InvalidInput);
}

TEST(RefinementMatrix, RefusesWhatIsNoRefinement) {
  const KnotVector coarse(2, {0, 0, 0, 0.5, 0.5, 1, 1, 1});
  EXPECT_THROW(refinementMatrix(coarse, KnotVector::uniformClamped(3, 4)), InvalidInput);
  EXPECT_THROW(refinementMatrix(coarse, KnotVector::uniformClamped(2, 2, 0, 2)), InvalidInput);
  try {
    refinementMatrix(coarse, KnotVector(2, {0, 0, 0, 0.25, 0.5, 0.75, 1, 1, 1}));
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(std::string(error.what()),
              "the fine knots have 0.5 1 times but the coarse ones 2 times: refining only adds knots");
  }
}

TEST(KnotInsertion, RefusesBadKnotsAndSaysWhich) {
  Random random(57);
  const auto surface =
      testing::randomSpline<2>(random, {KnotVector::uniformClamped(2, 2), KnotVector::uniformClamped(3, 2)}, 3, false);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(insertKnots(surface, 0, {nan}), InvalidInput);
  EXPECT_THROW(insertKnots(surface, 0, {-0.1}), InvalidInput);
  try {
    insertKnots(surface, 1, {0.5, 1.5});
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(std::string(error.what()),
              "the new knot 1.5 of direction v lies outside the domain [0, 1]: move it inside");
  }
  try {
    insertKnots(surface, 1, {0.5, 0.5, 0.5, 0.5});
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("knot 0.5 of direction v stands there more than 4 times"),
              std::string::npos);
  }
}

TEST(NetProduct, RefusesMatricesThatDoNotFit) {
  const Eigen::SparseMatrix<double> matrix(5, 4);
  EXPECT_THROW(multiplyAlong<2>(matrix, Net::Zero(12, 1), {3, 4}, 0), InvalidInput);
  EXPECT_THROW(multiplyAlong<2>(matrix, Net::Zero(13, 1), {3, 4}, 1), InvalidInput);
  EXPECT_EQ(multiplyAlong<2>(matrix, Net::Zero(12, 2), {3, 4}, 1).rows(), 15);
}

TEST(NetProduct, ActsOnTheNamedDirection) {
  Net net(8, 1);
  net << 0, 1, 2, 3, 4, 5, 6, 7;
  EXPECT_EQ(sliceAlong<3>(net, {2, 2, 2}, 0, 1, 1), (Net(4, 1) << 4, 5, 6, 7).finished());
  EXPECT_EQ(sliceAlong<3>(net, {2, 2, 2}, 1, 1, 1), (Net(4, 1) << 2, 3, 6, 7).finished());
  EXPECT_EQ(sliceAlong<3>(net, {2, 2, 2}, 2, 1, 1), (Net(4, 1) << 1, 3, 5, 7).finished());
  Eigen::SparseMatrix<double> sum(1, 2);
  sum.insert(0, 0) = 1;
  sum.insert(0, 1) = 10;
  EXPECT_EQ(multiplyAlong<3>(sum, net, {2, 2, 2}, 1), (Net(4, 1) << 20, 31, 64, 75).finished());
}

}  // namespace
}  // namespace strak
