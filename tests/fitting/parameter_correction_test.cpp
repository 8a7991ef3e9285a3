#include "strak/fitting/parameter_correction.h"

#include <gtest/gtest.h>

#include <random>

#include "strak/base/error.h"
#include "strak/fitting/parametrization.h"
#include "strak/metrology/closest_point.h"

namespace strak {
namespace {

template <int D>
FitMaker<D> onKnots(const std::array<KnotVector, D>& knots, Smoothing smoothing) {
  return [=](const FitPoints<D>& points, const Fit<D>*) {
    FitOptions<D> options;
    options.smoothing = smoothing;
    return fitLeastSquares<D>(knots, points, options);
  };
}

TEST(ParameterCorrection, FindsTheDistancesOfACurve) {
  // Points of a circle with parameters that run unevenly: a good fit of the shape, but not at these parameters.
  Net parameters(300, 1), points(300, 2);
  for (Index r = 0; r < 300; ++r) {
    const double t = static_cast<double>(r) / 299;
    points.row(r) << std::cos(2 * t), std::sin(2 * t);
    parameters(r, 0) = t + 0.02 * std::sin(40 * t) * t * (1 - t);
  }
  const auto make = onKnots<1>({KnotVector::uniformClamped(3, 8)}, Smoothing::fixed(1e-12));
  CorrectionOptions options;
  options.rounds = 60;
  const auto result = fitWithCorrection<1>({parameters, points}, make, options);
  EXPECT_GT(result.rms.front(), 1e-3);
  EXPECT_LT(result.rms.back(), 2e-5);
  for (std::size_t i = 1; i < result.rms.size(); ++i) EXPECT_LT(result.rms[i], result.rms[i - 1]);
  // The errors are the distances to the curve.
  double worst = 0;
  for (Index r = 0; r < 300; ++r) worst = std::max(worst, closestPoint<1>(result.fit.spline, points.row(r)).distance);
  EXPECT_NEAR(result.fit.summary.max, worst, 0.05 * worst);
}

TEST(ParameterCorrection, BringsASheetFromItsPlaneToItsNoise) {
  // A strongly curved cap whose plane parameters are crowded at the rim.
  std::mt19937_64 random(6);
  std::normal_distribution<double> noise(0, 1e-3);
  std::uniform_real_distribution<double> unit(-1, 1);
  Net points(6000, 3);
  for (Index r = 0; r < points.rows(); ++r) {
    const double a = 1.2 * unit(random), b = 1.1 * unit(random), radius = 1 + noise(random);
    points.row(r) << radius * std::sin(a), radius * std::cos(a) * std::sin(b), radius * std::cos(a) * std::cos(b);
  }
  const Net start = planeParameters(points);
  std::array<KnotVector, 2> knots;
  for (std::size_t k = 0; k < 2; ++k) {
    const auto column = start.col(static_cast<Index>(k));
    knots[k] = KnotVector::uniformClamped(3, 9, column.minCoeff(), column.maxCoeff());
  }
  const auto result = fitWithCorrection<2>({start, points}, onKnots<2>(knots, Smoothing::automatic()));
  EXPECT_GT(result.rounds, 0);
  EXPECT_LT(result.rms.back(), result.rms.front());
  EXPECT_NEAR(result.fit.summary.rms, 1e-3, 2e-4);
  for (Index k = 0; k < 2; ++k) {
    EXPECT_GE(result.parameters.col(k).minCoeff(), knots[static_cast<std::size_t>(k)].from());
    EXPECT_LE(result.parameters.col(k).maxCoeff(), knots[static_cast<std::size_t>(k)].to());
  }
}

TEST(ParameterCorrection, RefusesFunctionsAndStopsWhenAsked) {
  Net parameters(50, 1), heights(50, 1), points(50, 2);
  for (Index r = 0; r < 50; ++r) {
    parameters(r, 0) = static_cast<double>(r) / 49;
    heights(r, 0) = 1;
    points.row(r) << parameters(r, 0), std::sin(9 * parameters(r, 0));
  }
  const std::array<KnotVector, 1> knots{KnotVector::uniformClamped(3, 5)};
  EXPECT_THROW(fitWithCorrection<1>({parameters, heights}, onKnots<1>(knots, Smoothing::automatic())), InvalidInput);
  CorrectionOptions options;
  options.progress = Progress([](double, std::string_view) { return false; });
  const auto stopped = fitWithCorrection<1>({parameters, points}, onKnots<1>(knots, Smoothing::automatic()), options);
  EXPECT_TRUE(stopped.fit.summary.stopped);
  EXPECT_EQ(stopped.rounds, 0);
}

}  // namespace
}  // namespace strak
