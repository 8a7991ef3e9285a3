#include "strak/fairing/shape_descent.h"

#include <algorithm>
#include <chrono>
#include <memory>

#include "strak/fairing/shape_problem.h"
#include "strak/solve/hull_windows.h"

namespace strak {

namespace {

constexpr double kMetricWeight = 1e-3;       // mu of the first stage, at most
constexpr double kMetricShare = 0.01;        // ... and this part of roughness / metric of the input
constexpr double kLaterMetricWeight = 1e-4;  // of the second stage, whose arc lengths are those of the first result
constexpr double kLeastDamping = 1e-6;
constexpr double kFirstDamping = 1e-3;
constexpr double kMostDamping = 1e4;
constexpr double kSteps[] = {1, 0.4, 0.16, 0.064};
constexpr double kLeastShare = 0.05;  // of the predicted decrease that a step must bring
constexpr int kMostWithdrawals = 8;
constexpr int kMostRaises = 6;        // of weights between two withdrawals, where the part is large
constexpr int kMostTurns = 6;         // of the plate energy's weight, where the guard refuses
constexpr double kInnerShare = 0.02;  // of a step's decrease: how sharply the next one is solved
constexpr double kFinest = 1e-5, kCoarsest = 1e-3;
// Unknown points, of one patch and of several (whose waves are no longer than a patch): a step of one factor takes half
// a minute, so there are windows, and only steps that bring much are taken.
constexpr Index kLargePatch = 20'000, kLargePart = 10'000;
constexpr double kFirstGap = 10;         // the merit is a sum of logarithms
constexpr double kStartAccuracy = 1e-4;  // of the metric energy of the input

// When a stage ends; the figures by patches.
struct Stop {
  double change;     // of the merit, less than this ...
  int times;         // ... so often in a row
  double predicted;  // decrease of the next step
};
constexpr Stop kStopFirst{1e-2, 1, 1e-3};  // the second stage goes on from there
constexpr Stop kStopLater{2e-3, 2, 1e-4};
constexpr Stop kStopLarge{2e-2, 1, 1e-4};

class Descent {
 public:
  Descent(const std::vector<ShapePatch>& patches, const std::vector<ShapeJoin>& joins,
          const ShapeDescentOptions& options)
      : options_(options),
        problem_(patches, joins, options.tolerance, options.ballsOnPoints),
        e_(Eigen::VectorXd::Zero(3 * problem_.unknowns())),
        now_(problem_.figuresAt(e_)),
        accepted_{e_},
        lastStep_(options.maxSteps) {
    if (isLarge()) {
      makeWindows();
    } else {
      factor_ = std::make_unique<NestedCholesky>(problem_.pattern(), problem_.places());
    }
  }
  ShapeDescent run();

 private:
  bool isLarge() const { return problem_.unknowns() > (problem_.patches() > 1 ? kLargePart : kLargePatch); }
  // The merit is a sum over the patches.
  double scale() const { return static_cast<double>(problem_.patches()); }
  void setMetrics(double most);
  void minimize(const BlockMatrix& matrix, const Eigen::VectorXd& linear, double accuracy, Eigen::VectorXd& x);
  void startFromMetric();
  void stage(const Stop& stop);
  void makeWindows(std::vector<int> unknowns = {});
  bool raiseWeights();
  bool holds(ShapeDescent& result);
  void goTo(const Eigen::VectorXd& e);
  void lookBack(ShapeDescent& result);
  bool withdraw(ShapeDescent& result);
  void settle(ShapeDescent& result);
  void accept(const Eigen::VectorXd& e, ShapeProblem::Figures at);

  const ShapeDescentOptions& options_;
  ShapeProblem problem_;
  std::unique_ptr<NestedCholesky> factor_;  // of everything, or of ...
  std::unique_ptr<HullWindows> windows_;    // ... one window after the other
  Eigen::VectorXd e_;
  ShapeProblem::Figures now_;
  std::vector<Eigen::VectorXd> accepted_;
  Index steps_ = 0, lastStep_ = 0;
  int raises_ = 0;  // since patches were withdrawn
  StopReason stop_ = StopReason::precision;
};

void Descent::accept(const Eigen::VectorXd& e, ShapeProblem::Figures at) {
  e_ = e;
  now_ = std::move(at);
  accepted_.push_back(e_);
}

void Descent::setMetrics(double most) {
  problem_.setMetrics(e_, most, kMetricShare);
  now_ = problem_.figuresAt(e_);
}

void Descent::makeWindows(std::vector<int> unknowns) {
  windows_ = std::make_unique<HullWindows>(problem_.pattern(), problem_.places(), WindowOptions{}, std::move(unknowns));
}

bool Descent::raiseWeights() {
  if (isLarge() && ++raises_ > kMostRaises) return false;
  const std::vector<std::size_t> raised = problem_.raiseWeights(e_, now_);
  if (raised.empty()) return false;
  // The others have nothing new to answer to.
  if (windows_) makeWindows(problem_.unknownsOf(raised));
  now_ = problem_.figuresAt(e_);
  return true;
}

void Descent::minimize(const BlockMatrix& matrix, const Eigen::VectorXd& linear, double accuracy, Eigen::VectorXd& x) {
  const HullProblem problem{&matrix, linear, &problem_.rows()};
  const HullOptions options{.accuracy = scale() * accuracy, .firstGap = scale() * kFirstGap};
  if (windows_) {
    windows_->sweep(problem, x, options);
  } else {
    minimizeInHull(problem, *factor_, x, options);
  }
  x = problem_.withHeld(x);
}

// The minimum of the metric energy alone, where it has less of everything: the start for inputs that are folded or full
// of noise, from which the exact energies would not find the way.
void Descent::startFromMetric() {
  BlockMatrix matrix(problem_.pattern());
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(e_.size());
  problem_.addMetric(matrix, gradient);
  const Eigen::VectorXd diagonal = matrix.pointDiagonal();
  if (!(diagonal.minCoeff() > 0)) return;
  matrix.addDiagonal(1e-10 * diagonal);
  Eigen::VectorXd x = e_;
  minimize(matrix, gradient, kStartAccuracy, x);
  ShapeProblem::Figures at = problem_.figuresAt(x);
  for (std::size_t p = 0; p < problem_.patches(); ++p) {
    const ShapeEnergies& first = problem_.firstEnergies(p);
    if (!(at.patches[p].plate < first.plate) || !(at.patches[p].roughness < 0.5 * first.roughness)) return;
  }
  if (problem_.patchHolds(x, at)) accept(x, std::move(at));
}

// Steps until the merit stands still.
void Descent::stage(const Stop& stop) {
  double damping = kFirstDamping, accuracy = kCoarsest, lastPredicted = 0;
  int small = 0, turns = 0;
  while (true) {
    if (steps_ >= lastStep_) {
      stop_ = StopReason::steps;
      return;
    }
    if (!options_.progress.report(static_cast<double>(steps_) / static_cast<double>(lastStep_), "fairing")) {
      stop_ = StopReason::cancelled;
      return;
    }
    BlockMatrix matrix(problem_.pattern());
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(e_.size());
    problem_.addStep(e_, now_, matrix, gradient);
    const Eigen::VectorXd diagonal = matrix.pointDiagonal();
    bool accepted = false;
    double added = 0;
    while (!accepted) {
      matrix.addDiagonal((damping - added) * diagonal);
      added = damping;
      Eigen::VectorXd x = e_;
      minimize(matrix, gradient - matrix.times(e_), accuracy, x);
      const Eigen::VectorXd step = x - e_;
      double predicted = -(gradient.dot(step) + 0.5 * step.dot(matrix.times(step)));
      for (Index i = 0; i < diagonal.size(); ++i) {
        predicted += 0.5 * damping * diagonal[i] * step.segment<3>(3 * i).squaredNorm();
      }
      if (predicted < scale() * stop.predicted) {
        stop_ = StopReason::gain;
        if (!raiseWeights()) return;
        break;
      }
      Eigen::VectorXd refused;
      ShapeProblem::Figures refusedAt;
      double change = 0;
      for (double t : kSteps) {
        const Eigen::VectorXd tried = e_ + t * step;
        ShapeProblem::Figures at = problem_.figuresAt(tried);
        change = problem_.meritChange(now_, at);
        if (!(change <= -kLeastShare * t * predicted)) continue;
        if (!problem_.patchHolds(tried, at)) {
          if (refused.size() == 0) {
            refused = tried;
            refusedAt = at;
          }
          continue;
        }
        accept(tried, std::move(at));
        accepted = true;
        if (t == 1) damping = std::max(kLeastDamping, damping / 5);
        break;
      }
      if (accepted) {
        ++steps_;
        small = -change < scale() * stop.change ? small + 1 : 0;
        // Inner lines must hold at every step: the last one taken is the result.
        if (problem_.patches() == 1 && raiseWeights()) small = 0;
        accuracy = std::clamp(kInnerShare * predicted / scale(), kFinest, kCoarsest);
        // Steps that predict their squares would bring nothing more.
        const bool settled = lastPredicted > 0 && predicted * predicted < scale() * stop.predicted * lastPredicted;
        lastPredicted = predicted;
        if (small >= stop.times || settled) {
          stop_ = StopReason::gain;
          if (!raiseWeights()) return;
          small = 0;
          lastPredicted = 0;
        }
      } else if (refused.size() > 0 && turns < kMostTurns) {
        problem_.turnPlateWeight(refused, refusedAt);
        ++turns;
        break;  // the matrix has other weights now
      } else {
        damping *= 10;
        if (damping > kMostDamping) {
          stop_ = StopReason::precision;
          return;
        }
      }
    }
  }
}

bool Descent::holds(ShapeDescent& result) {
  return problem_.worseJoins(now_).empty() && problem_.worseFigures(e_, result.before, result.after).empty();
}

void Descent::goTo(const Eigen::VectorXd& e) {
  e_ = e;
  now_ = problem_.figuresAt(e_);
}

// Back to the last place that holds, or the start.
void Descent::lookBack(ShapeDescent& result) {
  while (accepted_.size() > 1) {
    accepted_.pop_back();
    goTo(accepted_.back());
    if (accepted_.size() > 1 && holds(result)) return;
  }
}

// The patches that do not hold go back to the input, and the others go on without them, until all holds. False if that
// leads nowhere.
bool Descent::withdraw(ShapeDescent& result) {
  for (int times = 0;; ++times) {
    std::vector<std::size_t> worse = problem_.worseFigures(e_, result.before, result.after);
    const auto more = problem_.worseJoins(now_);
    worse.insert(worse.end(), more.begin(), more.end());
    if (worse.empty()) return true;
    if (times == kMostWithdrawals || stop_ == StopReason::cancelled || !problem_.holdPatches(worse)) return false;
    const Eigen::VectorXd x = problem_.withHeld(e_);
    accept(x, problem_.figuresAt(x));
    if (windows_) makeWindows();
    raises_ = 0;
    lastStep_ = steps_ + options_.maxSteps;
    stage(isLarge() ? kStopLarge : kStopLater);
  }
}

// Leaves the best place where everything holds. Of a large part earlier places are not looked at: there is always a
// patch that does not hold.
void Descent::settle(ShapeDescent& result) {
  if (accepted_.size() == 1 || holds(result)) return;
  const Eigen::VectorXd last = e_;
  const bool several = problem_.patches() > 1;
  if (several && isLarge()) {
    accepted_.resize(1);
  } else {
    lookBack(result);
  }
  if (!several || accepted_.size() > 1) return;
  accept(last, problem_.figuresAt(last));
  if (withdraw(result)) return;
  accepted_.resize(1);
  goTo(accepted_.back());
}

ShapeDescent Descent::run() {
  const auto begin = std::chrono::steady_clock::now();
  ShapeDescent result;
  const bool nothingFree = problem_.unknowns() == 0 || problem_.isFlat();
  if (!nothingFree) {
    setMetrics(kMetricWeight);
    startFromMetric();
    stage(isLarge() ? kStopLarge : kStopFirst);
    const double firstMerit = problem_.plainMerit(now_);
    const std::size_t firstStage = accepted_.size();
    // The arc lengths of the input were those of its noise: once more with those of the result.
    if (stop_ != StopReason::cancelled && !isLarge()) {
      problem_.refineRows(e_);
      setMetrics(kLaterMetricWeight);
      problem_.resetPlateWeights();
      stage(kStopLater);
      if (problem_.patches() == 1 && problem_.plainMerit(now_) > firstMerit) {
        accepted_.resize(firstStage);
        goTo(accepted_.back());
      }
    }
  }
  settle(result);
  result.steps = steps_;
  result.stopReason = nothingFree ? StopReason::nothingFree : stop_;
  if (accepted_.size() == 1) {
    result.before.clear();
    for (std::size_t p = 0; p < problem_.patches(); ++p) result.before.push_back(problem_.before(p));
    result.after = result.before;
  }
  for (std::size_t j = 0; j < problem_.givenJoins(); ++j) {
    result.joinsBefore.push_back(problem_.firstJoin(j));
    result.joinsAfter.push_back(now_.joins[j]);
  }
  for (std::size_t p = 0; p < problem_.patches(); ++p) result.surfaces.push_back(problem_.surface(p, e_));
  const Eigen::VectorXd reached = problem_.rows().times(e_);
  for (Index i = 0; i < problem_.rows().count(); ++i) {
    result.activeRows += reached.segment<3>(3 * i).norm() > 0.998 * options_.tolerance;
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

}  // namespace

ShapePatch patchOf(const Surface& surface, const HeldPoints& held) {
  ShapePatch patch{surface, std::vector<int>(static_cast<std::size_t>(surface.net().rows()), -1)};
  int unknowns = 0;
  for (std::size_t r = 0; r < patch.unknownOf.size(); ++r) {
    if (held.empty() || held[r] == 0) patch.unknownOf[r] = unknowns++;
  }
  return patch;
}

ShapeDescent descendShape(const std::vector<ShapePatch>& patches, const std::vector<ShapeJoin>& joins,
                          const ShapeDescentOptions& options) {
  return Descent(patches, joins, options).run();
}

}  // namespace strak
