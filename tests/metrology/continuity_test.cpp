#include "strak/metrology/continuity.h"

#include "strak/base/error.h"
#include "strak/spline/knot_insertion.h"
#include "tests/metrology/test_surfaces.h"

namespace strak {
namespace {

using Eigen::Vector2d;

constexpr double kPi = std::numbers::pi;

// A quarter of a cylinder of the given radius around the y axis, tangent to the plane z = 0 at the line x = 0; u goes
// around, v along y.
Surface quarterCylinder(double radius) {
  const double s = std::numbers::sqrt2 / 2, r = radius;
  Net net(6, 4);
  for (Index j = 0; j < 2; ++j) {
    const double y = static_cast<double>(j);
    net.row(0 * 2 + j) << 0, y, 0, 1;
    net.row(1 * 2 + j) << s * r, s * y, 0, s;
    net.row(2 * 2 + j) << r, y, r, 1;
  }
  return {{KnotVector::uniformClamped(2, 1), KnotVector::uniformClamped(1, 1)}, net, true};
}

// The plane z = slope * x for x in [-1, 0], y in [from, to].
Surface plane(double slope, double from = 0, double to = 1, double lift = 0) {
  Net net(4, 3);
  net << -1, from, -slope + lift, -1, to, -slope + lift, 0, from, lift, 0, to, lift;
  const KnotVector knots = KnotVector::uniformClamped(1, 1);
  return {{knots, knots}, net};
}

TEST(EdgeContinuity, TangentPlaneAndCylinderJumpInCurvatureOnly) {
  const Surface flat = plane(0), round = quarterCylinder(4);
  const Continuity c = edgeContinuity(flat, domainEdge(flat, 0, true), round, domainEdge(round, 0, false));
  EXPECT_EQ(c.samples, 200);
  EXPECT_NEAR(c.gap.max, 0, 1e-9);
  EXPECT_NEAR(c.angle.max, 0, 1e-9);
  EXPECT_NEAR(c.curvature.max, 0.25, 1e-9);
  EXPECT_NEAR(c.curvature.rms, 0.25, 1e-9);
}

TEST(EdgeContinuity, MeasuresGapAndAngle) {
  const double slope = 0.1;
  const Surface tilted = plane(slope, 0, 1, 0.002), flat = plane(0);
  // The same edge from either side: the second surface is the first one's neighbour turned over.
  const Continuity c = edgeContinuity(tilted, domainEdge(tilted, 0, true), flat, domainEdge(flat, 0, true));
  EXPECT_NEAR(c.gap.max, 0.002, 1e-9);
  EXPECT_NEAR(c.gap.rms, 0.002, 1e-9);
  EXPECT_NEAR(c.angle.max, std::atan(slope), 1e-9);
  const Continuity turned = edgeContinuity(tilted, domainEdge(tilted, 0, true), flat, domainEdge(flat, 0, true),
                                           {.sides = NormalSides::opposite});
  EXPECT_NEAR(turned.angle.max, kPi - std::atan(slope), 1e-9);
}

TEST(EdgeContinuity, FindsCorrespondingPointsOfEdgesThatRunDifferently) {
  const Surface flat = plane(0), round = quarterCylinder(4);
  // The second edge backwards and at uneven speed; the first as a polyline.
  const ParameterCurve backwards = [](double t) { return Vector2d(0, (1 - t) * (1 - t)); };
  const ParameterCurve polyline = parameterPolyline({{1, 0}, {1, 0.3}, {1, 1}});
  const Continuity c = edgeContinuity(flat, polyline, round, backwards, {.samples = 57});
  EXPECT_NEAR(c.gap.max, 0, 1e-8);
  EXPECT_NEAR(c.curvature.max, 0.25, 1e-9);
}

TEST(EdgeContinuity, KeepsGoingOnCollapsedEdges) {
  const Surface ball = testing::sphere(1);
  const Continuity c = edgeContinuity(ball, domainEdge(ball, 1, false), ball, domainEdge(ball, 1, false));
  EXPECT_EQ(c.singular, c.samples);
  EXPECT_NEAR(c.gap.max, 0, 1e-12);
  EXPECT_EQ(c.angle.max, 0);
}

TEST(EdgeContinuity, ClosesTheSeamOfATorus) {
  const Surface ring = testing::torus(3, 1);
  const Continuity c = edgeContinuity(ring, domainEdge(ring, 0, false), ring, domainEdge(ring, 0, true));
  EXPECT_NEAR(c.gap.max, 0, 1e-7);
  EXPECT_NEAR(c.angle.max, 0, 1e-7);
  EXPECT_NEAR(c.curvature.max, 0, 1e-7);
}

TEST(InnerContinuity, NoLinesOnSmoothSplinesAndAllOnARoundSurface) {
  std::mt19937_64 random(6);
  const KnotVector smooth = KnotVector::uniformClamped(3, 4);
  EXPECT_TRUE(innerContinuity(testing::randomSpline<2>(random, {smooth, smooth}, 3)).empty());
  // A circle in four quarters is C1 in its homogeneous form and round all the same.
  const auto lines = innerContinuity(testing::torus(3, 1));
  ASSERT_EQ(lines.size(), 6u);
  for (const auto& line : lines) {
    EXPECT_EQ(line.multiplicity, 2);
    EXPECT_NEAR(line.continuity.angle.max, 0, 1e-7);
    EXPECT_NEAR(line.continuity.curvature.max, 0, 1e-10);
  }
}

TEST(InnerContinuity, SeesCreasesAndInsertedKnotsDoNotMatter) {
  // z = 0 for x < 0, z = x for x > 0: degree 1, creased by 45 degrees.
  Net net(6, 3);
  net << -1, 0, 0, -1, 1, 0, 0, 0, 0, 0, 1, 0, 1, 0, 1, 1, 1, 1;
  const Surface crease({KnotVector(1, {-1, -1, 0, 1, 1}), KnotVector::uniformClamped(1, 1)}, net);
  const auto lines = innerContinuity(insertKnots<2>(crease, 0, {0.5}));
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0].knot, 0);
  EXPECT_NEAR(lines[0].continuity.angle.max, kPi / 4, 1e-12);
  EXPECT_NEAR(lines[0].continuity.angle.rms, kPi / 4, 1e-12);
  EXPECT_NEAR(lines[1].continuity.angle.max, 0, 1e-7);
}

TEST(InnerContinuity, OfARealSurface) {
  STRAK_SHARED_SURFACE(surface, "gotools/surface.g2");
  bool found = false;
  for (const auto& line : innerContinuity(surface)) {
    if (line.direction != 0 || std::abs(line.knot - 76.74) > 0.01) continue;
    found = true;
    EXPECT_NEAR(line.continuity.curvature.max, 0.088, 1e-3);
    EXPECT_NEAR(line.continuity.curvature.rms, 0.048, 2e-3);
    EXPECT_LT(line.continuity.gap.max, 1e-9);
  }
  EXPECT_TRUE(found);
}

TEST(Continuity, RefusesBadInput) {
  EXPECT_THROW(parameterPolyline({{0, 0}}), InvalidInput);
  EXPECT_THROW(domainEdge(plane(0), 2, true), InvalidInput);
  const ParameterCurve edge = domainEdge(plane(0), 0, true);
  EXPECT_THROW(edgeContinuity(plane(0), edge, plane(0), edge, {.samples = 1}), InvalidInput);
  EXPECT_THROW(innerContinuity(plane(0), 0), InvalidInput);
}

}  // namespace
}  // namespace strak
