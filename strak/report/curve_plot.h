#pragma once
//
// Diagrams of curves: curvature over arc length, the way to the tolerance band, and the k-orthotomic.

#include <optional>
#include <string>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

struct CurvePlotOptions {
  int width = 900, height = 420;        // pixels
  double tolerance = 0;                 // of the band; 0: none is drawn
  std::optional<Eigen::Vector2d> pole;  // of the k-orthotomic; default: suggestedPole
  double factor = 2;                    // of the k-orthotomic
};

// Curvature over arc length, of `curve` or of both, `before` thin and grey: signed in the plane, the counted extrema as
// dots with their number. Where a few places are much more curved than the rest (an airfoil's nose) the scale is
// logarithmic away from zero; its marks tell. SVG. Throws InvalidInput for curves that are neither plane nor in space.
std::string curvaturePlotSvg(const Curve& curve, const Curve* before, const CurvePlotOptions& options = {});

// How far `curve` is from `before` at the same parameter (other domains: at the nearest point), along the left normal
// of `before` (in space: the distance), over arc length, with the band of the tolerance. Throws InvalidInput if their
// dimensions differ.
std::string tolerancePlotSvg(const Curve& curve, const Curve& before, const CurvePlotOptions& options = {});

// Measured points over arc length, a dot at its deviation (strak/metrology/point_deviation.h; not a number: none), with
// the band of the tolerance. `feet`: the curve's points that the deviations are measured from. Of the graph of a
// function: over its variable. Throws InvalidInput if no point has a deviation.
std::string deviationPlotSvg(const Curve& curve, const Eigen::Ref<const Net>& feet, const Eigen::VectorXd& deviations,
                             const CurvePlotOptions& options = {});

// The curve and its k-orthotomic with the cusps marked; plane curves only.
std::string orthotomicSvg(const Curve& curve, const CurvePlotOptions& options = {});

}  // namespace strak
