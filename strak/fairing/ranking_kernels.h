#pragma once
//
// The inner loops of local fairing, once per instruction set: move one control point, bring its neighbours' gradients
// and ranking numbers up to date, keep the maxima, find the largest. Plain pointers and declarations only.

#include <cstddef>

namespace strak::ranking {

// Ranking numbers of a row lie in blocks of so many; the tournament below has as many children a node as kFanOut.
inline constexpr std::ptrdiff_t kBlock = 32;
inline constexpr std::ptrdiff_t kFanOut = 8;
inline constexpr std::ptrdiff_t kMaxLevels = 24;

// Control points on a grid of rows along the last direction, padded so that no stencil leaves it; a place is an index
// into these arrays. Held and padding points have weight = inverse = shift = 0 and so never gain.
struct Grid {
  std::ptrdiff_t components;
  std::ptrdiff_t plane;   // numbers from one component to the next in gradient and shift
  std::ptrdiff_t stride;  // numbers a row, a multiple of kBlock
  std::ptrdiff_t rows;
  double* gradient;       // h = K d, half the energy's gradient
  double* shift;          // e = d - d0
  const double* weight;   // w = K_rr
  const double* inverse;  // 1 / w
  double* gain;           // ranking number
  double radius;          // of the balls as the ranking sees them; infinite for none
  // Maxima: level 0 holds one a block (row r, block b at b * rows + r), level l + 1 one for kFanOut of level l; the
  // last level is one node. All levels are padded with -1 to a multiple of kFanOut.
  std::ptrdiff_t levels;
  double* level[kMaxLevels];
};

// The row of K at one control point: row i covers `width` places from place + offset[i] on, with the values
// sum over f of outer[i * factors + f] * inner[f * width + j]. The rows come in runs of neighbouring grid rows.
struct Stencil {
  std::ptrdiff_t rows, rowsPerRun, width, factors;  // width: a multiple of 4
  const std::ptrdiff_t* offset;
  const double* outer;
  const double* inner;
};

#define STRAK_RANKING_KERNELS                                                                                          \
  /* Adds K times the move (one number a component) of the point at `place` to the gradient; shift is the caller's. */ \
  void moveAndRank(const Grid& grid, const Stencil& stencil, std::ptrdiff_t place, const double* move);                \
  /* Ranking numbers and maxima of the whole grid. */                                                                  \
  void rankAll(const Grid& grid);                                                                                      \
  /* Maxima of the one block that holds `place`, after its gain was changed by hand. */                                \
  void refreshBlock(const Grid& grid, std::ptrdiff_t place);                                                           \
  /* The place of the largest ranking number; the first of equals. */                                                  \
  std::ptrdiff_t largest(const Grid& grid);

namespace generic {
STRAK_RANKING_KERNELS
}
#ifdef STRAK_HAS_X86_SIMD
namespace avx2 {
STRAK_RANKING_KERNELS
}
namespace avx512 {
STRAK_RANKING_KERNELS
}
#endif

// Those for this processor.
struct Kernels {
  decltype(&generic::moveAndRank) moveAndRank;
  decltype(&generic::rankAll) rankAll;
  decltype(&generic::refreshBlock) refreshBlock;
  decltype(&generic::largest) largest;
};
const Kernels& chosen();

}  // namespace strak::ranking
