#pragma once
//
// The inner loops of the solvers, once per instruction set. Declarations only, so that files compiled for wide vectors
// share no inline code with the rest.

#include <cstddef>

namespace strak::kernels {

// Lengths n are multiples of 8 and rows may be read `bandwidth` numbers before and after (zeros).
#define STRAK_SOLVE_KERNELS                                                                                            \
  /* y[j] = sum_d band[d * bandStride + j] * x[j + d - bandwidth], d = 0 .. 2 bandwidth */                             \
  void bandTimesRow(const double* band, std::ptrdiff_t bandStride, int bandwidth, const double* x, double* y,          \
                    std::ptrdiff_t n);                                                                                 \
  /* y = sum_k factors[k] * rows[k] */                                                                                 \
  void combineRows(std::ptrdiff_t count, const double* factors, const double* const* rows, double* y,                  \
                   std::ptrdiff_t n);                                                                                  \
  /* C = A B, row-major; m x k times k x n, n a multiple of 8, the strides lda, ldb, ldc */                            \
  void multiply(std::ptrdiff_t m, std::ptrdiff_t n, std::ptrdiff_t k, const double* a, std::ptrdiff_t lda,             \
                const double* b, std::ptrdiff_t ldb, double* c, std::ptrdiff_t ldc);                                   \
  double dot(const double* x, const double* y, std::ptrdiff_t n);                                                      \
  void addScaled(double* y, double factor, const double* x, std::ptrdiff_t n);                                         \
  void scaleAndAdd(double* y, double factor, const double* x, std::ptrdiff_t n);                                       \
  void multiplyPointwise(double* y, const double* factors, std::ptrdiff_t n);                                          \
  /* y[j] -= factors[j] * x[j] */                                                                                      \
  void subtractProduct(double* y, const double* factors, const double* x, std::ptrdiff_t n);                           \
  /* In place: the symmetric band matrix of every mode becomes L and 1 / D of its L D L^T. Entry (i, i - d) of mode j  \
     stands at t[(i * (bandwidth + 1) + d) * modes + j]. Returns the least D_i / T_ii of the modes with used[j] > 0.   \
   */                                                                                                                  \
  double factorBands(std::ptrdiff_t size, int bandwidth, std::ptrdiff_t modes, const double* used, double* t);         \
  /* One step of accelerated projected gradients on a row of n points; see ball_minimizer.cpp. */                      \
  void projectedStep(int components, std::ptrdiff_t stride, std::ptrdiff_t n, const double* x, double* xOld,           \
                     const double* kx, const double* kxOld, const double* linear, const double* step, double momentum, \
                     double radius, double* restart);

namespace generic {
STRAK_SOLVE_KERNELS
}
#ifdef STRAK_HAS_X86_SIMD
namespace avx2 {
STRAK_SOLVE_KERNELS
}
namespace avx512 {
STRAK_SOLVE_KERNELS
}
#endif

// Those of the widest instruction set of this machine.
struct Table {
  decltype(&generic::bandTimesRow) bandTimesRow;
  decltype(&generic::combineRows) combineRows;
  decltype(&generic::multiply) multiply;
  decltype(&generic::dot) dot;
  decltype(&generic::addScaled) addScaled;
  decltype(&generic::scaleAndAdd) scaleAndAdd;
  decltype(&generic::multiplyPointwise) multiplyPointwise;
  decltype(&generic::subtractProduct) subtractProduct;
  decltype(&generic::factorBands) factorBands;
  decltype(&generic::projectedStep) projectedStep;
};
const Table& chosen();

}  // namespace strak::kernels
