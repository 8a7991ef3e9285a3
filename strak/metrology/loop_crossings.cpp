#include "strak/metrology/loop_crossings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "strak/base/error.h"
#include "strak/metrology/self_intersection.h"
#include "strak/spline/bezier.h"
#include "strak/spline/evaluate.h"

namespace strak {

namespace {

using Eigen::Vector2d;

constexpr double kMostChords = 1000;  // of a Bezier piece

struct Segment {
  Vector2d from, to;
  std::size_t loop, piece, number;  // the latter in the loop
};

double distanceTo(const Vector2d& point, const Segment& segment) {
  const Vector2d along = segment.to - segment.from;
  const double length = along.squaredNorm();
  const double t = length > 0 ? std::clamp((point - segment.from).dot(along) / length, 0.0, 1.0) : 0;
  return (point - segment.from - t * along).norm();
}

double cross(const Vector2d& a, const Vector2d& b) { return a[0] * b[1] - a[1] * b[0]; }

bool nearer(const Segment& a, const Segment& b, double distance) {
  const double nearest = std::min(std::min(distanceTo(a.from, b), distanceTo(a.to, b)),
                                  std::min(distanceTo(b.from, a), distanceTo(b.to, a)));
  if (nearest < distance) return true;
  const Vector2d along = a.to - a.from, other = b.to - b.from;
  return cross(along, b.from - a.from) * cross(along, b.to - a.from) < 0 &&
         cross(other, a.from - b.from) * cross(other, a.to - b.from) < 0;
}

// The segments sorted into the cells of a grid, those that reach into several into all of them.
class Grid {
 public:
  explicit Grid(const std::vector<Segment>& segments, double margin) {
    for (const Segment& segment : segments) box_.extend(segment.from).extend(segment.to);
    const double count = std::ceil(std::sqrt(static_cast<double>(segments.size())));
    cell_ = std::max(box_.sizes().maxCoeff() / count, 2 * margin);
    if (!(cell_ > 0)) cell_ = 1;
    columns_ = static_cast<std::size_t>(box_.sizes()[0] / cell_) + 1;
    cells_.resize(columns_ * (static_cast<std::size_t>(box_.sizes()[1] / cell_) + 1));
    for (std::size_t s = 0; s < segments.size(); ++s) {
      Eigen::AlignedBox2d reach(segments[s].from);
      reach.extend(segments[s].to);
      const auto [left, low] = cellAt(reach.min() - Vector2d::Constant(margin));
      const auto [right, high] = cellAt(reach.max() + Vector2d::Constant(margin));
      for (std::size_t row = low; row <= high; ++row) {
        for (std::size_t column = left; column <= right; ++column) cells_[row * columns_ + column].push_back(s);
      }
    }
  }
  const std::vector<std::vector<std::size_t>>& cells() const { return cells_; }

 private:
  std::pair<std::size_t, std::size_t> cellAt(const Vector2d& point) const {
    const Vector2d at = (point.cwiseMax(box_.min()).cwiseMin(box_.max()) - box_.min()) / cell_;
    const auto rows = cells_.size() / columns_;
    return {std::min(static_cast<std::size_t>(at[0]), columns_ - 1),
            std::min(static_cast<std::size_t>(at[1]), rows - 1)};
  }

  Eigen::AlignedBox2d box_;
  double cell_ = 1;
  std::size_t columns_ = 1;
  std::vector<std::vector<std::size_t>> cells_;
};

}  // namespace

std::vector<Vector2d> flattened(const CurveLoop& loop, double flatness) {
  std::vector<Vector2d> corners;
  for (const Curve& curve : loop) {
    if (curve.net().cols() != 2 || curve.isRational()) {
      throw InvalidInput("loops of the plane need curves with two coordinates and no weights");
    }
    const double degree = curve.degree(0);
    for (const auto& piece : bezierPieces<1>(curve)) {
      // A chord over a step h is off by at most h^2 / 8 times the second derivative.
      double bend = 0;
      for (Index i = 1; i + 1 < piece.points.rows(); ++i) {
        bend = std::max(bend, (piece.points.row(i - 1) - 2 * piece.points.row(i) + piece.points.row(i + 1)).norm());
      }
      const auto chords = static_cast<int>(
          std::clamp(std::ceil(std::sqrt(degree * (degree - 1) * bend / (8 * flatness))), 1.0, kMostChords));
      for (int i = 0; i < chords; ++i) {
        const double t = static_cast<double>(i) / chords;
        corners.push_back(evaluate<1>(curve, {piece.from[0] + t * (piece.to[0] - piece.from[0])}).transpose());
      }
    }
  }
  return corners;
}

std::vector<std::vector<NearPlace>> placesNotClear(const std::vector<CurveLoop>& loops, double clearance) {
  if (!(clearance > 0)) throw InvalidInput("the clearance of loops must be positive");
  std::vector<std::vector<NearPlace>> places(loops.size());
  std::vector<Segment> segments;
  std::vector<std::size_t> counts;
  for (std::size_t k = 0; k < loops.size(); ++k) {
    const std::size_t first = segments.size();
    for (std::size_t p = 0; p < loops[k].size(); ++p) {
      for (const Vector2d& corner : flattened({loops[k][p]}, clearance)) {
        if (segments.size() > first) segments.back().to = corner;
        segments.push_back({corner, corner, k, p, segments.size() - first});
      }
      // Neighbouring segments tell nothing of a tiny loop between them.
      const auto found = findSelfIntersection<1>(loops[k][p]);
      if (found.answer != SelfMeeting::free) {
        places[k].push_back({p, evaluate<1>(loops[k][p], found.a).transpose()});
      }
    }
    counts.push_back(segments.size() - first);
    if (segments.size() > first) segments.back().to = segments[first].from;
  }
  const double apart = 3 * clearance;  // both polygons may be off by one
  const Grid grid(segments, apart);
  for (const auto& cell : grid.cells()) {
    for (std::size_t i = 0; i < cell.size(); ++i) {
      for (std::size_t j = i + 1; j < cell.size(); ++j) {
        const Segment &a = segments[cell[i]], &b = segments[cell[j]];
        const std::size_t steps = a.loop == b.loop ? std::max(a.number, b.number) - std::min(a.number, b.number) : 2;
        if (a.loop == b.loop && (steps <= 1 || steps + 1 == counts[a.loop])) continue;
        if (!nearer(a, b, apart)) continue;
        places[a.loop].push_back({a.piece, (a.from + a.to) / 2});
        places[b.loop].push_back({b.piece, (b.from + b.to) / 2});
      }
    }
  }
  return places;
}

}  // namespace strak
