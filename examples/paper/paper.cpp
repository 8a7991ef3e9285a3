// The three examples of Hadenfeld, "Local Energy Fairing of B-Spline Surfaces", section 8: writes the surfaces as .g2
// files, before and after, and prints the paper's figures beside ours. Usage: strak_paper_examples [FOLDER]

#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "examples/paper/surfaces.h"
#include "strak/base/error.h"
#include "strak/exchange/model.h"
#include "strak/fairing/local_fairing.h"
#include "strak/fairing/optimal_fairing.h"
#include "strak/metrology/closest_point.h"
#include "strak/metrology/deviation.h"
#include "strak/spline/evaluate.h"

namespace {

using namespace strak;

constexpr Index kMeasured = 200;  // parameters a direction: 40,000 as in the paper

struct Example {
  std::string name;
  Surface surface;
  std::optional<Net> points;  // what it approximates
  HeldPoints held;
  double tolerance = kUnlimited;
  ParameterScale scale = ParameterScale::domain;
  Index steps = kUnlimitedSteps;  // where the local method ends, as early as the paper's
  std::string paper{};            // what it says
};

std::vector<double> evenly(const KnotVector& knots) {
  std::vector<double> parameters;
  for (Index i = 0; i < kMeasured; ++i) {
    parameters.push_back(knots.from() + knots.length() * static_cast<double>(i) / static_cast<double>(kMeasured - 1));
  }
  return parameters;
}

Net pointsOn(const Surface& surface) {
  return derivativesOnGrid<2>(surface, {evenly(surface.knots(0)), evenly(surface.knots(1))}, 0);
}

double measuredError(const Surface& a, const Surface& b) {
  return (pointsOn(a) - pointsOn(b)).rowwise().norm().maxCoeff();
}

double averageDistance(const Surface& surface, const Net& points) {
  const ClosestPointFinder<2> finder(surface);
  double sum = 0;
  for (const auto& point : points.rowwise()) sum += finder.find(point).distance;
  return sum / static_cast<double>(points.rows());
}

double longestBoundary(const Surface& surface) {
  const Net points = pointsOn(surface);
  const auto length = [&](Index first, Index step) {
    double sum = 0;
    for (Index i = 1; i < kMeasured; ++i) {
      sum += (points.row(first + i * step) - points.row(first + (i - 1) * step)).norm();
    }
    return sum;
  };
  constexpr Index kLast = kMeasured - 1;
  return std::max({length(0, 1), length(kLast * kMeasured, 1), length(0, kMeasured), length(kLast, kMeasured)});
}

void writeSurface(const std::filesystem::path& path, const Surface& surface) { modelOf({surface})->write(path); }

void printResult(const char* method, const Example& example, const Faired<2>& faired) {
  const FairingSummary& s = faired.summary;
  const double certified = certifyDeviation<2>(example.surface, faired.spline).upper;
  fmt::print("  {:<8} energy {:.6g} -> {:.6g}, gap {:.1e}, {} steps, {:.4f} s, {}\n", method, s.energyBefore,
             s.energyAfter, s.gap, s.steps, s.seconds, stopReasonName(s.stopReason));
  fmt::print("           measured error {:.4g}, certified deviation {:.4g}",
             measuredError(example.surface, faired.spline), certified);
  if (example.points)
    fmt::print(", average distance of the points {:.4g}", averageDistance(faired.spline, *example.points));
  fmt::print("\n");
}

void run(const Example& example, const std::filesystem::path& folder) {
  fmt::print("{}\n  degree {} x {}, {} x {} points, longest boundary {:.4g}", example.name, example.surface.degree(0),
             example.surface.degree(1), example.surface.size(0), example.surface.size(1),
             longestBoundary(example.surface));
  if (example.points)
    fmt::print(", average distance of the points {:.4g}", averageDistance(example.surface, *example.points));
  fmt::print("\n  paper    {}\n", example.paper);
  writeSurface(folder / (example.name + ".g2"), example.surface);

  LocalFairingOptions local;
  local.tolerance = example.tolerance;
  local.held = example.held;
  local.scale = example.scale;
  local.maxSteps = example.steps;
  const auto stepwise = fairLocally<2>(example.surface, thinPlate<2>(), local);
  printResult("local", example, stepwise);
  writeSurface(folder / (example.name + "-local.g2"), stepwise.spline);

  OptimalFairingOptions optimal;
  optimal.tolerance = example.tolerance;
  optimal.held = example.held;
  optimal.scale = example.scale;
  const auto best = fairOptimally<2>(example.surface, thinPlate<2>(), optimal);
  printResult("optimal", example, best);
  writeSurface(folder / (example.name + "-optimal.g2"), best.spline);
}

HeldPoints corners(const Surface& surface) {
  HeldPoints held(static_cast<std::size_t>(surface.net().rows()), 0);
  for (Index i : {Index{0}, surface.size(0) - 1}) {
    for (Index j : {Index{0}, surface.size(1) - 1}) held[static_cast<std::size_t>(surface.row({i, j}))] = 1;
  }
  return held;
}

void runAll(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  Example sphere{"sphere", paper::perturbedSphere(), {}, {}, 0.02};
  sphere.held = holdStrips<2>(sphere.surface, {5, 5, 5, 5});
  sphere.paper = "tolerance 0.02, strip of 5 held: measured error 0.012, 23.73 s (HP 9000/735)";
  run(sphere, folder);

  paper::Approximation approximation = paper::noisySheet();
  Example sheet{"sheet", approximation.surface, approximation.points, corners(approximation.surface)};
  sheet.steps = 2600;
  sheet.paper = "no tolerance, corners held: measured error 2.157, average distance 0.726 -> 1.469, 0.29 s";
  run(sheet, folder);

  approximation = paper::bodyPanel();
  Example panel{"panel", approximation.surface, approximation.points, {}};
  panel.held = holdStrips<2>(panel.surface, {1, 1, 1, 1});
  panel.steps = 1500;
  panel.paper = "no tolerance, boundary held: measured error 1.754, 0.18 s";
  run(panel, folder);
}

}  // namespace

int main(int count, char** arguments) {
  try {
    runAll(count > 1 ? arguments[1] : ".");
  } catch (const std::exception& error) {
    fmt::print(stderr, "strak_paper_examples: {}\n", error.what());
    return dynamic_cast<const InvalidInput*>(&error) != nullptr ? 2 : 1;
  }
  return 0;
}
