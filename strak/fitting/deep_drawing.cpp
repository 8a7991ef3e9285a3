#include "strak/fitting/deep_drawing.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "strak/base/error.h"
#include "strak/fitting/drawing_weights.h"
#include "strak/fitting/parametrization.h"
#include "strak/metrology/closest_points.h"
#include "strak/spline/evaluator.h"

namespace strak {

namespace {

constexpr double kFirstWeight = 1e-2;    // a plane, nearly
constexpr double kDoubtful = 0.1;        // SheetCheck::doubt; with more the other planes are tried
constexpr double kWide = 0.1;            // errors, in parts of the cloud's width, that make the plane doubtful, too
constexpr double kClearlyNearer = 0.5;   // ... and taken if the errors fall to this part
constexpr Index kTrialPoints = 5000;     // ... of so many points first
constexpr double kFactor = 0.25;         // of the weight, from step to step
constexpr double kLeastReduction = 0.7;  // a factor nearer to 1 is not tried before a fold
constexpr double kFewFolds = 0.05;       // of the cells: their control points are held, and the rest is drawn on ...
constexpr int kHoldingRounds = 6;        // ... after so many fits a step at most
constexpr double kLeastWeight = 1e-12;   // nothing is smoothed by less
constexpr double kGrowth = 0.05;         // of the domain's length, per step and edge
constexpr double kBetter = 0.99;         // cross validation's errors that are worth another step, ...
constexpr int kPatience = 3;             // ... within so many steps

std::array<KnotVector, 2> knotsOver(const Net& parameters, const DeepDrawingOptions& options) {
  std::array<KnotVector, 2> knots;
  for (std::size_t k = 0; k < 2; ++k) {
    const auto column = parameters.col(static_cast<Index>(k));
    const double from = column.minCoeff(), to = column.maxCoeff();
    if (!(from < to)) throw InvalidInput("all points have the same parameter in a direction: a surface needs extent");
    knots[k] = KnotVector::uniformClamped(options.degree[k], options.size[k] - options.degree[k], from, to);
  }
  return knots;
}

// The standard deviation of the parameters in the direction in which they are closer together.
double width(const Net& parameters) {
  const Net centred = parameters.rowwise() - parameters.colwise().mean();
  return std::sqrt(centred.colwise().squaredNorm().minCoeff() / static_cast<double>(parameters.rows()));
}

double area(const Net& parameters) {
  return (parameters.colwise().maxCoeff() - parameters.colwise().minCoeff()).prod();
}

struct Corrected {
  Net parameters;
  Eigen::VectorXd distances;  // beyond an edge from the tangent plane there, for the domain is to grow
};

// Some points of all, by which a plane is judged.
struct ThinnedCloud {
  Net parameters, values;
  Eigen::VectorXd weights;
  FitPoints<2> points() const { return {parameters, values, weights}; }
};

ThinnedCloud thinned(const Net& parameters, const Net& values, const Eigen::VectorXd& weights) {
  const Index step = (values.rows() + kTrialPoints - 1) / kTrialPoints, count = (values.rows() + step - 1) / step;
  const auto every = Eigen::seqN(0, count, step);
  ThinnedCloud some{parameters(every, Eigen::all), values(every, Eigen::all), {}};
  if (weights.size() > 0) some.weights = weights(every);
  return some;
}

// The parameters of the closest points. Where those lie on an edge, a step along the tangent plane leads beyond it.
Corrected corrected(const Surface& surface, const Net& values, const Net& starts) {
  auto closest = closestPointsFrom<2>(surface, values, starts);
  Net& parameters = closest.parameters;
  std::vector<Index> atEdge;
  for (Index r = 0; r < parameters.rows(); ++r) {
    bool edge = false;
    for (Index k = 0; k < 2; ++k) {
      const KnotVector& knots = surface.knots()[static_cast<std::size_t>(k)];
      edge = edge || parameters(r, k) <= knots.from() || parameters(r, k) >= knots.to();
    }
    if (edge) atEdge.push_back(r);
  }
  Net places(static_cast<Index>(atEdge.size()), 2);
  for (std::size_t i = 0; i < atEdge.size(); ++i) places.row(static_cast<Index>(i)) = parameters.row(atEdge[i]);
  const Net d = Evaluator<2>(surface).derivativesAt(places, 1);
  for (std::size_t i = 0; i < atEdge.size(); ++i) {
    const auto row = d.row(static_cast<Index>(i));
    const Eigen::RowVector3d error = values.row(atEdge[i]) - row.head<3>();
    Eigen::RowVector3d beside = error;
    for (Index k = 0; k < 2; ++k) {
      const auto along = row.segment<3>(3 + 3 * k);
      const KnotVector& knots = surface.knots()[static_cast<std::size_t>(k)];
      const double squares = along.squaredNorm(), most = kGrowth * knots.length();
      const double step = squares > 0 ? error.dot(along) / squares : 0;
      double& place = parameters(atEdge[i], k);
      if ((place <= knots.from() && step < 0) || (place >= knots.to() && step > 0)) {
        place += std::clamp(step, -most, most);
        beside -= step * along;
      }
    }
    closest.distances[atEdge[i]] = beside.norm();
  }
  return {std::move(parameters), std::move(closest.distances)};
}

// A few folds have a place; many are the sheet's.
bool mayBeHeld(const SheetCheck& check) {
  return check.folded > 0 && static_cast<double>(check.folded) <= kFewFolds * static_cast<double>(check.cells);
}

// Holds the control points that form these knot cells where they are on the surface.
void hold(const std::vector<std::array<Index, 2>>& cells, const Surface& surface, FitOptions<2>& fitting) {
  if (fitting.heldNet.rows() == 0) fitting.heldNet = surface.net();
  std::vector<bool> held(static_cast<std::size_t>(surface.net().rows()), false);
  for (const Index row : fitting.held) held[static_cast<std::size_t>(row)] = true;
  for (const auto& cell : cells) {
    for (Index i = 0; i <= surface.degree(0); ++i) {
      for (Index j = 0; j <= surface.degree(1); ++j) {
        const Index row = surface.row({cell[0] + i, cell[1] + j});
        if (held[static_cast<std::size_t>(row)]) continue;
        held[static_cast<std::size_t>(row)] = true;
        fitting.held.push_back(row);
        fitting.heldNet.row(row) = surface.net().row(row);
      }
    }
  }
}

}  // namespace

DrawnSheet drawSheet(const FitPoints<2>& points, const DeepDrawingOptions& options) {
  if (points.values.cols() != 3) throw InvalidInput("a sheet needs points with three coordinates");
  for (std::size_t k = 0; k < 2; ++k) {
    if (options.degree[k] < 1 || options.size[k] <= options.degree[k]) {
      throw InvalidInput("a sheet needs degrees of at least 1 and more control points than the degree");
    }
  }
  if (points.count() == 0) throw InvalidInput("there are no points to fit");
  FitOptions<2> fitting;
  if (std::min(options.degree[0], options.degree[1]) > 1) fitting.energy = thinPlate<2>();
  DrawnSheet result;
  Eigen::VectorXd weights = points.weights;
  const auto on = [&](const Net& parameters) { return FitPoints<2>{parameters, points.values, weights}; };
  const auto fitOf = [&](const Net& parameters, double weight) {
    fitting.smoothing = Smoothing::fixed(weight);
    return fitLeastSquares<2>(knotsOver(parameters, options), on(parameters), fitting);
  };
  Net parameters = points.parameters;
  const double planeArea = area(parameters);
  double weight = kFirstWeight, factor = kFactor;
  Fit<2> current = fitOf(parameters, weight);
  result.fit = current;
  result.parameters = parameters;
  result.weights = weights;
  result.rms.push_back(current.summary.rms);
  double best = current.summary.crossValidation;
  int idle = 0;
  bool holding = false;
  for (int step = 1; step < options.steps && weight > kLeastWeight; ++step) {
    if (idle >= kPatience) {
      if (!result.folded || holding) break;
      // Where it would fold the sheet stays as it is; the rest is drawn on.
      holding = true;
      factor = kFactor;
      idle = 0;
    }
    if (!options.progress.report(static_cast<double>(step) / options.steps, "drawing the sheet")) {
      result.fit.summary.stopped = true;
      break;
    }
    Corrected next = corrected(current.spline, points.values, parameters);
    if (options.robust) weights = drawingWeights(points.weights, next.distances, next.parameters);
    const Net& moved = next.parameters;
    const auto heldBefore = fitting.held;
    Fit<2> tried = fitOf(moved, weight * factor);
    SheetCheck check = checkSheet(tried.spline, on(moved), 0);
    for (int round = 0; holding && round < kHoldingRounds && mayBeHeld(check); ++round) {
      hold(check.foldedCells, current.spline, fitting);
      tried = fitOf(moved, weight * factor);
      check = checkSheet(tried.spline, on(moved), 0);
    }
    if (check.folded > 0) {
      fitting.held = heldBefore;
      if (factor == 1) {
        idle = kPatience;
        continue;
      }
      // Smaller steps, and in the end none: the parameters still settle at this weight.
      factor = std::sqrt(factor);
      if (factor > kLeastReduction) {
        factor = 1;
        result.folded = true;
      }
      continue;
    }
    weight *= factor;
    current = std::move(tried);
    parameters = std::move(next.parameters);
    result.rms.push_back(current.summary.rms);
    const double now = current.summary.crossValidation;
    ++idle;
    if (now < kBetter * best) {
      idle = 0;
      best = now;
      result.fit = current;
      result.parameters = parameters;
      result.weights = weights;
      result.held = fitting.held;
    }
  }
  result.stretch = area(result.parameters) / planeArea;
  result.check = checkSheet(result.fit.spline, {result.parameters, points.values, result.weights});
  return result;
}

namespace {

// Mean of the distances, which a few far points do not dominate.
double meanDistance(const DrawnSheet& sheet, const FitPoints<2>& points) {
  const auto closest = closestPointsFrom<2>(sheet.fit.spline, points.values, sheet.parameters);
  if (points.weights.size() == 0) return closest.distances.mean();
  return closest.distances.dot(points.weights) / points.weights.sum();
}

// With outliers a plain sheet is bent; without, Huber's weights may give up what the sheet has not reached yet. So both
// are drawn.
DrawnSheet drawWishedSheet(const FitPoints<2>& points, DeepDrawingOptions options) {
  const bool robust = std::exchange(options.robust, false);
  DrawnSheet plain = drawSheet(points, options);
  if (!robust || plain.fit.summary.stopped) return plain;
  options.robust = true;
  DrawnSheet sheet = drawSheet(points, options);
  return meanDistance(sheet, points) < meanDistance(plain, points) ? sheet : plain;
}

}  // namespace

DrawnCloud drawCloud(const Net& points, const Eigen::VectorXd& weights, const DeepDrawingOptions& options) {
  DrawnCloud best;
  double nearest = 0;  // mean distance of the best
  const auto isWorse = [&](const DrawnSheet& sheet, double distance) {
    return distance > kClearlyNearer * nearest ||
           (sheet.check.doubt() > kNotOneSheet && best.sheet.check.doubt() <= kNotOneSheet);
  };
  for (int plane = 0; plane < 3; ++plane) {
    DrawnSheet sheet;
    try {
      const Net parameters = planeParameters(points, plane);
      if (plane > 0 && points.rows() > kTrialPoints) {
        const ThinnedCloud some = thinned(parameters, points, weights);
        const DrawnSheet trial = drawWishedSheet(some.points(), options);
        if (trial.fit.summary.stopped || isWorse(trial, meanDistance(trial, some.points()))) continue;
      }
      sheet = drawWishedSheet({parameters, points, weights}, options);
    } catch (const InvalidInput&) {
      // From the side a cloud may be too thin.
      if (plane == 0) throw;
      continue;
    }
    const double distance = meanDistance(sheet, {sheet.parameters, points, weights});
    if (plane > 0 && isWorse(sheet, distance)) continue;
    nearest = distance;
    best = {std::move(sheet), plane};
    const SheetCheck& check = best.sheet.check;
    const bool near = check.thickness <= kThick && best.sheet.fit.summary.rms < kWide * width(best.sheet.parameters);
    if (best.sheet.fit.summary.stopped || (near && check.doubt() <= kDoubtful && !best.sheet.folded)) break;
  }
  return best;
}

}  // namespace strak
