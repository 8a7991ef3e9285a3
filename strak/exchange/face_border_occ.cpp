#include "strak/exchange/face_border_occ.h"

#include <BRep_Tool.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>

#include <algorithm>
#include <cmath>

namespace strak::cad {
namespace {

constexpr int kSamples = 201;        // of every edge
constexpr int kSamplesPerSpan = 8;   // of a trimming curve with many spans
constexpr double kOnSide = 1e-3;     // of the first span: an edge this near a side runs along it
constexpr double kExactlyOn = 1e-6;  // of the first span: this near, nothing of the surface is cut away
constexpr double kCovered = 1e-2;    // of the first span: a vertex may leave this much of a side to no edge

using Polyline = std::vector<Eigen::Vector2d>;

Polyline sample(const Geom2d_Curve& curve, double from, double to) {
  int count = kSamples;
  if (const auto* spline = dynamic_cast<const Geom2d_BSplineCurve*>(&curve)) {
    count = std::max(count, kSamplesPerSpan * (spline->NbKnots() - 1) + 1);
  }
  Polyline points;
  points.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const gp_Pnt2d point = curve.Value(from + (to - from) * i / (count - 1));
    points.emplace_back(point.X(), point.Y());
  }
  return points;
}

// Whether the edges along side `end` of direction k leave no part of it out; marks those that lie on it exactly.
bool isNatural(const std::vector<Polyline>& lines, const Surface& surface, int k, int end, std::vector<bool>& exact) {
  const KnotVector& knots = surface.knots(k);
  const KnotVector& other = surface.knots(1 - k);
  const auto spans = knots.spans();
  const Index span = end == 0 ? spans.front() : spans.back();
  const double side = end == 0 ? knots.from() : knots.to();
  const double length = knots[span + 1] - knots[span];

  std::vector<std::pair<double, double>> pieces;
  std::vector<std::size_t> marked;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    double stray = 0;
    for (const auto& point : lines[i]) stray = std::max(stray, std::abs(point[k] - side));
    if (stray > kOnSide * length) continue;
    const auto [low, high] = std::minmax_element(lines[i].begin(), lines[i].end(),
                                                 [&](const auto& a, const auto& b) { return a[1 - k] < b[1 - k]; });
    pieces.emplace_back((*low)[1 - k], (*high)[1 - k]);
    if (stray <= kExactlyOn * length) marked.push_back(i);
  }
  std::sort(pieces.begin(), pieces.end());
  double covered = other.from();
  const auto otherSpans = other.spans();
  const double hole = kCovered * std::min(other[otherSpans.front() + 1] - other[otherSpans.front()],
                                          other[otherSpans.back() + 1] - other[otherSpans.back()]);
  for (const auto& [low, high] : pieces) {
    if (low > covered + hole) return false;
    covered = std::max(covered, high);
  }
  if (covered < other.to() - hole) return false;
  for (std::size_t i : marked) exact[i] = true;
  return true;
}

}  // namespace

Border borderOf(const TopoDS_Face& located, const Surface& surface) {
  Border border;
  // In the surface's own place and sense: then a seam gives its two curves for its two uses.
  TopoDS_Face face = TopoDS::Face(located.Oriented(TopAbs_FORWARD));
  face.Location(TopLoc_Location());
  std::vector<Polyline> lines;
  for (TopExp_Explorer edges(face, TopAbs_EDGE); edges.More(); edges.Next()) {
    double from = 0, to = 0;
    const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(TopoDS::Edge(edges.Current()), face, from, to);
    if (curve.IsNull()) {
      border.missing = "one of its edges has no curve in the parameter plane";
      return border;
    }
    lines.push_back(sample(*curve, from, to));
  }
  if (lines.empty()) {
    border.naturalSide.fill(true);
    return border;
  }
  std::vector<bool> exact(lines.size(), false);
  for (std::size_t side = 0; side < 4; ++side) {
    const int k = side < 2 ? 0 : 1;
    border.naturalSide[side] = isNatural(lines, surface, k, side % 2 == 0 ? 0 : 1, exact);
  }
  if (std::find(exact.begin(), exact.end(), false) != exact.end()) border.trims = std::move(lines);
  return border;
}

}  // namespace strak::cad
