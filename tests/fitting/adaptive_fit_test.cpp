#include "strak/fitting/adaptive_fit.h"

#include <gtest/gtest.h>

#include "strak/base/error.h"
#include "strak/spline/evaluate.h"
#include "tests/fitting/franke.h"

namespace strak {
namespace {

std::array<KnotVector, 2> bicubic(Index spans) {
  return {KnotVector::uniformClamped(3, spans), KnotVector::uniformClamped(3, spans)};
}

TEST(AdaptiveFit, RefinesUntilAllPointsAreInside) {
  const Net points = test::frankePoints(20000, 0);
  AdaptiveFitOptions<2> options;
  options.fit.tolerance = 1e-3;
  const auto result = fitWithin<2>(bicubic(4), 1, passOf<2>({points.leftCols(2), points.rightCols(1)}), options);
  EXPECT_TRUE(result.reached);
  EXPECT_LE(result.fit.summary.max, 1e-3);
  EXPECT_EQ(result.fit.summary.insideShare(), 1);
  EXPECT_TRUE(result.outside.empty());
  EXPECT_GT(result.rounds, 0);
  // The errors are those of the spline that is returned.
  const Net errors = derivativesAt<2>(result.fit.spline, points.leftCols(2), 0) - points.rightCols(1);
  EXPECT_NEAR(errors.cwiseAbs().maxCoeff(), result.fit.summary.max, 1e-14);
  EXPECT_LT(result.fit.spline.net().rows(), 32 * 32);
}

TEST(AdaptiveFit, DoesNotRefineAfterPointsOfWeightZero) {
  Net points = test::frankePoints(5000, 0);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(5000);
  for (Index r = 0; r < 5000; r += 50) {
    points(r, 2) += 10;
    weights[r] = 0;
  }
  AdaptiveFitOptions<2> options;
  options.fit.tolerance = 5e-3;
  const auto result =
      fitWithin<2>(bicubic(8), 1, passOf<2>({points.leftCols(2), points.rightCols(1), weights}), options);
  EXPECT_TRUE(result.reached);
  EXPECT_LE(result.fit.summary.max, 5e-3);
}

TEST(AdaptiveFit, PutsKnotsWhereTheyAreNeeded) {
  // A step between two flat halves.
  Net parameters(4000, 1), values(4000, 1);
  for (Index r = 0; r < 4000; ++r) {
    parameters(r, 0) = static_cast<double>(r) / 3999;
    values(r, 0) = std::tanh(150 * (parameters(r, 0) - 0.3));
  }
  AdaptiveFitOptions<1> options;
  options.fit.tolerance = 1e-3;
  const auto result = fitWithin<1>({KnotVector::uniformClamped(3, 4)}, 1, passOf<1>({parameters, values}), options);
  ASSERT_TRUE(result.reached);
  EXPECT_GT(result.removed, 0);
  Index near = 0;
  for (const auto& knot : result.fit.spline.knots(0).innerKnots()) near += std::abs(knot.value - 0.3) < 0.1;
  EXPECT_GT(near, 5);
  EXPECT_GT(static_cast<double>(near), 0.6 * static_cast<double>(result.fit.spline.knots(0).innerKnots().size()));
}

TEST(AdaptiveFit, RemovesKnotsThatATooFineStartHas) {
  const Net points = test::frankePoints(20000, 0);
  AdaptiveFitOptions<2> options;
  options.fit.tolerance = 1e-2;
  const auto pass = passOf<2>({points.leftCols(2), points.rightCols(1)});
  const auto result = fitWithin<2>(bicubic(40), 1, pass, options);
  EXPECT_TRUE(result.reached);
  EXPECT_EQ(result.inserted, 0);
  EXPECT_GT(result.removed, 20);
  EXPECT_LE(result.fit.summary.max, 1e-2);
  options.removeKnots = false;
  EXPECT_EQ(fitWithin<2>(bicubic(40), 1, pass, options).fit.spline.net().rows(), 43 * 43);
}

TEST(AdaptiveFit, SaysWhereWhatIsOutside) {
  Net points = test::frankePoints(10000, 0);
  points(77, 2) += 0.5;
  AdaptiveFitOptions<2> options;
  options.fit.tolerance = 0.01;
  const auto pass = passOf<2>({points.leftCols(2), points.rightCols(1)});
  const auto all = fitWithin<2>(bicubic(10), 1, pass, options);
  EXPECT_FALSE(all.reached);
  ASSERT_FALSE(all.fit.summary.warnings.empty());
  EXPECT_EQ(all.fit.summary.worstPoint, 77);
  ASSERT_FALSE(all.outside.empty());
  EXPECT_LE(all.outside[0].from[0], points(77, 0));
  EXPECT_GE(all.outside[0].to[0], points(77, 0));
  EXPECT_LE(all.outside[0].from[1], points(77, 1));
  EXPECT_GE(all.outside[0].to[1], points(77, 1));
  options.share = 0.99;
  const auto most = fitWithin<2>(bicubic(10), 1, pass, options);
  EXPECT_TRUE(most.reached);
  EXPECT_GE(most.fit.summary.insideShare(), 0.99);
}

TEST(AdaptiveFit, StopsWhereNoiseIsLargerThanTheTolerance) {
  const Net points = test::frankePoints(5000, 0.05);
  AdaptiveFitOptions<2> options;
  options.fit.tolerance = 0.01;
  const auto result = fitWithin<2>(bicubic(8), 1, passOf<2>({points.leftCols(2), points.rightCols(1)}), options);
  EXPECT_FALSE(result.reached);
  EXPECT_LT(result.fit.spline.net().rows(), 5000);
  EXPECT_LT(test::frankeError(result.fit.spline), 0.02);
}

TEST(AdaptiveFit, RefusesMeaninglessWishes) {
  const Net points = test::frankePoints(100);
  const auto pass = passOf<2>({points.leftCols(2), points.rightCols(1)});
  AdaptiveFitOptions<2> options;
  EXPECT_THROW(fitWithin<2>(bicubic(4), 1, pass, options), InvalidInput);
  options.fit.tolerance = 0.1;
  options.share = 1.5;
  EXPECT_THROW(fitWithin<2>(bicubic(4), 1, pass, options), InvalidInput);
}

}  // namespace
}  // namespace strak
