#include "strak/report/feature_lines.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "strak/metrology/curvature_comb.h"
#include "strak/report/colour_map.h"

namespace strak {

namespace {

Index samplesPerSpan(const KnotVector& knots, Index samples, Index least, Index most) {
  return std::clamp<Index>(samples / static_cast<Index>(knots.spans().size()), least, most);
}

// Evenly spaced values inside the domain.
std::vector<double> insideValues(const KnotVector& knots, int count) {
  std::vector<double> out;
  out.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) out.push_back(knots.from() + knots.length() * (i + 0.5) / count);
  return out;
}

// The parts of a polyline in the parameter plane that lie in the region.
std::vector<std::vector<Eigen::Vector2d>> partsInside(const std::vector<Eigen::Vector2d>& line,
                                                      const TrimRegion& region) {
  if (region.isWholeDomain()) return {line};
  std::vector<std::vector<Eigen::Vector2d>> parts;
  bool before = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const bool in = region.inside(line[i]);
    if (i > 0 && in != before) {
      Eigen::Vector2d a = line[i - 1], b = line[i];
      for (int step = 0; step < 24; ++step) {
        const Eigen::Vector2d middle = (a + b) / 2;
        (region.inside(middle) == before ? a : b) = middle;
      }
      if (in) parts.emplace_back();
      parts.back().push_back(b);
    } else if (in && i == 0) {
      parts.emplace_back();
    }
    if (in) parts.back().push_back(line[i]);
    before = in;
  }
  return parts;
}

}  // namespace

std::vector<SpacePolyline> fieldLines(const SceneSurface& scene, const SurfaceField& field,
                                      const std::vector<double>& levels, double flatness) {
  const Surface& surface = scene.surface;
  Eigen::AlignedBox3d box;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (std::size_t i = 0; i < scene.samples.points.size(); ++i) {
    box.extend(scene.samples.points[i]);
    const double value = field(scene.samples.points[i], scene.samples.normals[i]);
    low = std::min(low, value);
    high = std::max(high, value);
  }
  const double size = box.isEmpty() ? 0 : box.diagonal().norm();
  if (!(size > 0)) return {};
  // Only the levels that the mesh points reach, or nearly reach.
  const double margin = 0.1 * (high - low) + 1e-3 * std::max(std::abs(low), std::abs(high));
  std::vector<double> reached;
  for (double level : levels)
    if (level > low - margin && level < high + margin) reached.push_back(level);
  if (reached.empty()) return {};
  LineOptions options;
  const double spans =
      static_cast<double>(surface.knots(0).spans().size()) * static_cast<double>(surface.knots(1).spans().size());
  options.samplesPerSpan = std::clamp<Index>(static_cast<Index>(std::sqrt(200'000 / spans)), 2, 8);
  options.minSamples = 48;
  options.flatness = std::clamp(flatness / size, 1e-6, 1e-2);
  if (!scene.region.isWholeDomain())
    options.inside = [&region = scene.region](double u, double v) { return region.inside({u, v}); };
  std::vector<SpacePolyline> out;
  for (SurfaceLine& line : levelLines(surface, field, reached, options)) out.push_back(std::move(line.points));
  return out;
}

std::vector<SpacePolyline> parameterLines(const SceneSurface& scene, int count) {
  std::vector<SpacePolyline> out;
  for (int fixed = 0; fixed < 2; ++fixed) {
    const KnotVector& along = scene.surface.knots(1 - fixed);
    const Index parts = samplesPerSpan(along, 240, 4, 60);
    for (double value : insideValues(scene.surface.knots(fixed), count)) {
      std::vector<Eigen::Vector2d> line;
      for (Index span : along.spans())
        for (Index i = 0; i <= parts; ++i) {
          Eigen::Vector2d p;
          p[fixed] = value;
          p[1 - fixed] =
              along[span] + (along[span + 1] - along[span]) * static_cast<double>(i) / static_cast<double>(parts);
          if (line.empty() || p != line.back()) line.push_back(p);
        }
      for (const auto& part : partsInside(line, scene.region)) out.push_back(pointsAt(scene.surface, part));
    }
  }
  return out;
}

std::vector<Comb> surfaceCombs(const SceneSurface& scene, int count, int density) {
  std::vector<Comb> combs;
  for (int fixed = 0; fixed < 2; ++fixed) {
    const Index samples = samplesPerSpan(scene.surface.knots(1 - fixed), density, 2, 32);
    for (double value : insideValues(scene.surface.knots(fixed), count)) {
      const CurvatureComb comb = curvatureComb(scene.surface, fixed, value, samples);
      bool open = false;
      for (std::size_t i = 0; i < comb.points.size(); ++i) {
        Eigen::Vector2d p;
        p[fixed] = value;
        p[1 - fixed] = comb.parameters[i];
        const bool in = scene.region.isWholeDomain() || scene.region.inside(p);
        if (in && !open) combs.emplace_back();
        open = in;
        if (!in) continue;
        combs.back().base.push_back(comb.points[i]);
        combs.back().direction.push_back(-comb.curvature[i] * comb.normals[i]);
      }
    }
  }
  return combs;
}

Comb curveComb(const SceneCurve& scene) {
  const CurvatureComb comb = curvatureComb(scene.curve, samplesPerSpan(scene.curve.knots(0), 480, 4, 64));
  Comb out;
  for (std::size_t i = 0; i < comb.points.size(); ++i) {
    out.base.push_back(comb.points[i]);
    out.direction.push_back(-comb.curvature[i] * comb.normals[i]);
  }
  return out;
}

int teethPerLine(const Scene& scene, int count, Index teeth) {
  const Index lines = Index{2} * count * static_cast<Index>(scene.surfaces.size());
  return static_cast<int>(std::clamp<Index>(teeth / std::max<Index>(lines, 1), 12, 480));
}

double largestCurvature(const std::vector<Comb>& combs) {
  std::vector<Weighted> lengths;
  for (const Comb& comb : combs)
    for (const Eigen::Vector3d& direction : comb.direction) lengths.push_back({direction.norm(), 1});
  return quantiles(std::move(lengths), 0, 0.995).second;
}

}  // namespace strak
