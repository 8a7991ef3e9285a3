#include "strak/fitting/border_loops.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "strak/base/error.h"
#include "strak/fitting/delaunay.h"

namespace strak {

namespace {

using Corner = std::size_t;  // of a triangle: 0, 1, 2

constexpr double kUsualTriangle = 0.75;  // quantile of the circles' radii in parts of the spacing
constexpr double kLargeTriangle = 2.75;  // in parts of the usual one: random points hardly leave such a circle empty
constexpr double kRaggedTriangle = 2;    // beside a hole or the outside: from here on it belongs to that
constexpr double kDensityJump = 8;       // between neighbours: more is no sparser region but something else
constexpr double kSmallestHole = 2;      // its area in parts of the square of such a large radius

Corner next(Corner k) { return (k + 1) % 3; }
Corner after(Corner k) { return (k + 2) % 3; }

double medianOf(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

class Shape {
 public:
  Shape(const Eigen::Ref<const Net>& points, const BorderOptions& options)
      : points_(points), options_(options), mesh_(delaunay(points)) {
    if (mesh_.triangles.empty()) {
      throw InvalidInput("the points have no border: fewer than three, or all of them on one line");
    }
    collectNeighbours();
    measureSpacing();
    chooseTriangles();
    cutPinches();
  }

  Borders borders() {
    Borders result;
    result.spacing = spacing_;
    result.gap = options_.gap > 0 ? options_.gap : 2 * limit_ * spacing_;
    const std::vector<std::int32_t> part = splitIntoParts(result);
    addLoops(part, result);
    std::vector<char> used(static_cast<std::size_t>(points_.rows()), 0);
    for (std::size_t t = 0; t < part.size(); ++t) {
      if (part[t] < 0) continue;
      for (std::int32_t v : mesh_.triangles[t]) {
        if (!std::exchange(used[static_cast<std::size_t>(v)], 1))
          ++result.parts[static_cast<std::size_t>(part[t])].points;
      }
    }
    for (std::size_t v = 0; v < used.size(); ++v) result.leftOut += neighbourCount(v) > 0 && used[v] == 0 ? 1 : 0;
    return result;
  }

 private:
  Eigen::Vector2d place(std::int32_t v) const { return points_.row(v).transpose(); }
  double distance(std::int32_t a, std::int32_t b) const { return (place(a) - place(b)).norm(); }
  std::size_t neighbourCount(std::size_t v) const { return first_[v + 1] - first_[v]; }

  double area(std::size_t t) const {
    const auto& v = mesh_.triangles[t];
    const Eigen::Vector2d a = place(v[1]) - place(v[0]), b = place(v[2]) - place(v[0]);
    return (a[0] * b[1] - a[1] * b[0]) / 2;
  }

  // The points that each point has an edge to.
  void collectNeighbours() {
    first_.assign(static_cast<std::size_t>(points_.rows()) + 1, 0);
    const auto forEachEdge = [&](const auto& visit) {
      for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
        for (Corner k = 0; k < 3; ++k) {
          const std::int32_t a = mesh_.triangles[t][next(k)], b = mesh_.triangles[t][after(k)];
          visit(static_cast<std::size_t>(a), b);
          if (mesh_.neighbours[t][k] < 0) visit(static_cast<std::size_t>(b), a);
        }
      }
    };
    forEachEdge([&](std::size_t from, std::int32_t) { ++first_[from + 1]; });
    for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
    neighbours_.resize(first_.back());
    std::vector<std::size_t> fill = first_;
    forEachEdge([&](std::size_t from, std::int32_t to) { neighbours_[fill[from]++] = to; });
  }

  // The distance of neighbours around each point: the median over its edges, and again over its neighbours, so that
  // neither a hole beside it nor its being an outlier shows.
  void measureSpacing() {
    const auto count = static_cast<std::size_t>(points_.rows());
    std::vector<double> own(count, 0), lengths;
    second_.assign(count, 0);
    for (std::size_t v = 0; v < count; ++v) {
      if (neighbourCount(v) == 0) continue;
      lengths.clear();
      for (std::size_t i = first_[v]; i < first_[v + 1]; ++i) {
        lengths.push_back(distance(static_cast<std::int32_t>(v), neighbours_[i]));
      }
      own[v] = medianOf(lengths);
      std::nth_element(lengths.begin(), lengths.begin() + 1, lengths.end());
      second_[v] = lengths[1];
    }
    around_.assign(count, 0);
    std::vector<double> all;
    for (std::size_t v = 0; v < count; ++v) {
      if (neighbourCount(v) == 0) continue;
      lengths.assign(1, own[v]);
      for (std::size_t i = first_[v]; i < first_[v + 1]; ++i) {
        lengths.push_back(own[static_cast<std::size_t>(neighbours_[i])]);
      }
      around_[v] = medianOf(lengths);
      all.push_back(around_[v]);
    }
    spacing_ = medianOf(all);
    limitGrowth();
  }

  // At the tip of a spike most edges are long ones to other tips; but no spacing grows faster than with the distance.
  void limitGrowth() {
    constexpr double kGrowth = 0.5;
    constexpr int kSweeps = 4;
    const auto relax = [&](std::size_t v) {
      for (std::size_t i = first_[v]; i < first_[v + 1]; ++i) {
        const double there = around_[static_cast<std::size_t>(neighbours_[i])];
        if (there >= around_[v]) continue;
        around_[v] = std::min(around_[v], there + kGrowth * distance(static_cast<std::int32_t>(v), neighbours_[i]));
      }
    };
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      for (std::size_t v = 0; v < around_.size(); ++v) relax(sweep % 2 == 0 ? v : around_.size() - 1 - v);
    }
  }

  // The radius of the circumscribed circle.
  double radius(std::size_t t) const {
    const auto& v = mesh_.triangles[t];
    return distance(v[0], v[1]) * distance(v[1], v[2]) * distance(v[2], v[0]) / (4 * area(t));
  }

  void chooseTriangles() {
    const std::size_t count = mesh_.triangles.size();
    kept_.assign(count, 0);
    std::vector<double> ratio(count);
    for (std::size_t t = 0; t < count; ++t) {
      double scale = 0, least = std::numeric_limits<double>::infinity();
      for (std::int32_t v : mesh_.triangles[t]) {
        scale = std::max(scale, around_[static_cast<std::size_t>(v)]);
        least = std::min(least, around_[static_cast<std::size_t>(v)]);
      }
      scale = std::min(scale, kDensityJump * least);
      ratio[t] = area(t) > 0 ? radius(t) / scale : std::numeric_limits<double>::infinity();
    }
    std::vector<double> sorted = ratio;
    const auto usual = sorted.begin() + static_cast<std::ptrdiff_t>(kUsualTriangle * static_cast<double>(count - 1));
    std::nth_element(sorted.begin(), usual, sorted.end());
    limit_ = kLargeTriangle * *usual;
    for (std::size_t t = 0; t < count; ++t) {
      const bool large = options_.gap > 0 ? 2 * radius(t) > options_.gap : ratio[t] > limit_;
      kept_[t] = large || !(area(t) > 0) ? 0 : 1;
    }
    fillSmallHoles();
    // What reaches into a corner of a hole is smaller than the hole.
    const double ragged = kRaggedTriangle / kLargeTriangle;
    std::vector<std::size_t> border;
    for (std::size_t t = 0; t < count; ++t) border.push_back(t);
    while (!border.empty()) {
      const std::size_t t = border.back();
      border.pop_back();
      const bool small = options_.gap > 0 ? 2 * radius(t) <= ragged * options_.gap : ratio[t] <= ragged * limit_;
      if (kept_[t] == 0 || small) continue;
      if (!isBorder(t, 0) && !isBorder(t, 1) && !isBorder(t, 2)) continue;
      kept_[t] = 0;
      for (std::int32_t n : mesh_.neighbours[t]) {
        if (n >= 0) border.push_back(static_cast<std::size_t>(n));
      }
    }
  }

  // Single large triangles, and a few that touch, come by chance.
  void fillSmallHoles() {
    std::vector<char> seen = kept_;
    std::vector<std::size_t> hole;
    for (std::size_t seed = 0; seed < kept_.size(); ++seed) {
      if (std::exchange(seen[seed], 1) != 0) continue;
      hole.assign(1, seed);
      double size = 0, scale = 0;
      bool open = false;
      for (std::size_t i = 0; i < hole.size(); ++i) {
        const std::size_t t = hole[i];
        size += area(t);
        for (std::int32_t v : mesh_.triangles[t]) scale = std::max(scale, around_[static_cast<std::size_t>(v)]);
        for (std::int32_t n : mesh_.neighbours[t]) {
          open = open || n < 0;
          if (n >= 0 && std::exchange(seen[static_cast<std::size_t>(n)], 1) == 0) {
            hole.push_back(static_cast<std::size_t>(n));
          }
        }
      }
      const double large = options_.gap > 0 ? options_.gap / 2 : limit_ * scale;
      if (open || size > kSmallestHole * large * large) continue;
      for (std::size_t t : hole) kept_[t] = 1;
    }
  }

  bool isBorder(std::size_t t, Corner k) const {
    const std::int32_t n = mesh_.neighbours[t][k];
    return n < 0 || kept_[static_cast<std::size_t>(n)] == 0;
  }

  // The kept triangles around corner `k` of t, to the left of its border edge that begins there.
  std::vector<std::size_t> fan(std::size_t t, Corner k) const {
    std::vector<std::size_t> triangles{t};
    const std::int32_t v = mesh_.triangles[t][k];
    for (;;) {
      // Across the edge that ends in v.
      const Corner opposite = next(k);
      if (isBorder(t, opposite)) return triangles;
      t = static_cast<std::size_t>(mesh_.neighbours[t][opposite]);
      const auto& corners = mesh_.triangles[t];
      k = static_cast<Corner>(std::find(corners.begin(), corners.end(), v) - corners.begin());
      triangles.push_back(t);
    }
  }

  // Where a point joins pieces all alone, only the largest of the pieces' triangles around it stay. That may leave
  // other such points.
  void cutPinches() {
    while (cutOnce()) {
    }
  }

  bool cutOnce() {
    std::vector<std::pair<std::int32_t, std::size_t>> starts;  // of border edges: the point, 3 * triangle + its corner
    for (std::size_t t = 0; t < kept_.size(); ++t) {
      for (Corner k = 0; k < 3 && kept_[t] != 0; ++k) {
        if (isBorder(t, k)) starts.emplace_back(mesh_.triangles[t][next(k)], 3 * t + next(k));
      }
    }
    std::sort(starts.begin(), starts.end());
    bool cut = false;
    for (std::size_t i = 0, end = 0; i < starts.size(); i = end) {
      while (end < starts.size() && starts[end].first == starts[i].first) ++end;
      if (end - i < 2) continue;
      std::vector<std::pair<double, std::vector<std::size_t>>> fans;
      for (std::size_t j = i; j < end; ++j) {
        if (kept_[starts[j].second / 3] == 0) continue;  // cut away at another point
        fans.emplace_back(0, fan(starts[j].second / 3, starts[j].second % 3));
        for (std::size_t f : fans.back().second) fans.back().first += area(f);
      }
      std::sort(fans.begin(), fans.end());
      for (std::size_t j = 0; j + 1 < fans.size(); ++j) {
        for (std::size_t f : fans[j].second) kept_[f] = 0;
        cut = true;
      }
    }
    return cut;
  }

  // The number of the part of each triangle, -1 for none.
  std::vector<std::int32_t> splitIntoParts(Borders& result) const {
    std::vector<std::int32_t> part(kept_.size(), -1);
    std::vector<BorderPart> parts;
    std::vector<std::size_t> open;
    for (std::size_t seed = 0; seed < kept_.size(); ++seed) {
      if (kept_[seed] == 0 || part[seed] >= 0) continue;
      const auto number = static_cast<std::int32_t>(parts.size());
      BorderPart& own = parts.emplace_back();
      part[seed] = number;
      open.assign(1, seed);
      while (!open.empty()) {
        const std::size_t t = open.back();
        open.pop_back();
        own.area += area(t);
        for (Corner k = 0; k < 3; ++k) {
          if (isBorder(t, k)) continue;
          const auto n = static_cast<std::size_t>(mesh_.neighbours[t][k]);
          if (part[n] >= 0) continue;
          part[n] = number;
          open.push_back(n);
        }
      }
    }
    if (parts.empty()) {
      throw InvalidInput("no two points are nearer to one another than the gap that counts as a hole: use a wider one");
    }
    // Outliers are few, however far apart.
    std::vector<std::size_t> triangles(parts.size(), 0), order(parts.size());
    for (std::int32_t p : part) {
      if (p >= 0) ++triangles[static_cast<std::size_t>(p)];
    }
    const auto most =
        static_cast<std::size_t>(std::max_element(triangles.begin(), triangles.end()) - triangles.begin());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return parts[a].area > parts[b].area; });
    std::vector<std::int32_t> rank(parts.size(), -1);
    for (std::size_t i : order) {
      if (parts[i].area < options_.smallestPart * parts[most].area ||
          static_cast<double>(triangles[i]) < options_.smallestPart * static_cast<double>(triangles[most])) {
        continue;
      }
      rank[i] = static_cast<std::int32_t>(result.parts.size());
      result.parts.push_back(parts[i]);
    }
    for (auto& p : part) p = p < 0 ? -1 : rank[static_cast<std::size_t>(p)];
    return part;
  }

  void addLoops(const std::vector<std::int32_t>& part, Borders& result) const {
    // Every point begins at most one border edge.
    std::vector<std::int32_t> follows(static_cast<std::size_t>(points_.rows()), -1);
    for (std::size_t t = 0; t < part.size(); ++t) {
      for (Corner k = 0; k < 3 && part[t] >= 0; ++k) {
        if (isBorder(t, k))
          follows[static_cast<std::size_t>(mesh_.triangles[t][next(k)])] = mesh_.triangles[t][after(k)];
      }
    }
    for (std::size_t t = 0; t < part.size(); ++t) {
      for (Corner k = 0; k < 3 && part[t] >= 0; ++k) {
        auto v = mesh_.triangles[t][next(k)];
        if (!isBorder(t, k) || follows[static_cast<std::size_t>(v)] < 0) continue;
        BorderLoop loop;
        std::vector<double> spacings;
        while (follows[static_cast<std::size_t>(v)] >= 0) {
          loop.points.push_back(v);
          spacings.push_back(second_[static_cast<std::size_t>(v)]);
          v = std::exchange(follows[static_cast<std::size_t>(v)], -1);
        }
        const Eigen::Vector2d origin = place(v);
        for (std::size_t i = 0; i < loop.points.size(); ++i) {
          const Eigen::Vector2d a = place(static_cast<std::int32_t>(loop.points[i])) - origin;
          const Eigen::Vector2d b =
              place(static_cast<std::int32_t>(loop.points[(i + 1) % loop.points.size()])) - origin;
          loop.area += (a[0] * b[1] - a[1] * b[0]) / 2;
        }
        loop.spacing = medianOf(spacings);
        BorderPart& owner = result.parts[static_cast<std::size_t>(part[t])];
        if (loop.area > 0) {
          owner.outer = std::move(loop);
        } else {
          owner.holes.push_back(std::move(loop));
        }
      }
    }
  }

  Eigen::Ref<const Net> points_;
  BorderOptions options_;
  Triangulation mesh_;
  std::vector<std::size_t> first_;        // of each point's neighbours
  std::vector<std::int32_t> neighbours_;  // of points
  std::vector<double> second_;            // distance of the second nearest neighbour
  std::vector<double> around_;            // spacing around each point
  double spacing_ = 0, limit_ = 0;
  std::vector<char> kept_;
};

}  // namespace

Borders findBorders(const Eigen::Ref<const Net>& points, const BorderOptions& options) {
  if (!(options.gap >= 0) || !std::isfinite(options.gap)) {
    throw InvalidInput("the gap that counts as a hole must be a positive length, or 0 to have it chosen");
  }
  // Neighbours beside one another in memory: three times as fast for millions of points in any order.
  const std::vector<std::int32_t> order = orderInPlane(points);
  Net sorted(points.rows(), 2);
  for (std::size_t i = 0; i < order.size(); ++i) sorted.row(static_cast<Index>(i)) = points.row(order[i]);
  Borders borders = Shape(sorted, options).borders();
  const auto rename = [&](BorderLoop& loop) {
    for (Index& i : loop.points) i = order[static_cast<std::size_t>(i)];
  };
  for (BorderPart& part : borders.parts) {
    rename(part.outer);
    for (BorderLoop& hole : part.holes) rename(hole);
  }
  return borders;
}

}  // namespace strak
