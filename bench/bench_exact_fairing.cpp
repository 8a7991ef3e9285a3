// Exact fairing against size, and the sparse factor under it against the library's.
//
// Inputs: square bicubic nets on the unit sphere with longitude and latitude in [-0.6, 0.6], every point but a strip of
// three moved by 0.02 times a vector uniform in the unit ball (std::mt19937_64, seed 1995); the strip is held, the
// certified deviation at most 0.02.

#include <benchmark/benchmark.h>

#include <Eigen/SparseCholesky>
#include <cmath>
#include <random>

#include "strak/energy/shape_energy.h"
#include "strak/fairing/exact_fairing.h"
#include "strak/solve/nested_cholesky.h"

namespace {

using namespace strak;

constexpr Index kStrip = 3;

Surface noisySphere(Index n) {
  const KnotVector knots = KnotVector::uniformClamped(3, n - 3);
  std::mt19937_64 engine(1995);
  const auto number = [&] { return 2 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1; };
  Net net(n * n, 3);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      const double lon = -0.6 + 1.2 * static_cast<double>(i) / static_cast<double>(n - 1);
      const double lat = -0.6 + 1.2 * static_cast<double>(j) / static_cast<double>(n - 1);
      Eigen::RowVector3d noise;
      do {
        noise << number(), number(), number();
      } while (noise.squaredNorm() > 1);
      const bool inner = std::min({i, j, n - 1 - i, n - 1 - j}) >= kStrip;
      net.row(i * n + j) << std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat);
      if (inner) net.row(i * n + j) += 0.02 * noise;
    }
  }
  return {{knots, knots}, net};
}

void exactFairing(benchmark::State& state) {
  const Surface input = noisySphere(state.range(0));
  const HeldPoints held = holdStrips<2>(input, {kStrip, kStrip, kStrip, kStrip});
  ExactFairing result;
  for (auto _ : state) result = fairExactly(input, held, {.tolerance = 0.02});
  state.counters["steps"] = static_cast<double>(result.summary.steps);
  state.counters["plate"] = result.after.plate;
  state.counters["roughness"] = result.after.isophoteRoughness;
  state.counters["roughnessBefore"] = result.before.isophoteRoughness;
}
BENCHMARK(exactFairing)->Arg(24)->Arg(52)->Arg(100)->Unit(benchmark::kMillisecond)->Iterations(1);

// The Gauss-Newton matrix of such a net, with a little damping.
struct System {
  std::shared_ptr<const BlockPattern> pattern;
  BlockMatrix matrix;
  Eigen::MatrixX3d places;

  explicit System(const Surface& input) : System(input, numbered(input)) {}

 private:
  System(const Surface& input, const std::vector<int>& unknownOf)
      : System(input, ShapeEnergy(input, unknownOf), unknownOf) {}
  System(const Surface& input, const ShapeEnergy& energy, const std::vector<int>& unknownOf)
      : pattern(std::make_shared<const BlockPattern>(
            patternOfCliques(1 + *std::max_element(unknownOf.begin(), unknownOf.end()), energy.cliques()))),
        matrix(pattern),
        places(pattern->size(), 3) {
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(3 * pattern->size());
    energy.addStep(input.net(), {1, 1, 0}, matrix, gradient);
    const Eigen::VectorXd diagonal = matrix.pointDiagonal();
    matrix.addDiagonal(1e-3 * diagonal);
    for (std::size_t r = 0; r < unknownOf.size(); ++r) {
      if (unknownOf[r] >= 0) places.row(unknownOf[r]) = input.net().row(static_cast<Index>(r));
    }
  }
  static std::vector<int> numbered(const Surface& input) {
    const HeldPoints held = holdStrips<2>(input, {kStrip, kStrip, kStrip, kStrip});
    std::vector<int> unknownOf(held.size(), -1);
    int count = 0;
    for (std::size_t r = 0; r < held.size(); ++r) {
      if (!held[r]) unknownOf[r] = count++;
    }
    return unknownOf;
  }
};

void nestedCholesky(benchmark::State& state) {
  const System system(noisySphere(state.range(0)));
  NestedCholesky factor(system.pattern, system.places);
  for (auto _ : state) {
    if (!factor.factor(system.matrix)) state.SkipWithError("not positive definite");
  }
  state.counters["numbers"] = static_cast<double>(factor.factorSize());
}
BENCHMARK(nestedCholesky)->Arg(24)->Arg(52)->Arg(100)->Unit(benchmark::kMillisecond);

// Eigen's factor of one column at a time, minimum degree ordering.
void eigenCholesky(benchmark::State& state) {
  const System system(noisySphere(state.range(0)));
  std::vector<Eigen::Triplet<double>> entries;
  for (Index j = 0; j < system.pattern->size(); ++j) {
    for (Index k = system.pattern->start[static_cast<std::size_t>(j)];
         k < system.pattern->start[static_cast<std::size_t>(j) + 1]; ++k) {
      const Index i = system.pattern->rows[static_cast<std::size_t>(k)];
      for (int c = 0; c < 9; ++c) {
        if (i != j || c / 3 >= c % 3) entries.emplace_back(3 * i + c / 3, 3 * j + c % 3, system.matrix.at(k)[c]);
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(3 * system.pattern->size(), 3 * system.pattern->size());
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor;
  factor.analyzePattern(matrix);
  for (auto _ : state) factor.factorize(matrix);
  state.counters["numbers"] = static_cast<double>(factor.matrixL().nestedExpression().nonZeros());
}
BENCHMARK(eigenCholesky)->Arg(24)->Arg(52)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
