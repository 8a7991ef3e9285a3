// Measuring: certified deviation, fairness figures, isophotes and the Hausdorff distance, by size of the net. Wall
// clock with all threads.
//
// Inputs: square nets on the unit sphere, longitude and latitude in [-0.6, 0.6], uniform clamped knots on [0, 1]; the
// second surface has every point but a strip of 5 moved by up to 0.02 (std::mt19937_64, seed 1995).

#include <benchmark/benchmark.h>

#include <cmath>
#include <random>

#include "strak/metrology/deviation.h"
#include "strak/metrology/fairness.h"
#include "strak/metrology/hausdorff.h"
#include "strak/metrology/isophotes.h"
#include "strak/spline/knot_insertion.h"

namespace {

using namespace strak;

Surface spherePatch(Index n, int degree, double noise) {
  Net net(n * n, 3);
  std::mt19937_64 random(1995);
  const auto coordinate = [&] { return 2 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1; };
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      const double longitude = -0.6 + 1.2 * static_cast<double>(i) / static_cast<double>(n - 1);
      const double latitude = -0.6 + 1.2 * static_cast<double>(j) / static_cast<double>(n - 1);
      net.row(i * n + j) << std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
          std::sin(latitude);
      if (std::min(i, j) < 5 || std::max(i, j) >= n - 5) continue;
      net.row(i * n + j) += noise / std::sqrt(3.0) * Eigen::RowVector3d(coordinate(), coordinate(), coordinate());
    }
  }
  const KnotVector knots = KnotVector::uniformClamped(degree, n - degree);
  return {{knots, knots}, std::move(net)};
}

// Arguments: points a side, degree.
void deviationOnTheSameKnots(benchmark::State& state) {
  const Surface a = spherePatch(state.range(0), static_cast<int>(state.range(1)), 0);
  const Surface b = spherePatch(state.range(0), static_cast<int>(state.range(1)), 0.02);
  Deviation<2> d;
  for (auto _ : state) d = certifyDeviation(a, b);
  state.counters["width"] = (d.upper - d.lower) / d.upper;
}
BENCHMARK(deviationOnTheSameKnots)
    ->Args({52, 4})
    ->Args({500, 3})
    ->Args({1000, 3})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

void deviationOnDifferentKnots(benchmark::State& state) {
  const Surface a = spherePatch(state.range(0), static_cast<int>(state.range(1)), 0);
  const Surface b = insertKnots<2>(spherePatch(state.range(0), static_cast<int>(state.range(1)), 0.02), 0, {0.123});
  for (auto _ : state) benchmark::DoNotOptimize(certifyDeviation(a, b));
}
BENCHMARK(deviationOnDifferentKnots)->Args({52, 4})->Args({500, 3})->UseRealTime()->Unit(benchmark::kMillisecond);

// Arguments: points a side, degree, noise in thousandths.
void fairnessFigures(benchmark::State& state) {
  const Surface s =
      spherePatch(state.range(0), static_cast<int>(state.range(1)), 1e-3 * static_cast<double>(state.range(2)));
  SurfaceFairness f;
  for (auto _ : state) f = surfaceFairness(s);
  state.counters["error"] = f.relativeError;
}
BENCHMARK(fairnessFigures)
    ->Args({52, 4, 0})
    ->Args({52, 4, 20})
    ->Args({500, 3, 0})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

void twentyIsophotes(benchmark::State& state) {
  const Surface s =
      spherePatch(state.range(0), static_cast<int>(state.range(1)), 1e-3 * static_cast<double>(state.range(2)));
  IsophoteOptions options;
  options.light = {1, 1, 1};
  for (auto _ : state) benchmark::DoNotOptimize(isophotes(s, options));
}
BENCHMARK(twentyIsophotes)->Args({52, 4, 0})->Args({52, 4, 20})->UseRealTime()->Unit(benchmark::kMillisecond);

void hausdorff(benchmark::State& state) {
  const Surface a = spherePatch(state.range(0), static_cast<int>(state.range(1)), 0);
  const Surface b = spherePatch(state.range(0), static_cast<int>(state.range(1)), 0.02);
  HausdorffDistance d;
  for (auto _ : state) d = hausdorffDistance(a, b);
  state.counters["samples"] = static_cast<double>(d.fromA.samples + d.fromB.samples);
}
BENCHMARK(hausdorff)->Args({52, 4})->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
