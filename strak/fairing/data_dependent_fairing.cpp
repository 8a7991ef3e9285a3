#include "strak/fairing/data_dependent_fairing.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "strak/base/error.h"
#include "strak/energy/beltrami_energy.h"
#include "strak/fairing/shape_problem.h"
#include "strak/solve/hull_minimizer.h"

namespace strak {

namespace {

constexpr double kSettled = 3e-3;  // of int 4 H^2: a step that changes less is the last one
constexpr double kFast = 0.1;      // ... and below this the balls may be refined
constexpr double kShares[] = {1, 0.4, 0.16};
constexpr double kShorter[] = {0.5, 0.25};  // the first step, where the guard refuses the whole
constexpr double kInnerAccuracy = 1e-5;     // of the energy
constexpr double kAnchor = 1e-10;           // of the diagonal: what holds the points that an energy leaves free

class Iteration {
 public:
  Iteration(ShapePatch patch, const DataDependentFairingOptions& options)
      : patches_{std::move(patch)},
        options_(options),
        problem_(patches_, {}, options.tolerance, options.ballsOnPoints),
        factor_(problem_.pattern(), problem_.places()) {}

  DataDependentFairing run();

 private:
  // A surface on the way: its displacements, and the energy in its geometry.
  struct Place {
    Eigen::VectorXd e;
    Net points;
    BeltramiEnergy energy;
    double value;  // int 4 H^2
  };
  Place placeAt(const Eigen::VectorXd& e) const;
  Eigen::VectorXd least(BlockMatrix& matrix, const Eigen::VectorXd& gradient, const Eigen::VectorXd& e);
  Eigen::VectorXd leastIn(const Place& place);
  Place firstReference(Place input);
  bool step(Place& place, double reached);
  StopReason iterate();
  bool jumpsHold(const Eigen::VectorXd& e) const;

  const std::vector<ShapePatch> patches_;  // the one that the problem refers to
  const DataDependentFairingOptions& options_;
  ShapeProblem problem_;
  NestedCholesky factor_;
  std::vector<Eigen::VectorXd> way_;  // the input and the surfaces after every step
};

Iteration::Place Iteration::placeAt(const Eigen::VectorXd& e) const {
  const Surface surface = problem_.surface(0, e);
  Place place{e, surface.euclideanNet(), BeltramiEnergy(surface, patches_[0].unknownOf), 0};
  place.value = place.energy.value(place.points);
  return place;
}

// The least of the quadratic function with this matrix, and this gradient at e, inside the tolerance; e if it cannot be
// found.
Eigen::VectorXd Iteration::least(BlockMatrix& matrix, const Eigen::VectorXd& gradient, const Eigen::VectorXd& e) {
  const Eigen::VectorXd diagonal = matrix.pointDiagonal();
  if (!diagonal.allFinite() || !(diagonal.minCoeff() > 0)) return e;
  matrix.addDiagonal(kAnchor * diagonal);
  Eigen::VectorXd x = e;
  const Eigen::VectorXd linear = gradient - matrix.times(e);
  minimizeInHull({&matrix, linear, &problem_.rows()}, factor_, x, {.accuracy = kInnerAccuracy});
  return problem_.shrunk(x);
}

Eigen::VectorXd Iteration::leastIn(const Place& place) {
  BlockMatrix matrix(problem_.pattern());
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(place.e.size());
  place.energy.addTo(place.points, 1 / place.value, matrix, gradient);
  return least(matrix, gradient, place.e);
}

// In the geometry of a noisy surface nothing tells that its parameter lines jitter: of the input itself the result
// would inherit that, and where the knots cannot follow, waves across the surface.
Iteration::Place Iteration::firstReference(Place input) {
  if (!options_.evenStart) return input;
  problem_.setMetrics(input.e, 1, 1);
  BlockMatrix matrix(problem_.pattern());
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(input.e.size());
  problem_.addMetric(matrix, gradient);
  Place even = placeAt(least(matrix, gradient, input.e));
  return even.value < input.value ? std::move(even) : std::move(input);
}

// Goes on from the place to the least energy in its geometry, where int 4 H^2 is less than `reached`, or as good as the
// same. The quadratic problem does not see how the geometry changes, so the whole way may be too far. False if nothing
// is gained.
bool Iteration::step(Place& place, double reached) {
  if (!(place.value > 0) || !std::isfinite(1 / place.value)) return false;
  const Eigen::VectorXd way = leastIn(place) - place.e;
  for (double share : kShares) {
    Place tried = placeAt(place.e + share * way);
    if (!(tried.value <= (share == 1 ? 1 + kSettled : 1 - kSettled) * reached)) continue;
    place = std::move(tried);
    return true;
  }
  return false;
}

StopReason Iteration::iterate() {
  if (problem_.unknowns() == 0 || problem_.isFlat()) return StopReason::nothingFree;
  Place place = placeAt(way_.front());
  double reached = place.value;
  place = firstReference(std::move(place));
  while (static_cast<int>(way_.size()) <= options_.maxSteps) {
    const double done = static_cast<double>(way_.size() - 1) / static_cast<double>(options_.maxSteps);
    if (!options_.progress.report(done, "fairing")) return StopReason::cancelled;
    double fall = 0;
    if (step(place, reached)) {
      way_.push_back(place.e);
      fall = 1 - place.value / reached;
      reached = place.value;
    }
    // What still moves when the energy stands still slides along the surface, for hundreds of steps.
    if (fall > kFast || problem_.refineRows(place.e) || fall > kSettled) continue;
    return StopReason::gain;
  }
  return StopReason::steps;
}

// The roughness of the curvature's jumps at knot lines, all together: the energy does not see them, so that single
// lines of a surface of degree 2 nearly always lose where the others gain.
bool Iteration::jumpsHold(const Eigen::VectorXd& e) const {
  const auto sum = [this](const Eigen::VectorXd& at) {
    double roughness = 0;
    for (const JoinFigures& line : problem_.figuresAt(at).joins) roughness += line.ofJump;
    return roughness;
  };
  return sum(e) <= sum(way_.front());
}

DataDependentFairing Iteration::run() {
  const auto begin = std::chrono::steady_clock::now();
  const Surface& input = patches_[0].surface;
  DataDependentFairing result{input, problem_.before(0), problem_.before(0), {}};
  FairingSummary& summary = result.summary;
  way_.emplace_back(Eigen::VectorXd::Zero(3 * problem_.unknowns()));
  summary.stopReason = iterate();
  summary.steps = static_cast<Index>(way_.size()) - 1;
  if (summary.stopReason != StopReason::nothingFree) summary.energyBefore = placeAt(way_.front()).value;
  std::vector<SurfaceFairness> before, after;
  const auto holds = [&](const Eigen::VectorXd& e) {
    summary.energyAfter = placeAt(e).value;
    return summary.energyAfter <= summary.energyBefore && jumpsHold(e) &&
           problem_.worseFigures(e, before, after).empty();
  };
  while (way_.size() > 1 && !holds(way_.back())) {
    const Eigen::VectorXd first = way_.back();
    way_.pop_back();
    ++result.takenBack;
    if (way_.size() > 1) continue;
    const auto kept =
        std::find_if(std::begin(kShorter), std::end(kShorter), [&](double t) { return holds(t * first); });
    if (kept != std::end(kShorter)) way_.emplace_back(*kept * first);
    break;
  }
  if (way_.size() > 1) {
    result.before = before.front();
    result.after = after.front();
  } else {
    summary.energyAfter = summary.energyBefore;
  }
  const Eigen::VectorXd& e = way_.back();
  result.spline = problem_.surface(0, e);
  summary.gap = std::numeric_limits<double>::quiet_NaN();
  summary.freePoints = problem_.unknowns();
  const Eigen::VectorXd reached = problem_.rows().times(e);
  for (Index i = 0; i < problem_.rows().count(); ++i) {
    summary.activePoints += reached.segment<3>(3 * i).norm() > 0.998 * options_.tolerance;
  }
  summary.largestMove = (result.spline.euclideanNet() - input.euclideanNet()).rowwise().norm().maxCoeff();
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

}  // namespace

DataDependentFairing fairDataDependently(const Surface& input, const HeldPoints& held,
                                         const DataDependentFairingOptions& options) {
  if (!(options.tolerance >= 0)) throw InvalidInput("the tolerance must not be negative: give a length");
  if (!held.empty() && static_cast<Index>(held.size()) != input.net().rows()) {
    throw InvalidInput("the list of held points must have one entry a control point");
  }
  ShapePatch patch = patchOf(input, options.tolerance > 0 ? held : HeldPoints(input.net().rows(), 1));
  if (!(options.tolerance < kUnlimited) &&
      std::find(patch.unknownOf.begin(), patch.unknownOf.end(), -1) == patch.unknownOf.end()) {
    throw InvalidInput(
        "without a tolerance the fairest surface is a plane: give a tolerance, or hold rows at its borders");
  }
  return Iteration(std::move(patch), options).run();
}

}  // namespace strak
