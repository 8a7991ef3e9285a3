#include "strak/metrology/ring_curvature.h"

#include <cmath>

#include "strak/base/error.h"
#include "tests/metrology/test_surfaces.h"

namespace strak {
namespace {

using namespace strak::testing;

// The half above the plane z = 0, its pole in (0, 0, radius).
Surface dome(double radius) {
  Net profile(3, 3);
  const double s = std::numbers::sqrt2 / 2;
  profile << radius, 0, 1, radius * s, radius * s, s, 0, radius, 1;
  return revolved(profile, {2, {0, 0, 0, 1, 1, 1}});
}

TEST(RingCurvature, OfASphereOf7point8MillimetresIs43point27Dioptres) {
  const RingCurvature ring = ringCurvature(dome(7.8));
  ASSERT_EQ(ring.axial.size(), 256);
  for (const double curvature : ring.axial) EXPECT_NEAR(curvature, 1 / 7.8, 1e-12);
  EXPECT_NEAR(337.5 * ring.mean, 43.27, 5e-3);
  EXPECT_NEAR(ring.flat, 1 / 7.8, 1e-12);
  EXPECT_NEAR(ring.steep, 1 / 7.8, 1e-12);
  EXPECT_LT(ring.irregular, 1e-12);
}

TEST(RingCurvature, OfABowlIsNegative) {
  // z = (x^2 + y^2) / 4: the normal's way back to the axis is sqrt(4 + r^2) long.
  const Surface bowl = paraboloid(0.25, 0, 0.25);
  RingOptions options;
  options.radius = 0.5;
  const RingCurvature ring = ringCurvature(bowl, options);
  for (const double curvature : ring.axial) EXPECT_NEAR(curvature, -1 / std::sqrt(4.25), 1e-12);
  options.centre = {5, 0};
  EXPECT_THROW(ringCurvature(bowl, options), InvalidInput);
}

TEST(RingCurvature, TellsTheMeridiansOfAnAstigmaticSurface) {
  // z = -(a x^2 + b x y + c y^2), turned by 30 degrees: curvatures 0.2 and 0.3 at the apex.
  const double turn = std::numbers::pi / 6, flat = 0.1, steep = 0.15, c = std::cos(turn), s = std::sin(turn);
  const Surface surface =
      paraboloid(-(flat * c * c + steep * s * s), -2 * (flat - steep) * c * s, -(flat * s * s + steep * c * c));
  RingOptions options;
  options.radius = 0.25;
  options.meridians = 360;
  const RingCurvature ring = ringCurvature(surface, options);
  const auto axial = [&](double half) {
    const double slope = 2 * half * options.radius;
    return slope / std::sqrt(1 + slope * slope) / options.radius;
  };
  EXPECT_NEAR(ring.axial[30], axial(flat), 1e-12);
  EXPECT_NEAR(ring.axial[120], axial(steep), 1e-12);
  EXPECT_NEAR(ring.flattest, axial(flat), 1e-12);
  EXPECT_NEAR(ring.steepest, axial(steep), 1e-12);
  EXPECT_NEAR(ring.flattestAngle, turn, 1e-9);
  EXPECT_NEAR(ring.steepestAngle, turn + std::numbers::pi / 2, 1e-9);
  EXPECT_NEAR(ring.flatAngle, turn, 1e-9);
  EXPECT_NEAR(ring.steepAngle, turn + std::numbers::pi / 2, 1e-9);
  EXPECT_NEAR(ring.flat, axial(flat), 1e-4);
  EXPECT_NEAR(ring.steep, axial(steep), 1e-4);
  EXPECT_LT(ring.irregular, 1e-4);
}

TEST(RingCurvature, RefusesRingsThatLeaveTheSurface) {
  RingOptions options;
  options.radius = 1.01;
  EXPECT_THROW(ringCurvature(paraboloid(1, 0, 1), options), InvalidInput);
  options.radius = -1;
  EXPECT_THROW(ringCurvature(paraboloid(1, 0, 1), options), InvalidInput);
  options.radius = 0.5;
  options.meridians = 9;
  EXPECT_THROW(ringCurvature(paraboloid(1, 0, 1), options), InvalidInput);
  // A wall has no ring around its own direction.
  EXPECT_THROW(ringCurvature(cylinder(0.5, 1)), InvalidInput);
}

}  // namespace
}  // namespace strak
