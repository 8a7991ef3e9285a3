#include "strak/fitting/through_points.h"

#include <fmt/format.h>

#include "strak/base/error.h"
#include "strak/metrology/closest_points.h"

namespace strak {

template <int D>
ThroughFit<D> fitThrough(const Fit<D>& fit, const Net& points, const ConditionalFitMaker<D>& make,
                         const ThroughOptions& options) {
  if (fit.spline.pointDimension() < 2 || points.cols() != fit.spline.pointDimension()) {
    throw InvalidInput("only curves and surfaces in space pass through points without parameters: give the parameters");
  }
  const Net net = fit.spline.euclideanNet();
  const double size = (net.colwise().maxCoeff() - net.colwise().minCoeff()).norm();
  ThroughFit<D> result;
  ClosestPoints<D> feet = closestPoints<D>(fit.spline, points);
  result.distances = feet.distances;
  Index worst = 0;
  if (result.distances.maxCoeff(&worst) > options.farthest * size) {
    throw InvalidInput(fmt::format(
        "condition {} lies {:.4g} away from the fit made without it, which is {:.4g} large: a fit that goes "
        "there would have another shape; correct or remove it, or give its parameters",
        worst + 1, result.distances[worst], size));
  }
  result.fit = fit;
  result.parameters = std::move(feet.parameters);
  while (result.rounds < options.rounds) {
    result.fit = make(result.parameters, result.fit);
    ++result.rounds;
    feet = closestPointsFrom<D>(result.fit.spline, points, result.parameters);
    result.largest = feet.distances.maxCoeff();
    if (result.largest <= options.within * size) return result;
    result.parameters = std::move(feet.parameters);
  }
  throw Failure(
      fmt::format("the conditions are missed by up to {:.4g} after {} rounds: remove some of them, or use more "
                  "control points",
                  result.largest, result.rounds));
}

template ThroughFit<1> fitThrough<1>(const Fit<1>&, const Net&, const ConditionalFitMaker<1>&, const ThroughOptions&);
template ThroughFit<2> fitThrough<2>(const Fit<2>&, const Net&, const ConditionalFitMaker<2>&, const ThroughOptions&);

}  // namespace strak
