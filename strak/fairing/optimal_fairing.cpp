#include "strak/fairing/optimal_fairing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "strak/base/cpu_time.h"
#include "strak/base/error.h"
#include "strak/fairing/fairing_problem.h"
#include "strak/fairing/free_factor.h"

namespace strak {

namespace {

[[noreturn]] void refuseSingular(const std::string& name, int order) {
  throw InvalidInput(
      fmt::format("the held points leave motions free that the energy '{}' does not see: hold at least {} rows on two "
                  "opposite sides, or give a tolerance",
                  name, order));
}

// min q without tolerance where no lower bound P is known or P is singular: a sparse factor of K on the free points.
template <int D>
BallResult solveByFactor(const FairingProblem<D>& problem, const QuadraticEnergy<D>& energy, double wishedGap, Net& e) {
  constexpr Index kMaxRefinements = 4;
  std::vector<Index> free;
  for (std::size_t r = 0; r < problem.held().size(); ++r) {
    if (!problem.held()[r]) free.push_back(static_cast<Index>(r));
  }
  const FreeFactor factor(problem.energy(), free);
  if (!factor.usable()) refuseSingular(energy.name, energy.order());
  const Net halfGradient = problem.halfGradient();
  const Eigen::MatrixXd linear = halfGradient(free, Eigen::all);
  BallResult result;
  Eigen::MatrixXd residual = -linear;
  for (result.iterations = 1;; ++result.iterations) {
    const Eigen::MatrixXd step = factor.solve(residual);
    for (std::size_t i = 0; i < free.size(); ++i) e.row(free[i]) += step.row(static_cast<Index>(i));
    const Net image = problem.energy().product(e);
    residual = -linear - image(free, Eigen::all);
    result.bound = factor.inverseNorm(residual);
    result.value = e.cwiseProduct(image + 2 * halfGradient).sum();
    if (result.bound <= wishedGap * std::abs(problem.energyBefore() + result.value)) break;
    if (result.iterations == kMaxRefinements) {
      result.stop = BallResult::Stop::precision;
      break;
    }
  }
  return result;
}

// d0 + e, rounded so that the distance measured in floating point stays within the radius.
void addWithin(double radius, const Net& e, MutableNetRef net) {
  for (Index r = 0; r < net.rows(); ++r) {
    const Point start = net.row(r);
    double factor = 1;
    Point moved = start + e.row(r);
    for (int attempt = 0; attempt < 60 && (moved - start).norm() > radius; ++attempt) {
      factor -= std::ldexp(1.0, attempt - 52);
      moved = start + factor * e.row(r);
    }
    if ((moved - start).norm() <= radius) net.row(r) = moved;
  }
}

}  // namespace

template <int D>
Faired<D> fairOptimally(const Spline<D>& input, const QuadraticEnergy<D>& energy,
                        const OptimalFairingOptions& options) {
  const double begin = threadSeconds();
  if (!(options.tolerance >= 0)) {
    throw InvalidInput(fmt::format("the tolerance is {}: give a length of 0 or more", options.tolerance));
  }
  if (!(options.gap >= 0)) throw InvalidInput(fmt::format("the wished gap is {}: give 0 or more", options.gap));
  Faired<D> result{input, {}};
  FairingSummary& summary = result.summary;
  FairingProblem<D> problem(input, energy, options.held, options.scale);
  summary.energyBefore = summary.energyAfter = problem.energyBefore();
  summary.freePoints = problem.freePoints();
  if (summary.freePoints == 0 || options.tolerance == 0) {
    summary.stopReason = StopReason::nothingFree;
    summary.seconds = threadSeconds() - begin;
    return result;
  }

  Net e = Net::Zero(input.net().rows(), input.net().cols());
  BallResult ball;
  {
    const BallOptions ballOptions{options.gap, options.maxIterations, options.progress};
    Field solution(problem.layout());
    const BallProblem task = problem.ball(options.tolerance);
    ball = std::isinf(options.tolerance) ? minimizeFreely(task, ballOptions, solution)
                                         : minimizeInBalls(task, ballOptions, solution);
    addBox(problem.layout(), solution, e);
  }
  if (ball.stop == BallResult::Stop::unproven) ball = solveByFactor(problem, energy, options.gap, e);

  addWithin(options.tolerance, e, result.spline.net());
  for (Index r = 0; r < e.rows(); ++r) {
    if (problem.held()[static_cast<std::size_t>(r)]) continue;
    const double move = (result.spline.net().row(r) - input.net().row(r)).norm();
    summary.largestMove = std::max(summary.largestMove, move);
    if (move >= options.tolerance * (1 - 1e-9)) ++summary.activePoints;
  }
  summary.energyAfter = summary.energyBefore + ball.value;
  const double reference = std::abs(summary.energyAfter);
  summary.gap = ball.bound <= 0 ? 0 : reference > 0 ? ball.bound / reference : kUnlimited;
  summary.steps = ball.iterations;
  const bool reached = ball.stop == BallResult::Stop::gap && (summary.gap <= options.gap || ball.bound <= 0);
  summary.stopReason = reached                                     ? StopReason::gap
                       : ball.stop == BallResult::Stop::iterations ? StopReason::steps
                       : ball.stop == BallResult::Stop::cancelled  ? StopReason::cancelled
                                                                   : StopReason::precision;
  summary.seconds = threadSeconds() - begin;
  return result;
}

template Faired<1> fairOptimally<1>(const Spline<1>&, const QuadraticEnergy<1>&, const OptimalFairingOptions&);
template Faired<2> fairOptimally<2>(const Spline<2>&, const QuadraticEnergy<2>&, const OptimalFairingOptions&);
template Faired<3> fairOptimally<3>(const Spline<3>&, const QuadraticEnergy<3>&, const OptimalFairingOptions&);

}  // namespace strak
