// Evaluation of a bi-quartic surface with 52 x 52 control points: position, first and second derivatives (18 numbers a
// point) on one thread, beside the packaged peers SISL and Open CASCADE in the same run. The last lines are the ratios.
//
// Every contestant is checked against the others before anything is measured.

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <random>

#include "strak/base/cpu.h"
#include "strak/spline/evaluator.h"

#ifdef STRAK_PEER_SISL
#include <sisl.h>
#endif
#ifdef STRAK_PEER_OCCT
#include <GeomAdaptor_Surface.hxx>
#include <Geom_BSplineSurface.hxx>
#endif

namespace {

using strak::Index;
using strak::Net;

constexpr int kRandom = 300'000;
constexpr int kSide = 500;
constexpr int kNumbers = 18;  // 6 derivatives of 3 coordinates

// A patch of the unit sphere with noise of 0.02 on the inner 40 x 40 control points: the input of the fairing
// benchmarks.
strak::Surface noisySphere() {
  constexpr int kPoints = 52;
  std::mt19937_64 engine(1995);
  const auto uniform = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  Net net(kPoints * kPoints, 3);
  for (int i = 0; i < kPoints; ++i) {
    for (int j = 0; j < kPoints; ++j) {
      const double longitude = -0.6 + 1.2 * i / 51;
      const double latitude = -0.6 + 1.2 * j / 51;
      net.row(i * kPoints + j) << std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
          std::sin(latitude);
    }
  }
  for (int j = 6; j <= 45; ++j) {
    for (int i = 6; i <= 45; ++i) {
      Eigen::RowVector3d noise;
      do {
        for (int c = 0; c < 3; ++c) noise[c] = 2 * uniform() - 1;
      } while (noise.squaredNorm() > 1);
      net.row(i * kPoints + j) += 0.02 * noise;
    }
  }
  const auto knots = strak::KnotVector::uniformClamped(4, 48);
  return {{knots, knots}, std::move(net)};
}

struct Input {
  strak::Surface surface = noisySphere();
  Net random{kRandom, 2};
  std::vector<double> side;
  // Results of all contestants go into memory that is already there.
  Net randomOut{kRandom, kNumbers};
  Net gridOut{kSide * kSide, kNumbers};

  Input() {
    std::mt19937_64 engine(7);
    for (Index r = 0; r < random.size(); ++r) random.data()[r] = static_cast<double>(engine() >> 11) * 0x1p-53;
    for (int i = 0; i < kSide; ++i) side.push_back(static_cast<double>(i) / (kSide - 1));
    randomOut.setZero();
    gridOut.setZero();
  }
};

Input& input() {
  static Input value;
  return value;
}

void strakRandom() {
  static const strak::Evaluator<2> evaluator(input().surface);
  evaluator.derivativesAt(input().random, 2, input().randomOut);
}
void strakGrid() {
  static const strak::Evaluator<2> evaluator(input().surface);
  evaluator.derivativesOnGrid({input().side, input().side}, 2, input().gridOut);
}
// The plain functions: preparation and memory for the result each time.
void strakRandomOneShot() { benchmark::DoNotOptimize(strak::derivativesAt(input().surface, input().random, 2).data()); }
void strakGridOneShot() {
  benchmark::DoNotOptimize(strak::derivativesOnGrid(input().surface, {input().side, input().side}, 2).data());
}

#ifdef STRAK_PEER_SISL
SISLSurf* sislSurface() {
  static SISLSurf* result = [] {
    const auto& surface = input().surface;
    std::vector<double> u = surface.knots(0).knots();
    std::vector<double> v = surface.knots(1).knots();
    std::vector<double> points;  // u fastest
    for (Index j = 0; j < surface.size(1); ++j) {
      for (Index i = 0; i < surface.size(0); ++i) {
        for (int c = 0; c < 3; ++c) points.push_back(surface.net()(surface.row({i, j}), c));
      }
    }
    return newSurf(static_cast<int>(surface.size(0)), static_cast<int>(surface.size(1)), 5, 5, u.data(), v.data(),
                   points.data(), 1, 3, 1);
  }();
  return result;
}

void checkSisl(int status) {
  if (status < 0) {
    fmt::print(stderr, "SISL failed with status {}\n", status);
    std::exit(1);
  }
}

void sislRandom() {
  SISLSurf* surface = sislSurface();
  int left1 = 0;
  int left2 = 0;
  int status = 0;
  double normal[3];
  for (int r = 0; r < kRandom; ++r) {
    double u[2] = {input().random(r, 0), input().random(r, 1)};
    s1421(surface, 2, u, &left1, &left2, &input().randomOut(r, 0), normal, &status);
    checkSisl(status);
  }
}

// Its grid has u fastest; the same surface with exchanged parameters costs the same, so the order is left as it is.
void sislGrid() {
  static std::vector<double> normals(static_cast<std::size_t>(kSide) * kSide * 3);
  int status = 0;
  s1506(sislSurface(), 2, kSide, input().side.data(), kSide, input().side.data(), input().gridOut.data(),
        normals.data(), &status);
  checkSisl(status);
}
#endif

#ifdef STRAK_PEER_OCCT
const Handle(Geom_BSplineSurface) & occtSurface() {
  static const Handle(Geom_BSplineSurface) result = [] {
    const auto& surface = input().surface;
    TColgp_Array2OfPnt poles(1, 52, 1, 52);
    for (int i = 0; i < 52; ++i) {
      for (int j = 0; j < 52; ++j) {
        const auto point = surface.net().row(surface.row({i, j}));
        poles.SetValue(i + 1, j + 1, gp_Pnt(point[0], point[1], point[2]));
      }
    }
    TColStd_Array1OfReal knots(1, 49);
    TColStd_Array1OfInteger multiplicities(1, 49);
    for (int i = 0; i <= 48; ++i) {
      knots.SetValue(i + 1, surface.knots(0)[4 + i]);
      multiplicities.SetValue(i + 1, i == 0 || i == 48 ? 5 : 1);
    }
    return new Geom_BSplineSurface(poles, knots, knots, multiplicities, multiplicities, 4, 4);
  }();
  return result;
}

void occtPoint(const Adaptor3d_Surface& surface, double u, double v, double* out) {
  gp_Pnt x;
  gp_Vec du, dv, duu, dvv, duv;
  surface.D2(u, v, x, du, dv, duu, dvv, duv);
  x.Coord(out[0], out[1], out[2]);
  const gp_Vec* vectors[] = {&du, &dv, &duu, &duv, &dvv};
  for (int k = 0; k < 5; ++k) vectors[k]->Coord(out[3 + 3 * k], out[4 + 3 * k], out[5 + 3 * k]);
}

// The adaptor keeps the last span's polynomial, which is what Open CASCADE offers for many points.
void occtGrid() {
  const GeomAdaptor_Surface adaptor(occtSurface());
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      occtPoint(adaptor, input().side[static_cast<std::size_t>(i)], input().side[static_cast<std::size_t>(j)],
                &input().gridOut(i * kSide + j, 0));
    }
  }
}

void occtRandom() {
  for (int r = 0; r < kRandom; ++r) {
    gp_Pnt x;
    gp_Vec du, dv, duu, dvv, duv;
    occtSurface()->D2(input().random(r, 0), input().random(r, 1), x, du, dv, duu, dvv, duv);
    double* out = &input().randomOut(r, 0);
    x.Coord(out[0], out[1], out[2]);
    const gp_Vec* vectors[] = {&du, &dv, &duu, &duv, &dvv};
    for (int k = 0; k < 5; ++k) vectors[k]->Coord(out[3 + 3 * k], out[4 + 3 * k], out[5 + 3 * k]);
  }
}
#endif

// Ends the program if a contestant's numbers differ from those of the plain evaluation, point by point.
void check(const char* name, void (*random)(), void (*grid)(), bool gridUFastest) {
  const auto& surface = input().surface;
  const auto compare = [&](const Net& out, Index row, double u, double v) {
    const Net expected = strak::derivatives(surface, {u, v}, 2);
    const Eigen::Map<const Net> found(out.data() + row * kNumbers, 6, 3);
    if ((found - expected).cwiseAbs().maxCoeff() > 1e-9 * expected.cwiseAbs().maxCoeff()) {
      fmt::print(stderr, "{} gives other derivatives at ({}, {})\n", name, u, v);
      std::exit(1);
    }
  };
  input().randomOut.setZero();
  input().gridOut.setZero();
  random();
  grid();
  for (int r = 0; r < kRandom; r += 997) compare(input().randomOut, r, input().random(r, 0), input().random(r, 1));
  for (int r = 0; r < kSide * kSide; r += 997) {
    const double slow = input().side[static_cast<std::size_t>(r / kSide)];
    const double fast = input().side[static_cast<std::size_t>(r % kSide)];
    compare(input().gridOut, r, gridUFastest ? fast : slow, gridUFastest ? slow : fast);
  }
}

void measure(const char* name, void (*work)(), int points) {
  benchmark::RegisterBenchmark(name,
                               [=](benchmark::State& state) {
                                 for (auto _ : state) work();
                                 state.SetItemsProcessed(state.iterations() * points);
                               })
      ->Unit(benchmark::kMillisecond)
      ->Repetitions(5)
      ->ReportAggregatesOnly(true);
}

// Prints as usual and keeps the median rates for the ratios.
class Ratios : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const auto& run : runs) {
      const auto rate = run.counters.find("items_per_second");
      if (run.aggregate_name == "median" && rate != run.counters.end()) {
        rates_[run.run_name.function_name] = rate->second;
      }
    }
  }

  void printRatios() const {
    fmt::print("\nMillion points a second on one thread (median), and how many times as fast as the peers\n");
    fmt::print("{:<8}{:>8}{:>10}{:>8}{:>8}{:>10}{:>10}\n", "", "strak", "one-shot", "SISL", "OCCT", "x SISL", "x OCCT");
    for (const std::string kind : {"random", "grid"}) {
      const auto rate = [&](const std::string& who) {
        const auto found = rates_.find(kind + "/" + who);
        return found == rates_.end() ? NAN : found->second / 1e6;
      };
      fmt::print("{:<8}{:>8.1f}{:>10.1f}{:>8.1f}{:>8.1f}{:>10.1f}{:>10.1f}\n", kind, rate("strak"),
                 rate("strak-one-shot"), rate("sisl"), rate("occt"), rate("strak") / rate("sisl"),
                 rate("strak") / rate("occt"));
    }
  }

 private:
  std::map<std::string, double> rates_;
};

}  // namespace

int main(int argc, char** argv) {
  const tbb::global_control oneThread(tbb::global_control::max_allowed_parallelism, 1);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  constexpr const char* kLevels[] = {"generic", "avx2", "avx512"};
  benchmark::AddCustomContext("instruction set", kLevels[static_cast<int>(strak::simdLevel())]);

  check("strak", strakRandom, strakGrid, false);
  measure("random/strak", strakRandom, kRandom);
  measure("random/strak-one-shot", strakRandomOneShot, kRandom);
  measure("grid/strak", strakGrid, kSide * kSide);
  measure("grid/strak-one-shot", strakGridOneShot, kSide * kSide);
#ifdef STRAK_PEER_SISL
  check("SISL", sislRandom, sislGrid, true);
  measure("random/sisl", sislRandom, kRandom);
  measure("grid/sisl", sislGrid, kSide * kSide);
#endif
#ifdef STRAK_PEER_OCCT
  check("Open CASCADE", occtRandom, occtGrid, false);
  measure("random/occt", occtRandom, kRandom);
  measure("grid/occt", occtGrid, kSide * kSide);
#endif
  Ratios reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  reporter.printRatios();
  return 0;
}
