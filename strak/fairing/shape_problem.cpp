#include "strak/fairing/shape_problem.h"

#include <algorithm>
#include <cmath>

namespace strak {

namespace {

constexpr int kMostHalvings = 2;       // of a span of the hull
constexpr double kReserve = 2e-4;      // of the tolerance: what a certificate by subdivision may add
constexpr double kActive = 0.95;       // of the radius: rows whose hull is worth refining
constexpr double kPlateFloor = 1e-14;  // below this all is rounding
constexpr double kGuardError = 1e-3;   // of the adaptive integrals ...
constexpr double kSharpError = 2e-5;   // ... and where before and after are this close:
constexpr double kClose = 0.98;
constexpr Index kEvaluations = 1'000'000;        // of an adaptive integral, at most ...
constexpr Index kSingularEvaluations = 150'000;  // ... and where more would not make it converge
constexpr double kMoreJoinWeight = 5;
constexpr double kFirstWeight = 0.01;  // of what is not to get smaller, only not larger
constexpr double kMostJoinWeight = 1e8;
constexpr double kMoreFigureWeight = 2;
constexpr double kMostFigureWeight = 1e4;
constexpr double kSmoothAngle = 1e-5;     // sine, mean: joins with less are smooth and may stay just so
constexpr double kSmoothAtMost = 1.7e-3;  // sine of 0.1 degrees: the largest at one place of a smooth join
constexpr double kSmoothJump = 0.02;      // of the largest curvature across the join

// A singular corner has no finite figures: there the descent's own quadrature must do.
bool trusted(const SurfaceFairness& figures) { return figures.relativeError < 0.01; }

double sizeOf(const Net& points) { return (points.colwise().maxCoeff() - points.colwise().minCoeff()).stableNorm(); }

// Whether no figure of `after` is larger than `limit` times that of `before`.
bool below(const SurfaceFairness& after, const SurfaceFairness& before, double limit) {
  return after.plate <= limit * before.plate && after.curvatureVariation <= limit * before.curvatureVariation &&
         after.isophoteRoughness <= limit * before.isophoteRoughness;
}

template <class T>
std::vector<T> ascending(std::vector<T> numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

}  // namespace

ShapeProblem::ShapeProblem(const std::vector<ShapePatch>& patches, const std::vector<ShapeJoin>& joins,
                           double tolerance, bool ballsOnPoints)
    : tolerance_(tolerance), ballsOnPoints_(ballsOnPoints) {
  for (const ShapePatch& input : patches) {
    Patch patch{&input, input.surface.euclideanNet(), ShapeEnergy(input.surface, input.unknownOf),
                evenLevels(input.surface, ballsOnPoints ? 0 : 1)};
    for (int u : input.unknownOf) unknowns_ = std::max<Index>(unknowns_, u + 1);
    tied_ = input.tied;
    patch.first = patch.energy.values(patch.start);
    patch.before = fairnessOf(patch, input.surface, kGuardError);
    if (!trusted(patch.before)) {
      // Compared are figures after the same work.
      patch.singular = true;
      patch.before = fairnessOf(patch, input.surface, kGuardError);
    }
    const double size = sizeOf(patch.start);
    patch.roughnessFloor = size > 0 ? 1e-14 / (size * size) : 1e-300;
    patches_.push_back(std::move(patch));
  }
  for (const ShapeJoin& join : joins) {
    const ShapePatch &a = patches[join.patchA], &b = patches[join.patchB];
    if (join.mirror) {
      joins_.push_back({join.patchA, join.patchA, JoinEnergy(a.surface, a.unknownOf, join.bankA, *join.mirror)});
      continue;
    }
    joins_.push_back(
        {join.patchA, join.patchB,
         JoinEnergy(a.surface, a.unknownOf, join.bankA, b.surface, b.unknownOf, join.bankB, join.reversed)});
    if (!join.withJump) joins_.back().wishedJump = joins_.back().jumpWeight = 0;
  }
  givenJoins_ = joins_.size();
  for (std::size_t p = 0; p < patches_.size(); ++p) addInnerLines(p);

  makePattern();
  const Figures first = figuresAt(Eigen::VectorXd::Zero(3 * unknowns_));
  for (std::size_t j = 0; j < joins_.size(); ++j) joins_[j].first = first.joins[j];
  makeRows();
}

void ShapeProblem::makePattern() {
  std::vector<std::vector<int>> cliques;
  const auto add = [&](std::vector<std::vector<int>> more) {
    cliques.insert(cliques.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
  };
  for (const Patch& patch : patches_) add(patch.energy.cliques());
  for (const Join& join : joins_) add(join.energy.cliques());
  if (!tied_) {
    pattern_ = std::make_shared<const BlockPattern>(patternOfCliques(unknowns_, cliques));
    return;
  }
  const auto full = std::make_shared<const BlockPattern>(patternOfCliques(tied_->points(), cliques));
  unknowns_ = tied_->unknowns();
  pattern_ = std::make_shared<const BlockPattern>(patternOfCliques(unknowns_, tied_->reduced(cliques)));
  reduction_.emplace(*tied_, full, *pattern_);
}

Eigen::MatrixX3d ShapeProblem::places() const {
  Eigen::MatrixX3d places = Eigen::MatrixX3d::Zero(unknowns_, 3);
  const auto put = [&](int u, const Patch& patch, Index row) {
    const Index columns = patch.input->surface.size(1);
    // The place in the net separates best: a blade bent on itself has far points side by side in space.
    if (patches_.size() == 1) {
      const Index i = row / columns, j = row % columns;
      places.row(u) << static_cast<double>(i), static_cast<double>(j), 0;
    } else {
      places.row(u) = patch.start.row(row);
    }
  };
  // Points that are unknowns themselves come last and have the last word.
  for (const bool plain : {false, true}) {
    for (const Patch& patch : patches_) {
      for (std::size_t r = 0; r < patch.input->unknownOf.size(); ++r) {
        const int point = patch.input->unknownOf[r];
        if (point < 0) continue;
        const auto row = static_cast<Index>(r);
        if (!tied_) {
          if (plain) put(point, patch, row);
          continue;
        }
        const auto& terms = tied_->terms(point);
        if ((terms.size() == 1) != plain) continue;
        for (const TiedPoints::Term& term : terms) put(term.unknown, patch, row);
      }
    }
  }
  return places;
}

bool ShapeProblem::isFlat() const {
  constexpr double kMuch = 1e4;
  return std::all_of(patches_.begin(), patches_.end(), [](const Patch& patch) {
    return patch.first.roughness <= kMuch * patch.roughnessFloor && patch.first.plate <= kMuch * kPlateFloor;
  });
}

// The knot lines where the surface is C1 only: its curvature may jump there, and no quadrature sees it.
void ShapeProblem::addInnerLines(std::size_t patch) {
  const ShapePatch& input = *patches_[patch].input;
  for (int k = 0; k < 2; ++k) {
    for (const auto& knot : input.surface.knots(k).innerKnots()) {
      if (knot.multiplicity != input.surface.degree(k) - 1) continue;
      JoinEnergy energy(input.surface, input.unknownOf, {k, knot.value, false}, input.surface, input.unknownOf,
                        {k, knot.value, true}, false);
      if (!energy.empty()) joins_.push_back({patch, patch, std::move(energy)});
    }
  }
}

// Over the active cells: what is held may be singular, or cut away.
SurfaceFairness ShapeProblem::fairnessOf(const Patch& patch, const Surface& surface, double relativeError) {
  FairnessOptions options;
  options.relativeError = relativeError;
  options.maxEvaluations = (patch.singular ? kSingularEvaluations : kEvaluations) + 100 * patch.energy.activeCells();
  if (!patch.energy.isWhole()) {
    options.context = &patch.energy;
    options.inside = [](double u, double v, const void* energy) {
      return static_cast<const ShapeEnergy*>(energy)->isActive(u, v);
    };
  }
  return surfaceFairness(surface, options);
}

Eigen::Vector3d ShapeProblem::move(int point, const Eigen::VectorXd& e) const {
  return tied_ ? tied_->at(point, e) : e.segment<3>(3 * static_cast<Index>(point));
}

Net ShapeProblem::points(const Patch& patch, const Eigen::VectorXd& e) const {
  Net moved = patch.start;
  for (std::size_t r = 0; r < patch.input->unknownOf.size(); ++r) {
    const int u = patch.input->unknownOf[r];
    if (u >= 0) moved.row(static_cast<Index>(r)) += move(u, e).transpose();
  }
  return moved;
}

Surface ShapeProblem::surface(std::size_t number, const Eigen::VectorXd& e) const {
  const Patch& patch = patches_[number];
  // Held points keep their bits: only free rows are written.
  Surface moved = patch.input->surface;
  Eigen::Ref<Net> net = moved.net();
  for (std::size_t r = 0; r < patch.input->unknownOf.size(); ++r) {
    const int u = patch.input->unknownOf[r];
    if (u < 0) continue;
    const double w = moved.isRational() ? net(static_cast<Index>(r), 3) : 1;
    net.row(static_cast<Index>(r)).head<3>() += w * move(u, e).transpose();
  }
  return moved;
}

void ShapeProblem::makeRows() {
  rows_ = {};
  if (!(tolerance_ < kUnlimited)) return;
  for (Patch& patch : patches_) {
    patch.firstRow = rows_.count();
    appendHullRows(patch.input->surface, patch.input->unknownOf, patch.levels, (1 - kReserve) * tolerance_, rows_);
  }
  if (tied_) rows_ = tied_->reduced(rows_);
}

bool ShapeProblem::refineRows(const Eigen::VectorXd& e) {
  if (ballsOnPoints_ || rows_.count() == 0) return false;
  bool changed = false;
  for (Patch& patch : patches_) {
    if (refineActive(patch.input->surface, patch.input->unknownOf, rows_, patch.firstRow, e, kActive, kMostHalvings,
                     patch.levels)) {
      changed = true;
    }
  }
  if (changed) makeRows();
  return changed;
}

Eigen::VectorXd ShapeProblem::shrunk(const Eigen::VectorXd& e) const {
  Eigen::VectorXd inside = tied_ ? tied_->confined(e) : e;
  const double ratio = rows_.largestRatio(inside);
  if (ratio > 1) inside *= (1 - 1e-12) / ratio;
  return inside;
}

ShapeProblem::Figures ShapeProblem::figuresAt(const Eigen::VectorXd& e) const {
  Figures at;
  std::vector<Net> nets;
  for (const Patch& patch : patches_) {
    nets.push_back(points(patch, e));
    at.patches.push_back(patch.energy.values(nets.back()));
    at.metric.push_back(patch.energy.metric(nets.back()));
    at.rough.push_back(at.patches.back().roughness + patch.roughnessFloor);
  }
  for (const Join& join : joins_) {
    at.joins.push_back(join.energy.figures(nets[join.a], nets[join.b]));
    const double half = 0.5 * join.roughness(at.joins.back());
    at.rough[join.a] += half;
    at.rough[join.b] += half;
  }
  return at;
}

double ShapeProblem::meritChange(const Figures& now, const Figures& at) const {
  double change = 0;
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    const Patch& patch = patches_[p];
    const double floor = patch.roughnessFloor;
    change += std::log(at.rough[p] / now.rough[p]);
    change +=
        (patch.roughWeight - 1) * std::log((at.patches[p].roughness + floor) / (now.patches[p].roughness + floor));
    change += patch.plateWeight * std::log((at.patches[p].plate + kPlateFloor) / (now.patches[p].plate + kPlateFloor));
    change += patch.metricWeight * (at.metric[p] - now.metric[p]) / now.rough[p];
  }
  return change;
}

template <class Fill>
void ShapeProblem::addTied(BlockMatrix& matrix, Eigen::VectorXd& gradient, const Fill& fill) const {
  if (!tied_) {
    fill(matrix, gradient);
    return;
  }
  BlockMatrix full(reduction_->full());
  Eigen::VectorXd force = Eigen::VectorXd::Zero(3 * full.size());
  fill(full, force);
  reduction_->add(full, matrix);
  gradient += tied_->reduced(force);
}

void ShapeProblem::addStep(const Eigen::VectorXd& e, const Figures& now, BlockMatrix& unknownsMatrix,
                           Eigen::VectorXd& unknownsGradient) const {
  addTied(unknownsMatrix, unknownsGradient, [&](BlockMatrix& matrix, Eigen::VectorXd& gradient) {
    std::vector<Net> nets;
    for (std::size_t p = 0; p < patches_.size(); ++p) {
      const Patch& patch = patches_[p];
      nets.push_back(points(patch, e));
      const ShapeEnergy::Weights weights{
          1 / now.rough[p] + (patch.roughWeight - 1) / (now.patches[p].roughness + patch.roughnessFloor),
          patch.plateWeight / (now.patches[p].plate + kPlateFloor), patch.metricWeight / now.rough[p]};
      patch.energy.addStep(nets[p], weights, matrix, gradient);
    }
    for (const Join& join : joins_) {
      const double weight = 0.5 * (1 / now.rough[join.a] + 1 / now.rough[join.b]);
      join.energy.addStep(nets[join.a], nets[join.b], weight * join.angleWeight, weight * join.jumpWeight, matrix,
                          gradient);
    }
  });
  holdPoints(unknownsMatrix, unknownsGradient);
}

void ShapeProblem::addMetric(BlockMatrix& unknownsMatrix, Eigen::VectorXd& unknownsGradient) const {
  addTied(unknownsMatrix, unknownsGradient, [&](BlockMatrix& matrix, Eigen::VectorXd& gradient) {
    for (const Patch& patch : patches_) {
      const double metric = patch.energy.metric(patch.start);
      if (metric > 0) patch.energy.addStep(patch.start, {0, 0, 1 / metric}, matrix, gradient);
    }
  });
}

void ShapeProblem::setMetrics(const Eigen::VectorXd& e, double most, double share) {
  for (Patch& patch : patches_) {
    const Net net = points(patch, e);
    patch.energy.setMetric(net);
    const double metric = patch.energy.metric(net);
    patch.metricWeight = metric > 0 ? std::min(most, share * patch.first.roughness / metric) : most;
  }
}

// Which figures of a patch are larger than the input's.
ShapeProblem::Worse ShapeProblem::worsePatch(std::size_t p, const Eigen::VectorXd& e, const Figures& at) const {
  const Patch& patch = patches_[p];
  const ShapeEnergies& now = at.patches[p];
  Worse worse{now.plate > patch.first.plate, now.roughness > patch.first.roughness};
  // The curvature variation is at most the roughness, so mostly it need not be integrated.
  if (!worse.plate && !worse.roughness && !patch.singular && now.roughness > 0.99 * patch.before.curvatureVariation) {
    const SurfaceFairness after = fairnessOf(patch, surface(p, e), kGuardError);
    worse.roughness = after.curvatureVariation > patch.before.curvatureVariation;
  }
  return worse;
}

// Steps of one surface never make a figure worse; those of many may on the way, or one face would keep all others from
// moving.
bool ShapeProblem::patchHolds(const Eigen::VectorXd& e, const Figures& at) const {
  if (patches_.size() > 1) return true;
  const Worse worse = worsePatch(0, e, at);
  return !worse.plate && !worse.roughness;
}

void ShapeProblem::turnPlateWeight(const Eigen::VectorXd& e, const Figures& at) {
  const Worse worse = worsePatch(0, e, at);
  if (worse.plate || worse.roughness) patches_[0].plateWeight *= worse.plate ? 3 : 1.0 / 3;
}

void ShapeProblem::resetPlateWeights() {
  if (patches_.size() == 1) patches_[0].plateWeight = 1;
}

// Which figures of a join are worse than the input's. On the way they may be: a step keeps joins smooth to first order
// only.
ShapeProblem::WorseJoin ShapeProblem::worseJoin(std::size_t j, const JoinFigures& now) const {
  const JoinFigures& first = joins_[j].first;
  const double seen = kSmoothJump * first.curvature;
  WorseJoin worse{now.meanAngle > std::max(first.meanAngle, kSmoothAngle),
                  now.meanJump > std::max(first.meanJump, seen)};
  // At one place it may be worse, as long as the join stays smooth.
  worse.angle = worse.angle || now.angle > std::max(first.angle, kSmoothAtMost);
  return worse;
}

std::vector<std::size_t> ShapeProblem::raiseWeights(const Eigen::VectorXd& e, const Figures& now) {
  std::vector<std::size_t> raised;
  const auto raise = [](bool worse, double factor, double most, double& weight) {
    if (!worse || weight >= most) return false;
    weight = std::max(kFirstWeight, weight * factor);
    return true;
  };
  for (std::size_t j = 0; j < joins_.size(); ++j) {
    const WorseJoin worse = worseJoin(j, now.joins[j]);
    const bool angle = raise(worse.angle, kMoreJoinWeight, kMostJoinWeight, joins_[j].angleWeight);
    const bool jump = raise(worse.jump, kMoreJoinWeight, kMostJoinWeight, joins_[j].jumpWeight);
    if (angle || jump) raised.insert(raised.end(), {joins_[j].a, joins_[j].b});
  }
  for (std::size_t p = 0; p < patches_.size() && patches_.size() > 1; ++p) {
    const Worse worse = worsePatch(p, e, now);
    const bool plate = raise(worse.plate, kMoreFigureWeight, kMostFigureWeight, patches_[p].plateWeight);
    const bool rough = raise(worse.roughness, kMoreFigureWeight, kMostFigureWeight, patches_[p].roughWeight);
    if (plate || rough) raised.push_back(p);
  }
  return ascending(std::move(raised));
}

bool ShapeProblem::figuresHold(std::size_t p, const Surface& moved, SurfaceFairness& before, SurfaceFairness& after) {
  Patch& patch = patches_[p];
  before = patch.before;
  after = fairnessOf(patch, moved, kGuardError);
  if (below(after, before, kClose)) return true;
  // Of many, one with a singular corner must not keep all others from moving.
  if (patch.singular || !trusted(after)) return patches_.size() > 1 || below(after, before, 1);
  if (!patch.sharpBefore) patch.sharpBefore = fairnessOf(patch, patch.input->surface, kSharpError);
  before = *patch.sharpBefore;
  after = fairnessOf(patch, moved, kSharpError);
  return below(after, before, 1);
}

std::vector<std::size_t> ShapeProblem::worseFigures(const Eigen::VectorXd& e, std::vector<SurfaceFairness>& before,
                                                    std::vector<SurfaceFairness>& after) {
  std::vector<std::size_t> worse;
  before.assign(patches_.size(), {});
  after.assign(patches_.size(), {});
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    if (!figuresHold(p, surface(p, e), before[p], after[p])) worse.push_back(p);
  }
  return worse;
}

std::vector<std::size_t> ShapeProblem::worseJoins(const Figures& at) const {
  std::vector<std::size_t> patches;
  for (std::size_t j = 0; j < joins_.size(); ++j) {
    const WorseJoin worse = worseJoin(j, at.joins[j]);
    if (worse.angle || worse.jump) patches.insert(patches.end(), {joins_[j].a, joins_[j].b});
  }
  return ascending(std::move(patches));
}

std::vector<int> ShapeProblem::unknownsOf(const std::vector<std::size_t>& patches) const {
  std::vector<int> unknowns;
  for (const std::size_t p : patches) {
    for (const int point : patches_[p].input->unknownOf) {
      if (point < 0) continue;
      if (!tied_) {
        unknowns.push_back(point);
      } else {
        for (const TiedPoints::Term& term : tied_->terms(point)) unknowns.push_back(term.unknown);
      }
    }
  }
  return ascending(std::move(unknowns));
}

bool ShapeProblem::holdPatches(const std::vector<std::size_t>& patches) {
  held_.resize(static_cast<std::size_t>(unknowns_), 0);
  bool more = false;
  for (const int unknown : unknownsOf(patches)) {
    char& held = held_[static_cast<std::size_t>(unknown)];
    more = more || held == 0;
    held = 1;
  }
  return more;
}

Eigen::VectorXd ShapeProblem::withHeld(const Eigen::VectorXd& e) const {
  if (held_.empty()) return shrunk(e);
  Eigen::VectorXd x = e;
  for (Index i = 0; i < unknowns_; ++i) {
    if (held_[static_cast<std::size_t>(i)] != 0) x.segment<3>(3 * i).setZero();
  }
  // Where held points have lost their share of a sum, the others may be too far away.
  return shrunk(rows_.drawnIn(std::move(x)));
}

void ShapeProblem::holdPoints(BlockMatrix& matrix, Eigen::VectorXd& gradient) const {
  constexpr double kStiff = 1e8;
  if (held_.empty()) return;
  Eigen::VectorXd stiff = Eigen::VectorXd::Zero(unknowns_);
  const Eigen::VectorXd diagonal = matrix.pointDiagonal();
  for (Index i = 0; i < unknowns_; ++i) {
    if (held_[static_cast<std::size_t>(i)] == 0) continue;
    stiff[i] = kStiff * diagonal[i];
    gradient.segment<3>(3 * i).setZero();
  }
  matrix.addDiagonal(stiff);
}

double ShapeProblem::plainMerit(const Figures& at) const {
  std::vector<double> rough;
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    rough.push_back(at.patches[p].roughness + patches_[p].roughnessFloor);
  }
  for (std::size_t j = 0; j < joins_.size(); ++j) {
    rough[joins_[j].a] += 0.5 * (at.joins[j].ofAngle + joins_[j].wishedJump * at.joins[j].ofJump);
    rough[joins_[j].b] += 0.5 * (at.joins[j].ofAngle + joins_[j].wishedJump * at.joins[j].ofJump);
  }
  double sum = 0;
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    sum += std::log(rough[p]) + std::log(at.patches[p].plate + kPlateFloor);
  }
  return sum;
}

}  // namespace strak
