#include "strak/metrology/point_deviation.h"

#include <cmath>

#include "strak/base/error.h"
#include "tests/metrology/test_surfaces.h"

namespace strak {
namespace {

using namespace strak::testing;

TEST(PointDeviation, HeightsOverAGraphAreVertical) {
  const Surface graph = paraboloid(0.5, 0.25, -1);
  EXPECT_TRUE(isGraph(graph));
  Net points(4, 3);
  points << 0, 0, 0.125, 1, -1, -0.75 - 0.5, 0.5, 0.25, 0.125 + 0.03125 - 0.0625, 1.5, 0, 0;
  const PointDeviation deviation = heightDeviation(graph, points);
  EXPECT_NEAR(deviation.values[0], 0.125, 1e-15);
  EXPECT_NEAR(deviation.values[1], -0.5, 1e-15);
  EXPECT_NEAR(deviation.values[2], 0, 1e-15);
  EXPECT_TRUE(std::isnan(deviation.values[3]));
  EXPECT_EQ(deviation.missed, 1);
  EXPECT_NEAR(deviation.feet(1, 2), -0.75, 1e-15);
}

TEST(PointDeviation, DistancesFromASphereHaveASign) {
  const Surface ball = sphere(2);
  EXPECT_FALSE(isGraph(ball));
  Net points(3, 3);
  points << 3, 0, 0, 0.3, 0.4, -1.2, 0, -2, 0;
  const PointDeviation deviation = normalDeviation(ball, points);
  const double outside = deviation.values[0] > 0 ? 1 : -1;  // as the normal points
  EXPECT_NEAR(deviation.values[0], outside, 1e-12);
  EXPECT_NEAR(deviation.values[1], -outside * 0.7, 1e-12);
  EXPECT_NEAR(deviation.values[2], 0, 1e-12);
  EXPECT_EQ(deviation.missed, 0);
  EXPECT_NEAR((deviation.feet.row(0) - Eigen::RowVector3d(2, 0, 0)).norm(), 0, 1e-12);
}

TEST(PointDeviation, TheLeftOfAPlaneCurveIsPositive) {
  Net net(2, 2);
  net << 0, 0, 3, 4;
  const Curve line({KnotVector(1, {0, 0, 1, 1})}, net);
  Net points(2, 2);
  points << 1.5 - 4, 2 + 3, 1.5 + 0.8, 2 - 0.6;
  const PointDeviation deviation = normalDeviation(line, points);
  EXPECT_NEAR(deviation.values[0], 5, 1e-12);
  EXPECT_NEAR(deviation.values[1], -1, 1e-12);
}

TEST(PointDeviation, RefusesWhatDoesNotFit) {
  const Net flat = Net::Zero(2, 2), space = Net::Zero(2, 3);
  EXPECT_THROW(normalDeviation(sphere(1), flat), InvalidInput);
  EXPECT_THROW(heightDeviation(sphere(1), space), InvalidInput);
  EXPECT_THROW(heightDeviation(paraboloid(1, 0, 1), flat), InvalidInput);
}

}  // namespace
}  // namespace strak
