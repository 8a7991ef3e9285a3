#pragma once
//
// Which instruction set the inner loops run with. One binary holds all of them; the choice is made once, at run time.

namespace strak {

enum class SimdLevel { generic, avx2, avx512 };

// The widest level this processor and this build support. The environment variable STRAK_SIMD (generic, avx2, avx512)
// lowers it, for tests and comparisons; it never raises it.
SimdLevel simdLevel();

}  // namespace strak

// Picks the function of the right namespace: `STRAK_SIMD_CHOOSE(multiply)` in a file that declares
// generic::multiply, avx2::multiply and avx512::multiply gives a pointer to the one to call.
#ifdef STRAK_HAS_X86_SIMD
#define STRAK_SIMD_CHOOSE(function)                                       \
  (::strak::simdLevel() == ::strak::SimdLevel::avx512 ? &avx512::function \
   : ::strak::simdLevel() == ::strak::SimdLevel::avx2 ? &avx2::function   \
                                                      : &generic::function)
#else
#define STRAK_SIMD_CHOOSE(function) (&generic::function)
#endif
