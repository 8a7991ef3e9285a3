#include "strak/fairing/optimality_gap.h"

#include <gtest/gtest.h>

#include <random>

#include "strak/base/error.h"
#include "strak/energy/energy_operator.h"
#include "strak/fairing/local_fairing.h"
#include "strak/fairing/optimal_fairing.h"

namespace strak {
namespace {

Surface roughSurface(int degree, Index spans, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto u = KnotVector::uniformClamped(degree, spans);
  const auto v = KnotVector::uniformClamped(degree, spans + 2);
  return Surface({u, v}, Net::NullaryExpr(u.size() * v.size(), 3, [&] { return uniform(random); }));
}

TEST(OptimalityGap, IsAnUpperBoundOfTheTrueDistance) {
  const Surface input = roughSurface(3, 7, 1);
  const auto held = holdStrips<2>(input, {2, 2, 2, 2});
  for (const auto& energy : {thinPlate<2>(), laplacian<2>()}) {
    for (double tolerance : {0.05, 0.5, kUnlimited}) {
      OptimalFairingOptions best;
      best.held = held;
      best.tolerance = tolerance;
      best.gap = 1e-11;
      const auto optimum = fairOptimally<2>(input, energy, best);
      LocalFairingOptions early;
      early.held = held;
      early.tolerance = tolerance;
      for (Index steps : {0, 10, 200, 5000}) {
        early.maxSteps = steps;
        const auto faired = fairLocally<2>(input, energy, early);
        const double gap = optimalityGap<2>(input, faired.spline, energy, held, tolerance, ParameterScale::lengths);
        const double reached = faired.summary.energyAfter;
        EXPECT_GE(gap * reached, (reached - optimum.summary.energyAfter) * (1 - 1e-9) - 1e-10 * reached);
        if (steps == 5000) {
          EXPECT_LT(gap, 0.1);  // and not a useless one
        }
      }
    }
  }
}

TEST(OptimalityGap, ProvesTheOptimum) {
  const Surface input = roughSurface(4, 6, 2);
  const auto held = holdStrips<2>(input, {2, 2, 2, 2});
  OptimalFairingOptions options;
  options.held = held;
  for (double tolerance : {0.1, kUnlimited}) {
    options.tolerance = tolerance;
    const auto faired = fairOptimally<2>(input, thinPlate<2>(), options);
    EXPECT_LE(optimalityGap<2>(input, faired.spline, thinPlate<2>(), held, tolerance, options.scale), 2e-6);
  }
}

TEST(OptimalityGap, SaysInfinityWhereNothingIsProven) {
  const Surface input = roughSurface(3, 5, 3);
  EXPECT_TRUE(std::isinf(optimalityGap<2>(input, input, thinPlate<2>(), {}, kUnlimited, ParameterScale::unit)));
  const auto twoSides = holdStrips<2>(input, {2, 2, 0, 0});
  EXPECT_TRUE(std::isinf(optimalityGap<2>(input, input, laplacian<2>(), twoSides, kUnlimited, ParameterScale::unit)));
  EXPECT_FALSE(std::isinf(optimalityGap<2>(input, input, laplacian<2>(), twoSides, 0.1, ParameterScale::unit)));
}

TEST(OptimalityGap, RefusesNetsThatBreakTheRules) {
  const Surface input = roughSurface(3, 5, 4);
  const auto held = holdStrips<2>(input, {2, 2, 2, 2});
  Surface moved = input;
  moved.net()(0, 0) += 1e-6;
  EXPECT_THROW(optimalityGap<2>(input, moved, thinPlate<2>(), held, 1, ParameterScale::unit), InvalidInput);
  moved = input;
  moved.net().row(moved.net().rows() / 2 + 3).array() += 0.5;
  EXPECT_THROW(optimalityGap<2>(input, moved, thinPlate<2>(), held, 0.5, ParameterScale::unit), InvalidInput);
  EXPECT_THROW(optimalityGap<2>(input, roughSurface(3, 6, 4), thinPlate<2>(), {}, 1, ParameterScale::unit),
               InvalidInput);
}

// The two ways to the same limit.
TEST(LocalAndOptimal, AgreeToTheirCertificates) {
  for (int degree : {2, 3, 4}) {
    const Surface input = roughSurface(degree, 6, static_cast<unsigned>(degree));
    for (double tolerance : {0.02, 0.3}) {
      LocalFairingOptions local;
      local.held = holdStrips<2>(input, {2, 2, 2, 2});
      local.tolerance = tolerance;
      local.gap = 1e-6;
      OptimalFairingOptions optimal;
      optimal.held = local.held;
      optimal.tolerance = tolerance;
      optimal.gap = 1e-9;
      const auto a = fairLocally<2>(input, thinPlate<2>(), local);
      const auto b = fairOptimally<2>(input, thinPlate<2>(), optimal);
      EXPECT_LE(a.summary.gap, 1e-6);
      const double slack = 1e-12 * a.summary.energyBefore;
      EXPECT_LE(a.summary.energyAfter * (1 - a.summary.gap), b.summary.energyAfter + slack);
      EXPECT_LE(b.summary.energyAfter * (1 - b.summary.gap), a.summary.energyAfter + slack);
    }
  }
}

}  // namespace
}  // namespace strak
