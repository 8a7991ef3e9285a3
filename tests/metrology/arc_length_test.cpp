#include "strak/metrology/arc_length.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/metrology/test_surfaces.h"

namespace strak {
namespace {

TEST(ArcLength, OfALineIsExactAndGoesOnBeyondItsEnds) {
  Net net(3, 3);
  net << 0, 0, 0, 1.5, 2, 0, 3, 4, 0;
  const Curve line({KnotVector(2, {2, 2, 2, 4, 4, 4})}, net);
  const Eigen::VectorXd lengths = arcLengths(line, Eigen::Vector4d(2, 3, 4, 1));
  EXPECT_NEAR(lengths[0], 0, 1e-14);
  EXPECT_NEAR(lengths[1], 2.5, 1e-14);
  EXPECT_NEAR(lengths[2], 5, 1e-14);
  EXPECT_NEAR(lengths[3], -2.5, 1e-12);
  EXPECT_NEAR(arcLengths(line, Eigen::VectorXd::Constant(1, 4.4))[0], 6, 1e-12);
}

TEST(ArcLength, OfACircle) {
  const Curve circle({testing::circleKnots()}, testing::circleNet(), true);
  const double quarter = std::numbers::pi / 2;
  const Eigen::VectorXd lengths = arcLengths(circle, Eigen::Vector3d(1, 2.5, 4));
  EXPECT_NEAR(lengths[0], quarter, 4e-5 * quarter);
  EXPECT_NEAR(lengths[1], 2.5 * quarter, 1e-4 * quarter);
  EXPECT_NEAR(lengths[2], 4 * quarter, 1.6e-4 * quarter);
  EXPECT_LT(lengths[2], 4 * quarter);
}

}  // namespace
}  // namespace strak
