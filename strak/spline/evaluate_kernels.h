#pragma once
//
// The inner loops of evaluation. Plain pointers only, see cmake/StrakRooms.cmake.
//
// Points are padded to 4 doubles. A net with more than 4 columns is kept as several planes of 4, one after another.
// The weights of a parameter are (order + 1) rows of `width` doubles: the derivatives of the basis functions of its
// span, followed by zeros.

#include <cstddef>

namespace strak {

// The basis functions of one direction, span by span, as polynomials in t = (u - centre) * scale, |t| <= 1.
struct BasisView {
  int degree;
  int width;                    // degree + 1 rounded up to a multiple of 4
  const double* starts;         // where each span begins; one more: where the last ends
  const std::ptrdiff_t* first;  // the first basis function of each span
  const double* centres;
  const double* scales;
  const double* coefficients;  // a span: degree + 1 rows of `width`, ascending powers of t
  // Equal buckets over the domain: buckets[b] is the last span known to begin at or before every u in bucket b.
  double from;
  double bucketScale;
  std::ptrdiff_t bucketCount;
  const std::ptrdiff_t* buckets;  // bucketCount + 1
};

// A padded net with `directions` directions.
struct NetView {
  int directions;
  std::ptrdiff_t sizes[3];
  int columns;  // coordinates a point, before padding
  const double* points;
  std::ptrdiff_t planeStride;  // doubles from one plane of 4 columns to the next
  int degrees[3];
  int widths[3];
};

// What is known about `count` parameters in one direction: the first basis function and the weights of each.
struct WeightsView {
  const std::ptrdiff_t* first;
  const double* weights;
};

#define STRAK_EVALUATE_KERNELS                                                                                         \
  /* First functions and weights of `count` parameters, `stride` doubles apart. */                                     \
  void basisWeights(const BasisView& basis, const double* parameters, std::ptrdiff_t stride, std::ptrdiff_t count,     \
                    int order, std::ptrdiff_t* first, double* weights);                                                \
  /* All derivatives at `count` points of a net; row r of the result begins at out + r * outStride. */                 \
  void contractPoints(const NetView& net, const WeightsView* weights, std::ptrdiff_t count, int order, double* out,    \
                      std::ptrdiff_t outStride);                                                                       \
  /* target[a][x] = sum_i weights[a][i] source[i][x] for a = 0..order, i = 0..degree, x = 0..length-1 (a multiple of   \
   * 4). */                                                                                                            \
  void contractLines(const double* weights, int width, int degree, int order, const double* source,                    \
                     std::ptrdiff_t sourceStride, std::ptrdiff_t length, double* target, std::ptrdiff_t targetStride); \
  /* The last direction of a grid: `lines` holds, for every combination of derivatives of the directions before the    \
     last (a; or (a, b), b fastest), one padded line of points; lineStride doubles apart. Writes the columns of one    \
     plane: coordinates firstColumn .. firstColumn + 3. */                                                             \
  void contractLast(const NetView& net, const double* lines, std::ptrdiff_t lineStride, const WeightsView& weights,    \
                    std::ptrdiff_t count, int order, int firstColumn, double* out, std::ptrdiff_t outStride);

namespace generic {
STRAK_EVALUATE_KERNELS
}
#ifdef STRAK_HAS_X86_SIMD
namespace avx2 {
STRAK_EVALUATE_KERNELS
}
namespace avx512 {
STRAK_EVALUATE_KERNELS
}
#endif

#undef STRAK_EVALUATE_KERNELS

}  // namespace strak
