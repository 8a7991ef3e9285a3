#include "strak/solve/dense_kernels.h"

#include "strak/base/cpu.h"

namespace strak::dense {

const Kernels& chosen() {
  static const Kernels kernels{STRAK_SIMD_CHOOSE(addOuter), STRAK_SIMD_CHOOSE(eliminate)};
  return kernels;
}

}  // namespace strak::dense
