#include "strak/solve/kernels.h"

#include "strak/base/cpu.h"

namespace strak::kernels {

const Table& chosen() {
  static const Table table{STRAK_SIMD_CHOOSE(bandTimesRow),      STRAK_SIMD_CHOOSE(combineRows),
                           STRAK_SIMD_CHOOSE(multiply),          STRAK_SIMD_CHOOSE(dot),
                           STRAK_SIMD_CHOOSE(addScaled),         STRAK_SIMD_CHOOSE(scaleAndAdd),
                           STRAK_SIMD_CHOOSE(multiplyPointwise), STRAK_SIMD_CHOOSE(subtractProduct),
                           STRAK_SIMD_CHOOSE(factorBands),       STRAK_SIMD_CHOOSE(projectedStep)};
  return table;
}

}  // namespace strak::kernels
