#include "strak/metrology/isophotes.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "strak/base/error.h"
#include "strak/metrology/level_lines.h"

namespace strak {

namespace {

using Eigen::Vector3d;

constexpr double kNoRange = 1e-10;  // of the field: less is rounding, a plane has no isophotes

void check(const Surface& surface, const LineOptions& options) {
  if (surface.pointDimension() != 3) {
    throw InvalidInput("lines need a surface in space: give control points with three coordinates");
  }
  if (options.samplesPerSpan < 1 || options.minSamples < 1 || options.maxSamples < 1 || !(options.flatness > 0)) {
    throw InvalidInput(fmt::format("the samples ({}, {}, {}) and the flatness {} must be positive",
                                   options.samplesPerSpan, options.minSamples, options.maxSamples, options.flatness));
  }
}

struct Bands {
  std::vector<Band> u, v;
};

Bands bandsOf(const Surface& surface, const LineOptions& options) {
  return {bandsOf(surface.knots(0), options), bandsOf(surface.knots(1), options)};
}

std::vector<LineGrid> gridsOf(const Surface& surface, const SurfaceField& field, const Bands& bands) {
  std::vector<LineGrid> grids;
  for (const Band& u : bands.u) {
    for (const Band& v : bands.v) grids.emplace_back(surface, field, u, v);
  }
  return grids;
}

std::vector<double> evenLevels(const std::vector<LineGrid>& grids, int count, const LineOptions& options) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const LineGrid& grid : grids) {
    for (Index i = 0; i <= grid.cellsU(); ++i) {
      for (Index j = 0; j <= grid.cellsV(); ++j) {
        const double value = grid.values(i, j);
        if (std::isnan(value)) continue;
        if (options.inside && !options.inside(grid.node(i, j)[0], grid.node(i, j)[1])) continue;
        least = std::min(least, value);
        most = std::max(most, value);
      }
    }
  }
  std::vector<double> levels;
  if (!(most - least > kNoRange * std::max({1.0, std::abs(least), std::abs(most)}))) return levels;
  for (int i = 1; i <= count; ++i) levels.push_back(std::lerp(least, most, static_cast<double>(i) / (count + 1)));
  return levels;
}

double sizeOf(const Surface& surface) {
  const Net points = surface.euclideanNet();
  return (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm();
}

std::vector<SurfaceLine> levelLines(const std::vector<LineGrid>& grids, double size, const std::vector<double>& levels,
                                    const LineOptions& options) {
  std::vector<std::vector<SurfaceLine>> found(levels.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, levels.size(), 1), [&](const auto& range) {
    for (std::size_t l = range.begin(); l < range.end(); ++l) {
      for (const LineGrid& grid : grids) {
        for (const LineTrace& trace : traceLevel(grid, levels[l], options.flatness * size)) {
          const auto between = [&](std::size_t s, double t) {
            return betweenVertices(grid, levels[l], trace.vertices[s], trace.vertices[s + 1], t, trace.cells[s]);
          };
          auto lines = clippedLines(trace, levels[l], options.inside, between);
          std::move(lines.begin(), lines.end(), std::back_inserter(found[l]));
        }
      }
    }
  });
  std::vector<SurfaceLine> result;
  for (auto& lines : found) std::move(lines.begin(), lines.end(), std::back_inserter(result));
  return result;
}

Vector3d unit(const Vector3d& direction, const char* what) {
  if (!(direction.norm() > 0) || !direction.allFinite()) {
    throw InvalidInput(fmt::format("the {} has no direction: give a vector other than zero", what));
  }
  return direction.normalized();
}

}  // namespace

SurfaceField isophoteField(const Vector3d& light) {
  return [l = unit(light, "light")](const Vector3d&, const Vector3d& normal) { return normal.dot(l); };
}

SurfaceField reflectionField(const Vector3d& light, const Vector3d& eye) {
  return [l = unit(light, "light"), e = unit(eye, "eye")](const Vector3d&, const Vector3d& normal) {
    return 2 * normal.dot(e) * normal.dot(l) - e.dot(l);
  };
}

SurfaceField highlightField(const Vector3d& place, const Vector3d& direction) {
  return [place, d = unit(direction, "light tube")](const Vector3d& point, const Vector3d& normal) {
    // The distance of two straight lines: the component of the way between them across both.
    const Vector3d across = normal.cross(d);
    const double length = across.norm();
    return length > 0 ? (place - point).dot(across) / length : 0;
  };
}

std::vector<SurfaceLine> levelLines(const Surface& surface, const SurfaceField& field,
                                    const std::vector<double>& levels, const LineOptions& options) {
  check(surface, options);
  const Bands bands = bandsOf(surface, options);
  return levelLines(gridsOf(surface, field, bands), sizeOf(surface), levels, options);
}

std::vector<double> evenLevels(const Surface& surface, const SurfaceField& field, int count,
                               const LineOptions& options) {
  check(surface, options);
  const Bands bands = bandsOf(surface, options);
  return evenLevels(gridsOf(surface, field, bands), count, options);
}

std::vector<SurfaceLine> isophotes(const Surface& surface, const IsophoteOptions& options) {
  check(surface, options);
  const SurfaceField field = isophoteField(options.light);
  const Bands bands = bandsOf(surface, options);
  const auto grids = gridsOf(surface, field, bands);
  return levelLines(grids, sizeOf(surface),
                    options.levels.empty() ? evenLevels(grids, options.lines, options) : options.levels, options);
}

std::vector<SurfaceLine> isoparametricLines(const Surface& surface, int direction, Index perSpan,
                                            const LineOptions& options) {
  check(surface, options);
  if (direction != 0 && direction != 1) {
    throw InvalidInput(fmt::format("there is no direction {}: give 0 (u) or 1 (v)", direction));
  }
  if (perSpan < 1) throw InvalidInput(fmt::format("{} lines a span are too few: give at least 1", perSpan));
  const KnotVector& fixed = surface.knots(direction);
  const auto fixedSpans = fixed.spans();
  std::vector<SurfaceLine> result;
  const auto add = [&](Index fixedSpan, double value) {
    for (const Band& band : bandsOf(surface.knots(1 - direction), options)) {
      const auto at = [&](double t, Index span) {
        LineVertex vertex;
        SurfaceJet jet;
        vertex.parameters[direction] = value;
        vertex.parameters[1 - direction] = t;
        const SurfacePiece piece(surface, direction == 0 ? fixedSpan : span, direction == 0 ? span : fixedSpan);
        piece.at(vertex.parameters[0], vertex.parameters[1], 0, jet);
        vertex.point = jet[0];
        return vertex;
      };
      LineTrace trace;
      for (std::size_t i = 0; i < band.parameters.size(); ++i) {
        trace.vertices.push_back(at(band.parameters[i], band.spans[std::min(i, band.spans.size() - 1)]));
      }
      const auto between = [&](std::size_t s, double t) -> std::optional<LineVertex> {
        return at(std::lerp(band.parameters[s], band.parameters[s + 1], t), band.spans[s]);
      };
      auto lines = clippedLines(trace, value, options.inside, between);
      std::move(lines.begin(), lines.end(), std::back_inserter(result));
    }
  };
  for (const Index span : fixedSpans) {
    for (Index i = 0; i < perSpan; ++i) {
      add(span, std::lerp(fixed[span], fixed[span + 1], static_cast<double>(i) / static_cast<double>(perSpan)));
    }
  }
  add(fixedSpans.back(), fixed.to());
  return result;
}

}  // namespace strak
