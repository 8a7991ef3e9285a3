#include "strak/fairing/ranking_kernels.h"

#ifdef __AVX2__
#include <immintrin.h>
#endif

#if defined(__AVX512F__)
#define STRAK_LANES 8
#elif defined(__AVX2__)
#define STRAK_LANES 4
#else
#define STRAK_LANES 2
#endif

namespace strak::ranking::STRAK_SIMD {

namespace {

// Vectors that may stand at any address of doubles.
template <int kLanes>
struct Lanes;
template <>
struct Lanes<2> {
  using Vec = double __attribute__((vector_size(16), aligned(8), may_alias));
};
template <>
struct Lanes<4> {
  using Vec = double __attribute__((vector_size(32), aligned(8), may_alias));
};
template <>
struct Lanes<8> {
  using Vec = double __attribute__((vector_size(64), aligned(8), may_alias));
};
using Wide = Lanes<STRAK_LANES>::Vec;
using Rest = Lanes<(STRAK_LANES > 4 ? 4 : STRAK_LANES)>::Vec;  // for the last places of a stencil row
constexpr int kWide = STRAK_LANES;

template <class Vec>
constexpr int kLanesOf = sizeof(Vec) / sizeof(double);

template <class Vec>
inline Vec load(const double* p) {
  return *reinterpret_cast<const Vec*>(p);
}
template <class Vec>
inline void store(double* p, Vec v) {
  *reinterpret_cast<Vec*>(p) = v;
}
template <class Vec>
inline Vec larger(Vec a, Vec b) {
  return a > b ? a : b;
}

template <class Vec>
inline double largestLane(Vec v) {
  double result = v[0];
  for (int i = 1; i < kLanesOf<Vec>; ++i) result = v[i] > result ? v[i] : result;
  return result;
}

// Square roots of all lanes, and whether any lane of a is larger than b: the compiler finds no short way by itself.
#ifdef __AVX512F__
inline Lanes<8>::Vec squareRoot(Lanes<8>::Vec v) { return _mm512_maskz_sqrt_pd(0xff, v); }
inline bool anyLarger(Lanes<8>::Vec a, double b) { return _mm512_cmp_pd_mask(a, _mm512_set1_pd(b), _CMP_GT_OQ) != 0; }
#endif
#ifdef __AVX2__
inline Lanes<4>::Vec squareRoot(Lanes<4>::Vec v) { return _mm256_sqrt_pd(v); }
inline bool anyLarger(Lanes<4>::Vec a, double b) {
  return _mm256_movemask_pd(_mm256_cmp_pd(a, _mm256_set1_pd(b), _CMP_GT_OQ)) != 0;
}
#else
inline Lanes<2>::Vec squareRoot(Lanes<2>::Vec v) {
  v[0] = __builtin_sqrt(v[0]);
  v[1] = __builtin_sqrt(v[1]);
  return v;
}
inline bool anyLarger(Lanes<2>::Vec a, double b) { return (a[0] > b) | (a[1] > b); }
#endif

// Cancellation leaves a gain of this part of the unconstrained one where a point cannot move at all.
constexpr double kCancellation = 4e-15;

// (5.9): w (|d - t|^2 - |t* - t|^2) = |h|^2 / w - w max(0, |t - d0| - radius)^2.
template <class Vec>
inline void rank(const Grid& grid, std::ptrdiff_t place, Vec gradientSquare, Vec targetSquare, Vec inverse) {
  Vec gain = gradientSquare * inverse;
  const double square = grid.radius * grid.radius;
  if (anyLarger(targetSquare, square)) {
    const Vec outside = squareRoot(targetSquare) - grid.radius;
    const Vec clipped = gain - load<Vec>(grid.weight + place) * outside * outside - kCancellation * gain;
    gain = targetSquare > square ? clipped : gain;
  }
  store(grid.gain + place, gain);
}

// One vector of places: h += values * move, then its ranking numbers. kComponents 0: as many as the grid says.
template <class Vec, int kComponents>
inline void update(const Grid& grid, std::ptrdiff_t place, Vec values, const double* move) {
  const std::ptrdiff_t components = kComponents > 0 ? kComponents : grid.components;
  const Vec inverse = load<Vec>(grid.inverse + place);
  Vec gradientSquare{};
  Vec targetSquare{};
  for (std::ptrdiff_t c = 0; c < components; ++c) {
    double* at = grid.gradient + c * grid.plane + place;
    const Vec h = load<Vec>(at) + values * move[c];
    store(at, h);
    const Vec target = load<Vec>(grid.shift + c * grid.plane + place) - h * inverse;
    gradientSquare += h * h;
    targetSquare += target * target;
  }
  rank(grid, place, gradientSquare, targetSquare, inverse);
}

template <class Vec, int kComponents>
inline void stencilPart(const Grid& grid, const Stencil& stencil, const double* outer, std::ptrdiff_t place,
                        std::ptrdiff_t column, const double* move) {
  Vec values{};
  for (std::ptrdiff_t f = 0; f < stencil.factors; ++f) {
    values += outer[f] * load<Vec>(stencil.inner + f * stencil.width + column);
  }
  update<Vec, kComponents>(grid, place + column, values, move);
}

template <int kComponents>
void updateAll(const Grid& grid, const Stencil& stencil, std::ptrdiff_t place, const double* move) {
  for (std::ptrdiff_t i = 0; i < stencil.rows; ++i) {
    const double* outer = stencil.outer + i * stencil.factors;
    const std::ptrdiff_t start = place + stencil.offset[i];
    std::ptrdiff_t j = 0;
    for (; j + kWide <= stencil.width; j += kWide) {
      stencilPart<Wide, kComponents>(grid, stencil, outer, start, j, move);
    }
    if (j < stencil.width) stencilPart<Rest, kComponents>(grid, stencil, outer, start, j, move);
  }
}

inline double blockMaximum(const double* gain) {
  Wide best = load<Wide>(gain);
  for (std::ptrdiff_t j = kWide; j < kBlock; j += kWide) best = larger(best, load<Wide>(gain + j));
  return largestLane(best);
}

inline double childrenMaximum(const double* children) {
  Wide best = load<Wide>(children);
  for (std::ptrdiff_t j = kWide; j < kFanOut; j += kWide) best = larger(best, load<Wide>(children + j));
  return largestLane(best);
}

// Maxima above the blocks of rows first .. last in block column `block`.
void refresh(const Grid& grid, std::ptrdiff_t first, std::ptrdiff_t last, std::ptrdiff_t block) {
  double* leaves = grid.level[0] + block * grid.rows;
  const double* gain = grid.gain + block * kBlock;
  for (std::ptrdiff_t r = first; r <= last; ++r) leaves[r] = blockMaximum(gain + r * grid.stride);
  std::ptrdiff_t low = block * grid.rows + first;
  std::ptrdiff_t high = block * grid.rows + last;
  for (std::ptrdiff_t l = 1; l < grid.levels; ++l) {
    low /= kFanOut;
    high /= kFanOut;
    for (std::ptrdiff_t i = low; i <= high; ++i) {
      grid.level[l][i] = childrenMaximum(grid.level[l - 1] + i * kFanOut);
    }
  }
}

// The first of `count` (at most 32) numbers that equals `value`, without branches; 0 if none does.
inline std::ptrdiff_t firstEqual(const double* numbers, std::ptrdiff_t count, double value) {
  unsigned bits = 0;
  for (std::ptrdiff_t i = 0; i < count; ++i) bits |= static_cast<unsigned>(numbers[i] == value) << i;
  return bits == 0 ? 0 : __builtin_ctz(bits);
}

}  // namespace

void moveAndRank(const Grid& grid, const Stencil& stencil, std::ptrdiff_t place, const double* move) {
  switch (grid.components) {
    case 1:
      updateAll<1>(grid, stencil, place, move);
      break;
    case 2:
      updateAll<2>(grid, stencil, place, move);
      break;
    case 3:
      updateAll<3>(grid, stencil, place, move);
      break;
    default:
      updateAll<0>(grid, stencil, place, move);
      break;
  }
  for (std::ptrdiff_t i = 0; i < stencil.rows; i += stencil.rowsPerRun) {
    const std::ptrdiff_t start = place + stencil.offset[i];
    const std::ptrdiff_t row = start / grid.stride;
    const std::ptrdiff_t column = start - row * grid.stride;
    const std::ptrdiff_t lastBlock = (column + stencil.width - 1) / kBlock;
    for (std::ptrdiff_t block = column / kBlock; block <= lastBlock; ++block) {
      refresh(grid, row, row + stencil.rowsPerRun - 1, block);
    }
  }
}

void rankAll(const Grid& grid) {
  for (std::ptrdiff_t place = 0; place < grid.rows * grid.stride; place += kWide) {
    Wide gradientSquare{};
    Wide targetSquare{};
    const Wide inverse = load<Wide>(grid.inverse + place);
    for (std::ptrdiff_t c = 0; c < grid.components; ++c) {
      const Wide h = load<Wide>(grid.gradient + c * grid.plane + place);
      const Wide target = load<Wide>(grid.shift + c * grid.plane + place) - h * inverse;
      gradientSquare += h * h;
      targetSquare += target * target;
    }
    rank(grid, place, gradientSquare, targetSquare, inverse);
  }
  for (std::ptrdiff_t block = 0; block < grid.stride / kBlock; ++block) refresh(grid, 0, grid.rows - 1, block);
}

void refreshBlock(const Grid& grid, std::ptrdiff_t place) {
  const std::ptrdiff_t row = place / grid.stride;
  refresh(grid, row, row, (place - row * grid.stride) / kBlock);
}

std::ptrdiff_t largest(const Grid& grid) {
  std::ptrdiff_t node = 0;
  const double best = grid.level[grid.levels - 1][0];
  for (std::ptrdiff_t l = grid.levels - 1; l > 0; --l) {
    node = node * kFanOut + firstEqual(grid.level[l - 1] + node * kFanOut, kFanOut, best);
  }
  const std::ptrdiff_t block = node / grid.rows;
  const std::ptrdiff_t start = (node - block * grid.rows) * grid.stride + block * kBlock;
  return start + firstEqual(grid.gain + start, kBlock, best);
}

}  // namespace strak::ranking::STRAK_SIMD
