// Fits of a noisy grid beside Open CASCADE's approximation (GeomAPI_PointsToBSplineSurface) in the same run, on one
// thread: Franke's function at 50 x 50 and 100 x 100 places with gaussian noise of 0.01. For the ratios, and FITPACK in
// the same run: peers/fitting.py.
//
// Open CASCADE takes grids only, and larger ones take it minutes. It is given three times the noise as its tolerance;
// with a smaller one it follows the noise. "true_rms" is the error against the function without noise.

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include "strak/fitting/least_squares.h"
#include "tests/fitting/franke.h"

#ifdef STRAK_PEER_OCCT
#include <GeomAPI_PointsToBSplineSurface.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Standard_Failure.hxx>
#include <TColgp_Array2OfPnt.hxx>
#endif

namespace {

using namespace strak;

constexpr double kNoise = 0.01;

// Rows x, y, value; the grid's rows one after the other. The noise is that of frankePoints.
Net noisyGrid(Index side) {
  const Net scattered = test::frankePoints(side * side);
  Net points(side * side, 3);
  for (Index r = 0; r < points.rows(); ++r) {
    const double x = static_cast<double>(r / side) / static_cast<double>(side - 1);
    const double y = static_cast<double>(r % side) / static_cast<double>(side - 1);
    const double noise = scattered(r, 2) - test::franke(scattered(r, 0), scattered(r, 1));
    points.row(r) << x, y, test::franke(x, y) + noise;
  }
  return points;
}

void leastSquares(benchmark::State& state) {
  const Net points = noisyGrid(state.range(0));
  const KnotVector knots = KnotVector::uniformClamped(3, 47);
  Fit<2> fit;
  for (auto _ : state) fit = fitLeastSquares<2>({knots, knots}, {points.leftCols(2), points.rightCols(1)}, {});
  state.counters["true_rms"] = test::frankeError(fit.spline);
  state.counters["points"] = static_cast<double>(fit.spline.net().rows());
}

#ifdef STRAK_PEER_OCCT
// Root of the mean square of the error at the points' own places of a finer grid; the surface is (x, y, z)(u, v) with
// nearly, but not exactly, x = u and y = v: its own x and y are taken.
double errorOf(const Geom_BSplineSurface& surface) {
  double u0 = 0, u1 = 1, v0 = 0, v1 = 1, sum = 0;
  surface.Bounds(u0, u1, v0, v1);
  for (int i = 0; i < 200; ++i) {
    for (int k = 0; k < 200; ++k) {
      const gp_Pnt p = surface.Value(u0 + (u1 - u0) * i / 199, v0 + (v1 - v0) * k / 199);
      const double e = p.Z() - test::franke(p.X(), p.Y());
      sum += e * e;
    }
  }
  return std::sqrt(sum / 40000);
}

void openCascade(benchmark::State& state, bool variational) {
  const Index side = state.range(0);
  const Net points = noisyGrid(side);
  TColgp_Array2OfPnt grid(1, static_cast<int>(side), 1, static_cast<int>(side));
  for (Index r = 0; r < points.rows(); ++r) {
    grid.SetValue(static_cast<int>(r / side) + 1, static_cast<int>(r % side) + 1,
                  gp_Pnt(points(r, 0), points(r, 1), points(r, 2)));
  }
  Handle(Geom_BSplineSurface) surface;
  for (auto _ : state) {
    try {
      const GeomAPI_PointsToBSplineSurface fit =
          variational ? GeomAPI_PointsToBSplineSurface(grid, 1, 1, 1, 8, GeomAbs_C2, 3 * kNoise)
                      : GeomAPI_PointsToBSplineSurface(grid, 3, 8, GeomAbs_C2, 3 * kNoise);
      surface = fit.Surface();
    } catch (const Standard_Failure& failure) {
      state.SkipWithError(failure.GetMessageString());
      return;
    }
  }
  state.counters["true_rms"] = errorOf(*surface);
  state.counters["points"] = static_cast<double>(surface->NbUPoles() * surface->NbVPoles());
}
#endif

void registerAll() {
  const auto sides = [](benchmark::internal::Benchmark* one) {
    one->Arg(50)->Arg(100)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
  };
  sides(benchmark::RegisterBenchmark("strak", leastSquares));
#ifdef STRAK_PEER_OCCT
  sides(benchmark::RegisterBenchmark("open-cascade", openCascade, false));
  sides(benchmark::RegisterBenchmark("open-cascade-variational", openCascade, true));
#endif
}

}  // namespace

int main(int argc, char** argv) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  benchmark::Initialize(&argc, argv);
  registerAll();
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
