#include "strak/metrology/trim_region.h"

#include <algorithm>
#include <tuple>

namespace strak {

namespace {

using Polyline = std::vector<Eigen::Vector2d>;

constexpr std::size_t kRows = 256;
constexpr double kStraightened = 1e-4;  // of the domain: how far a simplified polyline may leave the given one

// Douglas and Peucker: the fewest of the points that keep the polyline within `tolerance`.
void simplify(const Polyline& in, std::size_t first, std::size_t last, double tolerance, Polyline& out) {
  const Eigen::Vector2d chord = in[last] - in[first];
  const double length = chord.norm();
  double worst = -1;
  std::size_t split = first;
  for (std::size_t i = first + 1; i < last; ++i) {
    const Eigen::Vector2d d = in[i] - in[first];
    const double distance = length > 0 ? std::abs(chord.x() * d.y() - chord.y() * d.x()) / length : d.norm();
    if (distance > worst) {
      worst = distance;
      split = i;
    }
  }
  if (worst > tolerance) {
    simplify(in, first, split, tolerance, out);
    simplify(in, split, last, tolerance, out);
  } else {
    out.push_back(in[last]);
  }
}

// Bridges the ends of open polylines, nearest pairs first.
std::vector<TrimRegion::Segment> bridges(const std::vector<Polyline>& lines) {
  std::vector<Eigen::Vector2d> ends;
  for (const Polyline& line : lines) {
    if (line.front() == line.back()) continue;
    ends.push_back(line.front());
    ends.push_back(line.back());
  }
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < ends.size(); ++i)
    for (std::size_t j = i + 1; j < ends.size(); ++j) pairs.emplace_back((ends[i] - ends[j]).squaredNorm(), i, j);
  std::sort(pairs.begin(), pairs.end());
  std::vector<bool> used(ends.size(), false);
  std::vector<TrimRegion::Segment> out;
  for (const auto& [distance, i, j] : pairs) {
    if (used[i] || used[j]) continue;
    used[i] = used[j] = true;
    if (distance > 0) out.push_back({ends[i], ends[j]});
  }
  return out;
}

}  // namespace

TrimRegion::TrimRegion(const Surface& surface, const std::vector<std::vector<Eigen::Vector2d>>& trims)
    : domain_(Eigen::Vector2d(surface.knots(0).from(), surface.knots(1).from()),
              Eigen::Vector2d(surface.knots(0).to(), surface.knots(1).to())) {
  const Eigen::Vector2d size = domain_.sizes();
  std::vector<Polyline> lines;
  for (const Polyline& trim : trims) {
    if (trim.size() < 2) continue;
    // In units of the domain, with points next to its border put on it: kernels leave them 1e-9 off, on either side.
    Polyline unit, simple;
    for (const Eigen::Vector2d& p : trim) {
      Eigen::Vector2d q = (p - domain_.min()).cwiseQuotient(size);
      for (int k = 0; k < 2; ++k) q[k] = q[k] < 1e-6 ? 0 : q[k] > 1 - 1e-6 ? 1 : q[k];
      unit.push_back(q);
    }
    simple.push_back(unit.front());
    simplify(unit, 0, unit.size() - 1, kStraightened, simple);
    for (Eigen::Vector2d& q : simple)
      q = q.cwiseEqual(1.0).select(domain_.max(), domain_.min() + q.cwiseProduct(size)).eval();
    lines.push_back(std::move(simple));
  }
  for (const Polyline& line : lines)
    for (std::size_t i = 1; i < line.size(); ++i) segments_.push_back({line[i - 1], line[i]});
  for (const Segment& bridge : bridges(lines)) segments_.push_back(bridge);
  rows_.resize(kRows);
  for (std::size_t s = 0; s < segments_.size(); ++s) {
    const auto [low, high] = std::minmax({segments_[s].from.y(), segments_[s].to.y()});
    for (std::size_t r = row(low); r <= row(high); ++r) rows_[r].push_back(s);
  }
  bool leavesSomething = false;
  for (int i = 0; i < 61 && !leavesSomething; ++i)
    for (int j = 0; j < 61 && !leavesSomething; ++j)
      leavesSomething = inside(domain_.min() + Eigen::Vector2d((i + 0.5) / 61, (j + 0.5) / 61).cwiseProduct(size));
  if (!leavesSomething) segments_.clear();
}

std::size_t TrimRegion::row(double v) const {
  const double position = (v - domain_.min().y()) / domain_.sizes().y() * static_cast<double>(kRows);
  return static_cast<std::size_t>(std::clamp(position, 0.0, static_cast<double>(kRows - 1)));
}

bool TrimRegion::inside(const Eigen::Vector2d& p) const {
  if (isWholeDomain()) return domain_.contains(p);
  bool in = false;
  for (std::size_t s : rows_[row(p.y())]) {
    const Eigen::Vector2d &a = segments_[s].from, &b = segments_[s].to;
    if ((a.y() <= p.y()) == (b.y() <= p.y())) continue;
    const double u = a.x() + (b.x() - a.x()) * ((p.y() - a.y()) / (b.y() - a.y()));
    if (u <= p.x()) in = !in;
  }
  return in;
}

bool TrimRegion::isBorder(const Segment& segment) const {
  for (int k = 0; k < 2; ++k) {
    for (double side : {domain_.min()[k], domain_.max()[k]}) {
      if (segment.from[k] == side && segment.to[k] == side) return true;
    }
  }
  return false;
}

Cover TrimRegion::cover(const Eigen::AlignedBox2d& box) const {
  if (isWholeDomain()) return domain_.intersects(box) ? Cover::inside : Cover::outside;
  const Eigen::Vector2d margin = 2 * kStraightened * domain_.sizes();
  const Eigen::Vector2d low = box.min() - margin, high = box.max() + margin;
  for (std::size_t r = row(low.y()); r <= row(high.y()); ++r) {
    for (std::size_t s : rows_[r]) {
      const Eigen::Vector2d &a = segments_[s].from, &b = segments_[s].to;
      if ((a.cwiseMax(b).array() < low.array()).any() || (a.cwiseMin(b).array() > high.array()).any()) continue;
      if (isBorder(segments_[s])) continue;
      // Apart if all corners lie on one side of the line.
      const Eigen::Vector2d normal(a.y() - b.y(), b.x() - a.x());
      double least = 0, most = 0;
      for (int corner = 0; corner < 4; ++corner) {
        const Eigen::Vector2d c(corner & 1 ? high.x() : low.x(), corner & 2 ? high.y() : low.y());
        const double side = normal.dot(c - a);
        least = corner == 0 ? side : std::min(least, side);
        most = corner == 0 ? side : std::max(most, side);
      }
      if (least <= 0 && most >= 0) return Cover::cut;
    }
  }
  const Eigen::AlignedBox2d seen = box.intersection(domain_);
  return !seen.isEmpty() && inside(seen.center()) ? Cover::inside : Cover::outside;
}

bool TrimRegion::reaches(const double* from, const double* to, const void* context) {
  const Eigen::AlignedBox2d box(Eigen::Vector2d(from[0], from[1]), Eigen::Vector2d(to[0], to[1]));
  return static_cast<const TrimRegion*>(context)->cover(box) != Cover::outside;
}

std::vector<Cover> coverOfCells(const Surface& surface, const TrimRegion& region) {
  const KnotVector &u = surface.knots(0), &v = surface.knots(1);
  std::vector<Cover> cells;
  cells.reserve(u.spans().size() * v.spans().size());
  const std::vector<Index> columns = v.spans();
  for (Index i : u.spans()) {
    for (Index j : columns) {
      cells.push_back(region.cover({Eigen::Vector2d(u[i], v[j]), Eigen::Vector2d(u[i + 1], v[j + 1])}));
    }
  }
  return cells;
}

std::vector<TrimRegion::Segment> TrimRegion::segmentsBetween(double low, double high) const {
  std::vector<std::size_t> found;
  if (!isWholeDomain())
    for (std::size_t r = row(low); r <= row(high); ++r) found.insert(found.end(), rows_[r].begin(), rows_[r].end());
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  std::vector<Segment> out;
  for (std::size_t s : found) {
    const auto [bottom, top] = std::minmax({segments_[s].from.y(), segments_[s].to.y()});
    if (bottom <= high && top >= low) out.push_back(segments_[s]);
  }
  return out;
}

}  // namespace strak
