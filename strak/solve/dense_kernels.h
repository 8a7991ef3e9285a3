#pragma once
//
// The inner loops of the sparse factorisation and of element matrices, once per instruction set. Plain pointers and
// declarations only. All matrices are column-major.

#include <cstddef>

namespace strak::dense {

// Numbers of scratch space that the functions below need for matrices of up to `rows` rows.
inline constexpr std::ptrdiff_t kBlock = 64;
inline constexpr std::ptrdiff_t kPad = 32;

#define STRAK_DENSE_KERNELS                                                                                            \
  /* The lower triangle of C (n x n) += sign A A^T, A n x k. `scratch`: 2 kBlock (n + kPad) numbers. */                \
  void addOuter(std::ptrdiff_t n, std::ptrdiff_t k, const double* a, std::ptrdiff_t lda, double sign, double* c,       \
                std::ptrdiff_t ldc, double* scratch);                                                                  \
  /* Eliminates the first `own` of the columns of a symmetric matrix: `left` (all x own) becomes the factor's columns, \
   */                                                                                                                  \
  /* the lower triangle of `rest` (all - own, square) their Schur complement. Returns false if it is not positive */   \
  /* definite. `scratch`: as above for n = all. */                                                                     \
  bool eliminate(std::ptrdiff_t all, std::ptrdiff_t own, double* left, double* rest, double* scratch);

namespace generic {
STRAK_DENSE_KERNELS
}
#ifdef STRAK_HAS_X86_SIMD
namespace avx2 {
STRAK_DENSE_KERNELS
}
namespace avx512 {
STRAK_DENSE_KERNELS
}
#endif

// Those for this processor.
struct Kernels {
  decltype(&generic::addOuter) addOuter;
  decltype(&generic::eliminate) eliminate;
};
const Kernels& chosen();
// Numbers of scratch for matrices of n rows.
inline std::ptrdiff_t scratchSize(std::ptrdiff_t n) { return 2 * kBlock * (n + kPad); }

}  // namespace strak::dense
