#pragma once
//
// The inner loops over points. Plain pointers only, see cmake/StrakRooms.cmake.

#include <cstddef>

namespace strak::fitkernels {

// Points of one strip of knot cells, in the order in which they came. A record is s, t (the place in the cell, -1 to 1
// in each direction), the weight and the coordinates.
struct StripPoints {
  std::ptrdiff_t count;
  const double* records;
  std::ptrdiff_t length;  // doubles a record
  const int* cells;       // of each point, within the strip
};

// What is summed in a knot cell: first sum w T_i(s) T_j(t) for i = 0 .. 2 degree[0] and j = 0 .. width - 1, then for
// each coordinate sum w z T_i(s) T_j(t) for i = 0 .. degree[0], j = 0 .. rightWidth - 1, T the Chebyshev polynomials.
// The widths are padded to multiples of 4; `length` doubles a cell.
struct CellLayout {
  int degree[2];
  int width;
  int rightWidth;
  int columns;
  std::ptrdiff_t length;
};

#define STRAK_FIT_KERNELS                                                                                            \
  /* Adds the points to the sums of their cells; those without coordinates only if `withMatrix`. */                  \
  void addMoments(const StripPoints& points, const CellLayout& layout, bool withMatrix, double* cells);              \
  /* values[r * columns + c] = sum_ij C_ij T_i(s) T_j(t): a spline whose pieces are given as Chebyshev coefficients, \
   * columns x (degree[0] + 1) x rightWidth of them a cell. */                                                       \
  void evaluateCells(const StripPoints& points, const CellLayout& layout, const double* coefficients, double* values);

namespace generic {
STRAK_FIT_KERNELS
}
#ifdef STRAK_HAS_X86_SIMD
namespace avx2 {
STRAK_FIT_KERNELS
}
namespace avx512 {
STRAK_FIT_KERNELS
}
#endif

#undef STRAK_FIT_KERNELS

// Those for this processor.
struct Kernels {
  decltype(&generic::addMoments) addMoments;
  decltype(&generic::evaluateCells) evaluateCells;
};
const Kernels& chosen();

}  // namespace strak::fitkernels
