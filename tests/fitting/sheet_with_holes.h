#pragma once
//
// Points of the unit square with a round and a rectangular hole.

#include <cmath>
#include <random>
#include <vector>

#include "strak/spline/spline.h"

namespace strak::test {

inline constexpr double kRoundRadius = 0.15, kRoundArea = 0.0706858347, kSquareArea = 0.05;

inline bool onSheet(double x, double y) {
  return std::hypot(x - 0.3, y - 0.35) >= kRoundRadius && !(x > 0.6 && x < 0.8 && y > 0.5 && y < 0.75);
}

inline Net netOf(const std::vector<std::array<double, 2>>& points) {
  Net net(static_cast<Index>(points.size()), 2);
  for (std::size_t i = 0; i < points.size(); ++i) net.row(static_cast<Index>(i)) << points[i][0], points[i][1];
  return net;
}

// Random points of the unit square where `inside` says so.
template <typename Inside>
Net randomPoints(std::size_t count, unsigned seed, const Inside& inside) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(0, 1);
  std::vector<std::array<double, 2>> points;
  while (points.size() < count) {
    const double x = number(random), y = number(random);
    if (inside(x, y)) points.push_back({x, y});
  }
  return netOf(points);
}

// steps + 1 points a side.
template <typename Inside>
Net gridPoints(int steps, const Inside& inside) {
  std::vector<std::array<double, 2>> points;
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; j <= steps; ++j) {
      const double x = static_cast<double>(i) / steps, y = static_cast<double>(j) / steps;
      if (inside(x, y)) points.push_back({x, y});
    }
  }
  return netOf(points);
}

}  // namespace strak::test
