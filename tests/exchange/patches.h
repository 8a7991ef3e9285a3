#pragma once
//
// Patches that meet, for the tests of shared edges.

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "strak/exchange/model.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/reparametrize.h"

namespace strak::test {

// A bicubic graph z = f(x, y) over [x0, x1] x [y0, y1], near enough to it.
inline Surface graph(double x0, double x1, double y0, double y1, Index spansU, Index spansV,
                     const std::function<double(double, double)>& f) {
  const KnotVector u = KnotVector::uniformClamped(3, spansU), v = KnotVector::uniformClamped(3, spansV);
  const auto s = u.greville(), t = v.greville();
  Net net(u.size() * v.size(), 3);
  for (Index i = 0; i < u.size(); ++i) {
    for (Index j = 0; j < v.size(); ++j) {
      const double x = x0 + (x1 - x0) * s[static_cast<std::size_t>(i)];
      const double y = y0 + (y1 - y0) * t[static_cast<std::size_t>(j)];
      net.row(i * v.size() + j) << x, y, f(x, y);
    }
  }
  return Surface({u, v}, std::move(net));
}

inline double hill(double x, double y) { return 3 * std::sin(0.03 * x) * std::cos(0.02 * y); }

// Four patches over [0, 200] x [0, 160] around (100, 80): reversed and exchanged directions, different domains.
inline std::vector<Surface> fourPatches() {
  return {graph(0, 100, 0, 80, 4, 5, hill), reversed(graph(100, 200, 0, 80, 3, 5, hill), 1),
          transposed(graph(0, 100, 80, 160, 4, 2, hill)), withDomain(graph(100, 200, 80, 160, 3, 2, hill), 0, -2, 7)};
}

inline Eigen::Vector3d on(const Surface& surface, const std::vector<Eigen::Vector2d>& line, double t) {
  const double place = t * static_cast<double>(line.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(place), line.size() - 2);
  const Eigen::Vector2d p = line[i] + (place - static_cast<double>(i)) * (line[i + 1] - line[i]);
  return evaluate<2>(surface, {p[0], p[1]}).transpose();
}

// Largest distance of the edge's two images at equal parameters.
inline double apart(const Model& model, const SharedEdge& edge) {
  const auto& a = std::get<Surface>(*model.objects()[static_cast<std::size_t>(edge.faceA)].spline);
  const auto& b = std::get<Surface>(*model.objects()[static_cast<std::size_t>(edge.faceB)].spline);
  double largest = 0;
  for (int i = 0; i <= 20; ++i) {
    largest = std::max(largest, (on(a, edge.lineA, i / 20.0) - on(b, edge.lineB, i / 20.0)).norm());
  }
  return largest;
}

inline std::vector<AnySpline> any(const std::vector<Surface>& surfaces) { return {surfaces.begin(), surfaces.end()}; }

}  // namespace strak::test
