// Fitting: Franke's function with noise, the whole fit with the weight chosen automatically; points a second that are
// added to the normal equations block by block; closest points.
//
// Franke: generator, check sums and grid of the error as in tests/fitting/franke.h; bicubic, 50 x 50 control points,
// one thread. "true_rms" is the error against the function without noise.

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include <fstream>
#include <random>
#include <string>

#include "strak/fitting/least_squares.h"
#include "strak/metrology/closest_points.h"
#include "tests/fitting/franke.h"

namespace {

using namespace strak;

std::array<KnotVector, 2> knots50() { return {KnotVector::uniformClamped(3, 47), KnotVector::uniformClamped(3, 47)}; }

double peakMegabytes() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kilobytes = 0;
    if (word == "VmHWM:" && status >> kilobytes) return kilobytes / 1024;
  }
  return 0;
}

void franke(benchmark::State& state, const std::string& energy) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  const Net points = test::frankePoints(state.range(0));
  FitOptions<2> options;
  options.energy = energyNamed<2>(energy);
  Fit<2> fit;
  for (auto _ : state) fit = fitLeastSquares<2>(knots50(), {points.leftCols(2), points.rightCols(1)}, options);
  state.counters["true_rms"] = test::frankeError(fit.spline);
  state.counters["lambda"] = fit.summary.lambda;
  state.counters["freedom"] = fit.summary.freedom;
}
BENCHMARK_CAPTURE(franke, thirdDerivatives, "third-derivatives")
    ->RangeMultiplier(10)
    ->Range(10000, 1000000)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(franke, thinPlate, "thin-plate")
    ->RangeMultiplier(10)
    ->Range(10000, 1000000)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();

// Normal equations of so many points in blocks of 2^18: one block that is handed over again and again, as fast as a
// file could ever bring it. The argument is the number of threads.
void streamed(benchmark::State& state) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(state.range(0)));
  constexpr Index kBlock = Index{1} << 18;
  constexpr Index kBlocks = 40;
  const Net points = test::frankePoints(kBlock);
  std::ofstream("/proc/self/clear_refs") << "5";  // the peak counts from here
  for (auto _ : state) {
    NormalEquations<2> equations(knots50(), 1);
    for (Index b = 0; b < kBlocks; ++b) equations.add({points.leftCols(2), points.rightCols(1)});
    benchmark::DoNotOptimize(equations.sums());
  }
  state.counters["points/s"] =
      benchmark::Counter(static_cast<double>(kBlock * kBlocks), benchmark::Counter::kIsIterationInvariantRate);
  state.counters["MB"] = peakMegabytes();
}
BENCHMARK(streamed)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();

// Points off a bicubic 50 x 50 sheet, from starts a tenth of a knot span away; one thread.
void closest(benchmark::State& state) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  std::mt19937_64 random(42);
  const auto draw = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const auto knots = knots50();
  const auto u = knots[0].greville();
  Net net(2500, 3);
  for (Index r = 0; r < 2500; ++r) {
    const double x = u[static_cast<std::size_t>(r / 50)], y = u[static_cast<std::size_t>(r % 50)];
    net.row(r) << 10 * x, 8 * y, std::sin(6 * x) * std::cos(5 * y) + 0.02 * draw();
  }
  const Surface surface(knots, net);
  constexpr Index kCount = 100000;
  Net points(kCount, 3), starts(kCount, 2);
  for (Index r = 0; r < kCount; ++r) {
    const double a = draw(), b = draw();
    points.row(r) = evaluate<2>(surface, {a, b});
    for (Index c = 0; c < 3; ++c) points(r, c) += 0.1 * (draw() - 0.5);
    starts.row(r) << a + 0.004 * (draw() - 0.5), b + 0.004 * (draw() - 0.5);
  }
  ClosestPoints<2> found;
  for (auto _ : state) found = closestPointsFrom<2>(surface, points, starts);
  state.counters["points/s"] =
      benchmark::Counter(static_cast<double>(kCount), benchmark::Counter::kIsIterationInvariantRate);
  state.counters["difficult"] = static_cast<double>(found.difficult);
}
BENCHMARK(closest)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

}  // namespace

BENCHMARK_MAIN();
