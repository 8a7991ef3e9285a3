// Local fairing of the first example of Hadenfeld's paper (strak/fairing/local_fairing.h).

#include <gtest/gtest.h>

#include "strak/fairing/local_fairing.h"
#include "tests/energy/hadenfeld_net.h"
#include "tests/fairing/within_balls.h"

namespace strak {
namespace {

using testing::expectWithinBalls;
using testing::hadenfeldSurface;

LocalFairingOptions hadenfeldOptions(const Surface& surface) {
  LocalFairingOptions options;
  options.tolerance = 0.02;
  options.held = holdStrips<2>(surface, {5, 5, 5, 5});
  options.scale = ParameterScale::domain;
  return options;
}

TEST(HadenfeldExample, HasTheKnownPath) {
  const Surface surface = hadenfeldSurface(true);
  LocalFairingOptions options = hadenfeldOptions(surface);
  options.gap = 0;
  for (const auto& [steps, energy, error] :
       {std::tuple{2000, 2191.15, 0.01}, {50'000, 2144.79, 0.005}, {200'000, 2144.686, 5e-4}}) {
    options.maxSteps = steps;
    EXPECT_NEAR(fairLocally<2>(surface, thinPlate<2>(), options).summary.energyAfter, energy, error);
  }
}

TEST(HadenfeldExample, IsCertified) {
  const Surface surface = hadenfeldSurface(true);
  const LocalFairingOptions options = hadenfeldOptions(surface);
  const auto result = fairLocally<2>(surface, thinPlate<2>(), options);
  EXPECT_EQ(result.summary.stopReason, StopReason::gap);
  EXPECT_NEAR(result.summary.energyBefore, 3754.11852461, 1e-8);
  const double gap = (result.summary.energyAfter - 2144.68158900) / result.summary.energyAfter;
  EXPECT_LE(gap, result.summary.gap);
  EXPECT_LE(result.summary.gap, 1e-6);
  EXPECT_GT(gap, 0.01 * result.summary.gap);  // the bound is not a wild one
  EXPECT_EQ(result.summary.freePoints, 42 * 42);
  EXPECT_NEAR(static_cast<double>(result.summary.activePoints), 96, 5);
  expectWithinBalls(surface, result.spline, options.held, 0.02);
}

TEST(HadenfeldExample, RankedLiterallyHangsUpAtAPointOnItsBall) {
  const Surface surface = hadenfeldSurface(true);
  LocalFairingOptions options = hadenfeldOptions(surface);
  options.ranking = RankingNumber::literal;
  const auto hung = fairLocally<2>(surface, thinPlate<2>(), options);
  EXPECT_EQ(hung.summary.stopReason, StopReason::stalled);
  EXPECT_GT(hung.summary.energyAfter, 2200);
  EXPECT_GT(hung.summary.gap, 0.01);
  EXPECT_LT(hung.summary.steps, 10'000);

  // The paper's cure, a cap, ends short of the minimum.
  options.maxChangesPerPoint = 20;
  const auto capped = fairLocally<2>(surface, thinPlate<2>(), options);
  EXPECT_EQ(capped.summary.stopReason, StopReason::gain);
  EXPECT_LE(capped.summary.steps, 20 * capped.summary.freePoints);
  EXPECT_LT(capped.summary.energyAfter, 2150);
  EXPECT_GT(capped.summary.energyAfter, 2144.682 + 0.5);
  EXPECT_GE(capped.summary.gap, (capped.summary.energyAfter - 2144.68158900) / capped.summary.energyAfter);
  expectWithinBalls(surface, capped.spline, options.held, 0.02);

  // Long lists only delay it.
  options.maxChangesPerPoint = kUnlimitedSteps;
  options.pointsPerList = 5;
  EXPECT_EQ(fairLocally<2>(surface, thinPlate<2>(), options).summary.stopReason, StopReason::stalled);
}

TEST(HadenfeldExample, ReturnsTheBestNetSoFarWhenCancelled) {
  const Surface surface = hadenfeldSurface(true);
  LocalFairingOptions options = hadenfeldOptions(surface);
  options.gap = 1e-12;
  int calls = 0;
  double last = -1;
  options.progress = Progress([&](double fraction, std::string_view message) {
    EXPECT_GE(fraction, last);
    EXPECT_LE(fraction, 1);
    EXPECT_NE(message.find("gap"), std::string_view::npos);
    last = fraction;
    return ++calls < 3;
  });
  const auto result = fairLocally<2>(surface, thinPlate<2>(), options);
  EXPECT_EQ(result.summary.stopReason, StopReason::cancelled);
  EXPECT_EQ(calls, 3);
  EXPECT_GT(result.summary.steps, 0);
  EXPECT_LT(result.summary.energyAfter, 2150);
  expectWithinBalls(surface, result.spline, options.held, 0.02);

  options.progress = Progress([](double, std::string_view) { return false; });
  const auto atOnce = fairLocally<2>(surface, thinPlate<2>(), options);
  EXPECT_EQ(atOnce.summary.stopReason, StopReason::cancelled);
  EXPECT_EQ(atOnce.spline, surface);
}

}  // namespace
}  // namespace strak
