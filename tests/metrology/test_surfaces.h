#pragma once
//
// Surfaces and curves that the tests of this room measure: exact ones, random ones, and the shared examples.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>

#include "strak/spline/spline.h"

namespace strak::testing {

// The folder of the shared examples, or nothing where they are not installed.
inline std::filesystem::path sharedFile(const std::string& name) {
  const char* folder = std::getenv("STRAK_DATA");
  const std::filesystem::path path =
      (folder ? std::filesystem::path(folder) : std::filesystem::path(STRAK_SOURCE_DIR) / "../shared/data") / name;
  return std::filesystem::exists(path) ? path : std::filesystem::path();
}

// The first surface of a .g2 file (not rational).
inline Surface readG2Surface(const std::filesystem::path& path) {
  std::ifstream in(path);
  long kind = 0, major = 0, minor = 0, extra = 0, dimension = 0, rational = 0;
  in >> kind >> major >> minor >> extra;
  for (long i = 0; i < extra; ++i) in >> minor;
  in >> dimension >> rational;
  std::array<KnotVector, 2> knots;
  for (auto& direction : knots) {
    Index size = 0;
    int order = 0;
    in >> size >> order;
    std::vector<double> values(static_cast<std::size_t>(size + order));
    for (double& value : values) in >> value;
    direction = KnotVector(order - 1, values);
  }
  Net net(knots[0].size() * knots[1].size(), dimension);
  for (Index j = 0; j < knots[1].size(); ++j) {
    for (Index i = 0; i < knots[0].size(); ++i) {
      for (Index c = 0; c < dimension; ++c) in >> net(i * knots[1].size() + j, c);
    }
  }
  if (!in) throw std::runtime_error("cannot read " + path.string());
  return {knots, net};
}

#define STRAK_SHARED_SURFACE(variable, name)                                          \
  const auto variable##Path = ::strak::testing::sharedFile(name);                     \
  if (variable##Path.empty()) GTEST_SKIP() << name << " is not here: set STRAK_DATA"; \
  const Surface variable = ::strak::testing::readG2Surface(variable##Path)

// A full circle of radius 1 in the (x, y) plane: nine homogeneous points (x, y, w) on quadratic knots with double inner
// knots.
inline Net circleNet() {
  Net net(9, 3);
  const double s = std::numbers::sqrt2 / 2;
  const double xy[9][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}, {1, 0}};
  for (Index i = 0; i < 9; ++i) {
    const double w = i % 2 ? s : 1;
    net.row(i) << w * xy[i][0], w * xy[i][1], w;
  }
  return net;
}

inline KnotVector circleKnots() { return {2, {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4}}; }

// The surface that a profile in the (r, z) plane, given by homogeneous points (r, z, w), makes when it turns around the
// z axis; u runs around, v along the profile.
inline Surface revolved(const Net& profile, const KnotVector& knots) {
  const Net circle = circleNet();
  Net net(9 * profile.rows(), 4);
  for (Index i = 0; i < 9; ++i) {
    for (Index j = 0; j < profile.rows(); ++j) {
      net.row(i * profile.rows() + j) << circle(i, 0) * profile(j, 0), circle(i, 1) * profile(j, 0),
          circle(i, 2) * profile(j, 1), circle(i, 2) * profile(j, 2);
    }
  }
  return {{circleKnots(), knots}, net, true};
}

// The torus with the radii R > r around the z axis.
inline Surface torus(double major, double minor) {
  Net profile(9, 3);
  const Net circle = circleNet();
  for (Index i = 0; i < 9; ++i) {
    profile.row(i) << major * circle(i, 2) + minor * circle(i, 0), minor * circle(i, 1), circle(i, 2);
  }
  return revolved(profile, circleKnots());
}

// The sphere with its centre in the origin; its poles are collapsed edges.
inline Surface sphere(double radius) {
  Net profile(5, 3);
  const double s = std::numbers::sqrt2 / 2;
  profile << 0, -radius, 1, radius * s, -radius * s, s, radius, 0, 1, radius * s, radius * s, s, 0, radius, 1;
  return revolved(profile, {2, {0, 0, 0, 1, 1, 2, 2, 2}});
}

inline Surface cylinder(double radius, double height) {
  Net profile(2, 3);
  profile << radius, 0, 1, radius, height, 1;
  return revolved(profile, {1, {0, 0, 1, 1}});
}

// The graph z = f(x, y) of a polynomial a x^2 + b x y + c y^2 over [-1, 1]^2, one biquadratic piece.
inline Surface paraboloid(double a, double b, double c) {
  const double t[3] = {-1, 0, 1}, square[3] = {1, -1, 1};  // Bezier ordinates of x and x^2 on [-1, 1]
  Net net(9, 3);
  for (Index i = 0; i < 3; ++i) {
    for (Index j = 0; j < 3; ++j) net.row(i * 3 + j) << t[i], t[j], a * square[i] + b * t[i] * t[j] + c * square[j];
  }
  const KnotVector knots(2, {-1, -1, -1, 1, 1, 1});
  return {{knots, knots}, net};
}

// Random knots on [from, to]: uniform or not, clamped or not, some knots repeated up to the degree.
inline KnotVector randomKnots(std::mt19937_64& random, int degree, Index spans, double from = 0, double to = 1) {
  std::uniform_real_distribution<double> unit(0, 1);
  const bool clamped = unit(random) < 0.6, uniform = unit(random) < 0.4;
  std::vector<double> inner;
  for (Index i = 1; i < spans; ++i) {
    const double step = uniform ? 0.0 : 0.7 * (unit(random) - 0.5);
    const double u = from + (to - from) * (static_cast<double>(i) + step) / static_cast<double>(spans);
    const int times = degree > 0 && unit(random) < 0.25 ? 1 + static_cast<int>(unit(random) * degree) : 1;
    for (int k = 0; k < times; ++k) inner.push_back(u);
  }
  std::vector<double> knots;
  for (int k = degree; k >= 0; --k) knots.push_back(clamped ? from : from - 0.3 * k * (to - from));
  knots.insert(knots.end(), inner.begin(), inner.end());
  for (int k = 0; k <= degree; ++k) knots.push_back(clamped ? to : to + 0.2 * k * (to - from));
  return {degree, knots};
}

template <int D>
Spline<D> randomSpline(std::mt19937_64& random, const std::array<KnotVector, D>& knots, Index dimension,
                       bool rational = false, double size = 1) {
  std::uniform_real_distribution<double> unit(-1, 1);
  Index rows = 1;
  for (const auto& direction : knots) rows *= direction.size();
  Net net(rows, dimension + (rational ? 1 : 0));
  for (Index r = 0; r < rows; ++r) {
    for (Index c = 0; c < dimension; ++c) net(r, c) = size * unit(random);
    if (rational) {
      net(r, dimension) = 1 + 0.6 * unit(random);
      net.row(r).head(dimension) *= net(r, dimension);
    }
  }
  return {knots, net, rational};
}

}  // namespace strak::testing
