#include "strak/fairing/exact_curve_fairing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>

#include "strak/base/cpu_time.h"
#include "strak/base/error.h"
#include "strak/energy/curve_energy.h"
#include "strak/fairing/hull_rows.h"
#include "strak/fairing/plan_curve.h"
#include "strak/metrology/fairness.h"
#include "strak/metrology/plane_of_points.h"
#include "strak/metrology/self_intersection.h"
#include "strak/solve/hull_minimizer.h"

namespace strak {

namespace {

constexpr double kTheta = 0.05;       // weight of log bending against log variation
constexpr double kSliding = 1e-3;     // weight of uneven speed
constexpr double kRadius = 0.9998;    // of the tolerance: room for the width of the certificate
constexpr double kInnerShare = 1e-4;  // of a step's decrease: how sharply the next one is solved,
constexpr double kFinest = 1e-8;      // at most
constexpr double kCoarsest = 1e-5;    // and at least; parts of what the merit may fall
constexpr double kFirstGap = 10;      // likewise
constexpr int kQuiet = 2;             // steps in a row that hardly move anything: the end
constexpr int kPatience = 4;          // tenfold penalties without effect before a number of extrema is given up
constexpr int kHalvings = 2;          // of the spans of the difference

CurveFigures figuresOf(const Curve& curve) {
  FairnessOptions accurate;
  accurate.relativeError = 1e-6;
  const CurveFairness fairness = curveFairness(curve, accurate);
  return {fairness.length, fairness.bending, fairness.curvatureVariation, countCurvatureExtrema(curve)};
}

Curve displaced(const Curve& curve, const Net& displacement) {
  Curve result = curve;
  const Index columns = curve.pointDimension();
  for (Index i = 0; i < displacement.rows(); ++i) {
    if (displacement.row(i).isZero(0)) continue;
    const double weight = curve.isRational() ? curve.net()(i, columns) : 1;
    result.net().row(i).head(columns) += weight * displacement.row(i);
  }
  return result;
}

// A curve of the plane with the same geometry.
Curve flattened(const Curve& curve, const PointPlane& plane) {
  Net net(curve.net().rows(), curve.isRational() ? 3 : 2);
  net.leftCols(2) = (curve.euclideanNet().rowwise() - plane.origin.transpose()) * plane.axes.transpose();
  if (!curve.isRational()) return {curve.knots(), std::move(net)};
  net.col(2) = curve.net().col(3);
  for (Index i = 0; i < net.rows(); ++i) net.row(i).head(2) *= net(i, 2);
  return {curve.knots(), std::move(net), true};
}

class Fairer {
 public:
  Fairer(const Curve& curve, const ExactCurveFairingOptions& options)
      : curve_(curve),
        options_(options),
        map_(unknownsOf(curve, options.held, options.seamContinuity)),
        energy_(curve, map_, options.seamContinuity >= 0 && options.seamContinuity < 2),
        before_(figuresOf(curve)),
        start_(energy_.values(origin())) {
    if (!std::isfinite(start_.bending + start_.variation)) {
      throw InvalidInput(
          "the curve stands still somewhere (its derivative vanishes): it has no curvature to make fair");
    }
  }

  Index unknowns() const { return map_.unknowns; }
  const CurveFigures& before() const { return before_; }
  Index steps() const { return steps_; }
  // No displacement; displacements have three numbers an unknown, in the plane the third is zero.
  Eigen::VectorXd origin() const { return Eigen::VectorXd::Zero(3 * map_.unknowns); }
  // A row a control point.
  Net displacement(const Eigen::VectorXd& y) const { return map_.apply(y).leftCols(energy_.dimension()); }

  // Straight lines and circles have nothing to gain.
  bool isPerfect() const {
    const double length = before_.length;
    return !(start_.variation * length * length > 1e-10 * start_.bending) || !(start_.bending * length > 1e-16);
  }

  struct Outcome {
    Eigen::VectorXd y;
    CurveFigures figures;
    StopReason stop = StopReason::gain;
  };

  // Gauss-Newton from `from`. With `wrongWay` > 0 the prescribed signs count.
  Outcome descend(const Eigen::VectorXd& from, double wrongWay, Index maxSteps) {
    if (!factor_) prepare();
    Outcome best{from, figuresAt(from), StopReason::steps};
    Eigen::VectorXd y = from;
    CurveEnergyValues values = energy_.values(y);
    double damping = 1e-6, theta = kTheta, accuracy = kCoarsest;
    int quiet = 0, turns = 0;
    for (Index step = 0; step < maxSteps; ++step) {
      if (!options_.progress.report(-1, "fairing a curve")) {
        best.stop = StopReason::cancelled;
        return best;
      }
      const CurveEnergyValues weights{theta / values.bending, 1 / values.variation, kSliding * energy_.length(),
                                      wrongWay / energy_.length()};
      BlockMatrix undamped(pattern_);
      Eigen::VectorXd gradient;
      energy_.linearize(y, weights, undamped, gradient);
      const Eigen::VectorXd diagonal = undamped.pointDiagonal();
      const double floor = 1e-15 * diagonal.maxCoeff();
      // What the merit may fall, logarithms and a penalty.
      const double scale = 1 + wrongWay / energy_.length() * values.wrongWay;
      bool moved = false, blocked = false;
      for (int attempt = 0; attempt < 12 && !moved; ++attempt) {
        BlockMatrix matrix = undamped;
        matrix.addDiagonal((damping * diagonal).array() + floor);
        Eigen::VectorXd inner = y;
        const HullResult result = minimizeInHull({&matrix, gradient - matrix.times(y), &rows_}, *factor_, inner,
                                                 {.accuracy = scale * accuracy, .firstGap = scale * kFirstGap});
        ++steps_;
        if (!result.solved && inner == y) {
          damping = std::max(1e-10, damping * 10);
          continue;
        }
        inner /= std::max(1.0, rows_.largestRatio(inner));
        const Eigen::VectorXd move = inner - y;
        const double predicted = -gradient.dot(move) - move.dot(undamped.times(move)) / 2;
        const double reach = rows_.largestRatio(move);
        double length = 1;
        for (int cut = 0; cut < 4 && !moved; ++cut, length *= 0.4) {
          const Eigen::VectorXd candidate = y + length * move;
          const CurveEnergyValues next = energy_.values(candidate);
          const double decrease = merit(values, theta, wrongWay) - merit(next, theta, wrongWay);
          if (!(decrease >= 0.05 * length * predicted - 1e-12)) continue;
          if (!allowed(next)) {
            blocked = true;
            continue;
          }
          const CurveFigures figures = figuresAt(candidate);
          if (!withinInput(figures)) {
            blocked = true;
            continue;
          }
          moved = true;
          y = candidate;
          values = next;
          best.y = y;
          best.figures = figures;
          remember(best);
          accuracy = std::clamp(kInnerShare * decrease, kFinest, kCoarsest);
          const bool still = std::isfinite(options_.tolerance) ? length * reach < 2e-3 : decrease < 1e-7;
          // A penalty still grows; otherwise less than a step is solved to is nothing.
          quiet = wrongWay == 0 && predicted < kFinest ? kQuiet : still || decrease < 1e-9 ? quiet + 1 : 0;
          damping = length == 1 ? damping / 10 : damping;
          if (damping < 1e-13) damping = 0;
        }
        if (!moved) {
          if (predicted < 1e-9) return finish(best, StopReason::gain);
          if (blocked && turns < 4) {
            // A figure of the input would be exceeded: more weight on what grew.
            theta *= 4;
            ++turns;
            break;
          }
          damping = std::max(1e-10, damping * 30);
        }
      }
      if (quiet >= kQuiet) return finish(best, StopReason::gain);
      if (!moved && !(blocked && turns < 4)) return finish(best, StopReason::precision);
    }
    return best;
  }

  // No more than `wanted` extrema, or as few as bisection finds.
  Outcome reduceExtrema(const Outcome& from, Index wanted) {
    Outcome best = from;
    Index low = wanted;
    for (Index target = wanted; low < best.figures.extrema; target = std::midpoint(low, best.figures.extrema - 1)) {
      Outcome trial = best;
      int idle = 0;
      for (double weight = 1e-2; weight < 1e7 && trial.figures.extrema > target && idle < kPatience; weight *= 10) {
        const Index before = trial.figures.extrema;
        prescribe(curveAt(trial.y), target);
        trial = descend(trial.y, weight, 6);
        idle = weight < 1 || trial.figures.extrema < before ? 0 : idle + 1;
        if (trial.stop == StopReason::cancelled) break;
      }
      const bool reached = trial.figures.extrema <= target;
      if (trial.figures.extrema < best.figures.extrema) best = trial;
      if (trial.stop == StopReason::cancelled) {
        best.stop = StopReason::cancelled;
        break;
      }
      if (!reached) low = target + 1;
    }
    return best;
  }

  // The fairest on the way that had no more extrema than the input; the input itself if there was none.
  const std::optional<Outcome>& admissible() const { return admissible_; }

 private:
  void prepare() {
    if (std::isfinite(options_.tolerance)) {
      appendHullRows(curve_, map_, options_.ballsOnPoints ? 0 : kHalvings, kRadius * options_.tolerance, rows_);
    }
    auto cliques = energy_.cliques();
    for (std::size_t i = 0; i + 1 < rows_.start.size(); ++i) {
      cliques.emplace_back(rows_.point.begin() + rows_.start[i], rows_.point.begin() + rows_.start[i + 1]);
    }
    pattern_ = std::make_shared<const BlockPattern>(patternOfCliques(map_.unknowns, cliques));
    // Dissected along the curve, which costs what a band would.
    Eigen::MatrixX3d places = Eigen::MatrixX3d::Zero(map_.unknowns, 3);
    for (Index i = 0; i < map_.unknowns; ++i) places(i, 0) = static_cast<double>(i);
    factor_.emplace(pattern_, places);
  }

  Outcome finish(Outcome outcome, StopReason reason) const {
    outcome.stop = reason;
    return outcome;
  }

  void remember(const Outcome& outcome) {
    if (outcome.figures.extrema > before_.extrema) return;
    const bool fairer = !admissible_ || outcome.figures.curvatureVariation < admissible_->figures.curvatureVariation;
    if (fairer) admissible_ = outcome;
  }

  double merit(const CurveEnergyValues& v, double theta, double wrongWay) const {
    return std::log(v.variation) + theta * std::log(v.bending) + kSliding * energy_.length() * v.sliding +
           wrongWay / energy_.length() * v.wrongWay;
  }

  // Quadrature's own figures first: they are cheap.
  bool allowed(const CurveEnergyValues& v) const {
    constexpr double kSlack = 1e-9;
    return v.bending <= (1 + kSlack) * start_.bending && v.variation <= (1 + kSlack) * start_.variation;
  }

  bool withinInput(const CurveFigures& f) const {
    constexpr double kSlack = 1e-9;
    return f.bending <= (1 + kSlack) * before_.bending &&
           f.curvatureVariation <= (1 + kSlack) * before_.curvatureVariation;
  }

  Curve curveAt(const Eigen::VectorXd& y) const { return displaced(curve_, displacement(y)); }
  CurveFigures figuresAt(const Eigen::VectorXd& y) const { return figuresOf(curveAt(y)); }

  void prescribe(const Curve& curve, Index extrema) {
    const CurvatureProfile profile = mostSignificant(curvatureProfile(curve), extrema);
    std::vector<int> signs;
    signs.reserve(energy_.parameters().size());
    for (const double u : energy_.parameters()) signs.push_back(direction(profile, u));
    energy_.prescribe(std::move(signs));
  }

  const Curve& curve_;
  const ExactCurveFairingOptions& options_;
  PointMap map_;
  CurveEnergy energy_;
  CurveFigures before_;
  CurveEnergyValues start_;
  BallRows rows_;
  std::shared_ptr<const BlockPattern> pattern_;
  std::optional<NestedCholesky> factor_;
  std::optional<Outcome> admissible_;
  Index steps_ = 0;
};

void check(const Curve& curve, const ExactCurveFairingOptions& options) {
  if (!(options.tolerance >= 0)) throw InvalidInput("the tolerance of fairing must be a number not below zero");
  const auto n = static_cast<std::size_t>(curve.net().rows());
  const bool endsHeld = options.held.size() == n && options.held.front() != 0 && options.held.back() != 0;
  if (!std::isfinite(options.tolerance) && !endsHeld) {
    throw InvalidInput(
        "without a tolerance nothing would keep the curve in its place: give a tolerance, or hold points at both ends");
  }
}

bool sameFairness(const CurveFigures& before, const CurveFigures& after) {
  constexpr double kReshaped = 0.2;  // a nose made rounder within the tolerance gives less than this, noise much more
  return after.extrema >= before.extrema && after.curvatureVariation > kReshaped * before.curvatureVariation;
}

}  // namespace

ExactCurveFairing fairCurveExactly(const Curve& curve, const ExactCurveFairingOptions& options) {
  const double begun = threadSeconds();
  check(curve, options);
  // A planar curve in space is faired in its plane: fewer unknowns, a curvature with a sign, and it stays planar.
  std::optional<PointPlane> plane;
  if (curve.pointDimension() == 3) plane = planeOfPoints(curve.euclideanNet());
  const Curve flat = plane ? flattened(curve, *plane) : curve;
  Fairer fairer(flat, options);
  ExactCurveFairing result;
  result.spline = curve;
  result.before = result.after = fairer.before();
  FairingSummary& summary = result.summary;
  summary.energyBefore = summary.energyAfter = result.before.curvatureVariation;
  summary.gap = std::numeric_limits<double>::infinity();
  summary.freePoints = fairer.unknowns();
  result.extremaReached = options.maxExtrema < 0 || result.before.extrema <= options.maxExtrema;
  if (fairer.unknowns() == 0 || options.tolerance == 0) {
    summary.stopReason = StopReason::nothingFree;
  } else if (fairer.isPerfect()) {
    summary.stopReason = StopReason::gain;
    result.alreadyFair = true;
  } else {
    const Eigen::VectorXd start = fairer.origin();
    auto outcome = fairer.descend(start, 0, options.maxSteps);
    const Index most =
        options.maxExtrema >= 0 ? std::min(options.maxExtrema, result.before.extrema) : result.before.extrema;
    const StopReason stop = outcome.stop;
    if (outcome.figures.extrema > most && stop != StopReason::cancelled) outcome = fairer.reduceExtrema(outcome, most);
    summary.stopReason = outcome.stop == StopReason::cancelled ? outcome.stop : stop;
    if (outcome.figures.extrema > result.before.extrema) {
      outcome = fairer.admissible().value_or(Fairer::Outcome{start, result.before, stop});
    }
    summary.steps = fairer.steps();
    result.alreadyFair = options.leaveFair && sameFairness(result.before, outcome.figures);
    if (!result.alreadyFair) {
      Net displacement = fairer.displacement(outcome.y);
      if (plane) displacement = displacement * plane->axes;
      result.spline = displaced(curve, displacement);
      result.deviation = certifyDeviation(curve, result.spline);
      result.after = outcome.figures;
      summary.energyAfter = result.after.curvatureVariation;
      summary.largestMove = displacement.rowwise().norm().maxCoeff();
      if (!(result.deviation.upper <= options.tolerance))
        throw Failure("the certified deviation of a faired curve exceeds its tolerance");
      if (meetingAfterMove(curve, result.spline).isNew) {
        result.spline = curve;
        result.deviation = {};
        result.after = result.before;
        summary.energyAfter = summary.energyBefore;
        summary.largestMove = 0;
        summary.stopReason = StopReason::meetsItself;
      }
    }
  }
  result.extremaReached = options.maxExtrema < 0 || result.after.extrema <= options.maxExtrema;
  summary.seconds = threadSeconds() - begun;
  return result;
}

}  // namespace strak
