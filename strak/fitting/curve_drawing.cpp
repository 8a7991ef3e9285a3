#include "strak/fitting/curve_drawing.h"

#include <algorithm>
#include <cmath>

#include "strak/fitting/drawing_weights.h"
#include "strak/metrology/arc_length.h"
#include "strak/metrology/closest_points.h"
#include "strak/spline/evaluator.h"

namespace strak {

namespace {

constexpr Index kFewPoints = 16;       // too few to tell noise from shape
constexpr double kSmallNoise = 0.2;    // errors below this part of the steps leave the lengths as they are
constexpr double kFirstWeight = 1e-5;  // some six degrees of freedom: a loop stays a loop
constexpr double kFactor = 0.25;       // of the weight, from step to step
constexpr int kSteps = 14;             // at most: nothing is smoothed by less than 1e-13
constexpr double kBetter = 0.97;       // cross validation's errors that are worth another step, ...
constexpr double kGrowth = 0.05;       // of the domain's length, per step and end
constexpr int kPatience = 3;           // ... within so many steps
constexpr double kAsGood = 1.02;       // cross validation's errors that noise may make

double middleStep(const Net& points) {
  std::vector<double> steps;
  for (Index r = 1; r < points.rows(); ++r) steps.push_back((points.row(r) - points.row(r - 1)).norm());
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

KnotVector knotsOver(const Net& parameters, const CurveDrawingOptions& options) {
  return KnotVector::uniformClamped(options.degree, options.size - options.degree, parameters.minCoeff(),
                                    parameters.maxCoeff());
}

struct Corrected {
  Net parameters;
  Eigen::VectorXd distances;  // beyond an end from the tangent there
};

// The parameters of the closest points. Those of an end go on along its tangent, so that the curve can grow.
Corrected corrected(const Curve& curve, const Net& values, const Net& starts) {
  auto closest = closestPointsFrom<1>(curve, values, starts);
  Net& parameters = closest.parameters;
  const KnotVector& knots = curve.knots()[0];
  const Index columns = values.cols();
  for (const double end : {knots.from(), knots.to()}) {
    const Net d = Evaluator<1>(curve).derivativesAt(Net::Constant(1, 1, end), 1);
    const auto along = d.row(0).segment(columns, columns);
    if (!(along.squaredNorm() > 0)) continue;
    for (Index r = 0; r < parameters.rows(); ++r) {
      if (parameters(r, 0) != end) continue;
      const Eigen::RowVectorXd error = values.row(r) - d.row(0).head(columns);
      const double step = error.dot(along) / along.squaredNorm();
      if (end == knots.from() ? step >= 0 : step <= 0) continue;
      const double most = kGrowth * knots.length();
      parameters(r, 0) += std::clamp(step, -most, most);
      closest.distances[r] = (error - step * along).norm();
    }
  }
  return {std::move(parameters), std::move(closest.distances)};
}

}  // namespace

DrawnCurve drawCurve(const FitPoints<1>& points, const CurveDrawingOptions& options) {
  DrawnCurve result;
  result.parameters = points.parameters;
  if (points.count() < kFewPoints) return result;
  Eigen::VectorXd weights = points.weights;
  const auto fitOf = [&](const Net& parameters, const Smoothing& smoothing) {
    FitOptions<1> fitting;
    if (options.degree > 1) fitting.energy = thinPlate<1>();
    fitting.smoothing = smoothing;
    return fitLeastSquares<1>({knotsOver(parameters, options)}, {parameters, points.values, weights}, fitting);
  };
  const auto next = [&](const Fit<1>& fit, const Net& parameters) {
    Corrected at = corrected(fit.spline, points.values, parameters);
    if (options.robust) weights = drawingWeights(points.weights, at.distances, at.parameters);
    return std::move(at.parameters);
  };
  const Fit<1> plain = fitOf(points.parameters, Smoothing::automatic());
  if (plain.summary.rms < kSmallNoise * middleStep(points.values)) return result;

  Net parameters = points.parameters, drawn;
  double weight = kFirstWeight, best = 0;
  for (int step = 0, idle = 0; step < kSteps && idle < kPatience; ++step, weight *= kFactor) {
    if (!options.progress.report(static_cast<double>(step) / kSteps, "drawing the curve")) return result;
    const Fit<1> fit = fitOf(parameters, Smoothing::fixed(weight));
    parameters = next(fit, parameters);
    if (result.rms.empty()) parameters = arcLengths(fit.spline, parameters.col(0));
    ++idle;
    if (result.rms.empty() || fit.summary.crossValidation < kBetter * best) {
      idle = 0;
      best = fit.summary.crossValidation;
      drawn = parameters;
    }
    result.rms.push_back(fit.summary.rms);
  }
  // With the weights of the last step; without the errors along the curve, which corrected parameters do not have.
  const Net lengths = corrected(plain.spline, points.values, points.parameters).parameters;
  const FitSummary given = fitOf(lengths, Smoothing::automatic()).summary,
                   now = fitOf(drawn, Smoothing::automatic()).summary;
  result.drawn = now.crossValidation <= (now.freedom < given.freedom ? kAsGood : 1 / kAsGood) * given.crossValidation;
  if (result.drawn) result.parameters = std::move(drawn);
  return result;
}

}  // namespace strak
