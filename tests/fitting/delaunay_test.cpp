#include "strak/fitting/delaunay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <random>
#include <set>

#include "strak/base/error.h"

namespace strak {
namespace {

constexpr int kSide = 64;  // a power of two: rounding changes nothing

// Whole-numbered points with the corners of the square; many coincide, lie on lines and on circles.
Net wholePoints(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> number(0, kSide);
  Net points(count + 4, 2);
  points.topRows(4) << 0, 0, kSide, 0, kSide, kSide, 0, kSide;
  for (Index i = 4; i < points.rows(); ++i) points.row(i) << number(random), number(random);
  return points;
}

std::int64_t inCircle(const Net& p, const std::array<std::int32_t, 3>& t, Index d) {
  std::array<std::int64_t, 3> x{}, y{}, lift{};
  for (std::size_t k = 0; k < 3; ++k) {
    x[k] = static_cast<std::int64_t>(p(t[k], 0) - p(d, 0));
    y[k] = static_cast<std::int64_t>(p(t[k], 1) - p(d, 1));
    lift[k] = x[k] * x[k] + y[k] * y[k];
  }
  return lift[0] * (x[1] * y[2] - x[2] * y[1]) + lift[1] * (x[2] * y[0] - x[0] * y[2]) +
         lift[2] * (x[0] * y[1] - x[1] * y[0]);
}

TEST(Delaunay, NoPointLiesInTheCircleOfATriangle) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const Net points = wholePoints(60 * static_cast<int>(seed), seed);
    const Triangulation mesh = delaunay(points);
    double area = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& v = mesh.triangles[t];
      const Eigen::RowVector2d a = points.row(v[1]) - points.row(v[0]), b = points.row(v[2]) - points.row(v[0]);
      EXPECT_GT(a[0] * b[1] - a[1] * b[0], 0);
      area += (a[0] * b[1] - a[1] * b[0]) / 2;
      for (Index d = 0; d < points.rows(); ++d) EXPECT_LE(inCircle(points, v, d), 0);
    }
    EXPECT_EQ(area, kSide * kSide);
  }
}

TEST(Delaunay, NeighboursShareTheirEdge) {
  const Triangulation mesh = delaunay(wholePoints(500, 5));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t n = mesh.neighbours[t][k];
      if (n < 0) continue;
      const auto& other = mesh.triangles[static_cast<std::size_t>(n)];
      std::set<std::int32_t> all(mesh.triangles[t].begin(), mesh.triangles[t].end());
      all.insert(other.begin(), other.end());
      EXPECT_EQ(all.size(), 4U);
      EXPECT_EQ(std::count(other.begin(), other.end(), mesh.triangles[t][k]), 0);
    }
  }
}

TEST(Delaunay, PointsThatMakeNoTriangle) {
  EXPECT_TRUE(delaunay(Net(0, 2)).triangles.empty());
  EXPECT_TRUE(delaunay(Net::Ones(5, 2)).triangles.empty());
  Net line(4, 2);
  line << 0, 0, 1, 1, 2, 2, 3, 3;
  EXPECT_TRUE(delaunay(line).triangles.empty());
  EXPECT_THROW(delaunay(Net::Zero(3, 3)), InvalidInput);
  line(2, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(delaunay(line), InvalidInput);
}

}  // namespace
}  // namespace strak
