#include "strak/report/isobands.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <unordered_set>

#include "strak/report/svg.h"

namespace strak {

namespace {

using Vertex = std::uint32_t;
using Triangle = std::array<Vertex, 3>;

std::uint64_t pairKey(Vertex a, Vertex b) { return (static_cast<std::uint64_t>(a) << 32) | b; }

// The outline of a growing set of polygons: edges passed in both directions are inside and vanish.
class Outline {
 public:
  void add(const std::vector<Vertex>& polygon) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vertex a = polygon[i], b = polygon[(i + 1) % polygon.size()];
      if (a == b) continue;
      if (edges_.erase(pairKey(b, a)) == 0) edges_.insert(pairKey(a, b));
    }
  }

  std::string path(const std::vector<Eigen::Vector3d>& points) const {
    std::vector<std::uint64_t> edges(edges_.begin(), edges_.end());
    std::sort(edges.begin(), edges.end());
    std::vector<bool> used(edges.size(), false);
    std::string out;
    for (std::size_t first = 0; first < edges.size(); ++first) {
      if (used[first]) continue;
      PicturePolyline loop;
      for (std::size_t edge = first; edge < edges.size();) {
        used[edge] = true;
        loop.emplace_back(points[static_cast<Vertex>(edges[edge] >> 32)].head<2>());
        const auto next = static_cast<Vertex>(edges[edge]);
        edge = static_cast<std::size_t>(std::lower_bound(edges.begin(), edges.end(), pairKey(next, 0)) - edges.begin());
        while (edge < edges.size() && used[edge] && static_cast<Vertex>(edges[edge] >> 32) == next) ++edge;
        if (edge < edges.size() && static_cast<Vertex>(edges[edge] >> 32) != next) break;
      }
      out += polygonPath(loop);
    }
    return out;
  }

 private:
  std::unordered_set<std::uint64_t> edges_;
};

class BandCutter {
 public:
  BandCutter(PictureMesh& mesh, const std::vector<double>& levels)
      : mesh_(mesh), levels_(levels), crossings_(levels.size()), outlines_(levels.size() + 1) {
    // A value on a level would make polygons without area.
    for (double& value : mesh_.values)
      if (std::binary_search(levels.begin(), levels.end(), value))
        value = std::nextafter(value, std::numeric_limits<double>::infinity());
  }

  // Splits triangles that are partly hidden until they are smaller than a pixel.
  void add(const Triangle& t, const DepthBuffer& buffer) {
    const auto& p = mesh_.corners;
    const Eigen::Vector3d centre = (p[t[0]] + p[t[1]] + p[t[2]]) / 3;
    int seen = buffer.visible(centre, kSlack) ? 1 : 0;
    for (Vertex v : t) seen += buffer.visible(p[v], kSlack) ? 1 : 0;
    if (seen == 0) return;
    double longest = 0;
    for (int k = 0; k < 3; ++k)
      longest = std::max(
          longest, (p[t[static_cast<std::size_t>(k)]] - p[t[static_cast<std::size_t>((k + 1) % 3)]]).head<2>().norm());
    if (seen == 4 || longest < 0.8) {
      if (seen >= 2) cut(t);
      return;
    }
    const Vertex a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
    for (const Triangle& part : {Triangle{t[0], a, c}, Triangle{a, t[1], b}, Triangle{c, b, t[2]}, Triangle{a, b, c}})
      add(part, buffer);
  }

  std::vector<std::string> paths() const {
    std::vector<std::string> out;
    for (const Outline& outline : outlines_) out.push_back(outline.path(mesh_.corners));
    return out;
  }

 private:
  static constexpr double kSlack = 1.5;

  std::size_t band(Vertex v) const {
    return static_cast<std::size_t>(std::upper_bound(levels_.begin(), levels_.end(), mesh_.values[v]) -
                                    levels_.begin());
  }

  void cut(const Triangle& t) {
    const auto [low, high] = std::minmax({band(t[0]), band(t[1]), band(t[2])});
    if (low == high) {
      outlines_[low].add({t[0], t[1], t[2]});
      return;
    }
    std::vector<Vertex> polygon;
    for (std::size_t k = low; k <= high; ++k) {
      polygon.clear();
      for (std::size_t i = 0; i < 3; ++i) {
        const Vertex a = t[i], b = t[(i + 1) % 3];
        if (band(a) == k) polygon.push_back(a);
        // Entering and leaving the band on the way from a to b, in this order.
        if (band(a) < band(b)) {
          if (band(a) < k && band(b) >= k) polygon.push_back(crossing(a, b, k - 1));
          if (band(a) <= k && band(b) > k) polygon.push_back(crossing(a, b, k));
        } else if (band(a) > band(b)) {
          if (band(a) > k && band(b) <= k) polygon.push_back(crossing(a, b, k));
          if (band(a) >= k && band(b) < k) polygon.push_back(crossing(a, b, k - 1));
        }
      }
      outlines_[k].add(polygon);
    }
  }

  Vertex crossing(Vertex a, Vertex b, std::size_t level) {
    if (a > b) std::swap(a, b);
    const auto [place, isNew] = crossings_[level].try_emplace(pairKey(a, b), 0);
    if (isNew) {
      const double from = mesh_.values[a], to = mesh_.values[b];
      place->second = append(a, b, (levels_[level] - from) / (to - from));
    }
    return place->second;
  }

  Vertex middle(Vertex a, Vertex b) {
    if (a > b) std::swap(a, b);
    const auto [place, isNew] = middles_.try_emplace(pairKey(a, b), 0);
    if (isNew) place->second = append(a, b, 0.5);
    return place->second;
  }

  Vertex append(Vertex a, Vertex b, double part) {
    const Eigen::Vector3d point = mesh_.corners[a] * (1 - part) + mesh_.corners[b] * part;
    const double value = mesh_.values[a] * (1 - part) + mesh_.values[b] * part;
    mesh_.corners.push_back(point);
    mesh_.values.push_back(value);
    return static_cast<Vertex>(mesh_.corners.size() - 1);
  }

  PictureMesh& mesh_;
  const std::vector<double>& levels_;
  std::vector<std::unordered_map<std::uint64_t, Vertex>> crossings_;  // per level, by the mesh edge it lies on
  std::unordered_map<std::uint64_t, Vertex> middles_;
  std::vector<Outline> outlines_;
};

}  // namespace

std::vector<std::string> visibleBands(PictureMesh mesh, const std::vector<double>& levels, const DepthBuffer& buffer) {
  BandCutter cutter(mesh, levels);
  for (const Triangle& triangle : mesh.triangles) cutter.add(triangle, buffer);
  return cutter.paths();
}

}  // namespace strak
