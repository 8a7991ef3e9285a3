#include "strak/fairing/data_dependent_fairing.h"

#include <gtest/gtest.h>

#include "strak/base/error.h"
#include "strak/fairing/exact_fairing.h"
#include "strak/metrology/deviation.h"
#include "tests/energy/shape_surfaces.h"

namespace strak {
namespace {

using testing::bentSheet;
using testing::withRandomWeights;

// What every result promises.
void expectKept(const Surface& input, const DataDependentFairing& result, double tolerance, const HeldPoints& held) {
  constexpr double kRounding = 1 + 1e-9;
  EXPECT_LE(result.after.plate, kRounding * result.before.plate);
  EXPECT_LE(result.after.curvatureVariation, kRounding * result.before.curvatureVariation);
  EXPECT_LE(result.after.isophoteRoughness, kRounding * result.before.isophoteRoughness);
  EXPECT_LE(certifyDeviation(input, result.spline).upper, tolerance * (1 + 1e-9));
  for (std::size_t r = 0; r < held.size(); ++r) {
    if (held[r] == 0) continue;
    EXPECT_EQ(input.net().row(static_cast<Index>(r)), result.spline.net().row(static_cast<Index>(r))) << r;
  }
}

// A bent sheet with noise on the points that are not held.
Surface noisySheet(int p, int q, Index spans, double noise, const std::array<Index, 4>& strips, HeldPoints& held) {
  Surface sheet = bentSheet(p, q, spans, spans, noise);
  const Surface clean = bentSheet(p, q, spans, spans);
  held = holdStrips<2>(sheet, strips);
  for (std::size_t r = 0; r < held.size(); ++r) {
    if (held[r] != 0) sheet.net().row(static_cast<Index>(r)) = clean.net().row(static_cast<Index>(r));
  }
  return sheet;
}

TEST(DataDependentFairing, NoiseGoes) {
  HeldPoints held;
  const Surface input = noisySheet(3, 3, 8, 0.02, {2, 2, 2, 2}, held);
  const DataDependentFairing result = fairDataDependently(input, held, {.tolerance = 0.04});
  expectKept(input, result, 0.04, held);
  EXPECT_EQ(result.summary.stopReason, StopReason::gain);
  EXPECT_LT(result.summary.energyAfter, 0.5 * result.summary.energyBefore);
  const SurfaceFairness ideal = surfaceFairness(bentSheet(3, 3, 8, 8));
  EXPECT_LT(result.after.plate, 1.05 * ideal.plate);
  EXPECT_LT(result.after.isophoteRoughness, 0.5 * result.before.isophoteRoughness);
}

// In the input's own geometry its parameter lines may jitter as they do, and the knots cannot follow.
TEST(DataDependentFairing, AnEvenReferenceLeavesLessRoughness) {
  HeldPoints held;
  const Surface input = noisySheet(3, 3, 12, 0.03, {2, 2, 2, 2}, held);
  const DataDependentFairing even = fairDataDependently(input, held, {.tolerance = 0.05});
  const DataDependentFairing own = fairDataDependently(input, held, {.tolerance = 0.05, .evenStart = false});
  expectKept(input, own, 0.05, held);
  EXPECT_LT(even.after.isophoteRoughness, 0.5 * own.after.isophoteRoughness);
}

TEST(DataDependentFairing, EveryDegreeKeepsItsPromises) {
  for (int p = 2; p <= 4; ++p) {
    for (int q = 2; q <= 4; ++q) {
      HeldPoints held;
      const Surface input = noisySheet(p, q, 5, 0.02, {1, 1, 2, 1}, held);
      const DataDependentFairing result = fairDataDependently(input, held, {.tolerance = 0.02});
      expectKept(input, result, 0.02, held);
      EXPECT_LT(result.after.plate, result.before.plate) << p << q;
    }
  }
}

TEST(DataDependentFairing, RationalSurfacesKeepTheirWeights) {
  HeldPoints held;
  const Surface input = withRandomWeights(noisySheet(3, 3, 6, 0.02, {2, 2, 2, 2}, held));
  const DataDependentFairing result = fairDataDependently(input, held, {.tolerance = 0.02});
  expectKept(input, result, 0.02, held);
  EXPECT_GT(result.summary.largestMove, 0);
  EXPECT_EQ(result.spline.net().col(3), input.net().col(3));
}

TEST(DataDependentFairing, BallsOnPointsBoundTheMoves) {
  HeldPoints held;
  const Surface input = noisySheet(3, 3, 8, 0.02, {2, 2, 2, 2}, held);
  const DataDependentFairing points = fairDataDependently(input, held, {.tolerance = 0.004, .ballsOnPoints = true});
  const DataDependentFairing surface = fairDataDependently(input, held, {.tolerance = 0.004});
  EXPECT_LE(points.summary.largestMove, 0.004 * (1 + 1e-9));
  EXPECT_GT(surface.summary.largestMove, 0.004);
  EXPECT_GT(points.summary.activePoints, 0);
  EXPECT_LT(surface.summary.energyAfter, points.summary.energyAfter);
}

TEST(DataDependentFairing, DoesNotDependOnUnitsAndKnots) {
  HeldPoints held;
  const Surface input = noisySheet(3, 4, 5, 0.01, {2, 2, 2, 2}, held);
  const double tolerance = 0.01;
  const Net faired = fairDataDependently(input, held, {.tolerance = tolerance}).spline.net();
  const Surface knots{{input.knots(0).rescaled(-2, 5.3), input.knots(1).rescaled(0, 0.11)}, input.net()};
  EXPECT_LT((fairDataDependently(knots, held, {.tolerance = tolerance}).spline.net() - faired).cwiseAbs().maxCoeff(),
            1e-6 * tolerance);
  const Surface large{input.knots(), 1000 * input.net()};
  const Net scaled = fairDataDependently(large, held, {.tolerance = 1000 * tolerance}).spline.net() / 1000;
  EXPECT_LT((scaled - faired).cwiseAbs().maxCoeff(), 1e-6 * tolerance);
}

// Held at its plane border and nowhere else a crumpled sheet becomes the plane, the only surface that costs nothing.
TEST(DataDependentFairing, WithoutToleranceACrumpledPlaneBecomesPlane) {
  HeldPoints held;
  Surface input = noisySheet(4, 4, 6, 0, {1, 1, 1, 1}, held);
  for (Index r = 0; r < input.net().rows(); ++r) {
    input.net()(r, 2) = held[static_cast<std::size_t>(r)] != 0 ? 0 : 0.05 * std::sin(static_cast<double>(7 * r));
  }
  const DataDependentFairing result = fairDataDependently(input, held);
  EXPECT_LT(result.summary.energyAfter, 1e-6 * result.summary.energyBefore);
  EXPECT_LT(result.spline.net().col(2).cwiseAbs().maxCoeff(), 1e-4);
}

// Held at the border alone, a fair surface bends less only with more curvature variation.
TEST(DataDependentFairing, WhatGetsWorseIsTakenBack) {
  HeldPoints held;
  const Surface input = noisySheet(4, 4, 6, 0, {1, 1, 1, 1}, held);
  const DataDependentFairing result = fairDataDependently(input, held, {.tolerance = 0.05});
  expectKept(input, result, 0.05, held);
  EXPECT_GT(result.takenBack, 0);
}

TEST(DataDependentFairing, APlaneComesBackAsItWas) {
  Surface plane = bentSheet(3, 3, 4, 4);
  plane.net().col(2).setZero();
  const DataDependentFairing result = fairDataDependently(plane, {}, {.tolerance = 0.1});
  EXPECT_EQ(result.spline, plane);
  EXPECT_EQ(result.summary.stopReason, StopReason::nothingFree);
}

// Collapsed edges and nets on one line: no number that is none.
TEST(DataDependentFairing, DegenerateInputIsSurvived) {
  Surface pole = bentSheet(3, 3, 4, 4, 0.01);
  for (Index j = 0; j < pole.size(1); ++j) pole.net().row(j) = pole.net().row(0);
  const HeldPoints held = holdStrips<2>(pole, {2, 1, 0, 0});
  const DataDependentFairing result = fairDataDependently(pole, held, {.tolerance = 0.01});
  EXPECT_TRUE(result.spline.net().allFinite());
  expectKept(pole, result, 0.01, held);
  Surface line = bentSheet(3, 3, 3, 3);
  line.net().rightCols(2).setZero();
  EXPECT_EQ(fairDataDependently(line, {}, {.tolerance = 0.01}).spline, line);
}

TEST(DataDependentFairing, AStoppedRunReturnsTheBestSoFar) {
  const Surface input = bentSheet(3, 3, 6, 6, 0.02);
  int calls = 0;
  const Progress progress([&](double, std::string_view) { return ++calls < 2; });
  const DataDependentFairing result = fairDataDependently(input, {}, {.tolerance = 0.02, .progress = progress});
  EXPECT_EQ(result.summary.stopReason, StopReason::cancelled);
  EXPECT_EQ(result.summary.steps, 1);
  expectKept(input, result, 0.02, {});
}

TEST(DataDependentFairing, RefusesWhatMakesNoSense) {
  const Surface input = bentSheet(3, 3, 3, 3);
  EXPECT_THROW(fairDataDependently(input, {}), InvalidInput) << "no tolerance, nothing held";
  EXPECT_THROW(fairDataDependently(input, {}, {.tolerance = -1}), InvalidInput);
  EXPECT_THROW(fairDataDependently(input, {1, 0}, {.tolerance = 1}), InvalidInput);
  EXPECT_EQ(fairDataDependently(input, {}, {.tolerance = 0}).spline, input);
}

}  // namespace
}  // namespace strak
