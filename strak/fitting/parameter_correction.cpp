#include "strak/fitting/parameter_correction.h"

#include "strak/base/error.h"
#include "strak/metrology/closest_points.h"

namespace strak {

template <int D>
CorrectedFit<D> fitWithCorrection(const FitPoints<D>& points, const FitMaker<D>& make,
                                  const CorrectionOptions& options) {
  if (points.values.cols() < 2) {
    throw InvalidInput("the points of a function have their parameters: there is nothing to correct");
  }
  CorrectedFit<D> result;
  result.parameters = points.parameters;
  const auto fitOf = [&](const Net& parameters, const Fit<D>* previous) {
    return make({parameters, points.values, points.weights}, previous);
  };
  result.fit = fitOf(result.parameters, nullptr);
  result.rms.push_back(result.fit.summary.rms);
  while (result.rounds < options.rounds && !result.settled) {
    if (!options.progress.report(static_cast<double>(result.rounds) / options.rounds, "correcting the parameters")) {
      result.fit.summary.stopped = true;
      break;
    }
    Net parameters = closestPointsFrom<D>(result.fit.spline, points.values, result.parameters).parameters;
    Fit<D> next = fitOf(parameters, &result.fit);
    const double before = result.rms.back(), now = next.summary.rms;
    if (!(now < before)) {
      result.settled = true;
      break;
    }
    result.settled = now > (1 - options.settled) * before;
    result.fit = std::move(next);
    result.parameters = std::move(parameters);
    result.rms.push_back(now);
    ++result.rounds;
  }
  return result;
}

template CorrectedFit<1> fitWithCorrection<1>(const FitPoints<1>&, const FitMaker<1>&, const CorrectionOptions&);
template CorrectedFit<2> fitWithCorrection<2>(const FitPoints<2>&, const FitMaker<2>&, const CorrectionOptions&);

}  // namespace strak
