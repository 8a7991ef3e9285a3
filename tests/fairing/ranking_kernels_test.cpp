#include "strak/fairing/ranking_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "strak/base/cpu.h"
#include "tests/spline/random_splines.h"

namespace strak::ranking {
namespace {

using strak::testing::Random;

// Random points on a padded grid, with the arrays that the kernels work on.
struct Sample {
  static constexpr std::ptrdiff_t kPad = 4, kStencilRows = 2 * kPad + 1, kWidth = 12, kFactors = 3;
  std::vector<double> gradient, shift, weight, inverse, gain;
  std::vector<std::vector<double>> levels;
  std::vector<std::ptrdiff_t> offsets;
  std::vector<double> outer, inner;
  Grid grid{};
  Stencil stencil{};

  Sample(std::ptrdiff_t components, std::ptrdiff_t rows, std::ptrdiff_t columns, double radius, std::uint64_t seed) {
    Random random(seed);
    grid.components = components;
    grid.stride = (columns - 1 + kWidth + kBlock - 1) / kBlock * kBlock;
    grid.rows = rows + 2 * kPad;
    grid.plane = grid.rows * grid.stride + 8;
    grid.radius = radius;
    const auto points = static_cast<std::size_t>(grid.rows * grid.stride);
    gradient.assign(static_cast<std::size_t>(grid.plane * components), 0);
    shift = gradient;
    weight.assign(points, 0);
    inverse = gain = weight;
    for (std::ptrdiff_t i = 0; i < rows; ++i) {
      for (std::ptrdiff_t j = 0; j < columns; ++j) {
        const auto place = static_cast<std::size_t>((i + kPad) * grid.stride + kPad + j);
        const bool free = random.integer(0, 4) > 0;
        weight[place] = free ? random.uniform(0.5, 2) : 0;
        inverse[place] = free ? 1 / weight[place] : 0;
        for (std::ptrdiff_t c = 0; c < components; ++c) {
          const std::size_t at = static_cast<std::size_t>(c * grid.plane) + place;
          gradient[at] = random.uniform(-1, 1);
          const double reach = std::isinf(radius) ? 1 : radius;
          shift[at] = free ? random.uniform(-reach, reach) / std::sqrt(static_cast<double>(components)) : 0;
        }
      }
    }
    std::ptrdiff_t nodes = grid.rows * grid.stride / kBlock;
    while (true) {
      levels.emplace_back(static_cast<std::size_t>((nodes + kFanOut - 1) / kFanOut * kFanOut), -1);
      if (nodes == 1) break;
      nodes = (nodes + kFanOut - 1) / kFanOut;
    }
    for (std::ptrdiff_t i = -kPad; i <= kPad; ++i) offsets.push_back(i * grid.stride - kPad);
    for (std::ptrdiff_t i = 0; i < kStencilRows * kFactors; ++i) outer.push_back(random.uniform(-1, 1));
    for (std::ptrdiff_t i = 0; i < kFactors * kWidth; ++i) {
      inner.push_back(i % kWidth < kStencilRows ? random.uniform(-1, 1) : 0);
    }
    connect();
  }
  Sample(const Sample&) = delete;
  Sample& operator=(const Sample&) = delete;

  void connect() {
    grid.gradient = gradient.data();
    grid.shift = shift.data();
    grid.weight = weight.data();
    grid.inverse = inverse.data();
    grid.gain = gain.data();
    grid.levels = static_cast<std::ptrdiff_t>(levels.size());
    for (std::size_t l = 0; l < levels.size(); ++l) grid.level[l] = levels[l].data();
    stencil = {kStencilRows, kStencilRows, kWidth, kFactors, offsets.data(), outer.data(), inner.data()};
  }

  double expectedGain(std::size_t place) const {
    double unclipped = 0;
    double distance = 0;
    for (std::ptrdiff_t c = 0; c < grid.components; ++c) {
      const std::size_t at = static_cast<std::size_t>(c * grid.plane) + place;
      const double target = shift[at] - gradient[at] * inverse[place];
      unclipped += gradient[at] * gradient[at] * inverse[place];
      distance += target * target;
    }
    const double outside = std::max(0.0, std::sqrt(distance) - grid.radius);
    return unclipped - (std::isinf(grid.radius) ? 0 : weight[place] * outside * outside);
  }

  void expectTrue() const {
    for (std::size_t place = 0; place < gain.size(); ++place) EXPECT_NEAR(gain[place], expectedGain(place), 1e-12);
    EXPECT_EQ(levels.back()[0], *std::max_element(gain.begin(), gain.end()));
  }
};

void check(const Kernels& kernels) {
  for (std::ptrdiff_t components : {1, 2, 3, 4, 7}) {
    for (double radius : {std::numeric_limits<double>::infinity(), 0.3}) {
      Sample sample(components, 11, components == 2 ? 130 : 23, radius, 100 + static_cast<std::uint64_t>(components));
      kernels.rankAll(sample.grid);
      sample.expectTrue();
      for (int step = 0; step < 5; ++step) {
        const std::ptrdiff_t place = kernels.largest(sample.grid);
        EXPECT_EQ(sample.gain[static_cast<std::size_t>(place)], sample.levels.back()[0]);
        const std::vector<double> before = sample.gradient;
        std::vector<double> move;
        for (std::ptrdiff_t c = 0; c < components; ++c) move.push_back(0.1 * static_cast<double>(c + 1));
        kernels.moveAndRank(sample.grid, sample.stencil, place, move.data());
        for (std::ptrdiff_t i = 0; i < Sample::kStencilRows; ++i) {
          for (std::ptrdiff_t j = 0; j < Sample::kStencilRows; ++j) {
            double value = 0;
            for (std::ptrdiff_t f = 0; f < Sample::kFactors; ++f) {
              value += sample.outer[static_cast<std::size_t>(i * Sample::kFactors + f)] *
                       sample.inner[static_cast<std::size_t>(f * Sample::kWidth + j)];
            }
            const auto at = static_cast<std::size_t>(place + sample.offsets[static_cast<std::size_t>(i)] + j);
            EXPECT_NEAR(sample.gradient[at], before[at] + value * move[0], 1e-14);
          }
        }
        sample.expectTrue();
        // The chosen point leaves the list.
        sample.inverse[static_cast<std::size_t>(place)] = 0;
        sample.gain[static_cast<std::size_t>(place)] = 0;
        sample.weight[static_cast<std::size_t>(place)] = 0;
        kernels.refreshBlock(sample.grid, place);
        EXPECT_NE(kernels.largest(sample.grid), place);
      }
    }
  }
}

TEST(RankingKernels, KeepGradientRankingAndMaximaOnEveryInstructionSet) {
  check({&generic::moveAndRank, &generic::rankAll, &generic::refreshBlock, &generic::largest});
#ifdef STRAK_HAS_X86_SIMD
  if (simdLevel() >= SimdLevel::avx2) {
    check({&avx2::moveAndRank, &avx2::rankAll, &avx2::refreshBlock, &avx2::largest});
  }
  if (simdLevel() >= SimdLevel::avx512) {
    check({&avx512::moveAndRank, &avx512::rankAll, &avx512::refreshBlock, &avx512::largest});
  }
#endif
}

}  // namespace
}  // namespace strak::ranking
