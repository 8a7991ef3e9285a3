// Evaluation asks the heap for nothing in its inner loops. This file counts what the whole test program asks for.

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "strak/spline/evaluator.h"
#include "tests/spline/random_splines.h"

namespace {

std::atomic<long> requests{0};

}  // namespace

// Not inlined: the compiler would see malloc on one side of a pair and `new` on the other, and warn.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++requests;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace strak {
namespace {

TEST(EvaluateMemory, SinglePointsAskForNothing) {
  testing::Random random(150);
  for (const bool rational : {false, true}) {
    const auto cubic = KnotVector::uniformClamped(3, 5);
    const auto volume = testing::randomSpline<3>(random, {cubic, cubic, cubic}, 3, rational);
    const Evaluator<3> evaluator(volume);
    double out[60];
    const long before = requests;
    for (int i = 0; i < 100; ++i) evaluator.derivatives({0.01 * i, 0.5, 0.3}, 3, out);
    EXPECT_EQ(requests, before);
  }
}

TEST(EvaluateMemory, MorePointsAskForNoMore) {
  const tbb::global_control oneThread(tbb::global_control::max_allowed_parallelism, 1);
  testing::Random random(151);
  const auto quartic = KnotVector::uniformClamped(4, 5);
  const Evaluator<2> evaluator(testing::randomSpline<2>(random, {quartic, quartic}, 3, true));
  const auto requestsFor = [&](Index rows) {
    const Net parameters = Net::Constant(rows, 2, 0.3);
    Net out(rows, 18);
    evaluator.derivativesAt(parameters, 2, out);  // the library may set itself up
    const long before = requests;
    evaluator.derivativesAt(parameters, 2, out);
    return requests - before;
  };
  const long few = requestsFor(64);
  EXPECT_GT(few, 0);  // a task's scratch memory: the counter counts
  EXPECT_EQ(few, requestsFor(512));
}

}  // namespace
}  // namespace strak
