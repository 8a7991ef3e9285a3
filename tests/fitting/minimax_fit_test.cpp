#include "strak/fitting/minimax_fit.h"

#include <gtest/gtest.h>

#include "strak/spline/evaluate.h"
#include "tests/fitting/franke.h"

namespace strak {
namespace {

// The best cubic to x^4 on [-1, 1] is x^2 - 1 / 8, its error the Chebyshev polynomial T_4 / 8.
TEST(MinimaxFit, OfAQuarticByCubicsIsChebyshevs) {
  Net parameters(2001, 1), values(2001, 1);
  for (Index r = 0; r < 2001; ++r) {
    const double x = -1 + static_cast<double>(r) / 1000;
    parameters(r, 0) = x;
    values(r, 0) = x * x * x * x;
  }
  MinimaxFitOptions<1> options;
  options.fit.smoothing = Smoothing::fixed(0);
  options.gap = 1e-2;
  const auto result = fitMinimax<1>({KnotVector::uniformClamped(3, 1, -1, 1)}, {parameters, values}, options);
  EXPECT_TRUE(result.converged);
  EXPECT_NEAR(result.fit.summary.max, 0.125, 0.125 * 0.01);
  EXPECT_LE(result.bound, 0.125 * 0.125 * (1 + 1e-9));
  EXPECT_GE(result.objective, 0.125 * 0.125 * (1 - 1e-5));
  EXPECT_NEAR(evaluate<1>(result.fit.spline, {0})[0], -0.125, 2e-3);
}

TEST(MinimaxFit, IsBetterThanLeastSquaresAndCertified) {
  const Net points = test::frankePoints(3000, 0);
  const std::array<KnotVector, 2> knots{KnotVector::uniformClamped(3, 6), KnotVector::uniformClamped(3, 6)};
  MinimaxFitOptions<2> options;
  options.fit.smoothing = Smoothing::fixed(1e-10);
  options.gap = 0.1;
  const FitPoints<2> all{points.leftCols(2), points.rightCols(1)};
  const auto squares = fitLeastSquares<2>(knots, all, options.fit);
  const auto result = fitMinimax<2>(knots, all, options);
  EXPECT_TRUE(result.converged);
  EXPECT_LE(result.gap, 0.1);
  EXPECT_LT(result.fit.summary.max, 0.8 * squares.summary.max);
  EXPECT_NEAR(result.objective,
              result.fit.summary.max * result.fit.summary.max + result.fit.summary.lambda * result.fit.summary.energy,
              1e-12);
  options.rounds = 3;
  options.gap = 0;
  EXPECT_FALSE(fitMinimax<2>(knots, all, options).fit.summary.warnings.empty());
}

}  // namespace
}  // namespace strak
