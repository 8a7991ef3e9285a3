#include "strak/fitting/parametrization.h"

#include <gtest/gtest.h>

#include "strak/base/error.h"

namespace strak {
namespace {

TEST(Parametrization, ChordLengthsAddUp) {
  Net points(4, 2);
  points << 0, 0, 3, 4, 3, 4, 3, 3;
  Net expected(4, 1);
  expected << 0, 5, 5, 6;
  EXPECT_EQ(chordLengthParameters(points), expected);
  EXPECT_THROW(chordLengthParameters(Net::Ones(3, 3)), InvalidInput);
  EXPECT_THROW(chordLengthParameters(Net(0, 3)), InvalidInput);
}

TEST(Parametrization, PlaneParametersAreIsometricInThePlane) {
  // A 6 x 2 rectangle in a tilted plane.
  const Eigen::RowVector3d a(0, 0.6, 0.8), b(1, 0, 0);
  Net points(77, 3);
  for (Index i = 0; i < 11; ++i) {
    for (Index j = 0; j < 7; ++j) {
      points.row(i * 7 + j) =
          Eigen::RowVector3d(5, 6, 7) + 0.6 * static_cast<double>(i) * a + static_cast<double>(j) / 3 * b;
    }
  }
  const Net parameters = planeParameters(points);
  for (Index r = 1; r < 77; ++r) {
    EXPECT_NEAR((parameters.row(r) - parameters.row(0)).norm(), (points.row(r) - points.row(0)).norm(), 1e-13);
  }
  // The long side first, and along its largest coordinate.
  EXPECT_NEAR(parameters(76, 0) - parameters(0, 0), 6, 1e-13);
  EXPECT_NEAR(parameters(76, 1) - parameters(0, 1), 2, 1e-13);
}

TEST(Parametrization, APlaneNeedsMoreThanALine) {
  Net line(10, 3);
  for (Index r = 0; r < 10; ++r)
    line.row(r) << 1.0 + static_cast<double>(r), 3.0 * static_cast<double>(r), 0.1 * static_cast<double>(r);
  EXPECT_THROW(planeParameters(line), InvalidInput);
  EXPECT_THROW(planeParameters(Net::Ones(5, 3)), InvalidInput);
  EXPECT_THROW(planeParameters(Net::Random(5, 2)), InvalidInput);
}

}  // namespace
}  // namespace strak
