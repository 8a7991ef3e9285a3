#include "strak/report/surface_mesh.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "strak/metrology/curvature.h"
#include "strak/spline/evaluate.h"

namespace strak {

namespace {

constexpr double kKnotSide = 1e-7;  // distance of the two copies of a knot, relative to the domain

// Mesh lines in one direction: the knots, and `cells` cells in all, half of them shared out evenly among the spans and
// half by length. With more spans than cells only some knots stay: the ends and those of low continuity among them.
std::vector<double> meshLines(const KnotVector& knots, Index cells) {
  const std::vector<Index> spans = knots.spans();
  const auto count = static_cast<double>(spans.size());
  const double length = knots.length(), side = kKnotSide * length;
  std::vector<double> lines{knots.from()};
  const bool keepAll = static_cast<Index>(spans.size()) <= cells;
  double owed = 0;  // cells that the spans so far should have had and did not get
  for (Index span : spans) {
    const double from = knots[span], to = knots[span + 1];
    const bool last = span == spans.back();
    const bool kink = !last && knots.degree() > 1 && knots.multiplicity(to) >= knots.degree() - 1;
    owed += 0.5 * static_cast<double>(cells) * (1 / count + (to - from) / length);
    const auto parts = std::max<Index>(std::llround(owed), keepAll || last ? 1 : 0);
    owed -= static_cast<double>(parts);
    for (Index i = 1; i < parts; ++i)
      lines.push_back(from + (to - from) * static_cast<double>(i) / static_cast<double>(parts));
    if (parts == 0 && !kink) continue;
    if (kink && to - from > 10 * side) lines.push_back(to - side);
    lines.push_back(to);
  }
  return lines;
}

// The average length in space of the lines u = const (direction 1) or v = const (direction 0).
double averageLength(const Surface& surface, int direction) {
  constexpr int kAlong = 24, kAcross = 7;
  std::array<std::vector<double>, 2> grid;
  for (int k = 0; k < 2; ++k) {
    const int samples = k == direction ? kAlong : kAcross;
    const KnotVector& knots = surface.knots(k);
    for (int i = 0; i < samples; ++i)
      grid[static_cast<std::size_t>(k)].push_back(knots.from() + knots.length() * i / (samples - 1));
  }
  const Net points = derivativesOnGrid<2>(surface, grid, 0);
  const Index vs = static_cast<Index>(grid[1].size());
  double sum = 0;
  for (int line = 0; line < kAcross; ++line)
    for (int i = 1; i < kAlong; ++i) {
      const Index a = direction == 0 ? (i - 1) * vs + line : line * vs + i - 1;
      const Index b = direction == 0 ? i * vs + line : line * vs + i;
      sum += (points.row(b) - points.row(a)).norm();
    }
  return sum / kAcross;
}

// How many cells in u and v.
std::array<Index, 2> cellCounts(const Surface& surface, Index vertices) {
  const double lengths[2] = {averageLength(surface, 0), averageLength(surface, 1)};
  const double aspect = std::clamp(lengths[1] > 0 ? lengths[0] / lengths[1] : 30.0, 1.0 / 30, 30.0);
  // Halfway (geometrically) between square cells and the same number of cells in every span.
  const double spans[2] = {static_cast<double>(surface.knots(0).spans().size()),
                           static_cast<double>(surface.knots(1).spans().size())};
  const double ratio = std::sqrt(aspect * spans[0] / spans[1]);
  const auto budget = static_cast<double>(std::max<Index>(vertices, 16));
  return {std::max<Index>(2, std::llround(std::sqrt(budget * ratio))),
          std::max<Index>(2, std::llround(std::sqrt(budget / ratio)))};
}

// Collects triangles; equal corners become one vertex.
class Mesher {
 public:
  Mesher(const TrimRegion& region, ParameterMesh& mesh) : region_(region), mesh_(mesh) {}

  void addRectangle(double u0, double u1, double v0, double v1) {
    const auto a = vertex({u0, v0}), b = vertex({u1, v0}), c = vertex({u1, v1}), d = vertex({u0, v1});
    mesh_.triangles.push_back({a, b, c});
    mesh_.triangles.push_back({a, c, d});
  }

  // The part of a cell that lies in the region. Between two successive heights at which something begins, ends or
  // leaves the cell, it consists of trapezoids.
  void addCut(double u0, double u1, double v0, double v1, const std::vector<TrimRegion::Segment>& segments) {
    std::vector<double> heights{v0, v1};
    for (const auto& s : segments) {
      for (const Eigen::Vector2d& p : {s.from, s.to})
        if (p.x() >= u0 && p.x() <= u1) heights.push_back(p.y());
      for (double u : {u0, u1})
        if ((s.from.x() < u) != (s.to.x() < u))
          heights.push_back(s.from.y() + (s.to.y() - s.from.y()) * (u - s.from.x()) / (s.to.x() - s.from.x()));
    }
    std::sort(heights.begin(), heights.end());
    const double least = 1e-9 * region_.domain().sizes().y();
    double low = v0;
    for (double high : heights) {
      if (high <= low + least || high > v1) continue;
      addStrip(u0, u1, low, high, segments);
      low = high;
    }
  }

 private:
  struct Crossing {
    double middle, low, high;  // u at the middle, the lower and the upper end of the strip
  };

  void addStrip(double u0, double u1, double low, double high, const std::vector<TrimRegion::Segment>& segments) {
    const double middle = (low + high) / 2;
    std::vector<Crossing> crossings;
    bool in = false;
    for (const auto& s : segments) {
      if ((s.from.y() <= middle) == (s.to.y() <= middle)) continue;
      const auto at = [&](double v) {
        return s.from.x() + (s.to.x() - s.from.x()) * ((v - s.from.y()) / (s.to.y() - s.from.y()));
      };
      const double u = at(middle);
      if (u <= u0)
        in = !in;
      else if (u < u1)
        crossings.push_back({u, std::clamp(at(low), u0, u1), std::clamp(at(high), u0, u1)});
    }
    std::sort(crossings.begin(), crossings.end(), [](const auto& a, const auto& b) { return a.middle < b.middle; });
    Crossing left{u0, u0, u0};
    crossings.push_back({u1, u1, u1});
    for (const Crossing& right : crossings) {
      if (in) addTrapezoid(left, right, low, high);
      in = !in;
      left = right;
    }
  }

  void addTrapezoid(const Crossing& left, const Crossing& right, double low, double high) {
    const auto a = vertex({left.low, low}), b = vertex({right.low, low}), c = vertex({right.high, high}),
               d = vertex({left.high, high});
    if (a != b && b != c) mesh_.triangles.push_back({a, b, c});
    if (a != d && c != d) mesh_.triangles.push_back({a, c, d});
  }

  std::uint32_t vertex(const Eigen::Vector2d& p) {
    const Eigen::Vector2d unit = (p - region_.domain().min()).cwiseQuotient(region_.domain().sizes()) * 0x1p28;
    const std::uint64_t key =
        (static_cast<std::uint64_t>(std::llround(unit.x())) << 32) + static_cast<std::uint64_t>(std::llround(unit.y()));
    const auto [place, isNew] = known_.try_emplace(key, static_cast<std::uint32_t>(mesh_.parameters.size()));
    if (isNew) mesh_.parameters.push_back(p);
    return place->second;
  }

  const TrimRegion& region_;
  ParameterMesh& mesh_;
  std::unordered_map<std::uint64_t, std::uint32_t> known_;
};

// Whether the segment comes into the open rectangle; lying along its border does not count.
bool entersCell(const TrimRegion::Segment& s, double u0, double u1, double v0, double v1) {
  double from = 0, to = 1;
  const Eigen::Vector2d d = s.to - s.from;
  const double lows[2] = {u0, v0}, highs[2] = {u1, v1};
  for (int k = 0; k < 2; ++k) {
    if (d[k] == 0) {
      if (s.from[k] <= lows[k] || s.from[k] >= highs[k]) return false;
      continue;
    }
    const auto [enter, leave] = std::minmax({(lows[k] - s.from[k]) / d[k], (highs[k] - s.from[k]) / d[k]});
    from = std::max(from, enter);
    to = std::min(to, leave);
  }
  return from < to;
}

}  // namespace

ParameterMesh meshDomain(const Surface& surface, const TrimRegion& region, Index vertices) {
  const auto cells = cellCounts(surface, vertices);
  const std::vector<double> us = meshLines(surface.knots(0), cells[0]), vs = meshLines(surface.knots(1), cells[1]);
  const Eigen::Vector2d least = region.domain().sizes() * (2 * kKnotSide);
  ParameterMesh mesh;
  Mesher mesher(region, mesh);
  for (std::size_t j = 1; j < vs.size(); ++j) {
    const double v0 = vs[j - 1], v1 = vs[j];
    if (v1 - v0 < least.y()) continue;
    const std::vector<TrimRegion::Segment> segments = region.segmentsBetween(v0, v1);
    for (std::size_t i = 1; i < us.size(); ++i) {
      const double u0 = us[i - 1], u1 = us[i];
      if (u1 - u0 < least.x()) continue;
      const bool cut =
          std::any_of(segments.begin(), segments.end(), [&](const auto& s) { return entersCell(s, u0, u1, v0, v1); });
      if (cut)
        mesher.addCut(u0, u1, v0, v1, segments);
      else if (region.inside({(u0 + u1) / 2, (v0 + v1) / 2}))
        mesher.addRectangle(u0, u1, v0, v1);
    }
  }
  return mesh;
}

SurfaceSamples sampleSurface(const Surface& surface, const std::vector<Eigen::Vector2d>& parameters) {
  Net uv(static_cast<Index>(parameters.size()), 2);
  for (std::size_t i = 0; i < parameters.size(); ++i) uv.row(static_cast<Index>(i)) = parameters[i].transpose();
  const Net jets = derivativesAt(surface, uv, 2);
  const Eigen::Vector2d centre((surface.knots(0).from() + surface.knots(0).to()) / 2,
                               (surface.knots(1).from() + surface.knots(1).to()) / 2);
  SurfaceSamples samples;
  for (Index i = 0; i < jets.rows(); ++i) {
    const Net jet = Eigen::Map<const Net>(jets.row(i).data(), 6, 3);
    SurfaceCurvature c = surfaceCurvature(jet);
    samples.points.push_back(c.point);
    // An edge that is a single point (or a point where both derivatives are parallel): step towards the middle.
    for (double step = 1e-5; !c.regular && step < 0.1; step *= 10) {
      const Eigen::Vector2d inner = parameters[static_cast<std::size_t>(i)] * (1 - step) + centre * step;
      c = surfaceCurvature(surface, inner.x(), inner.y());
    }
    samples.normals.push_back(c.regular ? c.normal : Eigen::Vector3d::UnitZ());
    samples.gaussian.push_back(c.gaussian);
    samples.mean.push_back(c.mean);
  }
  return samples;
}

}  // namespace strak
