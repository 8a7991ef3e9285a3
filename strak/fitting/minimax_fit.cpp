#include "strak/fitting/minimax_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "strak/base/error.h"
#include "strak/spline/evaluator.h"

namespace strak {

namespace {

// Weights below this part of the largest are kept from vanishing: a point may come to matter again.
constexpr double kLeastWeight = 1e-12;

}  // namespace

template <int D>
MinimaxFit<D> fitMinimax(const std::array<KnotVector, D>& knots, const FitPoints<D>& points,
                         const MinimaxFitOptions<D>& options) {
  if (points.parameters.cols() != D || points.values.rows() != points.count()) {
    throw InvalidInput("a fit needs a row of parameters and of values for each point");
  }
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(points.count());
  for (Index r = 0; r < points.count(); ++r) {
    bool counts = points.weights.size() == 0 || points.weights[r] > 0;
    for (Index k = 0; k < D; ++k) {
      const KnotVector& u = knots[static_cast<std::size_t>(k)];
      counts = counts && points.parameters(r, k) >= u.from() && points.parameters(r, k) <= u.to();
    }
    weights[r] = counts ? 1 : 0;
  }
  MinimaxFit<D> result;
  FitOptions<D> fitOptions = options.fit;
  double best = std::numeric_limits<double>::infinity();
  while (result.rounds < options.rounds && !result.converged) {
    if (!options.fit.progress.report(static_cast<double>(result.rounds) / options.rounds, "evening out the errors")) {
      result.fit.summary.stopped = true;
      break;
    }
    Fit<D> fit = fitLeastSquares<D>(knots, FitPoints<D>{points.parameters, points.values, weights}, fitOptions);
    ++result.rounds;
    fitOptions.smoothing = Smoothing::fixed(fit.summary.lambda);
    const Eigen::VectorXd errors =
        (Evaluator<D>(fit.spline).derivativesAt(points.parameters, 0) - points.values).rowwise().norm();
    const double energy = fit.summary.lambda * fit.summary.energy;
    double largest = 0;
    for (Index r = 0; r < errors.size(); ++r) largest = std::max(largest, weights[r] > 0 ? errors[r] : 0);
    const double value = largest * largest + energy;
    result.bound = std::max(result.bound, fit.summary.rms * fit.summary.rms + energy);
    if (value < best) {
      best = value;
      const bool stopped = result.fit.summary.stopped;
      result.fit = std::move(fit);
      result.fit.summary.stopped = stopped;
    }
    result.objective = best;
    result.gap = best > 0 ? std::max(best - result.bound, 0.0) / best : 0;
    result.converged = result.gap <= options.gap;
    double heaviest = 0;
    for (Index r = 0; r < errors.size(); ++r) {
      weights[r] *= errors[r];
      heaviest = std::max(heaviest, weights[r]);
    }
    if (!(heaviest > 0)) break;
    for (Index r = 0; r < errors.size(); ++r) {
      if (weights[r] > 0) weights[r] = std::max(weights[r] / heaviest, kLeastWeight);
    }
  }
  if (!result.converged) {
    result.fit.summary.warnings.push_back(fmt::format(
        "the evening out of the errors ended after {} rounds with a gap of {:.2g}", result.rounds, result.gap));
  }
  return result;
}

template MinimaxFit<1> fitMinimax<1>(const std::array<KnotVector, 1>&, const FitPoints<1>&,
                                     const MinimaxFitOptions<1>&);
template MinimaxFit<2> fitMinimax<2>(const std::array<KnotVector, 2>&, const FitPoints<2>&,
                                     const MinimaxFitOptions<2>&);

}  // namespace strak
