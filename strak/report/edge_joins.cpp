#include "strak/report/edge_joins.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "strak/metrology/continuity.h"
#include "strak/spline/evaluate.h"

namespace strak {
namespace {

constexpr int kLinePoints = 33;

std::vector<Eigen::Vector3d> lineOn(const Surface& surface, const ParameterCurve& edge) {
  std::vector<Eigen::Vector3d> line;
  for (int i = 0; i < kLinePoints; ++i) {
    const Eigen::Vector2d p = edge(static_cast<double>(i) / (kLinePoints - 1));
    line.emplace_back(evaluate<2>(surface, {p[0], p[1]}).transpose());
  }
  return line;
}

bool inSpace(const Surface* surface) { return surface != nullptr && surface->pointDimension() == 3; }

}  // namespace

std::vector<EdgeJoin> measureJoins(const std::vector<SharedEdge>& edges, const std::vector<const Surface*>& before,
                                   const std::vector<const Surface*>& after, const JointOptions& options) {
  std::vector<const SharedEdge*> measured;
  for (const SharedEdge& edge : edges) {
    const auto a = static_cast<std::size_t>(edge.faceA), b = static_cast<std::size_t>(edge.faceB);
    if (!edge.samePlace || edge.lineA.size() < 2 || edge.lineB.size() < 2) continue;
    if (inSpace(before[a]) && inSpace(before[b]) && inSpace(after[a]) && inSpace(after[b])) measured.push_back(&edge);
  }
  std::vector<EdgeJoin> joins(measured.size());
  tbb::parallel_for(std::size_t{0}, measured.size(), [&](std::size_t e) {
    const SharedEdge& edge = *measured[e];
    const auto a = static_cast<std::size_t>(edge.faceA), b = static_cast<std::size_t>(edge.faceB);
    const ParameterCurve lineA = parameterPolyline(edge.lineA), lineB = parameterPolyline(edge.lineB);
    EdgeJoin& join = joins[e];
    join.name = edge.name;
    join.faceA = edge.faceA;
    join.faceB = edge.faceB;
    const auto measure = [&](const Surface& one, const Surface& other, double BeforeAfter::*state, JointKind& kind) {
      const Continuity found = edgeContinuity(
          one, lineA, other, lineB, {options.samples, edge.sameNormals ? NormalSides::same : NormalSides::opposite});
      join.gap.*state = found.gap.max;
      join.angle.*state = found.angle.max * 180 / std::numbers::pi;
      join.curvature.*state = found.curvature.max;
      join.angleMean.*state = found.angle.rms * 180 / std::numbers::pi;
      join.curvatureMean.*state = found.curvature.rms;
      if (state == &BeforeAfter::before) join.length = found.length;
      kind = jointKind(join.angle.*state, join.curvature.*state, found.largestCurvature, found.length, options);
    };
    measure(*before[a], *before[b], &BeforeAfter::before, join.kindBefore);
    join.lineBefore = lineOn(*before[a], lineA);
    if (before[a] == after[a] && before[b] == after[b]) {
      join.gap.after = join.gap.before;
      join.angle.after = join.angle.before;
      join.curvature.after = join.curvature.before;
      join.angleMean.after = join.angleMean.before;
      join.curvatureMean.after = join.curvatureMean.before;
      join.kindAfter = join.kindBefore;
      join.lineAfter = join.lineBefore;
      return;
    }
    measure(*after[a], *after[b], &BeforeAfter::after, join.kindAfter);
    join.lineAfter = lineOn(*after[a], lineA);
  });
  return joins;
}

std::vector<SidePair> joinableSides(const std::vector<SharedEdge>& edges) {
  std::vector<SidePair> pairs;
  for (const SharedEdge& edge : edges) {
    if (!edge.notJoinable.empty()) continue;
    const auto part = [](const std::vector<Eigen::Vector2d>& line, int side) -> SidePart {
      const int k = 1 - side / 2;
      return {std::min(line.front()[k], line.back()[k]), std::max(line.front()[k], line.back()[k])};
    };
    if (edge.sideA && edge.sideB) {
      pairs.push_back({edge.faceA, edge.faceB, *edge.sideA, *edge.sideB, {}});
    } else if (edge.alongA && edge.sideB) {
      pairs.push_back({edge.faceA, edge.faceB, *edge.alongA, *edge.sideB, part(edge.lineA, *edge.alongA)});
    } else if (edge.sideA && edge.alongB) {
      pairs.push_back({edge.faceB, edge.faceA, *edge.alongB, *edge.sideA, part(edge.lineB, *edge.alongB)});
    }
  }
  return pairs;
}

std::vector<const Surface*> surfacesOf(const std::vector<Object>& objects) {
  std::vector<const Surface*> surfaces;
  for (const Object& object : objects) {
    surfaces.push_back(object.spline ? std::get_if<Surface>(&*object.spline) : nullptr);
  }
  return surfaces;
}

JoinSummary summaryOf(const std::vector<EdgeJoin>& joins) {
  JoinSummary summary;
  const auto raise = [](BeforeAfter& largest, const BeforeAfter& figure) {
    largest.before = std::max(largest.before, figure.before);
    largest.after = std::max(largest.after, figure.after);
  };
  double length = 0;
  const auto add = [](BeforeAfter& sum, const BeforeAfter& mean, double weight) {
    sum.before += weight * mean.before * mean.before;
    sum.after += weight * mean.after * mean.after;
  };
  for (const EdgeJoin& join : joins) {
    ++summary.before[static_cast<std::size_t>(join.kindBefore)];
    ++summary.after[static_cast<std::size_t>(join.kindAfter)];
    raise(summary.gap, join.gap);
    if (join.kindBefore == JointKind::feature) continue;
    raise(summary.angle, join.angle);
    raise(summary.curvature, join.curvature);
    add(summary.angleMean, join.angleMean, join.length);
    add(summary.curvatureMean, join.curvatureMean, join.length);
    length += join.length;
  }
  for (BeforeAfter* mean : {&summary.angleMean, &summary.curvatureMean}) {
    *mean = {length > 0 ? std::sqrt(mean->before / length) : 0, length > 0 ? std::sqrt(mean->after / length) : 0};
  }
  return summary;
}

}  // namespace strak
