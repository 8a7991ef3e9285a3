#include "strak/metrology/isophotes.h"

#include <tbb/global_control.h>

#include <Eigen/Geometry>

#include "strak/base/error.h"
#include "strak/metrology/curvature.h"
#include "strak/spline/evaluate.h"
#include "tests/metrology/test_surfaces.h"

namespace strak {
namespace {

using Eigen::Vector3d;
using testing::paraboloid;

constexpr double kPi = std::numbers::pi;

Vector3d pointAt(const Surface& surface, const Eigen::Vector2d& p) {
  return evaluate<2>(surface, {p[0], p[1]}).transpose();
}

double lengthOf(const std::vector<SurfaceLine>& lines) {
  double length = 0;
  for (const SurfaceLine& line : lines) {
    for (std::size_t i = 1; i < line.points.size(); ++i) length += (line.points[i] - line.points[i - 1]).norm();
  }
  return length;
}

TEST(Isophotes, EveryVertexLiesOnItsLevelAndOnTheSurface) {
  STRAK_SHARED_SURFACE(surface, "fairness24/noisy.g2");
  IsophoteOptions options;
  options.light = {1, 2, 3};
  options.lines = 7;
  const auto lines = isophotes(surface, options);
  ASSERT_GT(lines.size(), 7u);
  const SurfaceField field = isophoteField(options.light);
  for (const SurfaceLine& line : lines) {
    ASSERT_EQ(line.parameters.size(), line.points.size());
    ASSERT_GE(line.points.size(), 2u);
    for (std::size_t i = 0; i < line.points.size(); ++i) {
      const auto c = surfaceCurvature(surface, line.parameters[i][0], line.parameters[i][1]);
      EXPECT_NEAR(field(c.point, c.normal), line.level, 1e-11);
      EXPECT_NEAR((c.point - line.points[i]).norm(), 0, 1e-12);
    }
  }
}

// The isophotes of z = x^2 + y^2 for light along z are circles around the vertex: n_z = 1 / sqrt(1 + 4 r^2).
TEST(Isophotes, OfAParaboloidAreClosedCircles) {
  const Surface bowl = paraboloid(1, 0, 1);
  IsophoteOptions options;
  const double r = 0.6;
  options.levels = {1 / std::sqrt(1 + 4 * r * r)};
  const auto lines = isophotes(bowl, options);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_TRUE(lines[0].closed);
  EXPECT_EQ(lines[0].points.front(), lines[0].points.back());
  for (const Vector3d& p : lines[0].points) EXPECT_NEAR(p.head<2>().norm(), r, 1e-11);
  EXPECT_NEAR(lengthOf(lines), 2 * kPi * r, 1e-3);
}

TEST(Isophotes, ChordsStayNearTheLine) {
  const Surface bowl = paraboloid(1, 0, 1);
  IsophoteOptions options;
  options.minSamples = 4;
  options.samplesPerSpan = 4;
  options.flatness = 1e-4;
  options.levels = {1 / std::sqrt(1 + 4 * 0.25)};
  const auto lines = isophotes(bowl, options);
  ASSERT_EQ(lines.size(), 1u);
  for (std::size_t i = 1; i < lines[0].points.size(); ++i) {
    const Vector3d middle = (lines[0].points[i] + lines[0].points[i - 1]) / 2;
    EXPECT_NEAR(middle.head<2>().norm(), 0.5, 5e-4);
  }
}

TEST(Isophotes, OfASphereAreParallelsUpToThePoles) {
  const Surface ball = testing::sphere(2);
  IsophoteOptions options;
  options.light = {0.2, -0.1, 1};
  options.lines = 9;
  const auto lines = isophotes(ball, options);
  const Vector3d light = options.light.normalized();
  ASSERT_GE(lines.size(), 9u);
  for (const SurfaceLine& line : lines) {
    for (const Vector3d& p : line.points) EXPECT_NEAR(std::abs(p.dot(light) / 2), std::abs(line.level), 1e-9);
  }
  // Nine circles at even levels.
  double expected = 0;
  for (int i = 1; i <= 9; ++i) expected += 2 * kPi * 2 * std::sqrt(1 - std::pow(-1 + 0.2 * i, 2));
  EXPECT_NEAR(lengthOf(lines), expected, 5e-3 * expected);
}

// A roof: linear across a crease at u = 1 (double knot, degree 2), bent along v.
Surface roof() {
  const KnotVector u(2, {0, 0, 0, 1, 1, 2, 2, 2}), v(2, {0, 0, 0, 1, 1, 1});
  Net net(15, 3);
  for (Index i = 0; i < 5; ++i) {
    const double x = static_cast<double>(i) / 2, height = i < 2 ? x : 2 - x;
    for (Index j = 0; j < 3; ++j) {
      const double y = static_cast<double>(j) / 2;
      net.row(i * 3 + j) << x, y, height + (j == 1 ? 0.3 : 0.0);
    }
  }
  return {{u, v}, net};
}

TEST(Isophotes, EndAtCreases) {
  IsophoteOptions options;
  options.light = {1, 0.5, 1};
  options.lines = 10;
  const auto lines = isophotes(roof(), options);
  ASSERT_FALSE(lines.empty());
  for (const SurfaceLine& line : lines) {
    bool left = false, right = false;
    for (const auto& p : line.parameters) {
      left = left || p[0] < 1 - 1e-12;
      right = right || p[0] > 1 + 1e-12;
    }
    EXPECT_FALSE(left && right);
  }
}

TEST(Isophotes, APlaneHasNone) { EXPECT_TRUE(isophotes(paraboloid(0, 0, 0)).empty()); }

TEST(Isophotes, AreCutByTheTrimmingPredicate) {
  const Surface bowl = paraboloid(1, 0, 1);
  IsophoteOptions options;
  options.levels = {1 / std::sqrt(1 + 4 * 0.25)};
  options.inside = [](double u, double) { return u <= 0.123; };
  const auto lines = isophotes(bowl, options);
  ASSERT_FALSE(lines.empty());
  double farthest = -1;
  for (const SurfaceLine& line : lines) {
    EXPECT_FALSE(line.closed);
    for (const auto& p : line.parameters) {
      EXPECT_LE(p[0], 0.123);
      farthest = std::max(farthest, p[0]);
    }
  }
  EXPECT_NEAR(farthest, 0.123, 1e-6);
  EXPECT_NEAR(lengthOf(lines), 0.5 * 2 * (kPi - std::acos(0.123 / 0.5)), 1e-3);
}

TEST(Isophotes, AreTheSameForAnyNumberOfThreads) {
  const Surface ball = testing::torus(2, 0.7);
  IsophoteOptions options;
  options.light = {1, 1, 1};
  const auto many = isophotes(ball, options);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto single = isophotes(ball, options);
  ASSERT_EQ(many.size(), single.size());
  for (std::size_t i = 0; i < many.size(); ++i) EXPECT_EQ(many[i].points, single[i].points);
}

TEST(LevelLines, ReflectionAndHighlightFieldsMeanWhatTheySay) {
  const Vector3d n = Vector3d(1, 2, 4).normalized(), eye = Vector3d::UnitZ(), light = Vector3d(0, 1, 1).normalized();
  const Vector3d mirrored = 2 * n.dot(eye) * n - eye;
  EXPECT_NEAR(reflectionField(light, 3 * eye)(Vector3d::Zero(), n), mirrored.dot(light), 1e-15);

  // The tube y = 1, z = 5 along x; the normal line through (2, 0, 0) straight up passes it at a distance of 1.
  const SurfaceField highlight = highlightField({-7, 1, 5}, {2, 0, 0});
  EXPECT_NEAR(std::abs(highlight({2, 0, 0}, Vector3d::UnitZ())), 1, 1e-15);
  EXPECT_NEAR(highlight({2, 1, 0}, Vector3d::UnitZ()), 0, 1e-15);

  const Surface bowl = paraboloid(0.2, 0.1, 0.3);
  const auto levels = evenLevels(bowl, highlight, 5);
  ASSERT_EQ(levels.size(), 5u);
  const auto lines = levelLines(bowl, highlight, levels);
  EXPECT_GE(lines.size(), 5u);
  for (const SurfaceLine& line : lines) {
    for (const auto& p : line.parameters) {
      const auto c = surfaceCurvature(bowl, p[0], p[1]);
      EXPECT_NEAR(highlight(c.point, c.normal), line.level, 1e-10);
    }
  }
}

TEST(LevelLines, RefuseBadOptions) {
  IsophoteOptions options;
  options.light.setZero();
  EXPECT_THROW(isophotes(paraboloid(1, 0, 1), options), InvalidInput);
  LineOptions flat;
  flat.flatness = 0;
  EXPECT_THROW(levelLines(paraboloid(1, 0, 1), isophoteField({0, 0, 1}), {0.5}, flat), InvalidInput);
}

TEST(IsoparametricLines, RunThroughKnotsAndBetweenThem) {
  const auto lines = isoparametricLines(roof(), 1, 4);
  // Five values of v; the crease cuts each line in two.
  ASSERT_EQ(lines.size(), 10u);
  for (const SurfaceLine& line : lines) {
    for (std::size_t i = 0; i < line.points.size(); ++i) {
      EXPECT_EQ(line.parameters[i][1], line.level);
      EXPECT_NEAR((line.points[i] - pointAt(roof(), line.parameters[i])).norm(), 0, 1e-14);
    }
  }
  LineOptions options;
  options.inside = [](double u, double) { return u < 0.5; };
  for (const SurfaceLine& line : isoparametricLines(roof(), 1, 1, options))
    EXPECT_NEAR(line.parameters.back()[0], 0.5, 1e-6);
}

}  // namespace
}  // namespace strak
