#include "strak/fitting/drawing_weights.h"

#include <gtest/gtest.h>

namespace strak {
namespace {

TEST(DrawingWeights, KeepOutliersOutOfTheDomain) {
  Net parameters(5, 2);
  parameters << 0, 0, 1, 2, 3, 1, 9, -9, -50, 50;
  Eigen::VectorXd distances(5), given(5);
  distances << 1, 1, 1, 100, 1;
  given << 1, 2, 1, 1, 0;
  Net expected = parameters;
  expected.row(3) << 3, 0;
  expected.row(4) << 0, 2;
  const Eigen::VectorXd weights = drawingWeights(given, distances, parameters);
  EXPECT_EQ(parameters, expected);
  EXPECT_EQ(weights.head<3>(), given.head<3>());
  EXPECT_GT(weights[3], 0);
  EXPECT_LT(weights[3], 0.03);
  EXPECT_EQ(weights[4], 0);
}

TEST(DrawingWeights, ChangeNothingWherePointsAreMet) {
  Net parameters = Net::Ones(3, 1);
  EXPECT_EQ(drawingWeights({}, Eigen::Vector3d(0, 0, 5), parameters), Eigen::VectorXd::Ones(3));
  EXPECT_EQ(parameters, Net::Ones(3, 1));
}

}  // namespace
}  // namespace strak
