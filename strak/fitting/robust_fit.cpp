#include "strak/fitting/robust_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "strak/base/error.h"
#include "strak/spline/evaluator.h"

namespace strak {

namespace {

// Rounds in which scale and smoothing are found: by Huber's loss, which has one minimum, then by Tukey's from there,
// because what far points add to the errors would pass for noise.
constexpr int kHuberRounds = 4, kTukeyRounds = 4;
constexpr double kSettled = 1e-7;         // relative change of the objective that is none
constexpr double kFirstSmoothing = 0.3;   // of |error| in l1, in parts of the scale ...
constexpr double kLastSmoothing = 0.2;    // ... and of the gap
constexpr double kSmoothingFactor = 0.8;  // ... getting smaller every round

template <int D>
class Reweighting {
 public:
  Reweighting(const std::array<KnotVector, D>& knots, const FitPoints<D>& points, const RobustFitOptions<D>& options)
      : knots_(knots), points_(points), options_(options) {
    base_ = points.weights.size() != 0 ? Eigen::VectorXd(points.weights) : Eigen::VectorXd::Ones(points.count());
    // Points outside the domain are left out by every fit: they must not count here.
    for (Index r = 0; r < points.count(); ++r) {
      for (Index k = 0; k < D; ++k) {
        const KnotVector& u = knots[static_cast<std::size_t>(k)];
        if (!(points.parameters(r, k) >= u.from() && points.parameters(r, k) <= u.to())) base_[r] = 0;
      }
    }
    total_ = base_.sum();
    weights_ = options.first.size() > 0 ? options.first : Eigen::VectorXd::Ones(points.count());
  }

  RobustFit<D> run() {
    RobustFit<D> result;
    fit(options_.fit.smoothing, result);
    result.scale = scaleOf();
    if (!(result.scale > 0)) {  // most points are met exactly: nothing to reweight by
      result.converged = true;
      finish(result);
      return result;
    }
    for (int i = 0; i < kHuberRounds + kTukeyRounds && goOn(result); ++i) {
      reweight(i < kHuberRounds ? Loss::huber : Loss::tukey, result.scale, 0);
      fit(options_.fit.smoothing, result);
      result.scale = scaleOf();
      ++result.rounds;
    }
    double before = objective(result);
    double least = kFirstSmoothing * result.scale;
    while (result.rounds < options_.rounds && !result.converged && goOn(result)) {
      const Eigen::VectorXd errorsBefore = errors_;
      reweight(options_.loss, result.scale, least);
      // The fit's mean is over its own weights; lambda is meant against the mean over the points'.
      fit(Smoothing::fixed(result.lambda * total_ / effective()), result);
      ++result.rounds;
      const double now = objective(result);
      if (options_.loss == Loss::absolute) {
        result.gap = gapOf(result, errorsBefore, least);
        result.converged = result.gap <= options_.gap;
        least = std::max(kSmoothingFactor * least, kLastSmoothing * options_.gap * result.scale);
      } else {
        result.gap = std::abs(before - now) / std::max(now, std::numeric_limits<double>::min());
        result.converged = result.gap <= kSettled;
      }
      before = now;
    }
    finish(result);
    return result;
  }

 private:
  bool goOn(RobustFit<D>& result) {
    const bool go = options_.fit.progress.report(static_cast<double>(result.rounds) / options_.rounds, "reweighting");
    if (!go) result.fit.summary.stopped = true;
    return go;
  }

  double effective() const { return base_.dot(weights_); }

  void reweight(Loss loss, double scale, double least) {
    for (Index r = 0; r < weights_.size(); ++r) weights_[r] = lossWeight(loss, errors_[r], scale, least);
  }

  void fit(const Smoothing& smoothing, RobustFit<D>& result) {
    const Eigen::VectorXd weights = base_.cwiseProduct(weights_);
    FitOptions<D> options = options_.fit;
    options.smoothing = smoothing;
    const bool stopped = result.fit.summary.stopped;
    result.fit = fitLeastSquares<D>(knots_, FitPoints<D>{points_.parameters, points_.values, weights}, options);
    result.fit.summary.stopped = stopped;
    result.lambda = result.fit.summary.lambda * effective() / total_;
    errors_ = (Evaluator<D>(result.fit.spline).derivativesAt(points_.parameters, 0) - points_.values).rowwise().norm();
  }

  double scaleOf() const {
    if (options_.scale > 0) return options_.scale;
    std::vector<double> used;
    for (Index r = 0; r < errors_.size(); ++r) {
      if (base_[r] > 0) used.push_back(errors_[r]);
    }
    return robustScale(Eigen::Map<const Eigen::VectorXd>(used.data(), static_cast<Index>(used.size())));
  }

  double energyTerm(const RobustFit<D>& result) const { return result.lambda * result.fit.summary.energy; }

  double objective(RobustFit<D>& result) const {
    double sum = 0;
    for (Index r = 0; r < errors_.size(); ++r) sum += base_[r] * lossOf(options_.loss, errors_[r], result.scale);
    result.objective = sum / total_ + energyTerm(result);
    return result.objective;
  }

  // The fit is stationary for its weights, so y = error / (the old error, smoothed) solves the dual problem but for its
  // length; divided by the longest it is feasible, and its value a lower bound.
  double gapOf(const RobustFit<D>& result, const Eigen::VectorXd& before, double least) const {
    double longest = 1, sum = 0;
    for (Index r = 0; r < errors_.size(); ++r) {
      if (!(base_[r] > 0)) continue;
      const double length = errors_[r] / std::hypot(before[r], least);
      longest = std::max(longest, length);
      sum += base_[r] * length * errors_[r];
    }
    const double energy = energyTerm(result), t = 1 / longest;
    const double bound = t * (2 * result.scale * sum / total_ + 2 * energy) - t * t * energy;
    return std::max(result.objective - bound, 0.0) / std::max(result.objective, std::numeric_limits<double>::min());
  }

  void finish(RobustFit<D>& result) const {
    double squares = 0;
    FitSummary& summary = result.fit.summary;
    summary.max = 0;
    for (Index r = 0; r < errors_.size(); ++r) {
      // The last least squares may have given outliers no weight.
      if (base_[r] > 0 && errors_[r] > summary.max) {
        summary.max = errors_[r];
        summary.worstPoint = r;
        summary.worstPlace.assign(points_.parameters.row(r).begin(), points_.parameters.row(r).end());
      }
      squares += base_[r] * errors_[r] * errors_[r];
      if (base_[r] > 0 && errors_[r] > kOutlier * result.scale) ++result.outliers;
    }
    summary.rms = std::sqrt(squares / total_);
    summary.lambda = result.lambda;
    result.weights = weights_;
    if (!result.converged) {
      summary.warnings.push_back(
          fmt::format("the reweighting ended after {} rounds with a gap of {:.2g}", result.rounds, result.gap));
    }
  }

  const std::array<KnotVector, D>& knots_;
  const FitPoints<D>& points_;
  const RobustFitOptions<D>& options_;
  Eigen::VectorXd base_, weights_, errors_;
  double total_ = 0;
};

}  // namespace

template <int D>
RobustFit<D> fitRobustly(const std::array<KnotVector, D>& knots, const FitPoints<D>& points,
                         const RobustFitOptions<D>& options) {
  if (!(options.scale >= 0) || !std::isfinite(options.scale)) {
    throw InvalidInput(
        fmt::format("the scale of the noise ({}) must be a finite number that is not negative", options.scale));
  }
  if (points.parameters.cols() != D || points.values.rows() != points.count()) {
    throw InvalidInput("a robust fit needs a row of parameters and of values for each point");
  }
  if (options.first.size() > 0 && options.first.size() != points.count()) {
    throw InvalidInput(fmt::format("a robust fit of {} points has {} weights to begin with: give one a point or none",
                                   points.count(), options.first.size()));
  }
  return Reweighting<D>(knots, points, options).run();
}

template RobustFit<1> fitRobustly<1>(const std::array<KnotVector, 1>&, const FitPoints<1>&, const RobustFitOptions<1>&);
template RobustFit<2> fitRobustly<2>(const std::array<KnotVector, 2>&, const FitPoints<2>&, const RobustFitOptions<2>&);

}  // namespace strak
