#include "strak/fairing/local_fairing.h"

#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "strak/base/cpu.h"
#include "strak/base/cpu_time.h"
#include "strak/base/error.h"
#include "strak/energy/energy_operator.h"
#include "strak/fairing/local_fairing_kernels.h"

namespace strak {

namespace ranking {

struct Kernels {
  decltype(&generic::moveAndRank) moveAndRank = STRAK_SIMD_CHOOSE(moveAndRank);
  decltype(&generic::rankAll) rankAll = STRAK_SIMD_CHOOSE(rankAll);
  decltype(&generic::refreshBlock) refreshBlock = STRAK_SIMD_CHOOSE(refreshBlock);
  decltype(&generic::largest) largest = STRAK_SIMD_CHOOSE(largest);
};

}  // namespace ranking

namespace {

// Points stay so far inside their ball that the rounding of the result cannot carry them out.
constexpr double kInside = 1 - 0x1p-50;
// Moves shorter than this part of the largest coordinate leave no trace in the result, however many follow.
constexpr double kSmallestMove = 0x1p-58;
// A point on its ball that would move by less than this part of the radius stays: that is rounding.
constexpr double kJitter = 0x1p-48;
// A weight below this part of the sum of its terms' sizes is rounding.
constexpr double kSmallestWeight = 1e-14;
// A pivot below this part of the largest is rounding: the matrix is singular.
constexpr double kSmallestPivot = 1e-13;
constexpr Index kStepsPerReport = 1 << 14;
// The dual bound begins after so many moves a free point, and is looked at again when the steps have grown by a third.
constexpr Index kSweepsBeforeDualBound = 16;

Index roundedUp(Index n, Index multiple) { return (n + multiple - 1) / multiple * multiple; }

template <int D>
constexpr Index factorLimit() {
  return D == 1 ? 1'000'000 : D == 2 ? 40'000 : 2'000;
}

// The free points' block of K, factored, for the dual bound.
class FreeFactor {
 public:
  template <int D>
  FreeFactor(const EnergyOperator<D>& energy, const Spline<D>& spline, const std::vector<Index>& free) {
    std::vector<Index> place(static_cast<std::size_t>(spline.net().rows()), -1);
    for (std::size_t i = 0; i < free.size(); ++i) place[static_cast<std::size_t>(free[i])] = static_cast<Index>(i);
    std::vector<Eigen::Triplet<double, Index>> entries;
    for (std::size_t i = 0; i < free.size(); ++i) {
      typename Spline<D>::Sizes index{};
      for (Index k = D - 1, rest = free[i]; k >= 0; --k) {
        index[static_cast<std::size_t>(k)] = rest % spline.size(static_cast<int>(k));
        rest /= spline.size(static_cast<int>(k));
      }
      const auto stencil = energy.row(index);
      for (std::size_t s = 0; s < stencil.values.size(); ++s) {
        typename Spline<D>::Sizes other{};
        auto rest = static_cast<Index>(s);
        for (std::size_t k = D; k-- > 0;) {
          other[k] = stencil.first[k] + rest % stencil.count[k];
          rest /= stencil.count[k];
        }
        const Index column = place[static_cast<std::size_t>(spline.row(other))];
        if (column >= 0 && column <= static_cast<Index>(i)) {
          entries.emplace_back(static_cast<Index>(i), column, stencil.values[s]);
        }
      }
    }
    Eigen::SparseMatrix<double> matrix(static_cast<Index>(free.size()), static_cast<Index>(free.size()));
    matrix.setFromTriplets(entries.begin(), entries.end());
    factor_.compute(matrix);
    if (factor_.info() != Eigen::Success) return;
    const Eigen::VectorXd pivots = factor_.vectorD();
    usable_ = pivots.minCoeff() > kSmallestPivot * pivots.cwiseAbs().maxCoeff();
  }

  // False if the energy leaves a motion of the free points unpunished: then there is no such bound.
  bool usable() const { return usable_; }
  // Sum over the columns r of r^T K^-1 r.
  double inverseNorm(const Eigen::MatrixXd& columns) const {
    return columns.cwiseProduct(factor_.solve(columns)).sum();
  }

 private:
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
  bool usable_ = false;
};

// The state of the method: gradient, moves and ranking numbers of all points.
template <int D>
class LocalDescent {
 public:
  // `net` is the input's, possibly with another origin.
  LocalDescent(const Spline<D>& input, const Net& net, const EnergyOperator<D>& energy,
               const LocalFairingOptions& options);

  StopReason run();
  void write(Faired<D>& result) const;

 private:
  static constexpr std::size_t kLast = D - 1;

  void layOut();
  void copyStencils();
  void fillPoints(const Net& net);
  void buildTournament();

  // Where component c of the point at `place` stands in gradient_ and shift_.
  template <class Component>
  std::size_t number(std::ptrdiff_t place, Component c) const {
    return static_cast<std::size_t>(static_cast<std::ptrdiff_t>(c) * grid_.plane + place);
  }
  template <class Component>
  double& shiftOf(std::ptrdiff_t place, Component c) {
    return shift_[number(place, c)];
  }

  std::ptrdiff_t next();
  double moveToTarget(std::ptrdiff_t place);
  void retire(std::ptrdiff_t place);

  double energyNow() const;
  double frankWolfeBound() const;
  double dualBound();
  void certify(bool withDual);
  bool report() const;

  const Spline<D>& input_;
  const EnergyOperator<D>& energy_;
  const LocalFairingOptions& options_;
  const ranking::Kernels kernels_;

  // Layout: row (i, j) of the padded leading directions, the last direction along the row.
  typename Spline<D>::Sizes sizes_, pad_{};
  ranking::Grid grid_{};
  ranking::Stencil stencil_{};
  std::vector<std::ptrdiff_t> offsets_;
  std::vector<Index> outerOfRow_;      // number of the unpadded row
  std::vector<double> outer_, inner_;  // parts of the stencils, per unpadded row and per column
  std::vector<double> gradient_, shift_, weight_, inverse_, gain_;
  std::vector<std::vector<double>> levels_;

  std::vector<Index> free_;             // rows of the net
  std::vector<std::ptrdiff_t> places_;  // of the free points
  Eigen::MatrixXd startGradient_;       // of the free points
  std::vector<Index> changes_;          // by place, only if they are limited
  std::vector<double> move_;
  std::vector<std::ptrdiff_t> list_;  // the sorted ranking list, last first
  std::unique_ptr<FreeFactor> factor_;

  double energyBefore_ = 0;
  double bound_ = kUnlimited;  // of E - E*
  double gap_ = kUnlimited;
  double firstGap_ = kUnlimited;
  double smallestMove_ = 0;
  Index steps_ = 0;
};

template <int D>
LocalDescent<D>::LocalDescent(const Spline<D>& input, const Net& net, const EnergyOperator<D>& energy,
                              const LocalFairingOptions& options)
    : input_(input), energy_(energy), options_(options), sizes_(input.sizes()) {
  layOut();
  copyStencils();
  fillPoints(net);
  buildTournament();
  kernels_.rankAll(grid_);
}

template <int D>
void LocalDescent<D>::layOut() {
  for (std::size_t k = 0; k < D; ++k) pad_[k] = input_.degree(static_cast<int>(k));
  stencil_.width = roundedUp(2 * pad_[kLast] + 1, 4);
  grid_.components = input_.net().cols();
  grid_.stride = roundedUp(sizes_[kLast] - 1 + stencil_.width, ranking::kBlock);
  // An even number of blocks would let neighbouring rows compete for the same places of the cache.
  if (grid_.stride >= 8 * ranking::kBlock && grid_.stride / ranking::kBlock % 2 == 0) grid_.stride += ranking::kBlock;
  grid_.rows = 1;
  for (std::size_t k = 0; k < kLast; ++k) grid_.rows *= sizes_[k] + 2 * pad_[k];
  grid_.plane = grid_.rows * grid_.stride + 8;
  grid_.radius = options_.ranking == RankingNumber::literal ? kUnlimited : options_.tolerance * kInside;

  offsets_.assign(1, 0);
  for (std::size_t k = 0; k < kLast; ++k) {
    std::vector<std::ptrdiff_t> longer;
    for (std::ptrdiff_t row : offsets_) {
      for (Index i = -pad_[k]; i <= pad_[k]; ++i) longer.push_back(row * (sizes_[k] + 2 * pad_[k]) + i);
    }
    offsets_ = longer;
  }
  for (std::ptrdiff_t& row : offsets_) row = row * grid_.stride - pad_[kLast];
  stencil_.rows = static_cast<std::ptrdiff_t>(offsets_.size());
  stencil_.rowsPerRun = D == 1 ? 1 : 2 * pad_[D == 3 ? 1 : 0] + 1;
  stencil_.offset = offsets_.data();
}

// K = sum over the different factors f of the last direction of A_f (x) V_f, A_f over the leading directions together.
template <int D>
void LocalDescent<D>::copyStencils() {
  const auto& lastFactors = energy_.factors(D - 1);
  std::vector<int> used;
  std::vector<std::size_t> number(lastFactors.size());
  for (const auto& term : energy_.terms()) {
    if (std::find(used.begin(), used.end(), term.factor[kLast]) == used.end()) {
      number[static_cast<std::size_t>(term.factor[kLast])] = used.size();
      used.push_back(term.factor[kLast]);
    }
  }
  const std::size_t factors = used.size();
  stencil_.factors = static_cast<std::ptrdiff_t>(factors);
  const auto width = static_cast<std::size_t>(stencil_.width);
  inner_.assign(static_cast<std::size_t>(sizes_[kLast]) * factors * width, 0);
  for (Index j = 0; j < sizes_[kLast]; ++j) {
    for (std::size_t f = 0; f < factors; ++f) {
      const auto row = lastFactors[static_cast<std::size_t>(used[f])].band.row(j);
      std::copy(row.begin(), row.end(),
                inner_.begin() + static_cast<std::ptrdiff_t>((static_cast<std::size_t>(j) * factors + f) * width));
    }
  }

  Index outerRows = 1;
  for (std::size_t k = 0; k < kLast; ++k) outerRows *= sizes_[k];
  outerOfRow_.assign(static_cast<std::size_t>(grid_.rows), -1);
  const std::size_t stencilRows = offsets_.size();
  outer_.assign(static_cast<std::size_t>(outerRows) * stencilRows * factors, 0);
  for (Index o = 0; o < outerRows; ++o) {
    std::array<Index, 3> index{};
    Index padded = 0;
    for (Index k = D - 2, rest = o, step = 1; k >= 0; --k) {
      const auto d = static_cast<std::size_t>(k);
      index[d] = rest % sizes_[d];
      padded += (index[d] + pad_[d]) * step;
      step *= sizes_[d] + 2 * pad_[d];
      rest /= sizes_[d];
    }
    outerOfRow_[static_cast<std::size_t>(padded)] = o;
    double* table = outer_.data() + static_cast<std::size_t>(o) * stencilRows * factors;
    for (const auto& term : energy_.terms()) {
      for (std::size_t s = 0; s < stencilRows; ++s) {
        double value = term.coefficient;
        auto rest = static_cast<Index>(s);
        for (std::size_t k = kLast; k-- > 0;) {
          const auto& band = energy_.factors(static_cast<int>(k))[static_cast<std::size_t>(term.factor[k])].band;
          value *= band(index[k], rest % (2 * pad_[k] + 1));
          rest /= 2 * pad_[k] + 1;
        }
        table[s * factors + number[static_cast<std::size_t>(term.factor[kLast])]] += value;
      }
    }
  }
}

template <int D>
void LocalDescent<D>::fillPoints(const Net& net) {
  const Index components = grid_.components;
  const auto places = static_cast<std::size_t>(grid_.rows * grid_.stride);
  gradient_.assign(static_cast<std::size_t>(components * grid_.plane), 0);
  shift_ = gradient_;
  weight_.assign(places, 0);
  inverse_.assign(places, 0);
  gain_.assign(places, 0);
  move_.assign(static_cast<std::size_t>(components), 0);

  const Net product = energy_.product(net);
  energyBefore_ = net.cwiseProduct(product).sum();
  double largestWeight = 0;
  Index r = 0;
  for (Index row = 0; row < grid_.rows; ++row) {
    const Index outer = outerOfRow_[static_cast<std::size_t>(row)];
    if (outer < 0) continue;
    for (Index j = 0; j < sizes_[kLast]; ++j, ++r) {
      const Index place = row * grid_.stride + pad_[kLast] + j;
      for (Index c = 0; c < components; ++c)
        gradient_[static_cast<std::size_t>(c * grid_.plane + place)] = product(r, c);
      typename Spline<D>::Sizes index{};
      for (std::size_t k = D; k-- > 0;) {
        Index rest = r;
        for (std::size_t l = D - 1; l > k; --l) rest /= sizes_[l];
        index[k] = rest % sizes_[k];
      }
      const auto diagonal = [&](std::size_t k, int factor) {
        return energy_.factors(static_cast<int>(k))[static_cast<std::size_t>(factor)](index[k], index[k]);
      };
      bool seenByDomain = true;
      for (std::size_t k = 0; k < D; ++k) seenByDomain = seenByDomain && diagonal(k, 0) > 0;
      if (!seenByDomain || (!options_.held.empty() && options_.held[static_cast<std::size_t>(r)] != 0)) continue;
      double weight = 0;
      double size = 0;
      for (const auto& term : energy_.terms()) {
        double value = term.coefficient;
        for (std::size_t k = 0; k < D; ++k) value *= diagonal(k, term.factor[k]);
        weight += value;
        size += std::abs(value);
      }
      if (!(weight > kSmallestWeight * size)) {
        throw InvalidInput(
            fmt::format("the energy does not see control point {}, which is free: hold it, raise the degree "
                        "or choose an energy of lower order",
                        r));
      }
      weight_[static_cast<std::size_t>(place)] = weight;
      inverse_[static_cast<std::size_t>(place)] = 1 / weight;
      largestWeight = std::max(largestWeight, weight);
      free_.push_back(r);
      places_.push_back(place);
    }
  }
  if (!std::isfinite(energyBefore_ * largestWeight)) {
    throw InvalidInput("the energy of the spline is too large for double precision: use a larger unit of length");
  }
  startGradient_.resize(static_cast<Index>(free_.size()), components);
  for (std::size_t i = 0; i < free_.size(); ++i) startGradient_.row(static_cast<Index>(i)) = product.row(free_[i]);
  smallestMove_ = kSmallestMove * input_.net().cwiseAbs().maxCoeff();
  if (options_.maxChangesPerPoint < kUnlimitedSteps) changes_.assign(places, 0);

  grid_.gradient = gradient_.data();
  grid_.shift = shift_.data();
  grid_.weight = weight_.data();
  grid_.inverse = inverse_.data();
  grid_.gain = gain_.data();
}

template <int D>
void LocalDescent<D>::buildTournament() {
  Index nodes = grid_.rows * (grid_.stride / ranking::kBlock);
  while (true) {
    levels_.emplace_back(static_cast<std::size_t>(roundedUp(nodes, ranking::kFanOut)), -1);
    if (nodes == 1) break;
    nodes = (nodes + ranking::kFanOut - 1) / ranking::kFanOut;
  }
  grid_.levels = static_cast<std::ptrdiff_t>(levels_.size());
  for (std::size_t l = 0; l < levels_.size(); ++l) grid_.level[l] = levels_[l].data();
}

// The place to be moved next, or -1 if no point gains enough.
template <int D>
std::ptrdiff_t LocalDescent<D>::next() {
  if (options_.pointsPerList == 1) {
    const std::ptrdiff_t place = kernels_.largest(grid_);
    return gain_[static_cast<std::size_t>(place)] > options_.minGain ? place : -1;
  }
  const auto gainOf = [this](std::ptrdiff_t place) { return gain_[static_cast<std::size_t>(place)]; };
  while (!list_.empty()) {
    const std::ptrdiff_t place = list_.back();
    list_.pop_back();
    if (gainOf(place) > options_.minGain) return place;
  }
  const auto before = [&](std::ptrdiff_t a, std::ptrdiff_t b) {
    return gainOf(a) > gainOf(b) || (gainOf(a) == gainOf(b) && a < b);
  };
  list_ = places_;
  const Index count = std::min<Index>(options_.pointsPerList, static_cast<Index>(list_.size()));
  std::partial_sort(list_.begin(), list_.begin() + count, list_.end(), before);
  list_.resize(static_cast<std::size_t>(count));
  std::reverse(list_.begin(), list_.end());
  const std::ptrdiff_t first = list_.back();
  list_.pop_back();
  return gainOf(first) > options_.minGain ? first : -1;
}

// Moves the point to its target, or to the ball's point nearest to the target (14); returns the length of the move.
template <int D>
double LocalDescent<D>::moveToTarget(std::ptrdiff_t place) {
  const double inverse = 1 / weight_[static_cast<std::size_t>(place)];
  double square = 0;
  for (std::size_t c = 0; c < move_.size(); ++c) {
    move_[c] = shiftOf(place, c) - gradient_[number(place, c)] * inverse;
    square += move_[c] * move_[c];
  }
  const double radius = options_.tolerance * kInside;
  const double factor = square > radius * radius ? radius / std::sqrt(square) : 1;
  double length = 0;
  for (std::size_t c = 0; c < move_.size(); ++c) {
    move_[c] = move_[c] * factor - shiftOf(place, c);
    length += move_[c] * move_[c];
  }
  length = std::sqrt(length);
  if (factor < 1 && length <= kJitter * options_.tolerance) return 0;
  for (std::size_t c = 0; c < move_.size(); ++c) shiftOf(place, c) += move_[c];
  const std::ptrdiff_t row = place / grid_.stride;
  const std::ptrdiff_t column = place - row * grid_.stride - pad_[kLast];
  stencil_.outer = outer_.data() + outerOfRow_[static_cast<std::size_t>(row)] * stencil_.rows * stencil_.factors;
  stencil_.inner = inner_.data() + column * stencil_.factors * stencil_.width;
  kernels_.moveAndRank(grid_, stencil_, place, move_.data());
  return length;
}

template <int D>
void LocalDescent<D>::retire(std::ptrdiff_t place) {
  inverse_[static_cast<std::size_t>(place)] = 0;
  gain_[static_cast<std::size_t>(place)] = 0;
  kernels_.refreshBlock(grid_, place);
}

// E - E0 = sum of e . (h0 + h), free of the cancellation in d . K d.
template <int D>
double LocalDescent<D>::energyNow() const {
  double change = 0;
  for (std::size_t i = 0; i < free_.size(); ++i) {
    for (Index c = 0; c < grid_.components; ++c) {
      const auto at = static_cast<std::size_t>(c * grid_.plane + places_[i]);
      change += shift_[at] * (startGradient_(static_cast<Index>(i), c) + gradient_[at]);
    }
  }
  return energyBefore_ + change;
}

// E - E* <= sum of 2 h . e + 2 tolerance |h|: what a linear model of E could lose within the balls.
template <int D>
double LocalDescent<D>::frankWolfeBound() const {
  double bound = 0;
  for (const std::ptrdiff_t place : places_) {
    double product = 0;
    double square = 0;
    for (Index c = 0; c < grid_.components; ++c) {
      const auto at = static_cast<std::size_t>(c * grid_.plane + place);
      product += gradient_[at] * shift_[at];
      square += gradient_[at] * gradient_[at];
    }
    if (square > 0) bound += 2 * (product + options_.tolerance * std::sqrt(square));
  }
  return bound;
}

// With multipliers m >= 0 of the balls and r = h + m e, E - E* <= sum of m (tolerance^2 - |e|^2) + r^T K^-1 r.
template <int D>
double LocalDescent<D>::dualBound() {
  if (static_cast<Index>(free_.size()) > factorLimit<D>()) return kUnlimited;
  if (!factor_) factor_ = std::make_unique<FreeFactor>(energy_, input_, free_);
  if (!factor_->usable()) return kUnlimited;
  Eigen::MatrixXd residual(static_cast<Index>(free_.size()), grid_.components);
  double bound = 0;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const auto place = static_cast<std::size_t>(places_[i]);
    double product = 0;
    double square = 0;
    double targetSquare = 0;
    for (Index c = 0; c < grid_.components; ++c) {
      const auto at = static_cast<std::size_t>(c * grid_.plane) + place;
      product += gradient_[at] * shift_[at];
      square += shift_[at] * shift_[at];
      const double target = shift_[at] - gradient_[at] / weight_[place];
      targetSquare += target * target;
    }
    const double radius = options_.tolerance;
    const double multiplier = targetSquare > radius * radius && product < 0 ? -product / square : 0;
    if (multiplier > 0) bound += multiplier * (radius * radius - square);
    for (Index c = 0; c < grid_.components; ++c) {
      const auto at = static_cast<std::size_t>(c * grid_.plane) + place;
      residual(static_cast<Index>(i), c) = gradient_[at] + multiplier * shift_[at];
    }
  }
  return bound + factor_->inverseNorm(residual);
}

template <int D>
void LocalDescent<D>::certify(bool withDual) {
  bound_ = frankWolfeBound();
  if (withDual) bound_ = std::min(bound_, dualBound());
  bound_ = std::max(bound_, 0.0);
  gap_ = bound_ == 0 ? 0 : bound_ / std::abs(energyNow());
  if (!std::isfinite(firstGap_)) firstGap_ = gap_;
}

template <int D>
bool LocalDescent<D>::report() const {
  double fraction = -1;
  if (std::isfinite(firstGap_) && options_.gap > 0 && firstGap_ > options_.gap) {
    fraction = std::log(firstGap_ / std::max(gap_, options_.gap)) / std::log(firstGap_ / options_.gap);
  }
  if (options_.maxSteps < kUnlimitedSteps) {
    fraction =
        std::max(fraction, static_cast<double>(steps_) / static_cast<double>(std::max<Index>(options_.maxSteps, 1)));
  }
  return options_.progress.report(std::clamp(fraction, -1.0, 1.0),
                                  fmt::format("gap {:.1e} after {} steps", gap_, steps_));
}

template <int D>
StopReason LocalDescent<D>::run() {
  const auto count = static_cast<Index>(free_.size());
  gap_ = 0;
  if (count == 0 || options_.tolerance == 0) return StopReason::nothingFree;
  const bool bounded = std::isfinite(options_.tolerance);
  const Index betweenBounds = std::max<Index>(64, count / 2);
  Index nextBound = 0;
  Index nextDual = kSweepsBeforeDualBound * count;
  Index nextReport = 0;
  Index idle = 0;
  StopReason reason{};
  while (true) {
    if (steps_ >= nextBound) {
      const bool dual = steps_ >= nextDual;
      certify(dual);
      if (gap_ <= options_.gap) return StopReason::gap;
      nextBound = steps_ + betweenBounds;
      if (dual) nextDual = steps_ + steps_ / 3;
    }
    if (steps_ >= nextReport) {
      reason = StopReason::cancelled;
      if (!report()) break;
      nextReport = steps_ + kStepsPerReport;
    }
    reason = StopReason::steps;
    if (steps_ >= options_.maxSteps) break;
    reason = StopReason::gain;
    const std::ptrdiff_t place = next();
    if (place < 0) break;
    const double length = moveToTarget(place);
    ++steps_;
    if (!changes_.empty() && ++changes_[static_cast<std::size_t>(place)] >= options_.maxChangesPerPoint) retire(place);

    if (length > smallestMove_) {
      idle = 0;
      continue;
    }
    if (bounded && options_.ranking == RankingNumber::literal) {
      if (!changes_.empty() || ++idle < options_.pointsPerList) continue;
      reason = StopReason::stalled;
    } else {
      reason = StopReason::precision;
    }
    break;
  }
  certify(!bounded || factor_ != nullptr);
  return gap_ <= options_.gap && reason != StopReason::cancelled ? StopReason::gap : reason;
}

template <int D>
void LocalDescent<D>::write(Faired<D>& result) const {
  FairingSummary& summary = result.summary;
  auto net = result.spline.net();
  for (std::size_t i = 0; i < free_.size(); ++i) {
    Eigen::RowVectorXd shift(grid_.components);
    for (Index c = 0; c < grid_.components; ++c)
      shift[c] = shift_[static_cast<std::size_t>(c * grid_.plane + places_[i])];
    if (shift.norm() >= options_.tolerance * (1 - 1e-9)) ++summary.activePoints;
    // Far from the origin the sum rounds more coarsely than the move: then a little less of it keeps the ball.
    auto point = net.row(free_[i]);
    const auto original = input_.net().row(free_[i]);
    point = original + shift;
    for (double part = 1 - 0x1p-40; (point - original).norm() > options_.tolerance; part = 1 - 4 * (1 - part)) {
      point = original + std::max(part, 0.0) * shift;
    }
    summary.largestMove = std::max(summary.largestMove, (point - original).norm());
  }
  summary.energyBefore = energyBefore_;
  summary.energyAfter = energyNow();
  summary.gap = gap_;
  summary.steps = steps_;
  summary.freePoints = static_cast<Index>(free_.size());
}

template <int D>
void checkOptions(const Spline<D>& input, const LocalFairingOptions& options) {
  const auto check = [](bool good, const char* name, const char* wish) {
    if (!good) throw InvalidInput(fmt::format("the {} of local fairing {}", name, wish));
  };
  check(options.tolerance >= 0, "tolerance", "must be zero or more: give a length in the model's unit");
  check(options.gap >= 0, "gap", "must be zero or more: give e.g. 1e-6");
  check(options.minGain >= 0, "least gain", "must be zero or more");
  check(options.maxSteps >= 0, "number of steps", "must be zero or more");
  check(options.maxChangesPerPoint >= 1, "number of changes per point", "must be one or more");
  check(options.pointsPerList >= 1, "number of points per list", "must be one or more");
  if (!options.held.empty() && static_cast<Index>(options.held.size()) != input.net().rows()) {
    throw InvalidInput(fmt::format("the list of held points has {} entries but the net has {} points: give one a point",
                                   options.held.size(), input.net().rows()));
  }
}

// Without terms that see the value itself, the origin is free: the centre of the net keeps the most digits.
template <int D>
Net centredNet(const Spline<D>& input, const QuadraticEnergy<D>& energy) {
  const auto order = [](const std::array<int, D>& a) { return std::accumulate(a.begin(), a.end(), 0); };
  const bool originIsFree = std::all_of(energy.terms.begin(), energy.terms.end(),
                                        [&](const auto& term) { return order(term.a) > 0 && order(term.b) > 0; });
  return originIsFree ? Net(input.net().rowwise() - input.net().colwise().mean()) : input.net();
}

}  // namespace

template <int D>
Faired<D> fairLocally(const Spline<D>& input, const QuadraticEnergy<D>& energy, const LocalFairingOptions& options) {
  const double start = threadSeconds();
  checkOptions(input, options);
  const EnergyOperator<D> op(energy, scaledKnots(input, options.scale));
  Faired<D> result{input, {}};
  LocalDescent<D> descent(input, centredNet(input, energy), op, options);
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
