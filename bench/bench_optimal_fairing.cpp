// Optimal fairing: the paper's first example, and cost against size. Each line states energy, certified gap,
// iterations, processor seconds and the peak memory above what the program held before (Linux).
//
// Inputs: square nets on the unit sphere with longitude and latitude in [-0.6, 0.6], every point but the strip moved by
// 0.02 times a vector uniform in the unit ball (std::mt19937_64, seed 1995); the strip stays fixed.

#include <benchmark/benchmark.h>

#include <cmath>
#include <fstream>
#include <random>
#include <string>

#include "strak/fairing/optimal_fairing.h"

namespace {

using namespace strak;

enum class Knots { uniform, uneven, doubled };

KnotVector makeKnots(int degree, Index points, Knots kind) {
  if (kind == Knots::uniform) return KnotVector::uniformClamped(degree, points - degree);
  // `uneven`: spans alternate 1 : 4. `doubled`: every inner knot twice, so that the surface is only C1 for degree 3.
  std::vector<double> knots(static_cast<std::size_t>(degree) + 1, 0.0);
  double u = 0;
  for (Index i = 0; static_cast<Index>(knots.size()) < points; ++i) {
    u += kind == Knots::uneven && i % 2 == 1 ? 4 : 1;
    knots.push_back(u);
    if (kind == Knots::doubled && static_cast<Index>(knots.size()) < points) knots.push_back(u);
  }
  knots.insert(knots.end(), static_cast<std::size_t>(degree) + 1, u + 1);
  return KnotVector(degree, knots).rescaled(0, 1);
}

Surface spherePatch(Index n, Index m, int degree, Index clean, Knots kind) {
  Net net(n * m, 3);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < m; ++j) {
      const double lon = -0.6 + 1.2 * static_cast<double>(i) / static_cast<double>(n - 1);
      const double lat = -0.6 + 1.2 * static_cast<double>(j) / static_cast<double>(m - 1);
      net.row(i * m + j) << std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat);
    }
  }
  std::mt19937_64 random(1995);
  const auto draw = [&] { return 2 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1; };
  for (Index j = clean; j < m - clean; ++j) {
    for (Index i = clean; i < n - clean; ++i) {
      Eigen::RowVector3d r;
      do {
        r[0] = draw();
        r[1] = draw();
        r[2] = draw();
      } while (r.squaredNorm() > 1);
      net.row(i * m + j) += 0.02 * r;
    }
  }
  return Surface({makeKnots(degree, n, kind), makeKnots(degree, m, kind)}, std::move(net));
}

double megabytes(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kilobytes = 0;
    if (word == key && status >> kilobytes) return kilobytes / 1024;
  }
  return 0;
}

void fair(benchmark::State& state, const Surface& input, const std::string& energy, Index strip, double tolerance,
          double gap) {
  OptimalFairingOptions options;
  options.held = holdStrips<2>(input, {strip, strip, strip, strip});
  options.tolerance = tolerance;
  options.gap = gap;
  options.scale = ParameterScale::domain;
  std::ofstream("/proc/self/clear_refs") << "5";  // the peak counts from here
  const double before = megabytes("VmRSS:");
  FairingSummary summary;
  for (auto _ : state) {
    summary = fairOptimally<2>(input, energyNamed<2>(energy), options).summary;
    state.SetIterationTime(summary.seconds);
  }
  state.counters["energy"] = summary.energyAfter;
  state.counters["gap"] = summary.gap;
  state.counters["iterations"] = static_cast<double>(summary.steps);
  state.counters["MB"] = megabytes("VmHWM:") - before;
}

void add(const std::string& name, Index n, Index m, int degree, Index strip, Index clean, Knots kind,
         const std::string& energy, double tolerance, double gap) {
  benchmark::RegisterBenchmark(name.c_str(),
                               [=](benchmark::State& state) {
                                 fair(state, spherePatch(n, m, degree, clean, kind), energy, strip, tolerance, gap);
                               })
      ->UseManualTime()
      ->Unit(benchmark::kMillisecond)
      ->MinTime(n * m < 50000 ? 0.3 : 0.01);
}

}  // namespace

int main(int argc, char** argv) {
  add("example1/free", 52, 52, 4, 5, 6, Knots::uniform, "thin-plate", kUnlimited, 1e-6);
  add("example1/0.02/1e-6", 52, 52, 4, 5, 6, Knots::uniform, "thin-plate", 0.02, 1e-6);
  add("example1/0.02/1e-8", 52, 52, 4, 5, 6, Knots::uniform, "thin-plate", 0.02, 1e-8);
  add("example1/0.02/third-derivatives/1e-6", 52, 52, 4, 5, 6, Knots::uniform, "third-derivatives", 0.02, 1e-6);
  for (Index n : {50, 100, 200, 500, 1000}) {
    const std::string size = std::to_string(n) + "x" + std::to_string(n);
    add(size + "/free", n, n, 3, 3, 3, Knots::uniform, "thin-plate", kUnlimited, 1e-6);
    add(size + "/0.02/" +
            (n < 500    ? "1e-6"
             : n == 500 ? "1e-5"
                        : "1e-4"),
        n, n, 3, 3, 3, Knots::uniform, "thin-plate", 0.02,
        n < 500    ? 1e-6
        : n == 500 ? 1e-5
                   : 1e-4);
  }
  for (Index n : {50, 200, 500}) {
    const std::string size = std::to_string(n) + "x" + std::to_string(n);
    add(size + "/uneven-knots/free", n, n, 3, 3, 3, Knots::uneven, "thin-plate", kUnlimited, 1e-6);
    add(size + "/uneven-knots/0.02/1e-5", n, n, 3, 3, 3, Knots::uneven, "thin-plate", 0.02, 1e-5);
    add(size + "/double-knots/free", n, n, 3, 3, 3, Knots::doubled, "thin-plate", kUnlimited, 1e-6);
    add(size + "/double-knots/0.02/1e-5", n, n, 3, 3, 3, Knots::doubled, "thin-plate", 0.02, 1e-5);
    add(size + "/third-derivatives/free", n, n, 3, 3, 3, Knots::uniform, "third-derivatives", kUnlimited, 1e-6);
  }
  add("1000x20/free", 1000, 20, 3, 3, 3, Knots::uniform, "thin-plate", kUnlimited, 1e-6);
  add("1000x20/0.02/1e-5", 1000, 20, 3, 3, 3, Knots::uniform, "thin-plate", 0.02, 1e-5);
  add("10000x20/free", 10000, 20, 3, 3, 3, Knots::uniform, "thin-plate", kUnlimited, 1e-6);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
