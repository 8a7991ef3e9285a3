#include "strak/fitting/domain_shape.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/fitting/franke.h"

namespace strak {
namespace {

// Franke's function with noise, stretched to a domain of this length.
Net stretched(Index count, double length) {
  Net points = test::frankePoints(count);
  points.col(0) *= length;
  return points;
}

std::array<KnotVector, 2> knotsOver(double length, Index spans) {
  return {KnotVector::uniformClamped(3, spans, 0, length), KnotVector::uniformClamped(3, spans, 0, 1)};
}

TEST(DomainShape, IsASquareWhereXAndYAreOfDifferentKinds) {
  // With few points a million times as long as wide nothing holds the surface together across.
  for (const double length : {30.0, 1e4, 1e6, 1e10}) {
    const Net points = stretched(200, length);
    const Net parameters = points.leftCols(2), values = points.rightCols(1);
    const auto knots = knotsOver(length, 17);
    const auto pass = passOf<2>({parameters, values});
    EXPECT_EQ(shapeFor(knots, 1, pass, {}), ParameterScale::unit) << length;
  }
}

TEST(DomainShape, IsThatOfTheGroundWhereItMeansLengths) {
  // Waves as long along the strip as across.
  Net points = test::frankePoints(4000);
  for (Index r = 0; r < points.rows(); ++r) {
    const double noise = (points(r, 2) - test::franke(points(r, 0), points(r, 1))) / 0.01;
    points(r, 0) *= 15;
    points(r, 2) = std::sin(6 * points(r, 0)) * std::cos(6 * points(r, 1)) + 0.5 * noise;
  }
  const Net parameters = points.leftCols(2), values = points.rightCols(1);
  const auto pass = passOf<2>({parameters, values});
  const std::array<KnotVector, 2> knots{KnotVector::uniformClamped(3, 90, 0, 15),
                                        KnotVector::uniformClamped(3, 12, 0, 1)};
  EXPECT_EQ(shapeFor(knots, 1, pass, {}), ParameterScale::lengths);
  // Domains that are not elongated are not asked about.
  EXPECT_EQ(shapeFor(knotsOver(2, 17), 1, pass, {}), ParameterScale::lengths);
}

}  // namespace
}  // namespace strak
