#include "strak/fitting/fit_kernels.h"

#include "strak/base/cpu.h"

namespace strak::fitkernels {

const Kernels& chosen() {
  static const Kernels kernels{STRAK_SIMD_CHOOSE(addMoments), STRAK_SIMD_CHOOSE(evaluateCells)};
  return kernels;
}

}  // namespace strak::fitkernels
