#include "strak/fairing/local_fairing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "strak/base/cpu_time.h"
#include "strak/base/error.h"
#include "strak/energy/energy_operator.h"
#include "strak/fairing/fairing_problem.h"
#include "strak/fairing/free_factor.h"
#include "strak/fairing/ranked_net.h"

namespace strak {

namespace {

// Moves shorter than this part of the largest coordinate leave no trace in the result, however many follow.
constexpr double kSmallestMove = 0x1p-58;
constexpr double kEnergyRounding = 0x1p-52;
constexpr Index kStepsPerReport = 1 << 14;
// The dual bound begins after so many moves a free point, and is looked at again when the steps have grown by a fifth.
constexpr Index kSweepsBeforeDualBound = 8;

// So many free points can be factored in about a second.
template <int D>
constexpr Index factorLimit() {
  return D == 1 ? 100'000 : D == 2 ? 10'000 : 1'000;
}

template <int D>
class LocalDescent {
 public:
  // `net` is the input's, possibly with another origin.
  LocalDescent(const Spline<D>& input, const Net& net, const QuadraticEnergy<D>& quadratic,
               const EnergyOperator<D>& energy, const LocalFairingOptions& options)
      : input_(input),
        quadratic_(quadratic),
        energy_(energy),
        options_(options),
        bounded_(std::isfinite(options.tolerance)),
        net_(energy, net, options.held, options.tolerance,
             options.ranking == RankingNumber::literal ? kUnlimited : options.tolerance),
        smallestMove_(kSmallestMove * input.net().cwiseAbs().maxCoeff()) {
    if (options.maxChangesPerPoint < kUnlimitedSteps) changes_.assign(static_cast<std::size_t>(net_.places()), 0);
  }

  StopReason run();
  void write(Faired<D>& result) const;

 private:
  using Place = typename RankedNet<D>::Place;

  Place next();
  void makeList();
  bool hungUp(double length);
  double frankWolfeBound() const;
  double dualBound();
  double factorBound();
  void certify(bool withDual);
  bool report() const;

  const Spline<D>& input_;
  const QuadraticEnergy<D>& quadratic_;
  const EnergyOperator<D>& energy_;
  const LocalFairingOptions& options_;
  const bool bounded_;
  RankedNet<D> net_;
  const double smallestMove_;

  std::vector<Index> changes_;                  // by place, only if they are limited
  std::vector<Place> list_;                     // the sorted ranking list, last first
  std::unique_ptr<FairingProblem<D>> problem_;  // for the dual bound, from the first time on
  BallProblem ball_;
  std::unique_ptr<FreeFactor> factor_;
  double gap_ = 0;
  double firstGap_ = kUnlimited;
  Index steps_ = 0;
  Index idleSteps_ = 0;  // in a row
};

// The place to be moved next, or -1 if no point gains enough.
template <int D>
typename LocalDescent<D>::Place LocalDescent<D>::next() {
  const auto ifEnough = [this](Place place) { return net_.gain(place) > options_.minGain ? place : -1; };
  if (options_.pointsPerList == 1) return ifEnough(net_.largest());
  while (!list_.empty()) {
    const Place place = list_.back();
    list_.pop_back();
    if (ifEnough(place) >= 0) return place;
  }
  makeList();
  const Place first = list_.back();
  list_.pop_back();
  return ifEnough(first);
}

template <int D>
void LocalDescent<D>::makeList() {
  list_ = net_.freePlaces();
  const Index count = std::min<Index>(options_.pointsPerList, static_cast<Index>(list_.size()));
  std::partial_sort(list_.begin(), list_.begin() + count, list_.end(), [this](Place a, Place b) {
    return net_.gain(a) > net_.gain(b) || (net_.gain(a) == net_.gain(b) && a < b);
  });
  list_.resize(static_cast<std::size_t>(count));
  std::reverse(list_.begin(), list_.end());
}

// Whether the points of a whole list did not move, so that the next list will be the same for ever.
template <int D>
bool LocalDescent<D>::hungUp(double length) {
  idleSteps_ = length > smallestMove_ ? 0 : idleSteps_ + 1;
  if (idleSteps_ == 0) return false;
  if (options_.ranking == RankingNumber::gain || !bounded_) return true;
  return changes_.empty() && idleSteps_ >= std::min<Index>(options_.pointsPerList, net_.places());
}

// E - E* <= sum of 2 h . e + 2 tolerance |h|, h half the gradient and e the move: what a linear model of E could lose
// within the balls.
template <int D>
double LocalDescent<D>::frankWolfeBound() const {
  double bound = 0;
  for (const Place place : net_.freePlaces()) {
    double product = 0;
    double square = 0;
    for (Index c = 0; c < net_.components(); ++c) {
      product += net_.gradient(place, c) * net_.shift(place, c);
      square += net_.gradient(place, c) * net_.gradient(place, c);
    }
    if (square > 0) bound += 2 * (product + options_.tolerance * std::sqrt(square));
  }
  return bound;
}

// The dual bound through a part of K that can be diagonalised (ball_minimizer.h), or through a factor of all of K for
// the energies of which no such part is known.
template <int D>
double LocalDescent<D>::dualBound() {
  const auto& places = net_.freePlaces();
  Net moves = Net::Zero(input_.net().rows(), net_.components());
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (Index c = 0; c < net_.components(); ++c) moves(net_.freeRows()[i], c) = net_.shift(places[i], c);
  }
  if (!problem_) {
    problem_ = std::make_unique<FairingProblem<D>>(input_, quadratic_, options_.held, options_.scale);
    ball_ = problem_->ball(options_.tolerance);
  }
  if (!ball_.lowerBound.empty()) {
    Field field(problem_->layout());
    packBox(problem_->layout(), moves, Eigen::RowVectorXd::Zero(net_.components()), field);
    const double bound = boundAt(ball_, field).bound;
    if (std::isfinite(bound)) return bound;
  }
  return static_cast<Index>(places.size()) <= factorLimit<D>() ? factorBound() : kUnlimited;
}

// With multipliers m >= 0 of the balls and r = h + m e, E - E* <= sum of m (tolerance^2 - |e|^2) + r^T K^-1 r.
template <int D>
double LocalDescent<D>::factorBound() {
  const auto& places = net_.freePlaces();
  if (!factor_) factor_ = std::make_unique<FreeFactor>(energy_, net_.freeRows());
  if (!factor_->usable()) return kUnlimited;
  const double ballSquare = options_.tolerance * options_.tolerance;
  Eigen::MatrixXd residual(static_cast<Index>(places.size()), net_.components());
  double bound = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    double product = 0;
    double square = 0;
    double targetSquare = 0;
    for (Index c = 0; c < net_.components(); ++c) {
      const double h = net_.gradient(places[i], c);
      const double e = net_.shift(places[i], c);
      const double target = e - h / net_.weight(places[i]);
      product += h * e;
      square += e * e;
      targetSquare += target * target;
    }
    const double multiplier = targetSquare > ballSquare && product < 0 ? -product / square : 0;
    if (multiplier > 0) bound += multiplier * (ballSquare - square);
    for (Index c = 0; c < net_.components(); ++c) {
      residual(static_cast<Index>(i), c) = net_.gradient(places[i], c) + multiplier * net_.shift(places[i], c);
    }
  }
  return bound + factor_->inverseNorm(residual);
}

template <int D>
void LocalDescent<D>::certify(bool withDual) {
  double bound = frankWolfeBound();
  if (withDual) bound = std::min(bound, dualBound());
  // An energy far below the first one is known to the rounding of that only.
  const double reference = std::max(std::abs(net_.energy()), kEnergyRounding * net_.startEnergy());
  gap_ = !(bound > 0) ? 0 : reference > 0 ? bound / reference : kUnlimited;
  if (!std::isfinite(firstGap_)) firstGap_ = gap_;
}

template <int D>
bool LocalDescent<D>::report() const {
  double fraction = -1;
  if (std::isfinite(firstGap_) && options_.gap > 0 && firstGap_ > options_.gap) {
    fraction = std::log(firstGap_ / std::max(gap_, options_.gap)) / std::log(firstGap_ / options_.gap);
  }
  if (options_.maxSteps < kUnlimitedSteps) {
    const auto allowed = static_cast<double>(std::max<Index>(options_.maxSteps, 1));
    fraction = std::max(fraction, static_cast<double>(steps_) / allowed);
  }
  return options_.progress.report(std::clamp(fraction, -1.0, 1.0),
                                  fmt::format("gap {:.1e} after {} steps", gap_, steps_));
}

template <int D>
StopReason LocalDescent<D>::run() {
  const auto freeCount = static_cast<Index>(net_.freeRows().size());
  if (freeCount == 0 || options_.tolerance == 0) return StopReason::nothingFree;
  Index nextBound = 0;
  Index nextDual = kSweepsBeforeDualBound * freeCount;
  Index nextReport = 0;
  StopReason reason{};
  while (true) {
    if (steps_ >= nextBound) {
      const bool dual = steps_ >= nextDual;
      certify(dual);
      if (gap_ <= options_.gap) return StopReason::gap;
      nextBound = steps_ + std::max<Index>(64, freeCount / 2);
      if (dual) nextDual = steps_ + steps_ / 5;
    }
    reason = StopReason::cancelled;
    if (steps_ >= nextReport) {
      if (!report()) break;
      nextReport = steps_ + kStepsPerReport;
    }
    reason = StopReason::steps;
    if (steps_ >= options_.maxSteps) break;
    reason = StopReason::gain;
    const Place place = next();
    if (place < 0) break;
    const double length = net_.moveToTarget(place);
    ++steps_;
    if (!changes_.empty() && ++changes_[static_cast<std::size_t>(place)] >= options_.maxChangesPerPoint) {
      net_.retire(place);
    }
    const bool literal = options_.ranking == RankingNumber::literal && bounded_;
    reason = literal ? StopReason::stalled : StopReason::precision;
    if (hungUp(length)) break;
  }
  certify(!bounded_ || problem_ != nullptr);
  return gap_ <= options_.gap && reason != StopReason::cancelled ? StopReason::gap : reason;
}

template <int D>
void LocalDescent<D>::write(Faired<D>& result) const {
  FairingSummary& summary = result.summary;
  auto net = result.spline.net();
  Eigen::RowVectorXd shift(net_.components());
  for (std::size_t i = 0; i < net_.freeRows().size(); ++i) {
    for (Index c = 0; c < net_.components(); ++c) shift[c] = net_.shift(net_.freePlaces()[i], c);
    const double length = shift.norm();
    if (length == 0) continue;
    if (length >= options_.tolerance * (1 - 1e-9)) ++summary.activePoints;
    // Far from the origin the sum rounds more coarsely than the move: then a little less of it keeps the ball.
    auto point = net.row(net_.freeRows()[i]);
    const auto original = input_.net().row(net_.freeRows()[i]);
    point = original + shift;
    for (double less = 0x1p-40; (point - original).norm() > options_.tolerance; less *= 4) {
      point = original + std::max(1 - less, 0.0) * shift;
    }
    summary.largestMove = std::max(summary.largestMove, (point - original).norm());
  }
  summary.energyBefore = net_.startEnergy();
  summary.energyAfter = net_.energy();
  summary.gap = gap_;
  summary.steps = steps_;
  summary.freePoints = static_cast<Index>(net_.freeRows().size());
}

template <int D>
void checkOptions(const Spline<D>& input, const LocalFairingOptions& options) {
  const auto check = [](bool good, const char* name, const char* wish) {
    if (!good) throw InvalidInput(fmt::format("the {} of local fairing must be {}", name, wish));
  };
  check(options.tolerance >= 0, "tolerance", "zero or more: give a length in the model's unit");
  check(options.gap >= 0, "gap", "zero or more: give e.g. 1e-6");
  check(options.minGain >= 0, "least gain", "zero or more: give an amount of energy");
  check(options.maxSteps >= 0, "number of steps", "zero or more");
  check(options.maxChangesPerPoint >= 1, "number of changes per point", "one or more");
  check(options.pointsPerList >= 1, "number of points per list", "one or more");
  if (!options.held.empty() && static_cast<Index>(options.held.size()) != input.net().rows()) {
    throw InvalidInput(fmt::format("the list of held points has {} entries but the net has {} points: give one a point",
                                   options.held.size(), input.net().rows()));
  }
}

// Without terms that see the value itself, the origin is free: the centre of the net keeps the most digits.
template <int D>
Net centredNet(const Spline<D>& input, const QuadraticEnergy<D>& energy) {
  const auto order = [](const std::array<int, D>& a) { return std::accumulate(a.begin(), a.end(), 0); };
  for (const auto& term : energy.terms) {
    if (order(term.a) == 0 || order(term.b) == 0) return input.net();
  }
  return input.net().rowwise() - input.net().colwise().mean();
}

}  // namespace

template <int D>
Faired<D> fairLocally(const Spline<D>& input, const QuadraticEnergy<D>& energy, const LocalFairingOptions& options) {
  const double start = threadSeconds();
  checkOptions(input, options);
  const EnergyOperator<D> op(energy, scaledKnots(input, options.scale));
  Faired<D> result{input, {}};
  LocalDescent<D> descent(input, centredNet(input, energy), energy, op, options);
  result.summary.stopReason = descent.run();
  descent.write(result);
  if (input.isRational() && !(result.spline.net().rightCols(1).minCoeff() > 0)) {
    throw Failure("a weight of the rational spline would no longer be positive: give a smaller tolerance");
  }
  result.summary.seconds = threadSeconds() - start;
  return result;
}

template Faired<1> fairLocally(const Spline<1>&, const QuadraticEnergy<1>&, const LocalFairingOptions&);
template Faired<2> fairLocally(const Spline<2>&, const QuadraticEnergy<2>&, const LocalFairingOptions&);
template Faired<3> fairLocally(const Spline<3>&, const QuadraticEnergy<3>&, const LocalFairingOptions&);

}  // namespace strak
