#include "strak/report/surface_mesh.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <numeric>
#include <random>

#include "strak/report/isobands.h"
#include "tests/report/shapes.h"

namespace strak {
namespace {

using namespace test;

double meshArea(const ParameterMesh& mesh) {
  double area = 0;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector2d a = mesh.parameters[t[1]] - mesh.parameters[t[0]],
                          b = mesh.parameters[t[2]] - mesh.parameters[t[0]];
    area += (a.x() * b.y() - a.y() * b.x()) / 2;
    EXPECT_GT(a.x() * b.y() - a.y() * b.x(), -1e-15) << "a triangle is the wrong way round";
  }
  return area;
}

double polygonArea(const std::vector<Eigen::Vector2d>& p) {
  double area = 0;
  for (std::size_t i = 1; i < p.size(); ++i) area += (p[i - 1].x() * p[i].y() - p[i].x() * p[i - 1].y()) / 2;
  return area;
}

const Surface& flat() {
  static const Surface surface = sheet([](double, double) { return 0.0; });
  return surface;
}

TEST(SurfaceMesh, WithoutTrimsItCoversTheDomain) {
  EXPECT_NEAR(meshArea(meshDomain(flat(), TrimRegion(flat(), {}), 500)), 1, 1e-12);
}

TEST(SurfaceMesh, FollowsTheBudget) {
  for (Index budget : {100, 1000, 20000}) {
    const auto vertices = static_cast<double>(meshDomain(flat(), TrimRegion(flat(), {}), budget).parameters.size());
    EXPECT_GT(vertices, 0.5 * static_cast<double>(budget));
    EXPECT_LT(vertices, 2.5 * static_cast<double>(budget));
  }
}

TEST(SurfaceMesh, MoreSpansThanTheBudgetStillCoverTheDomain) {
  const Surface fine = sheet([](double, double) { return 0.0; }, 90);
  const ParameterMesh mesh = meshDomain(fine, TrimRegion(fine, {}), 400);
  EXPECT_NEAR(meshArea(mesh), 1, 1e-12);
  EXPECT_LT(mesh.parameters.size(), 1500u);
}

RC_GTEST_PROP(SurfaceMesh, CutsStarsWithHolesExactly, ()) {
  std::mt19937 random(*rc::gen::inRange(0u, 100000u));
  std::uniform_real_distribution<double> radius(0.2, 0.48);
  const int corners = *rc::gen::inRange(3, 40);
  std::vector<Eigen::Vector2d> star;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * M_PI * i / corners, r = radius(random);
    star.emplace_back(0.5 + r * std::cos(angle), 0.5 + r * std::sin(angle));
  }
  star.push_back(star.front());
  const auto hole = circle(0.05, 7);
  // The outline in two open pieces, one of them backwards.
  const auto half = static_cast<std::ptrdiff_t>(star.size() / 2);
  std::vector<Eigen::Vector2d> first(star.begin(), star.begin() + half + 1), second(star.begin() + half, star.end());
  std::reverse(second.begin(), second.end());
  const TrimRegion region(flat(), {first, second, hole});
  const ParameterMesh mesh = meshDomain(flat(), region, *rc::gen::inRange(30, 3000));
  RC_ASSERT(std::abs(meshArea(mesh) - (polygonArea(star) - polygonArea(hole))) < 2e-4);
}

TEST(TrimRegion, KnowsInsideFromOutsideAndBridgesSmallGaps) {
  auto outline = circle(0.4, 100);
  outline.pop_back();  // leaves a gap of one edge
  const TrimRegion region(flat(), {outline, circle(0.1, 30)});
  for (const auto& [u, v, in] : std::vector<std::tuple<double, double, bool>>{
           {0.5, 0.5, false}, {0.5, 0.75, true}, {0.05, 0.05, false}, {0.89, 0.5, true}, {0.97, 0.5, false}})
    EXPECT_EQ(region.inside({u, v}), in) << u << ", " << v;
}

TEST(TrimRegion, TrimsAlongTheDomainKeepAllOfIt) {
  const double off = 1e-9;  // as kernels leave them
  const TrimRegion region(flat(),
                          {{{-off, off}, {1, 0}}, {{1 + off, 0}, {1, 1}}, {{1, 1 - off}, {0, 1}}, {{0, 1}, {off, 0}}});
  EXPECT_NEAR(meshArea(meshDomain(flat(), region, 300)), 1, 1e-9);
}

TEST(TrimRegion, TrimsThatEncloseNothingLeaveTheWholeDomain) {
  EXPECT_TRUE(TrimRegion(flat(), {{{0.2, 0.2}, {0.7, 0.2}}}).isWholeDomain());
  EXPECT_TRUE(TrimRegion(flat(), {{{0.2, 0.2}}, {}}).isWholeDomain());
}

TEST(SurfaceSamples, OfASphereAreThoseOfASphereAlsoAtThePoles) {
  const Surface surface = sphere();
  const SurfaceSamples samples = sampleSurface(surface, {{0.3, 0}, {1.7, 0.4}, {3.9, 1.0}, {2.2, 2}});
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LT((samples.normals[i].cross(samples.points[i])).norm(), 1e-4);
    EXPECT_NEAR(samples.gaussian[i], 1, 1e-3);
    EXPECT_NEAR(std::abs(samples.mean[i]), 1, 1e-3);
  }
}

TEST(SurfaceSamples, SeeTheJumpOfCurvatureAtADoubleKnot) {
  // Two parabolas of different curvature in one surface, joined C1.
  const KnotVector u(2, {0, 0, 0, 1, 2, 2, 2}), v = KnotVector::uniformClamped(1, 1);
  Net net(8, 3);
  net << 0, 0, 0, 0, 1, 0, 0.5, 0, 0, 0.5, 1, 0, 1.5, 0, 0, 1.5, 1, 0, 2, 0, 1, 2, 1, 1;
  const Surface surface({u, v}, net);
  const ParameterMesh mesh = meshDomain(surface, TrimRegion(surface, {}), 60);
  const SurfaceSamples samples = sampleSurface(surface, mesh.parameters);
  double left = -1, right = -1;
  for (std::size_t i = 0; i < mesh.parameters.size(); ++i) {
    if (mesh.parameters[i].x() == 1) right = std::abs(samples.mean[i]);
    if (std::abs(mesh.parameters[i].x() - 1 + 2e-7) < 1e-9) left = std::abs(samples.mean[i]);
  }
  EXPECT_NEAR(left, 0, 1e-5);
  EXPECT_GT(right, 0.1);
}

TEST(Isobands, ShareTheVisibleAreaByLevels) {
  // f = x on a square of 100 pixels, cut at 25 and 70.
  PictureMesh mesh;
  for (int i = 0; i <= 10; ++i)
    for (int j = 0; j <= 10; ++j) {
      mesh.corners.emplace_back(20 + 10.0 * i, 20 + 10.0 * j, 0);
      mesh.values.push_back(10.0 * i);
    }
  for (std::uint32_t i = 0; i < 10; ++i)
    for (std::uint32_t j = 0; j < 10; ++j) {
      const std::uint32_t a = i * 11 + j, b = a + 11;
      mesh.triangles.push_back({a, b, b + 1});
      mesh.triangles.push_back({a, b + 1, a + 1});
    }
  const auto areaOf = [](const std::string& path) {
    std::vector<Eigen::Vector2d> points;
    double x = 0, y = 0, area = 0;
    for (std::size_t i = 0; i < path.size();) {
      if (path[i] == 'M' || path[i] == ' ') ++i;
      if (path[i] == 'Z') {
        points.push_back(points.front());
        area += std::abs(polygonArea(points));
        points.clear();
        ++i;
        continue;
      }
      std::size_t used = 0;
      x = std::stod(path.substr(i), &used);
      i += used + 1;
      y = std::stod(path.substr(i), &used);
      i += used;
      points.emplace_back(x, y);
    }
    return area;
  };
  const DepthBuffer nothing(200, 200);
  const auto bands = visibleBands(mesh, {25, 70}, nothing);
  ASSERT_EQ(bands.size(), 3u);
  EXPECT_NEAR(areaOf(bands[0]), 2500, 1);
  EXPECT_NEAR(areaOf(bands[1]), 4500, 1);
  EXPECT_NEAR(areaOf(bands[2]), 3000, 1);
  // A screen in front of the right half.
  DepthBuffer screen(200, 200);
  screen.add({70, 0, 50}, {200, 0, 50}, {200, 200, 50});
  screen.add({70, 0, 50}, {200, 200, 50}, {70, 200, 50});
  const auto seen = visibleBands(mesh, {25, 70}, screen);
  EXPECT_NEAR(areaOf(seen[0]) + areaOf(seen[1]), 5000, 120);
  EXPECT_EQ(seen[2], "");
}

}  // namespace
}  // namespace strak
