#include "strak/report/depth_buffer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace strak {

namespace {
constexpr double kFine = 2;  // raster points per pixel
constexpr float kNothing = -std::numeric_limits<float>::infinity();
}  // namespace

DepthBuffer::DepthBuffer(int width, int height)
    : width_(static_cast<int>(width * kFine)),
      height_(static_cast<int>(height * kFine)),
      depth_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), kNothing) {}

void DepthBuffer::add(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector2d p = a.head<2>() * kFine, q = b.head<2>() * kFine, r = c.head<2>() * kFine;
  const double area = (q - p).x() * (r - p).y() - (q - p).y() * (r - p).x();
  if (area == 0) return;
  const int y0 = static_cast<int>(std::max(0.0, std::ceil(std::min({p.y(), q.y(), r.y()}) - 0.5)));
  const int y1 = static_cast<int>(std::min(height_ - 1.0, std::floor(std::max({p.y(), q.y(), r.y()}) - 0.5)));
  const int x0 = static_cast<int>(std::max(0.0, std::ceil(std::min({p.x(), q.x(), r.x()}) - 0.5)));
  const int x1 = static_cast<int>(std::min(width_ - 1.0, std::floor(std::max({p.x(), q.x(), r.x()}) - 0.5)));
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const Eigen::Vector2d d(x + 0.5 - p.x(), y + 0.5 - p.y());
      const double wq = (d.x() * (r - p).y() - d.y() * (r - p).x()) / area;
      const double wr = ((q - p).x() * d.y() - (q - p).y() * d.x()) / area;
      if (wq < 0 || wr < 0 || wq + wr > 1) continue;
      float& nearest =
          depth_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
      nearest = std::max(nearest, static_cast<float>(a.z() + wq * (b.z() - a.z()) + wr * (c.z() - a.z())));
    }
}

bool DepthBuffer::visible(const Eigen::Vector3d& point, double slack) const {
  const int x = static_cast<int>(std::floor(point.x() * kFine)), y = static_cast<int>(std::floor(point.y() * kFine));
  // The furthest of the neighbours: on a slope they lie at different depths, and beside an edge there is nothing.
  float nearest = std::numeric_limits<float>::infinity();
  for (int j = y - 1; j <= y + 1; ++j)
    for (int i = x - 1; i <= x + 1; ++i) {
      if (i < 0 || j < 0 || i >= width_ || j >= height_) return true;
      nearest = std::min(
          nearest,
          depth_[static_cast<std::size_t>(j) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(i)]);
    }
  return point.z() + slack >= nearest;
}

std::vector<std::vector<Eigen::Vector2d>> visiblePieces(const std::vector<Eigen::Vector3d>& line,
                                                        const DepthBuffer& buffer) {
  struct Run {
    bool visible;
    std::vector<Eigen::Vector2d> points;
    double length = 0;
  };
  std::vector<Run> runs;
  const auto extend = [&](const Eigen::Vector3d& p) {
    Run& run = runs.back();
    if (!run.points.empty()) run.length += (run.points.back() - p.head<2>()).norm();
    run.points.emplace_back(p.head<2>());
  };
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (i == 0) {
      runs.push_back({buffer.visible(line[0]), {}});
      extend(line[0]);
      continue;
    }
    const Eigen::Vector3d step = line[i] - line[i - 1];
    const int parts = std::max(1, static_cast<int>(std::ceil(step.head<2>().norm() / 0.7)));
    Eigen::Vector3d before = line[i - 1];
    for (int k = 1; k <= parts; ++k) {
      const Eigen::Vector3d after = k == parts ? line[i] : Eigen::Vector3d(line[i - 1] + step * k / parts);
      const bool visible = buffer.visible(after);
      if (visible != runs.back().visible) {
        Eigen::Vector3d low = before, high = after;
        for (int b = 0; b < 6; ++b) {
          const Eigen::Vector3d middle = (low + high) / 2;
          (buffer.visible(middle) == visible ? high : low) = middle;
        }
        extend(high);
        runs.push_back({visible, {}});
        extend(high);
      }
      // Points in between were only looked at; the line keeps its own.
      if (k == parts) extend(after);
      before = after;
    }
  }
  std::vector<std::vector<Eigen::Vector2d>> pieces;
  bool open = false;  // the last piece is still growing
  for (const Run& run : runs) {
    if (!run.visible && !(run.length < 1 && open)) {
      open = false;
      continue;
    }
    if (open) {
      pieces.back().insert(pieces.back().end(), run.points.begin() + 1, run.points.end());
    } else {
      pieces.push_back(run.points);
      open = true;
    }
  }
  std::erase_if(pieces, [](const auto& piece) {
    double length = 0;
    for (std::size_t i = 1; i < piece.size(); ++i) length += (piece[i] - piece[i - 1]).norm();
    return length < 1;
  });
  return pieces;
}

}  // namespace strak
