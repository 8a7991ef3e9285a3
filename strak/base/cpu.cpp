#include "strak/base/cpu.h"

#include <algorithm>
#include <cstdlib>
#include <string_view>

namespace strak {

namespace {

SimdLevel detect() {
#ifdef STRAK_HAS_X86_SIMD
  SimdLevel best = SimdLevel::generic;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) best = SimdLevel::avx2;
  if (best == SimdLevel::avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw")) {
    best = SimdLevel::avx512;
  }
  const char* wish = std::getenv("STRAK_SIMD");
  if (wish && std::string_view(wish) == "generic") return SimdLevel::generic;
  if (wish && std::string_view(wish) == "avx2") return std::min(best, SimdLevel::avx2);
  return best;
#else
  return SimdLevel::generic;
#endif
}

}  // namespace

SimdLevel simdLevel() {
  static const SimdLevel level = detect();
  return level;
}

}  // namespace strak
