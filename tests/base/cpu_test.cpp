#include "strak/base/cpu.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace strak {
namespace {

// The level is chosen once a process, so every wish needs a process of its own.
int levelWith(const char* wish) {
  if (wish) {
    ::setenv("STRAK_SIMD", wish, 1);
  } else {
    ::unsetenv("STRAK_SIMD");
  }
  return 10 + static_cast<int>(simdLevel());
}

int widest() {
#ifdef STRAK_HAS_X86_SIMD
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return 10;
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                 __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw")
             ? 12
             : 11;
#else
  return 10;
#endif
}

class Cpu : public ::testing::Test {
 protected:
  void SetUp() override { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};
using CpuDeathTest = Cpu;

TEST_F(CpuDeathTest, TakesTheWidestByItself) {
  EXPECT_EXIT(std::exit(levelWith(nullptr)), ::testing::ExitedWithCode(widest()), "");
  EXPECT_EXIT(std::exit(levelWith("avx512")), ::testing::ExitedWithCode(widest()), "");
  EXPECT_EXIT(std::exit(levelWith("something else")), ::testing::ExitedWithCode(widest()), "");
}

TEST_F(CpuDeathTest, WishesOnlyLowerTheLevel) {
  EXPECT_EXIT(std::exit(levelWith("generic")), ::testing::ExitedWithCode(10), "");
  EXPECT_EXIT(std::exit(levelWith("avx2")), ::testing::ExitedWithCode(widest() < 11 ? widest() : 11), "");
}

}  // namespace
}  // namespace strak
