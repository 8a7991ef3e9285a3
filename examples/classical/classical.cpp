// All methods for curves side by side on the same input and tolerance: what bending, curvature variation, curvature
// extrema, deviation and time each gives. Prints tables in Markdown.
//
//   strak_classical [TOLERANCE FILE]...     without arguments: a spiral with noise

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <random>

#include "strak/base/error.h"
#include "strak/exchange/model.h"
#include "strak/fairing/eck_hadenfeld.h"
#include "strak/fairing/exact_curve_fairing.h"
#include "strak/fairing/farin_sapidis.h"
#include "strak/fairing/kjellander.h"
#include "strak/fairing/optimal_fairing.h"
#include "strak/fairing/plan_curve.h"
#include "strak/metrology/fairness.h"

namespace {

using namespace strak;

Curve noisySpiral() {
  constexpr Index kPoints = 60;
  std::mt19937 random(1);
  const KnotVector knots = KnotVector::uniformClamped(3, kPoints - 3);
  Net net(kPoints, 2);
  for (Index i = 0; i < kPoints; ++i) {
    const double u = knots.greville()[static_cast<std::size_t>(i)], angle = 5 * u, radius = 2 + 8 * u;
    // Plain arithmetic on the generator's bits: the same noise with every library.
    const auto noise = [&] { return 0.02 * (static_cast<double>(random()) / 2147483648.0 - 1); };
    net.row(i) << radius * std::cos(angle) + noise(), radius * std::sin(angle) + noise();
  }
  return {{knots}, net};
}

void compare(const std::string& name, const Curve& curve, double tolerance) {
  const std::array<Index, 2> rows{1, 1};
  const CurvePlan exactPlan = planCurve(curve, rows);
  FairingPlanOptions<1> planOptions;
  planOptions.rows = rows;
  planOptions.refine = false;
  const HeldPoints held = planFairing(curve, planOptions).held;

  const auto exact = [&](Index extrema) {
    ExactCurveFairingOptions options;
    options.tolerance = tolerance;
    options.held = exactPlan.held;
    options.seamContinuity = exactPlan.seamContinuity;
    options.maxExtrema = extrema;
    return exactPlan.onInput(fairCurveExactly(exactPlan.spline, options).spline);
  };
  const auto quadratic = [&](const char* energy) {
    OptimalFairingOptions options;
    options.tolerance = tolerance;
    options.held = held;
    return fairOptimally(curve, energyNamed<1>(energy), options).spline;
  };
  const auto with = [&]<class Options>(Options options) {
    options.tolerance = tolerance;
    options.held = held;
    return options;
  };
  const auto eck = [&](int derivative) {
    EckHadenfeldOptions options = with(EckHadenfeldOptions{});
    options.derivative = derivative;
    return fairByEckHadenfeld(curve, options).spline;
  };
  const std::vector<std::pair<std::string, std::function<Curve()>>> methods{
      {"input", [&] { return curve; }},
      {"exact (curvature variation)", [&] { return exact(-1); }},
      {"exact, fewest extrema", [&] { return exact(0); }},
      {"optimal, squared X''", [&] { return quadratic("thin-plate"); }},
      {"optimal, squared X'''", [&] { return quadratic("third-derivatives"); }},
      {"Eck-Hadenfeld, X''", [&] { return eck(2); }},
      {"Eck-Hadenfeld, X'''", [&] { return eck(3); }},
      {"Farin-Sapidis, knots out and in", [&] { return fairByKnotRemoval(curve, with(CubicFairingOptions{})).spline; }},
      {"Farin, degree down and up", [&] { return fairByDegreeReduction(curve, with(CubicFairingOptions{})).spline; }},
      {"Kjellander", [&] { return fairByKjellander<1>(curve, with(KjellanderOptions{})).spline; }},
  };
  fmt::print("\n**{}**: {} control points, tolerance {:g}\n\n", name, curve.net().rows(), tolerance);
  fmt::print("| method | bending | curvature variation | extrema | deviation | time |\n|---|---|---|---|---|---|\n");
  for (const auto& [method, fair] : methods) {
    const auto begun = std::chrono::steady_clock::now();
    try {
      const Curve result = fair();
      const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
      const CurveFairness fairness = curveFairness(result);
      fmt::print("| {} | {:.4g} | {:.4g} | {} | {:.3g} | {:.0f} ms |\n", method, fairness.bending,
                 fairness.curvatureVariation, countCurvatureExtrema(result), certifyDeviation(curve, result).upper,
                 1000 * seconds);
    } catch (const InvalidInput& error) {
      fmt::print("| {} | {} | | | | |\n", method, error.what());
    }
  }
}

}  // namespace

int main(int count, char** arguments) {
  try {
    if (count < 3) compare("spiral with noise 0.02", noisySpiral(), 0.04);
    for (int i = 1; i + 1 < count; i += 2) {
      const auto model = strak::readModel(arguments[i + 1]);
      compare(model->objects().front().name, std::get<Curve>(model->objects().front().spline.value()),
              std::stod(arguments[i]));
    }
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}
