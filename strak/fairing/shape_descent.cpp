#include "strak/fairing/shape_descent.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "strak/base/error.h"
#include "strak/fairing/hull_rows.h"
#include "strak/solve/hull_minimizer.h"

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
constexpr double kStopChange = 2e-3;  // of the merit, twice in a row
constexpr double kStopPredicted = 1e-4;
constexpr int kMostTurns = 6;         // of the plate energy's weight, where the guard refuses
constexpr int kMostHalvings = 2;      // of a span of the hull
constexpr double kActive = 0.95;      // of the radius: rows whose hull is worth refining
constexpr double kGuardError = 1e-3;  // of the adaptive integrals while descending
constexpr double kFinalError = 2e-5;
constexpr double kInnerShare = 0.02;  // of a step's decrease: how sharply the next one is solved
constexpr double kFinest = 1e-5, kCoarsest = 1e-3;
constexpr double kMoreJoinWeight = 5;
constexpr double kMostJoinWeight = 1e8;
constexpr double kMoreFigureWeight = 2;
constexpr double kMostFigureWeight = 1e4;
constexpr double kSmoothAngle = 1e-5;     // sine, mean: joins with less are smooth and may stay just so
constexpr double kSmoothAtMost = 1.7e-3;  // sine of 0.1 degrees: the largest at one place of a smooth join
constexpr double kSmoothJump = 0.02;      // of the largest curvature across the join
constexpr double kStartAccuracy = 1e-6;   // of the metric energy of the input

Eigen::VectorXd zeros(Index n) { return Eigen::VectorXd::Zero(n); }

// A singular corner has no finite figures: there the descent's own quadrature must do.
bool trusted(const SurfaceFairness& figures) { return figures.relativeError < 0.01; }

class Descent {
 public:
  Descent(const std::vector<ShapePatch>& patches, const std::vector<ShapeJoin>& joins,
          const ShapeDescentOptions& options);
  ShapeDescent run();

 private:
  struct Patch {
    const ShapePatch* input;
    Net start;  // points in space
    ShapeEnergy energy;
    ShapeEnergies first;      // over the active cells
    SurfaceFairness before;   // the same and more, integrated adaptively
    double metricWeight = 0;  // mu
    double plateWeight = 1;   // theta
    double roughWeight = 1;   // psi
    double roughnessFloor = 0, plateFloor = 0;
    SpanLevels levels;
    Index firstRow = 0;
  };
  struct Join {
    std::size_t a, b;  // patches; the same for an inner knot line
    JoinEnergy energy;
    JoinFigures first;
    double angleWeight = 1, jumpWeight = 1;
    double roughness(const JoinFigures& now) const { return angleWeight * now.ofAngle + jumpWeight * now.ofJump; }
  };
  struct Figures {
    std::vector<ShapeEnergies> patches;  // without joins
    std::vector<JoinFigures> joins;
    std::vector<double> rough;  // of the patches with their share of the joins, and never zero
  };

  static SurfaceFairness figuresOf(const Patch& patch, const Surface& surface, double relativeError);
  Net pointsOf(const Patch& patch, const Eigen::VectorXd& e) const;
  Surface surfaceOf(const Patch& patch, const Eigen::VectorXd& e) const;
  void addInnerLines(std::size_t patch);
  Figures figuresAt(const Eigen::VectorXd& e) const;
  double meritChange(const Figures& at, const Eigen::VectorXd& e) const;
  struct Worse {
    bool plate = false, roughness = false;
  };
  Worse worseThanInput(std::size_t patch, const Eigen::VectorXd& e, const Figures& at) const;
  bool guardHolds(const Eigen::VectorXd& e, const Figures& at, bool turnWeights);
  struct WorseJoin {
    bool angle = false, jump = false;
  };
  WorseJoin worseThanInput(std::size_t j, const JoinFigures& now) const;
  bool joinsHold(const Figures& at) const;
  bool raiseWeights();
  bool figuresHold(const Eigen::VectorXd& e, double relativeError, std::vector<SurfaceFairness>& figures) const;
  void makeRows();
  void setMetrics(double most, double share);
  bool startFromMetric();
  bool stage();
  bool refineRows();
  Eigen::VectorXd shrunk(const Eigen::VectorXd& e) const;
  double merit() const;
  bool keepGoing(double fraction, const char* message);

  const ShapeDescentOptions& options_;
  std::vector<Patch> patches_;
  std::vector<Join> joins_;
  std::size_t givenJoins_ = 0;
  Figures now_;
  Index unknowns_ = 0;
  std::shared_ptr<const BlockPattern> pattern_;
  std::optional<NestedCholesky> factor_;
  BallRows rows_;
  Eigen::VectorXd e_;
  std::vector<Eigen::VectorXd> accepted_;
  std::vector<double> metricNow_;
  Index steps_ = 0;
  StopReason stop_ = StopReason::precision;
};

double sizeOf(const Net& points) { return (points.colwise().maxCoeff() - points.colwise().minCoeff()).stableNorm(); }

Descent::Descent(const std::vector<ShapePatch>& patches, const std::vector<ShapeJoin>& joins,
                 const ShapeDescentOptions& options)
    : options_(options) {
  for (const ShapePatch& input : patches) {
    Patch patch{&input,
                input.surface.euclideanNet(),
                ShapeEnergy(input.surface, input.unknownOf),
                {},
                {},
                0,
                1,
                1,
                0,
                0,
                evenLevels(input.surface, options.ballsOnPoints ? 0 : 1),
                0};
    for (int u : input.unknownOf) unknowns_ = std::max<Index>(unknowns_, u + 1);
    patch.first = patch.energy.values(patch.start);
    patch.before = figuresOf(patch, input.surface, kGuardError);
    // A plane has nothing to lose: below this all is rounding.
    const double size = sizeOf(patch.start);
    patch.plateFloor = 1e-14;
    patch.roughnessFloor = size > 0 ? 1e-14 / (size * size) : 1e-300;
    patches_.push_back(std::move(patch));
  }
  for (const ShapeJoin& join : joins) {
    const ShapePatch &a = patches[join.patchA], &b = patches[join.patchB];
    joins_.push_back({join.patchA,
                      join.patchB,
                      JoinEnergy(a.surface, a.unknownOf, join.bankA, b.surface, b.unknownOf, join.bankB, join.reversed,
                                 join.withJump),
                      {}});
  }
  givenJoins_ = joins_.size();
  for (std::size_t p = 0; p < patches_.size(); ++p) addInnerLines(p);

  std::vector<std::vector<int>> cliques;
  const auto add = [&](std::vector<std::vector<int>> more) {
    cliques.insert(cliques.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
  };
  for (const Patch& patch : patches_) add(patch.energy.cliques());
  for (const Join& join : joins_) add(join.energy.cliques());
  pattern_ = std::make_shared<const BlockPattern>(patternOfCliques(unknowns_, cliques));
  Eigen::MatrixX3d places = Eigen::MatrixX3d::Zero(unknowns_, 3);
  for (const Patch& patch : patches_) {
    for (std::size_t r = 0; r < patch.input->unknownOf.size(); ++r) {
      const int u = patch.input->unknownOf[r];
      if (u < 0) continue;
      // The place in the net separates best; only several patches need that in space.
      const Index columns = patch.input->surface.size(1), row = static_cast<Index>(r);
      places.row(u) = patch.start.row(row);
      if (patches_.size() == 1)
        places.row(u) << static_cast<double>(row / columns), static_cast<double>(row % columns), 0;
    }
  }
  factor_.emplace(pattern_, places);
  e_ = zeros(3 * unknowns_);
  now_ = figuresAt(e_);
  for (std::size_t j = 0; j < joins_.size(); ++j) {
    Join& join = joins_[j];
    join.first = now_.joins[j];
  }
  makeRows();
}

// The knot lines where the surface is C1 only: its curvature may jump there, and no quadrature sees it.
void Descent::addInnerLines(std::size_t patch) {
  const ShapePatch& input = *patches_[patch].input;
  for (int k = 0; k < 2; ++k) {
    for (const auto& knot : input.surface.knots(k).innerKnots()) {
      if (knot.multiplicity != input.surface.degree(k) - 1) continue;
      JoinEnergy energy(input.surface, input.unknownOf, {k, knot.value, false}, input.surface, input.unknownOf,
                        {k, knot.value, true}, false);
      if (!energy.empty()) joins_.push_back({patch, patch, std::move(energy), {}});
    }
  }
}

// Over the active cells: what is held may be singular, or cut away.
SurfaceFairness Descent::figuresOf(const Patch& patch, const Surface& surface, double relativeError) {
  FairnessOptions options;
  options.relativeError = relativeError;
  options.maxEvaluations = 1'000'000 + 100 * patch.energy.activeCells();
  if (!patch.energy.isWhole()) {
    options.context = &patch.energy;
    options.inside = [](double u, double v, const void* energy) {
      return static_cast<const ShapeEnergy*>(energy)->isActive(u, v);
    };
  }
  return surfaceFairness(surface, options);
}

Net Descent::pointsOf(const Patch& patch, const Eigen::VectorXd& e) const {
  Net points = patch.start;
  for (std::size_t r = 0; r < patch.input->unknownOf.size(); ++r) {
    const int u = patch.input->unknownOf[r];
    if (u >= 0) points.row(static_cast<Index>(r)) += e.segment<3>(3 * u).transpose();
  }
  return points;
}

Surface Descent::surfaceOf(const Patch& patch, const Eigen::VectorXd& e) const {
  // Held points keep their bits: only free rows are written.
  Surface surface = patch.input->surface;
  Eigen::Ref<Net> net = surface.net();
  for (std::size_t r = 0; r < patch.input->unknownOf.size(); ++r) {
    const int u = patch.input->unknownOf[r];
    if (u < 0) continue;
    const double w = surface.isRational() ? net(static_cast<Index>(r), 3) : 1;
    for (int c = 0; c < 3; ++c) net(static_cast<Index>(r), c) += w * e[3 * u + c];
  }
  return surface;
}

void Descent::makeRows() {
  rows_ = {};
  if (!(options_.tolerance < kUnlimited)) return;
  for (Patch& patch : patches_) {
    patch.firstRow = rows_.count();
    appendHullRows(patch.input->surface, patch.input->unknownOf, patch.levels, options_.tolerance, rows_);
  }
}

bool Descent::refineRows() {
  if (options_.ballsOnPoints || rows_.count() == 0) return false;
  bool changed = false;
  for (Patch& patch : patches_) {
    if (refineActive(patch.input->surface, patch.input->unknownOf, rows_, patch.firstRow, e_, kActive, kMostHalvings,
                     patch.levels)) {
      changed = true;
    }
  }
  if (changed) makeRows();
  return changed;
}

// Feasible to the last bit: the balls are convex and contain zero.
Eigen::VectorXd Descent::shrunk(const Eigen::VectorXd& e) const {
  const double ratio = rows_.largestRatio(e);
  Eigen::VectorXd inside = e;
  if (ratio > 1) inside *= (1 - 1e-12) / ratio;
  return inside;
}

Descent::Figures Descent::figuresAt(const Eigen::VectorXd& e) const {
  Figures at;
  std::vector<Net> points;
  for (const Patch& patch : patches_) {
    points.push_back(pointsOf(patch, e));
    at.patches.push_back(patch.energy.values(points.back()));
    at.rough.push_back(at.patches.back().roughness + patch.roughnessFloor);
  }
  for (const Join& join : joins_) {
    at.joins.push_back(join.energy.figures(points[join.a], points[join.b]));
    const double half = 0.5 * join.roughness(at.joins.back());
    at.rough[join.a] += half;
    at.rough[join.b] += half;
  }
  return at;
}

// The merit at e less that at e_: sum of log (roughness with joins) + (psi - 1) log roughness + theta log plate + mu
// metric / roughness at e_.
double Descent::meritChange(const Figures& at, const Eigen::VectorXd& e) const {
  double change = 0;
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    const Patch& patch = patches_[p];
    change += std::log(at.rough[p] / now_.rough[p]);
    change += (patch.roughWeight - 1) * std::log((at.patches[p].roughness + patch.roughnessFloor) /
                                                 (now_.patches[p].roughness + patch.roughnessFloor));
    change += patch.plateWeight *
              std::log((at.patches[p].plate + patch.plateFloor) / (now_.patches[p].plate + patch.plateFloor));
    change += patch.metricWeight * (patch.energy.metric(pointsOf(patch, e)) - metricNow_[p]) / now_.rough[p];
  }
  return change;
}

// Which figures of a patch are larger than the input's.
Descent::Worse Descent::worseThanInput(std::size_t p, const Eigen::VectorXd& e, const Figures& at) const {
  const Patch& patch = patches_[p];
  const ShapeEnergies& now = at.patches[p];
  Worse worse{now.plate > patch.first.plate, now.roughness > patch.first.roughness};
  // The curvature variation is at most the roughness, so mostly it need not be integrated.
  if (!worse.plate && !worse.roughness && now.roughness > 0.99 * patch.before.curvatureVariation) {
    const SurfaceFairness after = figuresOf(patch, surfaceOf(patch, e), kGuardError);
    worse.roughness = after.curvatureVariation > patch.before.curvatureVariation && trusted(patch.before);
  }
  return worse;
}

// With `turnWeights` the plate energy's weight is turned towards the figure that is worse. Steps of one surface never
// make a figure worse; those of many may on the way, or one face would keep all others from moving.
bool Descent::guardHolds(const Eigen::VectorXd& e, const Figures& at, bool turnWeights) {
  if (patches_.size() > 1) return true;
  const Worse worse = worseThanInput(0, e, at);
  if (turnWeights && (worse.plate || worse.roughness)) patches_[0].plateWeight *= worse.plate ? 3 : 1.0 / 3;
  return !worse.plate && !worse.roughness;
}

// Which figures of a join are worse than the input's. On the way they may be: a step keeps joins smooth to first order
// only.
Descent::WorseJoin Descent::worseThanInput(std::size_t j, const JoinFigures& now) const {
  const JoinFigures& first = joins_[j].first;
  const double seen = kSmoothJump * first.curvature;
  WorseJoin worse{now.meanAngle > std::max(first.meanAngle, kSmoothAngle),
                  now.meanJump > std::max(first.meanJump, seen)};
  // At one place it may be worse, as long as the join stays smooth.
  worse.angle = worse.angle || now.angle > std::max(first.angle, kSmoothAtMost);
  return worse;
}

bool Descent::joinsHold(const Figures& at) const {
  for (std::size_t j = 0; j < joins_.size(); ++j) {
    const WorseJoin worse = worseThanInput(j, at.joins[j]);
    if (worse.angle || worse.jump) return false;
  }
  return true;
}

// Raises the weights of what is worse than the input's: joins, and of several patches their figures; false if there is
// nothing to raise.
bool Descent::raiseWeights() {
  bool raised = false;
  const auto raise = [&raised](bool worse, double factor, double most, double& weight) {
    if (!worse || weight >= most) return;
    weight *= factor;
    raised = true;
  };
  for (std::size_t j = 0; j < joins_.size(); ++j) {
    const WorseJoin worse = worseThanInput(j, now_.joins[j]);
    raise(worse.angle, kMoreJoinWeight, kMostJoinWeight, joins_[j].angleWeight);
    raise(worse.jump, kMoreJoinWeight, kMostJoinWeight, joins_[j].jumpWeight);
  }
  for (std::size_t p = 0; p < patches_.size() && patches_.size() > 1; ++p) {
    const Worse worse = worseThanInput(p, e_, now_);
    raise(worse.plate, kMoreFigureWeight, kMostFigureWeight, patches_[p].plateWeight);
    raise(worse.roughness, kMoreFigureWeight, kMostFigureWeight, patches_[p].roughWeight);
  }
  if (raised) now_ = figuresAt(e_);
  return raised;
}

bool Descent::figuresHold(const Eigen::VectorXd& e, double relativeError, std::vector<SurfaceFairness>& figures) const {
  figures.clear();
  for (const Patch& patch : patches_) {
    const SurfaceFairness& before = patch.before;
    const SurfaceFairness after = figuresOf(patch, surfaceOf(patch, e), relativeError);
    figures.push_back(after);

    if (!trusted(before) || !trusted(after)) continue;
    if (after.plate > before.plate || after.curvatureVariation > before.curvatureVariation ||
        after.isophoteRoughness > before.isophoteRoughness) {
      return false;
    }
  }
  return true;
}

// Of what has been reached: both energies count alike.
double Descent::merit() const {
  std::vector<double> rough;
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    rough.push_back(now_.patches[p].roughness + patches_[p].roughnessFloor);
  }
  // With the first weights: those of now depend on the way.
  for (std::size_t j = 0; j < joins_.size(); ++j) {
    rough[joins_[j].a] += 0.5 * (now_.joins[j].ofAngle + now_.joins[j].ofJump);
    rough[joins_[j].b] += 0.5 * (now_.joins[j].ofAngle + now_.joins[j].ofJump);
  }
  double sum = 0;
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    sum += std::log(rough[p]) + std::log(now_.patches[p].plate + patches_[p].plateFloor);
  }
  return sum;
}

bool Descent::keepGoing(double fraction, const char* message) {
  if (options_.progress.report(fraction, message)) return true;
  stop_ = StopReason::cancelled;
  return false;
}

void Descent::setMetrics(double most, double share) {
  for (Patch& patch : patches_) {
    patch.energy.setMetric(pointsOf(patch, e_));
    const double metric = patch.energy.metric(pointsOf(patch, e_));
    patch.metricWeight = metric > 0 ? std::min(most, share * patch.first.roughness / metric) : most;
  }
}

// The minimum of the metric energy alone, where it has less of everything: the start for inputs that are folded or full
// of noise, from which the exact energies would not find the way.
bool Descent::startFromMetric() {
  BlockMatrix matrix(pattern_);
  Eigen::VectorXd gradient = zeros(3 * unknowns_);
  for (const Patch& patch : patches_) {
    const double metric = patch.energy.metric(patch.start);
    if (metric > 0) patch.energy.addStep(patch.start, {0, 0, 1 / metric}, matrix, gradient);
  }
  const Eigen::VectorXd diagonal = matrix.pointDiagonal();
  if (!(diagonal.minCoeff() > 0)) return false;
  matrix.addDiagonal(1e-10 * diagonal);
  Eigen::VectorXd x = e_;
  minimizeInHull({&matrix, gradient, &rows_}, *factor_, x, {.accuracy = kStartAccuracy});
  x = shrunk(x);
  Figures at = figuresAt(x);
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    if (!(at.patches[p].plate < patches_[p].first.plate) ||
        !(at.patches[p].roughness < 0.5 * patches_[p].first.roughness)) {
      return false;
    }
  }
  if (!guardHolds(x, at, false)) return false;
  e_ = x;
  now_ = std::move(at);
  accepted_.push_back(e_);
  return true;
}

// Steps until the merit stands still; returns false if nothing was gained at all.
bool Descent::stage() {
  double damping = kFirstDamping, accuracy = kCoarsest;
  int small = 0, turns = 0;
  bool gained = false;
  while (true) {
    if (steps_ >= options_.maxSteps) {
      stop_ = StopReason::steps;
      return gained;
    }
    if (!keepGoing(static_cast<double>(steps_) / static_cast<double>(options_.maxSteps), "fairing")) return gained;
    BlockMatrix matrix(pattern_);
    Eigen::VectorXd gradient = zeros(3 * unknowns_);
    metricNow_.clear();
    std::vector<Net> points;
    for (std::size_t p = 0; p < patches_.size(); ++p) {
      const Patch& patch = patches_[p];
      points.push_back(pointsOf(patch, e_));
      patch.energy.addStep(
          points[p],
          {1 / now_.rough[p] + (patch.roughWeight - 1) / (now_.patches[p].roughness + patch.roughnessFloor),
           patch.plateWeight / (now_.patches[p].plate + patch.plateFloor), patch.metricWeight / now_.rough[p]},
          matrix, gradient);
      metricNow_.push_back(patch.energy.metric(points[p]));
    }
    for (const Join& join : joins_) {
      const double weight = 0.5 * (1 / now_.rough[join.a] + 1 / now_.rough[join.b]);
      join.energy.addStep(points[join.a], points[join.b], weight * join.angleWeight, weight * join.jumpWeight, matrix,
                          gradient);
    }
    const Eigen::VectorXd diagonal = matrix.pointDiagonal();
    bool accepted = false;
    while (!accepted) {
      BlockMatrix damped = matrix;
      damped.addDiagonal(damping * diagonal);
      Eigen::VectorXd x = e_;
      const Eigen::VectorXd linear = gradient - damped.times(e_);
      minimizeInHull({&damped, linear, &rows_}, *factor_, x, {.accuracy = accuracy});
      x = shrunk(x);
      const Eigen::VectorXd step = x - e_;
      const double predicted = -(gradient.dot(step) + 0.5 * step.dot(matrix.times(step)));
      if (predicted < kStopPredicted) {
        stop_ = StopReason::gain;
        if (!raiseWeights()) return gained;
        break;
      }
      Eigen::VectorXd refused;
      Figures refusedAt;
      double change = 0;
      for (double t : kSteps) {
        const Eigen::VectorXd tried = e_ + t * step;
        Figures at = figuresAt(tried);
        change = meritChange(at, tried);
        if (!(change <= -kLeastShare * t * predicted)) continue;
        if (!guardHolds(tried, at, false)) {
          if (refused.size() == 0) {
            refused = tried;
            refusedAt = at;
          }
          continue;
        }
        e_ = tried;
        now_ = std::move(at);
        accepted = true;
        if (t == 1) damping = std::max(kLeastDamping, damping / 5);
        break;
      }
      if (accepted) {
        ++steps_;

        accepted_.push_back(e_);
        gained = true;
        small = -change < kStopChange ? small + 1 : 0;
        // Inner lines must hold at every step: the last one taken is the result.
        if (patches_.size() == 1 && raiseWeights()) small = 0;
        accuracy = std::clamp(kInnerShare * predicted, kFinest, kCoarsest);
        if (small >= 2) {
          stop_ = StopReason::gain;
          if (!raiseWeights()) return gained;
          small = 0;
        }
      } else if (refused.size() > 0 && turns < kMostTurns) {
        guardHolds(refused, refusedAt, true);
        now_ = figuresAt(e_);
        ++turns;
        break;  // the matrix has other weights now
      } else {
        damping *= 10;
        if (damping > kMostDamping) {
          stop_ = StopReason::precision;
          return gained;
        }
      }
    }
  }
}

ShapeDescent Descent::run() {
  const auto begin = std::chrono::steady_clock::now();
  ShapeDescent result;
  accepted_.push_back(e_);
  bool flat = true;
  for (const Patch& patch : patches_) {
    if (patch.first.roughness > 1e4 * patch.roughnessFloor || patch.first.plate > 1e4 * patch.plateFloor) flat = false;
  }
  if (unknowns_ > 0 && !flat) {
    setMetrics(kMetricWeight, kMetricShare);
    startFromMetric();
    stage();
    const double firstMerit = merit();
    const std::size_t firstStage = accepted_.size();
    // The arc lengths of the input were those of its noise: once more with those of the result.
    if (stop_ != StopReason::cancelled) {
      refineRows();
      setMetrics(kLaterMetricWeight, kMetricShare);
      for (Patch& patch : patches_) {
        if (patches_.size() == 1) patch.plateWeight = 1;
      }
      stage();
      if (patches_.size() == 1 && merit() > firstMerit) accepted_.resize(firstStage);
    }
  }
  result.steps = steps_;
  result.stopReason = unknowns_ == 0 || flat ? StopReason::nothingFree : stop_;
  for (Patch& patch : patches_) patch.before = figuresOf(patch, patch.input->surface, kFinalError);
  // The last surface whose figures hold when integrated sharply.
  while (accepted_.size() > 1 &&
         !(joinsHold(figuresAt(accepted_.back())) && figuresHold(accepted_.back(), kFinalError, result.after))) {
    accepted_.pop_back();
  }
  const Eigen::VectorXd& e = accepted_.back();
  now_ = figuresAt(e);
  for (std::size_t j = 0; j < givenJoins_; ++j) {
    result.joinsBefore.push_back(joins_[j].first);
    result.joinsAfter.push_back(now_.joins[j]);
  }
  for (const Patch& patch : patches_) {
    result.before.push_back(patch.before);
    result.surfaces.push_back(surfaceOf(patch, e));
  }
  if (accepted_.size() == 1) result.after = result.before;
  if (rows_.count() > 0) {
    const Eigen::VectorXd reached = rows_.times(e);
    for (Index i = 0; i < rows_.count(); ++i) {
      result.activeRows += reached.segment<3>(3 * i).norm() > 0.999 * options_.tolerance;
    }
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

}  // namespace

ShapeDescent descendShape(const std::vector<ShapePatch>& patches, const std::vector<ShapeJoin>& joins,
                          const ShapeDescentOptions& options) {
  return Descent(patches, joins, options).run();
}

}  // namespace strak
