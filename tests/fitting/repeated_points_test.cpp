#include "strak/fitting/repeated_points.h"

#include <gtest/gtest.h>

#include "strak/fitting/least_squares.h"
#include "tests/fitting/franke.h"

namespace strak {
namespace {

TEST(RepeatedPoints, AreMergedWithTheirWeights) {
  Net parameters(5, 1), values(5, 1);
  parameters << 1, 2, 1, 1, 2;
  values << 7, 8, 7, 9, 8;
  Eigen::VectorXd weights(5);
  weights << 1, 2, 3, 4, 5;
  EXPECT_EQ(mergeRepeatedPoints(parameters, values, weights), 2);
  EXPECT_EQ(parameters, Net(Eigen::RowVector3d(1, 2, 1).transpose()));
  EXPECT_EQ(values, Net(Eigen::RowVector3d(7, 8, 9).transpose()));
  EXPECT_EQ(weights, Eigen::Vector3d(4, 7, 4));
  Eigen::VectorXd none;
  EXPECT_EQ(mergeRepeatedPoints(parameters, values, none), 0);
  EXPECT_EQ(none.size(), 0);
}

TEST(RepeatedPoints, DoNotPassForMeasurements) {
  const Net points = test::frankePoints(3000);
  Net parameters(9000, 2), values(9000, 1);
  for (Index r = 0; r < 9000; ++r) {
    parameters.row(r) = points.row(r % 3000).leftCols(2);
    values.row(r) = points.row(r % 3000).rightCols(1);
  }
  const std::array<KnotVector, 2> knots{KnotVector::uniformClamped(3, 20), KnotVector::uniformClamped(3, 20)};
  const auto once = fitLeastSquares<2>(knots, {points.leftCols(2), points.rightCols(1)});
  Eigen::VectorXd weights;
  EXPECT_EQ(mergeRepeatedPoints(parameters, values, weights), 6000);
  const auto merged = fitLeastSquares<2>(knots, {parameters, values, weights});
  EXPECT_NEAR(merged.summary.freedom, once.summary.freedom, 1e-3);
}

}  // namespace
}  // namespace strak
