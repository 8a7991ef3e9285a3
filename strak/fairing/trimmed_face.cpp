#include "strak/fairing/trimmed_face.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace strak {
namespace {

constexpr double kOnSide = 1e-3;  // of the first span: an edge this near a side runs along it

// First and last of a row of things, perhaps none (first > last).
struct Range {
  Index first, last;
};

std::vector<double> breakpoints(const KnotVector& knots) {
  std::vector<double> values{knots.from()};
  for (const auto& knot : knots.innerKnots()) values.push_back(knot.value);
  values.push_back(knots.to());
  return values;
}

// One entry a cell of the knot grid, v fastest.
struct Cells {
  std::vector<Index> uSpans, vSpans;
  std::vector<std::uint8_t> touched, visible;
};

// First and last span that the closed interval [low, high] meets (empty: first > last). Spans by their breakpoints.
Range spansMet(const std::vector<double>& points, double low, double high) {
  const auto spans = static_cast<Index>(points.size()) - 1;
  if (high < points.front() || low > points.back()) return {0, -1};
  const Index first = std::lower_bound(points.begin(), points.end(), low) - points.begin() - 1;
  const Index last = std::upper_bound(points.begin(), points.end(), high) - points.begin() - 1;
  return {std::clamp<Index>(first, 0, spans - 1), std::clamp<Index>(last, 0, spans - 1)};
}

Cells classify(const Surface& surface, const FaceBorder& border, const std::vector<bool>& along) {
  Cells cells{surface.knots(0).spans(), surface.knots(1).spans(), {}, {}};
  const std::vector<double> u = breakpoints(surface.knots(0));
  const std::vector<double> v = breakpoints(surface.knots(1));
  const std::size_t columns = cells.vSpans.size();
  cells.touched.assign(cells.uSpans.size() * columns, 0);
  cells.visible.assign(cells.uSpans.size() * columns, 0);
  const Eigen::Vector2d slack(1e-9 * surface.knots(0).length(), 1e-9 * surface.knots(1).length());

  std::vector<std::vector<double>> crossings(columns);  // of the border with the middle line of each column of cells
  for (std::size_t edge = 0; edge < border.trims.size(); ++edge) {
    const auto& line = border.trims[edge];
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const Eigen::Vector2d& a = line[i];
      const Eigen::Vector2d& b = line[i + 1];
      for (std::size_t t = 0; t < columns; ++t) {
        const double middle = std::midpoint(v[t], v[t + 1]);
        if ((a.y() <= middle) != (b.y() <= middle)) {
          crossings[t].push_back(a.x() + (middle - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
        }
      }
      if (along[edge]) continue;
      // Between two samples the curve leaves its chord by about an eighth of the second difference; take half of it.
      Eigen::Vector2d margin = slack;
      if (i > 0) margin += 0.5 * (line[i - 1] - 2 * a + b).cwiseAbs();
      if (i + 2 < line.size()) margin += 0.5 * (a - 2 * b + line[i + 2]).cwiseAbs();
      const Eigen::Vector2d low = a.cwiseMin(b) - margin;
      const Eigen::Vector2d high = a.cwiseMax(b) + margin;
      const Range s = spansMet(u, low.x(), high.x());
      const Range t = spansMet(v, low.y(), high.y());
      for (Index row = s.first; row <= s.last; ++row) {
        for (Index column = t.first; column <= t.last; ++column) {
          cells.touched[static_cast<std::size_t>(row) * columns + static_cast<std::size_t>(column)] = 1;
        }
      }
    }
  }
  for (std::size_t t = 0; t < columns; ++t) {
    std::sort(crossings[t].begin(), crossings[t].end());
    for (std::size_t s = 0; s < cells.uSpans.size(); ++s) {
      const double middle = std::midpoint(u[s], u[s + 1]);
      const auto before = std::lower_bound(crossings[t].begin(), crossings[t].end(), middle) - crossings[t].begin();
      cells.visible[s * columns + t] = before % 2 == 1;
    }
  }
  return cells;
}

}  // namespace

SideEdges edgesAlongSides(const Surface& surface, const FaceBorder& border) {
  SideEdges edges;
  edges.along.assign(border.trims.size(), false);
  for (std::size_t side = 0; side < 4; ++side) {
    edges.bordered[side] = border.naturalSide[side];
    const auto k = static_cast<Index>(side / 2);
    const KnotVector& knots = surface.knots(static_cast<int>(k));
    const std::vector<Index> spans = knots.spans();
    const Index span = side % 2 == 0 ? spans.front() : spans.back();
    const double at = side % 2 == 0 ? knots.from() : knots.to();
    for (std::size_t i = 0; i < border.trims.size(); ++i) {
      double stray = 0;
      for (const auto& point : border.trims[i]) stray = std::max(stray, std::abs(point[k] - at));
      if (stray > kOnSide * (knots[span + 1] - knots[span])) continue;
      edges.along[i] = true;
      edges.bordered[side] = true;
      edges.stray[side] = std::max(edges.stray[side], stray);
    }
  }
  return edges;
}

std::pair<double, double> borderExtent(const FaceBorder& border, int direction) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto& line : border.trims) {
    for (const auto& point : line) {
      low = std::min(low, point[direction]);
      high = std::max(high, point[direction]);
    }
  }
  return {low, high};
}

HeldPoints holdTrimmed(const Surface& surface, const FaceBorder& border, const std::vector<bool>& along) {
  if (border.trims.empty()) return {};
  const Cells cells = classify(surface, border, along);
  const auto points = static_cast<std::size_t>(surface.net().rows());
  HeldPoints touched(points, 0), seen(points, 0);
  for (std::size_t s = 0; s < cells.uSpans.size(); ++s) {
    for (std::size_t t = 0; t < cells.vSpans.size(); ++t) {
      const std::size_t cell = s * cells.vSpans.size() + t;
      if (!cells.touched[cell] && !cells.visible[cell]) continue;
      for (Index i = cells.uSpans[s] - surface.degree(0); i <= cells.uSpans[s]; ++i) {
        for (Index j = cells.vSpans[t] - surface.degree(1); j <= cells.vSpans[t]; ++j) {
          (cells.touched[cell] ? touched : seen)[static_cast<std::size_t>(surface.row({i, j}))] = 1;
        }
      }
    }
  }
  for (std::size_t r = 0; r < points; ++r) touched[r] = touched[r] || !seen[r];
  return touched;
}

}  // namespace strak
