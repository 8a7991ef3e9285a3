#include "strak/exchange/face_edges.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <numeric>

#include "strak/spline/evaluate.h"

namespace strak {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kOnSide = 1e-6;  // of the first span: an edge this near a side lies on it
constexpr double kWhole = 1e-4;   // of the end spans: a vertex may leave this much of a side to no edge
constexpr int kSamples = 17;      // places where two edges are compared
constexpr int kTable = 64;        // where the search for the nearest place starts

// A point of the curve in space, t in [0, 1].
using SpaceCurve = std::function<Vector3d(double)>;

Vector2d at(const std::vector<Vector2d>& line, double t) {
  const double place = std::clamp(t, 0.0, 1.0) * static_cast<double>(line.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(place), line.size() - 2);
  return line[i] + (place - static_cast<double>(i)) * (line[i + 1] - line[i]);
}

SpaceCurve inSpace(const FaceEdge& edge, const Surface& surface) {
  return [&edge, &surface](double t) -> Vector3d {
    const Vector2d p = at(edge.line, t);
    return evaluate<2>(surface, {p[0], p[1]}).transpose();
  };
}

struct Foot {
  double t, distance;
};

// The nearest place of the curve to `point` near t: golden section, good to 1e-10 of the curve.
Foot footNear(const SpaceCurve& curve, const Vector3d& point, double t, double reach) {
  const double golden = (std::sqrt(5.0) - 1) / 2;
  const auto footAt = [&](double u) { return Foot{u, (curve(u) - point).norm()}; };
  const auto nearer = [](const Foot& a, const Foot& b) { return a.distance <= b.distance ? a : b; };
  double low = std::max(0.0, t - reach), high = std::min(1.0, t + reach);
  Foot left = footAt(high - golden * (high - low)), right = footAt(low + golden * (high - low));
  Foot least = nearer(nearer(footAt(low), footAt(high)), nearer(left, right));
  while (high - low > 1e-10) {
    if (left.distance <= right.distance) {
      high = right.t;
      right = left;
      left = footAt(high - golden * (high - low));
      least = nearer(least, left);
    } else {
      low = left.t;
      left = right;
      right = footAt(low + golden * (high - low));
      least = nearer(least, right);
    }
  }
  return least;
}

// Whether every point of `a` lies on `b`. `backwards`: where their parameters agree, they run opposite ways.
bool liesOn(const SpaceCurve& a, const SpaceCurve& b, bool backwards, double tolerance) {
  std::vector<Vector3d> table;
  for (int i = 1; i + 1 < kSamples; ++i) {
    const double t = static_cast<double>(i) / (kSamples - 1);
    const Vector3d point = a(t);
    if ((b(backwards ? 1 - t : t) - point).norm() <= tolerance) continue;
    for (int k = 0; table.empty() || (k <= kTable && static_cast<int>(table.size()) <= kTable); ++k) {
      table.push_back(b(static_cast<double>(k) / kTable));
    }
    const auto nearest = std::min_element(table.begin(), table.end(), [&](const Vector3d& p, const Vector3d& q) {
      return (p - point).squaredNorm() < (q - point).squaredNorm();
    });
    const auto place = static_cast<double>(nearest - table.begin()) / kTable;
    if (footNear(b, point, place, 1.0 / kTable).distance > tolerance) return false;
  }
  return true;
}

// A side's direction and value in the parameter plane.
struct SideLine {
  int direction;
  double value, from, to;  // of the other direction: its range
};

SideLine lineOf(const Surface& surface, int side) {
  const int direction = side / 2;
  const KnotVector& knots = surface.knots(direction);
  const KnotVector& other = surface.knots(1 - direction);
  return {direction, side % 2 == 0 ? knots.from() : knots.to(), other.from(), other.to()};
}

// Whether the face lies to the left of its side, taken in the direction of the rising parameter.
bool leftOfSide(int side) { return side == 1 || side == 2; }

double firstSpan(const KnotVector& knots, bool atEnd) {
  const auto spans = knots.spans();
  const Index span = atEnd ? spans.back() : spans.front();
  return knots[span + 1] - knots[span];
}

// The nearest place of the curve to `point`, to rounding.
Foot footOf(const SpaceCurve& curve, const Vector3d& point) {
  int nearest = 0;
  double least = (curve(0) - point).norm();
  for (int k = 1; k <= kTable; ++k) {
    const double distance = (curve(static_cast<double>(k) / kTable) - point).norm();
    if (distance < least) {
      least = distance;
      nearest = k;
    }
  }
  Foot foot = footNear(curve, point, static_cast<double>(nearest) / kTable, 1.0 / kTable);
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 3; ++i) {
    const double low = std::max(0.0, foot.t - kStep), high = std::min(1.0, foot.t + kStep);
    const Vector3d along = (curve(high) - curve(low)) / (high - low);
    if (!(along.squaredNorm() > 0)) break;
    foot.t = std::clamp(foot.t + along.dot(point - curve(foot.t)) / along.squaredNorm(), 0.0, 1.0);
  }
  if (foot.t < 1e-9) foot.t = 0;
  if (foot.t > 1 - 1e-9) foot.t = 1;
  foot.distance = (curve(foot.t) - point).norm();
  return foot;
}

// An edge that takes part in the search, as a curve in space.
struct Candidate {
  std::size_t edge;
  SpaceCurve curve;
  Vector3d start, end, middle;  // middle of the ends, whichever way it runs
  double tolerance;
};

// Whole sides that lie on a part of another side (T-junctions), among edges that coincide with no other one.
std::vector<SharedEdge> partsOfEdges(const std::vector<FaceEdge>& edges, const std::vector<const Surface*>& surfaces,
                                     const std::vector<const Candidate*>& alone) {
  std::vector<SharedEdge> result;
  for (const Candidate* longer : alone) {
    const FaceEdge& whole = edges[longer->edge];
    if (!whole.along) continue;
    Vector3d low = longer->start, high = longer->start;
    for (int i = 1; i < kSamples; ++i) {
      const Vector3d point = longer->curve(static_cast<double>(i) / (kSamples - 1));
      low = low.cwiseMin(point);
      high = high.cwiseMax(point);
    }
    const double margin = 0.1 * (high - low).norm();  // what the curve may bulge between the samples
    const auto outside = [&](const Vector3d& point) {
      return ((low - point).array() > margin).any() || ((point - high).array() > margin).any();
    };
    for (const Candidate* shorter : alone) {
      const FaceEdge& part = edges[shorter->edge];
      if (shorter == longer || !part.side || outside(shorter->start) || outside(shorter->end)) continue;
      const double tolerance = std::max(longer->tolerance, shorter->tolerance);
      const Foot first = footOf(longer->curve, shorter->start), last = footOf(longer->curve, shorter->end);
      if (first.distance > tolerance || last.distance > tolerance || first.t == last.t) continue;
      const double from = std::min(first.t, last.t), to = std::max(first.t, last.t);
      FaceEdge stretch = whole;
      for (std::size_t i = 0; i < whole.line.size(); ++i) {
        const double share = static_cast<double>(i) / static_cast<double>(whole.line.size() - 1);
        stretch.line[i] = at(whole.line, std::lerp(from, to, share));
      }
      const bool opposite = first.t > last.t;
      if (!liesOn(shorter->curve, inSpace(stretch, *surfaces[static_cast<std::size_t>(whole.face)]), opposite,
                  tolerance)) {
        continue;
      }
      findSide(*surfaces[static_cast<std::size_t>(whole.face)], stretch);
      SharedEdge edge = sharedEdge(stretch, part, opposite);
      edge.sewn = false;
      if (whole.name != part.name) edge.name += " / " + part.name;
      result.push_back(std::move(edge));
    }
  }
  return result;
}

}  // namespace

FaceEdge sideEdge(const Surface& surface, Index face, int side) {
  const SideLine line = lineOf(surface, side);
  FaceEdge edge;
  edge.face = face;
  edge.side = edge.along = side;
  edge.left = leftOfSide(side);
  for (const double t : {line.from, line.to}) {
    Vector2d p;
    p[line.direction] = line.value;
    p[1 - line.direction] = t;
    edge.line.push_back(p);
  }
  return edge;
}

void findSide(const Surface& surface, FaceEdge& edge) {
  edge.side.reset();
  edge.along.reset();
  for (int side = 0; side < 4; ++side) {
    const SideLine line = lineOf(surface, side);
    const int k = line.direction;
    const double slack = kOnSide * firstSpan(surface.knots(k), side % 2 == 1);
    const bool on = std::all_of(edge.line.begin(), edge.line.end(),
                                [&](const Vector2d& p) { return std::abs(p[k] - line.value) <= slack; });
    if (!on) continue;
    const double start = edge.line.front()[1 - k], end = edge.line.back()[1 - k];
    edge.along = side;
    edge.left = leftOfSide(side) == (start < end);
    const double low = std::min(start, end), high = std::max(start, end);
    if (std::abs(low - line.from) <= kWhole * firstSpan(surface.knots(1 - k), false) &&
        std::abs(high - line.to) <= kWhole * firstSpan(surface.knots(1 - k), true)) {
      edge.side = side;
    }
    return;
  }
}

SharedEdge sharedEdge(const FaceEdge& a, const FaceEdge& b, bool oppositeWays) {
  SharedEdge edge;
  edge.name = a.name;
  edge.faceA = a.face;
  edge.faceB = b.face;
  edge.lineA = a.line;
  edge.lineB = b.line;
  if (oppositeWays) std::reverse(edge.lineB.begin(), edge.lineB.end());
  edge.sideA = a.side;
  edge.sideB = b.side;
  edge.alongA = a.along;
  edge.alongB = b.along;
  edge.sameNormals = a.left != (b.left != oppositeWays);
  if (a.along && b.along) {
    const auto rises = [](const std::vector<Vector2d>& line, int side) {
      const int k = 1 - side / 2;
      return line.front()[k] < line.back()[k];
    };
    edge.reversed = rises(edge.lineA, *a.along) != rises(edge.lineB, *b.along);
  }
  return edge;
}

std::vector<SharedEdge> coincidentEdges(const std::vector<FaceEdge>& edges,
                                        const std::vector<const Surface*>& surfaces) {
  std::vector<Candidate> candidates;
  double widest = 0;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const Surface* surface = surfaces[static_cast<std::size_t>(edges[e].face)];
    if (surface == nullptr || surface->pointDimension() != 3 || edges[e].line.size() < 2) continue;
    SpaceCurve curve = inSpace(edges[e], *surface);
    Candidate candidate{e, curve, curve(0), curve(1), Vector3d::Zero(), edges[e].tolerance};
    candidate.middle = (candidate.start + candidate.end) / 2;
    const double length = std::max((curve(0.5) - candidate.start).norm(), (curve(0.25) - candidate.start).norm());
    if (!(length > 10 * candidate.tolerance)) continue;  // a pole
    widest = std::max(widest, candidate.tolerance);
    candidates.push_back(std::move(candidate));
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.middle.x() < b.middle.x() || (a.middle.x() == b.middle.x() && a.edge < b.edge);
  });
  std::vector<std::array<std::size_t, 3>> pairs;  // smaller edge, larger edge, opposite ways
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Candidate& a = candidates[i];
    for (std::size_t j = i + 1; j < candidates.size(); ++j) {
      const Candidate& b = candidates[j];
      if (b.middle.x() - a.middle.x() > widest) break;
      const double tolerance = std::max(a.tolerance, b.tolerance);
      if ((a.middle - b.middle).norm() > tolerance) continue;
      for (const bool opposite : {false, true}) {
        const Vector3d& start = opposite ? b.end : b.start;
        const Vector3d& end = opposite ? b.start : b.end;
        if ((a.start - start).norm() > tolerance || (a.end - end).norm() > tolerance) continue;
        // Closed ones have the same ends both ways: then only the way on which the insides agree is right.
        if ((a.start - a.end).norm() <= tolerance && (b.curve(opposite ? 0.75 : 0.25) - a.curve(0.25)).norm() >
                                                         (b.curve(opposite ? 0.25 : 0.75) - a.curve(0.25)).norm()) {
          continue;
        }
        if (!liesOn(a.curve, b.curve, opposite, tolerance)) continue;
        pairs.push_back({std::min(a.edge, b.edge), std::max(a.edge, b.edge), opposite ? 1U : 0U});
        break;
      }
    }
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<SharedEdge> result;
  for (const auto& [first, second, opposite] : pairs) {
    SharedEdge edge = sharedEdge(edges[first], edges[second], opposite == 1);
    edge.sewn = false;
    if (edges[first].name != edges[second].name) edge.name += " / " + edges[second].name;
    result.push_back(std::move(edge));
  }
  std::vector<bool> met(edges.size(), false);
  for (const auto& pair : pairs) met[pair[0]] = met[pair[1]] = true;
  std::vector<const Candidate*> alone;
  for (const Candidate& candidate : candidates) {
    if (!met[candidate.edge]) alone.push_back(&candidate);
  }
  std::sort(alone.begin(), alone.end(), [](const auto* a, const auto* b) { return a->edge < b->edge; });
  std::vector<SharedEdge> parts = partsOfEdges(edges, surfaces, alone);
  std::move(parts.begin(), parts.end(), std::back_inserter(result));
  return result;
}

void markCrowded(std::vector<SharedEdge>& edges) {
  // Two pairs that have the same place of one face in common belong to one edge of three faces.
  const auto key = [](Index face, const std::vector<Vector2d>& line) {
    const Vector2d low = line.front().cwiseMin(line.back()), high = line.front().cwiseMax(line.back());
    const Vector2d middle = line[line.size() / 2];
    // A straight line has no point of its own in between: its end stands for it.
    const Vector2d inner = line.size() > 2 ? middle : high;
    return std::tuple(face, low[0], low[1], high[0], high[1], inner[0], inner[1]);
  };
  using Key = decltype(key(0, {}));
  std::map<Key, std::vector<std::size_t>> uses;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    uses[key(edges[e].faceA, edges[e].lineA)].push_back(e);
    uses[key(edges[e].faceB, edges[e].lineB)].push_back(e);
  }
  for (const auto& [place, users] : uses) {
    if (users.size() < 2) continue;
    for (std::size_t e : users) {
      if (edges[e].notJoinable.empty()) edges[e].notJoinable = "more than two faces meet there";
    }
  }
}

}  // namespace strak
