#include "strak/spline/spline.h"

#include <gtest/gtest.h>

#include <limits>

#include "strak/base/error.h"

namespace strak {
namespace {

TEST(Spline, RefusesNetsThatDoNotFit) {
  const auto knots = KnotVector::uniformClamped(2, 2);
  EXPECT_THROW(Curve({knots}, Net::Zero(3, 2)), InvalidInput);
  EXPECT_THROW(Curve({knots}, Net::Zero(4, 0)), InvalidInput);
  EXPECT_THROW(Curve({knots}, Net::Zero(4, 1), true), InvalidInput);  // a weight but no coordinate
  Net net = Net::Zero(4, 2);
  net(2, 1) = std::numeric_limits<double>::quiet_NaN();
  try {
    Curve({knots}, net);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(std::string(error.what()), "control point 2 is not finite: correct its coordinates");
  }
  net(2, 1) = -1;
  EXPECT_THROW(Curve({knots}, net, true), InvalidInput);  // weights 0 and -1
}

TEST(Spline, CountsRowMajorWithTheLastIndexFastest) {
  const auto u = KnotVector::uniformClamped(1, 1);
  const auto v = KnotVector::uniformClamped(2, 1);
  const auto w = KnotVector::uniformClamped(3, 1);
  const Volume volume({u, v, w}, Net::Zero(24, 1));
  EXPECT_EQ(volume.row({1, 2, 3}), 23);
  EXPECT_EQ(volume.row({1, 0, 2}), 14);
  EXPECT_EQ(volume.sizes(), (Volume::Sizes{2, 3, 4}));
}

TEST(Spline, DividesByTheWeights) {
  Net net(2, 3);
  net << 2, 4, 2, 3, 6, 0.5;
  const Curve curve({KnotVector::uniformClamped(1, 1)}, net, true);
  EXPECT_EQ(curve.pointDimension(), 2);
  EXPECT_EQ(curve.euclideanNet(), (Net(2, 2) << 1, 2, 6, 12).finished());
}

}  // namespace
}  // namespace strak
