// Local fairing: point moves a second, by size, degree, energy and tolerance, set-up and certificates included, and the
// whole way to a certified gap on the paper's first example. Times are processor time of one thread.
//
// Inputs: square nets on the unit sphere, longitude and latitude in [-0.6, 0.6], uniform clamped knots on [0, 1], every
// point but the strip moved by 0.02 times a vector uniform in the unit ball (std::mt19937_64, seed 1995); the strip is
// held.

#include <benchmark/benchmark.h>

#include <cmath>
#include <random>

#include "strak/fairing/local_fairing.h"

namespace {

using namespace strak;

Surface spherePatch(Index n, int degree, Index strip) {
  Net net(n * n, 3);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      const double longitude = -0.6 + 1.2 * static_cast<double>(i) / static_cast<double>(n - 1);
      const double latitude = -0.6 + 1.2 * static_cast<double>(j) / static_cast<double>(n - 1);
      net.row(i * n + j) << std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
          std::sin(latitude);
    }
  }
  std::mt19937_64 random(1995);
  const auto coordinate = [&] { return 2 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1; };
  for (Index j = strip; j < n - strip; ++j) {
    for (Index i = strip; i < n - strip; ++i) {
      Eigen::RowVector3d r;
      do {
        for (int c = 0; c < 3; ++c) r[c] = coordinate();
      } while (r.squaredNorm() > 1);
      net.row(i * n + j) += 0.02 * r;
    }
  }
  const KnotVector knots = KnotVector::uniformClamped(degree, n - degree);
  return {{knots, knots}, std::move(net)};
}

LocalFairingOptions optionsFor(const Surface& surface, Index strip, double tolerance) {
  LocalFairingOptions options;
  options.tolerance = tolerance;
  options.held = holdStrips<2>(surface, {strip, strip, strip, strip});
  options.scale = ParameterScale::domain;
  return options;
}

void report(benchmark::State& state, const FairingSummary& summary) {
  state.SetIterationTime(summary.seconds);
  state.counters["energy"] = summary.energyAfter;
  state.counters["gap"] = summary.gap;
  state.counters["steps"] = static_cast<double>(summary.steps);
}

// Arguments: points a side, degree, tolerance in thousandths (0: none), energy (0 thin plate, 1 third derivatives).
void steps(benchmark::State& state) {
  const auto n = static_cast<Index>(state.range(0));
  const auto degree = static_cast<int>(state.range(1));
  const Surface surface = spherePatch(n, degree, n == 52 ? 6 : 3);
  const double tolerance = state.range(2) == 0 ? kUnlimited : 1e-3 * static_cast<double>(state.range(2));
  LocalFairingOptions options = optionsFor(surface, n == 52 ? 5 : 3, tolerance);
  options.gap = 0;
  options.maxSteps = 1'000'000;
  const auto energy = state.range(3) == 0 ? thinPlate<2>() : thirdDerivatives<2>();
  Index moves = 0;
  for (auto _ : state) {
    const auto result = fairLocally<2>(surface, energy, options);
    report(state, result.summary);
    moves += result.summary.steps;
  }
  state.SetItemsProcessed(moves);
}
BENCHMARK(steps)
    ->ArgNames({"points", "degree", "tolerance", "third"})
    ->Args({52, 4, 20, 0})
    ->Args({52, 4, 0, 0})
    ->Args({52, 4, 20, 1})
    ->Args({52, 3, 20, 0})
    ->Args({52, 5, 20, 0})
    ->Args({200, 3, 20, 0})
    ->Args({500, 3, 20, 0})
    ->Args({200, 4, 20, 0})
    ->Args({500, 4, 20, 0})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

// Until the gap is certified to be below 10^-argument.
void untilGap(benchmark::State& state) {
  const Surface surface = spherePatch(52, 4, 6);
  LocalFairingOptions options = optionsFor(surface, 5, 0.02);
  options.gap = std::pow(10, -static_cast<double>(state.range(0)));
  for (auto _ : state) report(state, fairLocally<2>(surface, thinPlate<2>(), options).summary);
}
BENCHMARK(untilGap)->Arg(2)->Arg(4)->Arg(6)->Arg(8)->UseManualTime()->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
