#include "strak/fairing/ranked_net.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "strak/base/cpu.h"
#include "strak/base/error.h"

namespace strak {

namespace {

// Points stay so far inside their ball that the rounding of the moves cannot carry them out.
constexpr double kInside = 1 - 0x1p-50;
// A point on its ball that would move by less than this part of the radius stays: that is rounding.
constexpr double kJitter = 0x1p-48;
// A weight below this part of the sum of its terms' sizes is rounding.
constexpr double kSmallestWeight = 1e-14;

Index roundedUp(Index n, Index multiple) { return (n + multiple - 1) / multiple * multiple; }

}  // namespace

namespace ranking {

const Kernels& chosen() {
  static const Kernels kernels{STRAK_SIMD_CHOOSE(moveAndRank), STRAK_SIMD_CHOOSE(rankAll),
                               STRAK_SIMD_CHOOSE(refreshBlock), STRAK_SIMD_CHOOSE(largest)};
  return kernels;
}

}  // namespace ranking

template <int D>
RankedNet<D>::RankedNet(const EnergyOperator<D>& energy, const Net& net, const HeldPoints& held, double radius,
                        double rankingRadius)
    : radius_(radius), sizes_(energy.sizes()) {
  for (std::size_t k = 0; k < D; ++k) pad_[k] = energy.factors(static_cast<int>(k)).front().bandwidth;
  grid_.components = net.cols();
  grid_.radius = rankingRadius * kInside;
  layOut();
  copyLastDirection(energy);
  copyLeadingDirections(energy);
  fillPoints(energy, net, held);
  buildTournament();
  kernels_.rankAll(grid_);
}

template <int D>
void RankedNet<D>::layOut() {
  stencil_.width = roundedUp(2 * pad_[kLast] + 1, 4);
  grid_.stride = roundedUp(sizes_[kLast] - 1 + stencil_.width, ranking::kBlock);
  // An even number of blocks would let neighbouring rows compete for the same places of the cache.
  if (grid_.stride >= 8 * ranking::kBlock && grid_.stride / ranking::kBlock % 2 == 0) grid_.stride += ranking::kBlock;
  grid_.rows = 1;
  offsets_.assign(1, 0);
  for (std::size_t k = 0; k < kLast; ++k) {
    const Index paddedSize = sizes_[k] + 2 * pad_[k];
    grid_.rows *= paddedSize;
    std::vector<std::ptrdiff_t> longer;
    for (std::ptrdiff_t row : offsets_) {
      for (Index i = -pad_[k]; i <= pad_[k]; ++i) longer.push_back(row * paddedSize + i);
    }
    offsets_ = longer;
  }
  for (std::ptrdiff_t& row : offsets_) row = row * grid_.stride - pad_[kLast];
  grid_.plane = grid_.rows * grid_.stride + 8;
  stencil_.rows = static_cast<std::ptrdiff_t>(offsets_.size());
  stencil_.rowsPerRun = D == 1 ? 1 : 2 * pad_[D == 3 ? 1 : 0] + 1;
  stencil_.offset = offsets_.data();
}

// K = sum over the different factors V_f of the last direction of A_f (x) V_f, A_f over the leading directions
// together.
template <int D>
void RankedNet<D>::copyLastDirection(const EnergyOperator<D>& energy) {
  std::vector<int> used;
  for (const auto& term : energy.terms()) {
    const int factor = term.factor[kLast];
    const auto known = std::find(used.begin(), used.end(), factor);
    lastFactor_.push_back(static_cast<std::size_t>(known - used.begin()));
    if (known == used.end()) used.push_back(factor);
  }
  stencil_.factors = static_cast<std::ptrdiff_t>(used.size());
  inner_.assign(static_cast<std::size_t>(sizes_[kLast] * stencil_.factors * stencil_.width), 0);
  auto target = inner_.begin();
  for (Index j = 0; j < sizes_[kLast]; ++j) {
    for (int factor : used) {
      const auto row = energy.factors(D - 1)[static_cast<std::size_t>(factor)].band.row(j);
      std::copy(row.begin(), row.end(), target);
      target += stencil_.width;
    }
  }
}

template <int D>
void RankedNet<D>::copyLeadingDirections(const EnergyOperator<D>& energy) {
  Index rows = 1;
  for (std::size_t k = 0; k < kLast; ++k) rows *= sizes_[k];
  unpadded_.assign(static_cast<std::size_t>(grid_.rows), -1);
  const std::size_t tableSize = offsets_.size() * static_cast<std::size_t>(stencil_.factors);
  outer_.assign(static_cast<std::size_t>(rows) * tableSize, 0);
  for (Index r = 0; r < rows; ++r) {
    std::array<Index, 3> index{};
    Index rest = r;
    for (std::size_t k = kLast; k-- > 0;) {
      index[k] = rest % sizes_[k];
      rest /= sizes_[k];
    }
    Index padded = 0;
    for (std::size_t k = 0; k < kLast; ++k) padded = padded * (sizes_[k] + 2 * pad_[k]) + index[k] + pad_[k];
    unpadded_[static_cast<std::size_t>(padded)] = r;

    double* table = outer_.data() + static_cast<std::size_t>(r) * tableSize;
    for (std::size_t t = 0; t < energy.terms().size(); ++t) {
      const auto& term = energy.terms()[t];
      for (std::size_t s = 0; s < offsets_.size(); ++s) {
        double value = term.coefficient;
        rest = static_cast<Index>(s);
        for (std::size_t k = kLast; k-- > 0;) {
          const auto& factor = energy.factors(static_cast<int>(k))[static_cast<std::size_t>(term.factor[k])];
          value *= factor.band(index[k], rest % (2 * pad_[k] + 1));
          rest /= 2 * pad_[k] + 1;
        }
        table[s * static_cast<std::size_t>(stencil_.factors) + lastFactor_[t]] += value;
      }
    }
  }
}

template <int D>
void RankedNet<D>::fillPoints(const EnergyOperator<D>& energy, const Net& net, const HeldPoints& held) {
  const auto points = static_cast<std::size_t>(grid_.rows * grid_.stride);
  gradient_.assign(static_cast<std::size_t>(components() * grid_.plane), 0);
  shift_ = gradient_;
  weight_.assign(points, 0);
  inverse_.assign(points, 0);
  gain_.assign(points, 0);
  move_.assign(static_cast<std::size_t>(components()), 0);
  grid_.gradient = gradient_.data();
  grid_.shift = shift_.data();
  grid_.weight = weight_.data();
  grid_.inverse = inverse_.data();
  grid_.gain = gain_.data();

  const Net product = energy.product(net);
  startEnergy_ = net.cwiseProduct(product).sum();
  double largestWeight = 0;
  Index r = 0;
  for (Index row = 0; row < grid_.rows; ++row) {
    if (unpadded_[static_cast<std::size_t>(row)] < 0) continue;
    for (Index j = 0; j < sizes_[kLast]; ++j, ++r) {
      const Place place = row * grid_.stride + pad_[kLast] + j;
      for (Index c = 0; c < components(); ++c) gradient_[number(place, c)] = product(r, c);
      if (!held.empty() && held[static_cast<std::size_t>(r)] != 0) continue;

      std::array<Index, D> index{};
      Index rest = r;
      for (std::size_t k = D; k-- > 0;) {
        index[k] = rest % sizes_[k];
        rest /= sizes_[k];
      }
      const auto diagonal = [&](std::size_t k, int factor) {
        return energy.factors(static_cast<int>(k))[static_cast<std::size_t>(factor)](index[k], index[k]);
      };
      // The first factor of every direction is the mass matrix.
      bool inDomain = true;
      for (std::size_t k = 0; k < D; ++k) inDomain = inDomain && diagonal(k, 0) > 0;
      if (!inDomain) continue;
      double weight = 0;
      double size = 0;
      for (const auto& term : energy.terms()) {
        double value = term.coefficient;
        for (std::size_t k = 0; k < D; ++k) value *= diagonal(k, term.factor[k]);
        weight += value;
        size += std::abs(value);
      }
      if (!(weight > kSmallestWeight * size)) {
        throw InvalidInput(
            fmt::format("the energy does not see control point {}, which is free: hold it, raise the "
                        "degree or choose an energy of lower order",
                        r));
      }
      weight_[static_cast<std::size_t>(place)] = weight;
      inverse_[static_cast<std::size_t>(place)] = 1 / weight;
      largestWeight = std::max(largestWeight, weight);
      freeRows_.push_back(r);
      freePlaces_.push_back(place);
      for (Index c = 0; c < components(); ++c) startGradient_.push_back(product(r, c));
    }
  }
  if (!std::isfinite(startEnergy_ * largestWeight)) {
    throw InvalidInput("the energy of the spline is too large for double precision: use a larger unit of length");
  }
}

template <int D>
void RankedNet<D>::buildTournament() {
  Index nodes = grid_.rows * (grid_.stride / ranking::kBlock);
  levels_.emplace_back(static_cast<std::size_t>(roundedUp(nodes, ranking::kFanOut)), -1);
  while (nodes > 1) {
    nodes = (nodes + ranking::kFanOut - 1) / ranking::kFanOut;
    levels_.emplace_back(static_cast<std::size_t>(roundedUp(nodes, ranking::kFanOut)), -1);
  }
  grid_.levels = static_cast<std::ptrdiff_t>(levels_.size());
  for (std::size_t l = 0; l < levels_.size(); ++l) grid_.level[l] = levels_[l].data();
}

template <int D>
double RankedNet<D>::moveToTarget(Place place) {
  const double inverse = 1 / weight(place);
  double square = 0;
  for (Index c = 0; c < components(); ++c) {
    const double target = shift(place, c) - gradient(place, c) * inverse;
    move_[static_cast<std::size_t>(c)] = target;
    square += target * target;
  }
  const double radius = radius_ * kInside;
  const double factor = square > radius * radius ? radius / std::sqrt(square) : 1;
  double length = 0;
  for (Index c = 0; c < components(); ++c) {
    double& move = move_[static_cast<std::size_t>(c)];
    move = move * factor - shift(place, c);
    length += move * move;
  }
  length = std::sqrt(length);
  if (factor < 1 && length <= kJitter * radius_) return 0;
  for (Index c = 0; c < components(); ++c) shift_[number(place, c)] += move_[static_cast<std::size_t>(c)];

  const Index row = place / grid_.stride;
  const Index column = place - row * grid_.stride - pad_[kLast];
  stencil_.outer = outer_.data() + unpadded_[static_cast<std::size_t>(row)] * stencil_.rows * stencil_.factors;
  stencil_.inner = inner_.data() + column * stencil_.factors * stencil_.width;
  kernels_.moveAndRank(grid_, stencil_, place, move_.data());
  return length;
}

template <int D>
void RankedNet<D>::retire(Place place) {
  inverse_[static_cast<std::size_t>(place)] = 0;
  gain_[static_cast<std::size_t>(place)] = 0;
  kernels_.refreshBlock(grid_, place);
}

// E - E0 = sum of e . (h0 + h), free of the cancellation in d . K d.
template <int D>
double RankedNet<D>::energy() const {
  double change = 0;
  const double* start = startGradient_.data();
  for (Place place : freePlaces_) {
    for (Index c = 0; c < components(); ++c) change += shift(place, c) * (*start++ + gradient(place, c));
  }
  return startEnergy_ + change;
}

template class RankedNet<1>;
template class RankedNet<2>;
template class RankedNet<3>;

}  // namespace strak
