#include "strak/fitting/least_squares.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <limits>
#include <random>

#include "strak/base/error.h"
#include "strak/energy/energy_operator.h"
#include "strak/spline/evaluate.h"
#include "tests/fitting/franke.h"

namespace strak {
namespace {

Net randomParameters(Index count, Index directions, double from, double to, unsigned seed = 3) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  Net result(count, directions);
  for (Index r = 0; r < count; ++r) {
    for (Index k = 0; k < directions; ++k) result(r, k) = std::lerp(from, to, unit(random));
  }
  return result;
}

std::array<KnotVector, 2> bicubic(Index spans, double from = 0, double to = 1) {
  return {KnotVector::uniformClamped(3, spans, from, to), KnotVector::uniformClamped(3, spans, from, to)};
}

TEST(LeastSquares, ReproducesSplinesOfItsOwnSpaceWithoutSmoothing) {
  for (const auto& [p, q] : std::vector<std::pair<int, int>>{{1, 2}, {3, 3}, {5, 4}}) {
    const std::array<KnotVector, 2> knots{KnotVector::uniformClamped(p, 9, -2, 3),
                                          KnotVector::uniformClamped(q, 7, 0, 0.1)};
    Net net(knots[0].size() * knots[1].size(), 3);
    std::mt19937_64 random(5);
    for (Index r = 0; r < net.rows(); ++r) {
      for (Index c = 0; c < 3; ++c) net(r, c) = static_cast<double>(random() >> 11) * 0x1p-53;
    }
    const Surface original(knots, net);
    Net parameters = randomParameters(20000, 2, 0, 1);
    parameters.col(0) = (5 * parameters.col(0)).array() - 2;
    parameters.col(1) *= 0.1;
    const Net values = derivativesAt<2>(original, parameters, 0);
    FitOptions<2> options;
    options.smoothing = Smoothing::fixed(0);
    const auto fit = fitLeastSquares<2>(knots, {parameters, values}, options);
    EXPECT_LT((fit.spline.net() - net).cwiseAbs().maxCoeff(), 1e-12) << p << ' ' << q;
    EXPECT_LT(fit.summary.max, 1e-12);
    EXPECT_EQ(fit.summary.freedom, static_cast<double>(net.rows()));
  }
}

TEST(LeastSquares, ReproducesPolynomialsThatTheEnergyDoesNotSee) {
  const Net parameters = randomParameters(50, 2, 0, 2);  // far fewer points than control points
  const auto knots = bicubic(17, 0, 2);
  for (const auto& energy : {thinPlate<2>(), thirdDerivatives<2>()}) {
    const bool third = energy.order() == 3;
    Net values(50, 1);
    const auto f = [&](double x, double y) { return 2 - x + 3 * y + (third ? x * x - 0.5 * x * y : 0); };
    for (Index r = 0; r < 50; ++r) values(r, 0) = f(parameters(r, 0), parameters(r, 1));
    FitOptions<2> options;
    options.energy = energy;
    for (const double lambda : {1e-6, 1.0}) {
      options.smoothing = Smoothing::fixed(lambda);
      const auto fit = fitLeastSquares<2>(knots, {parameters, values}, options);
      for (double x : {0.0, 0.3, 2.0}) {
        // Rounding of lambda K grows with lambda and, for third derivatives, with the sixth power of the knots'
        // density.
        EXPECT_NEAR(evaluate<2>(fit.spline, {x, 1.7})[0], f(x, 1.7), third ? 1e-9 + 1e-5 * lambda : 1e-8)
            << energy.name << ' ' << lambda;
      }
    }
  }
}

// min 1/n sum (x_k - a)^2 ... with the energy int f'^2 on [0, 1] and degree 1 on one span, by hand.
TEST(LeastSquares, MinimisesMeanSquarePlusLambdaTimesEnergy) {
  const KnotVector line = KnotVector::uniformClamped(1, 1, 0, 10);
  Net parameters(2, 1), values(2, 1);
  parameters << 0, 10;
  values << 1, 4;
  FitOptions<1> options;
  options.smoothing = Smoothing::fixed(0.25);
  const auto fit = fitLeastSquares<1>({line}, {parameters, values}, options);
  // f = (a, b): ((a - 1)^2 + (b - 4)^2) / 2 + (b - a)^2 / 4: the slope in the normalised domain is b - a = 3 / 2.
  EXPECT_NEAR(fit.spline.net()(0, 0), 1.75, 1e-14);
  EXPECT_NEAR(fit.spline.net()(1, 0), 3.25, 1e-14);
  EXPECT_NEAR(fit.summary.energy, 2.25, 1e-13);
  EXPECT_NEAR(fit.summary.rms, 0.75, 1e-14);
  EXPECT_NEAR(fit.summary.freedom, 1.5, 1e-6);  // 1 for the mean, 1 / (1 + 4 * 0.25) for the slope
}

TEST(LeastSquares, TheWeightMeansTheSameInOtherUnitsAndWithMorePoints) {
  const Net points = test::frankePoints(4000);
  FitOptions<2> options;
  options.smoothing = Smoothing::fixed(1e-7);
  const auto fit = fitLeastSquares<2>(bicubic(20), {points.leftCols(2), points.rightCols(1)}, options);
  // Every point three times; lengths in thousandths and shifted; heights in other units.
  Net other(12000, 3);
  for (Index r = 0; r < other.rows(); ++r) {
    other.row(r) << 1000 * points(r % 4000, 0) + 7, 1000 * points(r % 4000, 1) + 7, 25 * points(r % 4000, 2);
  }
  const auto same = fitLeastSquares<2>(bicubic(20, 7, 1007), {other.leftCols(2), other.rightCols(1)}, options);
  EXPECT_LT((same.spline.net() - 25 * fit.spline.net()).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_NEAR(same.summary.energy / fit.summary.energy, 625, 1e-4);
  EXPECT_NEAR(same.summary.freedom, fit.summary.freedom, 1e-4);
  // Finer knots: the same weight, nearly the same function.
  const auto finer = fitLeastSquares<2>(bicubic(40), {points.leftCols(2), points.rightCols(1)}, options);
  EXPECT_NEAR(finer.summary.freedom, fit.summary.freedom, 0.02 * fit.summary.freedom);
  EXPECT_NEAR(finer.summary.rms, fit.summary.rms, 1e-2 * fit.summary.rms);
}

TEST(LeastSquares, TheWeightOfPointsInSpaceDoesNotDependOnTheParametersScale) {
  // A sheet three times as long as wide, once with unit parameters, once stretched differently in u and v.
  const Net uv = randomParameters(3000, 2, 0, 1);
  Net points(3000, 3), stretched(3000, 2);
  std::mt19937_64 random(9);
  for (Index r = 0; r < 3000; ++r) {
    const double u = uv(r, 0), v = uv(r, 1);
    points.row(r) << 3 * u, v, std::sin(5 * u) * v + 0.01 * static_cast<double>(random() >> 11) * 0x1p-53;
    stretched.row(r) << 40 * u - 3, 0.2 * v;
  }
  FitOptions<2> options;
  options.smoothing = Smoothing::fixed(1e-6);
  const auto fit = fitLeastSquares<2>(bicubic(10), {uv, points}, options);
  const auto same =
      fitLeastSquares<2>({KnotVector::uniformClamped(3, 10, -3, 37), KnotVector::uniformClamped(3, 10, 0, 0.2)},
                         {stretched, points}, options);
  EXPECT_LT((fit.spline.net() - same.spline.net()).cwiseAbs().maxCoeff(), 1e-9);
  // The lengths count, not the parameters: other than with the unit square.
  options.scale = ParameterScale::unit;
  const auto unit = fitLeastSquares<2>(bicubic(10), {uv, points}, options);
  EXPECT_GT((fit.spline.net() - unit.spline.net()).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(LeastSquares, MeetsInterpolationConditionsExactly) {
  const Net points = test::frankePoints(2000);
  FitOptions<2> options;
  options.smoothing = Smoothing::fixed(1e-6);
  options.conditionParameters.resize(3, 2);
  options.conditionParameters << 0, 0, 0.5, 0.5, 1, 0.25;
  options.conditionValues.resize(3, 1);
  options.conditionValues << 1, -2, 0.5;
  const auto fit = fitLeastSquares<2>(bicubic(15), {points.leftCols(2), points.rightCols(1)}, options);
  EXPECT_NEAR(evaluate<2>(fit.spline, {0, 0})[0], 1, 1e-13);
  EXPECT_NEAR(evaluate<2>(fit.spline, {0.5, 0.5})[0], -2, 1e-13);
  EXPECT_NEAR(evaluate<2>(fit.spline, {1, 0.25})[0], 0.5, 1e-13);
  // It is the constrained minimum: any other net that meets them has a larger objective.
  const auto objective = [&](const Net& net) {
    FitErrors<2> errors(Surface(bicubic(15), net), 0);
    errors.add({points.leftCols(2), points.rightCols(1)});
    return errors.squares() / errors.weight() + 1e-6 * EnergyOperator<2>(thirdDerivatives<2>(), bicubic(15)).value(net);
  };
  const double least = objective(fit.spline.net());
  Net other = fit.spline.net();
  other(8 * 18 + 3, 0) += 1e-3;  // its function vanishes at the three places
  EXPECT_GT(objective(other), least);
  other(8 * 18 + 3, 0) -= 2e-3;
  EXPECT_GT(objective(other), least);

  options.conditionParameters.row(1) = options.conditionParameters.row(0);
  EXPECT_THROW(fitLeastSquares<2>(bicubic(15), {points.leftCols(2), points.rightCols(1)}, options), InvalidInput);
  options.conditionParameters(1, 0) = 2;
  EXPECT_THROW(fitLeastSquares<2>(bicubic(15), {points.leftCols(2), points.rightCols(1)}, options), InvalidInput);
}

TEST(LeastSquares, HeldRowsKeepTheirBits) {
  const Net points = test::frankePoints(3000);
  const auto knots = bicubic(12);
  FitOptions<2> options;
  options.heldNet = Net::Constant(15 * 15, 1, 1.0 / 3);
  for (Index j = 0; j < 15; ++j) {
    options.held.push_back(j);
    options.held.push_back(14 * 15 + j);
  }
  const auto fit = fitLeastSquares<2>(knots, {points.leftCols(2), points.rightCols(1)}, options);
  for (Index r : options.held) EXPECT_EQ(fit.spline.net()(r, 0), 1.0 / 3);
  EXPECT_LT(fit.summary.freedom, 13 * 15);
  // The rest is where the objective is least: no gradient there.
  FitErrors<2> errors(fit.spline, 0);
  errors.add({points.leftCols(2), points.rightCols(1)});
  const Net gradient = fit.summary.lambda * EnergyOperator<2>(thirdDerivatives<2>(), knots).product(fit.spline.net()) -
                       errors.right() / errors.weight();
  EXPECT_LT(gradient.middleRows(15, 13 * 15).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_GT(gradient.topRows(15).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(LeastSquares, WeightedPointsCountAsOftenAsTheirWeight) {
  const Net points = test::frankePoints(1500);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(1500);
  weights.head(500).setConstant(2);
  Net repeated(2000, 3);
  repeated << points, points.topRows(500);
  FitOptions<2> options;
  options.smoothing = Smoothing::fixed(1e-7);
  const auto fit = fitLeastSquares<2>(bicubic(12), {points.leftCols(2), points.rightCols(1), weights}, options);
  const auto same = fitLeastSquares<2>(bicubic(12), {repeated.leftCols(2), repeated.rightCols(1)}, options);
  EXPECT_LT((fit.spline.net() - same.spline.net()).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(LeastSquares, PointsOfWeightZeroAreNone) {
  const Net points = test::frankePoints(1500);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(1500);
  weights.tail(900).setZero();
  for (const Smoothing& smoothing : {Smoothing::automatic(), Smoothing::likeliest(), Smoothing::noise(0.01)}) {
    FitOptions<2> options;
    options.smoothing = smoothing;
    const auto fit = fitLeastSquares<2>(bicubic(12), {points.leftCols(2), points.rightCols(1), weights}, options);
    const Net few = points.topRows(600);
    const auto same = fitLeastSquares<2>(bicubic(12), {few.leftCols(2), few.rightCols(1)}, options);
    EXPECT_NEAR(fit.summary.lambda / same.summary.lambda, 1, 1e-6);
    EXPECT_LT((fit.spline.net() - same.spline.net()).cwiseAbs().maxCoeff(), 1e-8);
  }
}

TEST(LeastSquares, TheChosenWeightIsNearTheBestOnFranke) {
  const Net points = test::frankePoints(100000);
  EXPECT_EQ(points(0, 0), 0.75515553295453897);
  EXPECT_EQ(points(0, 1), 0.63903139385469743);
  EXPECT_NEAR(points(0, 2), 0.196016213, 1e-9);
  EXPECT_NEAR(points.col(2).sum(), 40581.2920081, 1e-6);
  const auto knots = bicubic(47);
  FitOptions<2> options;
  const auto chosen = fitLeastSquares<2>(knots, {points.leftCols(2), points.rightCols(1)}, options);
  const double error = test::frankeError(chosen.spline);
  EXPECT_LE(error, 6.4e-4);
  EXPECT_NEAR(chosen.summary.crossValidation, 0.01, 1e-4);
  double best = std::numeric_limits<double>::infinity();
  for (const double factor : {0.1, 0.3, 3.0, 10.0}) {
    options.smoothing = Smoothing::fixed(factor * chosen.summary.lambda);
    best = std::min(
        best, test::frankeError(fitLeastSquares<2>(knots, {points.leftCols(2), points.rightCols(1)}, options).spline));
  }
  EXPECT_LE(error, 1.05 * best);
}

TEST(LeastSquares, TheChosenWeightIsWhereCrossValidationIsLeast) {
  const Net points = test::frankePoints(2000, 0.05);
  const auto knots = bicubic(12);
  FitOptions<2> options;
  const auto at = [&](double lambda) {
    options.smoothing = Smoothing::fixed(lambda);
    return fitLeastSquares<2>(knots, {points.leftCols(2), points.rightCols(1)}, options).summary;
  };
  const auto chosen = fitLeastSquares<2>(knots, {points.leftCols(2), points.rightCols(1)}, options).summary;
  EXPECT_NEAR(at(chosen.lambda).freedom, chosen.freedom, 1e-3 * chosen.freedom);
  for (const double factor : {0.01, 0.5, 2.0, 100.0}) {
    EXPECT_GT(at(factor * chosen.lambda).crossValidation, chosen.crossValidation) << factor;
  }
}

// The trace by its definition: how much each fitted value changes with its own point.
TEST(LeastSquares, TheFreedomIsTheTraceOfTheInfluenceMatrix) {
  const Net points = test::frankePoints(60);
  const auto knots = bicubic(5);
  FitOptions<2> options;
  options.smoothing = Smoothing::fixed(1e-5);
  Net values = points.rightCols(1);
  const auto base = fitLeastSquares<2>(knots, {points.leftCols(2), values}, options);
  double trace = 0;
  for (Index r = 0; r < 60; ++r) {
    values(r, 0) += 1;
    const auto moved = fitLeastSquares<2>(knots, {points.leftCols(2), values}, options);
    const Surface::Parameter at{points(r, 0), points(r, 1)};
    trace += evaluate<2>(moved.spline, at)[0] - evaluate<2>(base.spline, at)[0];
    values(r, 0) -= 1;
  }
  EXPECT_NEAR(base.summary.freedom, trace, 0.01 * trace);
}

TEST(LeastSquares, LeavesTheNoiseThatIsKnown) {
  const Net points = test::frankePoints(20000);
  FitOptions<2> options;
  options.smoothing = Smoothing::noise(0.012);
  const auto fit = fitLeastSquares<2>(bicubic(20), {points.leftCols(2), points.rightCols(1)}, options);
  EXPECT_NEAR(fit.summary.rms, 0.012, 1e-5);
  EXPECT_TRUE(fit.summary.warnings.empty());
  options.smoothing = Smoothing::noise(1e-3);
  const auto impossible = fitLeastSquares<2>(bicubic(20), {points.leftCols(2), points.rightCols(1)}, options);
  ASSERT_EQ(impossible.summary.warnings.size(), 1U);
  EXPECT_NE(impossible.summary.warnings[0].find("no smoothing weight leaves the noise"), std::string::npos);
}

TEST(LeastSquares, DoesNotDependOnTheThreads) {
  const Net points = test::frankePoints(60000);
  const auto fitWith = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return fitLeastSquares<2>(bicubic(30), {points.leftCols(2), points.rightCols(1)});
  };
  EXPECT_EQ(fitWith(1).spline.net(), fitWith(4).spline.net());
}

TEST(LeastSquares, FitsCurvesInSpace) {
  Net parameters(400, 1), points(400, 3);
  for (Index r = 0; r < 400; ++r) {
    const double t = static_cast<double>(r) / 399;
    parameters(r, 0) = t;
    points.row(r) << std::cos(6 * t), std::sin(6 * t), t;
  }
  const auto fit = fitLeastSquares<1>({KnotVector::uniformClamped(5, 30)}, {parameters, points});
  EXPECT_LT(fit.summary.max, 1e-7);
}

TEST(LeastSquares, BridgesHolesSmoothly) {
  Net points = test::frankePoints(5000, 0);
  Index kept = 0;
  for (Index r = 0; r < 5000; ++r) {
    if (std::hypot(points(r, 0) - 0.6, points(r, 1) - 0.55) > 0.2) points.row(kept++) = points.row(r);
  }
  const auto fit =
      fitLeastSquares<2>(bicubic(30), {points.topRows(kept).leftCols(2), points.topRows(kept).rightCols(1)});
  EXPECT_LT(std::abs(evaluate<2>(fit.spline, {0.6, 0.55})[0] - test::franke(0.6, 0.55)), 0.15);
}

TEST(LeastSquares, DoesNotDependOnThePlaceOfTheModel) {
  const Net points = test::frankePoints(5000);
  Net moved = points;
  moved.col(0).array() += 5e5;
  moved.col(1).array() += 4e6;
  moved.col(2).array() += 1e7;
  const auto here = fitLeastSquares<2>(bicubic(15), {points.leftCols(2), points.rightCols(1)});
  const auto there = fitLeastSquares<2>(
      {KnotVector::uniformClamped(3, 15, 5e5, 5e5 + 1), KnotVector::uniformClamped(3, 15, 4e6, 4e6 + 1)},
      {moved.leftCols(2), moved.rightCols(1)});
  EXPECT_NEAR(there.summary.lambda, here.summary.lambda, 1e-3 * here.summary.lambda);
  EXPECT_LT((there.spline.net().array() - 1e7 - here.spline.net().array()).abs().maxCoeff(), 1e-6);
}

TEST(LeastSquares, SaysWhereACloudHasTwoSheets) {
  Net points = test::frankePoints(8000);
  const auto warningsOf = [](const Net& xyz) {
    return fitLeastSquares<2>(bicubic(10), {xyz.leftCols(2), xyz.rightCols(1)}).summary.warnings;
  };
  EXPECT_TRUE(warningsOf(points).empty());
  Net folded = points;
  for (Index r = 0; r < 8000; r += 3) {
    if (points(r, 0) > 0.5) folded(r, 2) += 0.2 + points(r, 1);
  }
  const auto fit = fitLeastSquares<2>(bicubic(10), {folded.leftCols(2), folded.rightCols(1)});
  EXPECT_NEAR(twoGroups<2>(fit).share, 0.5, 0.1);
  EXPECT_GT(twoGroups<2>(fit).place[0], 0.5);
  ASSERT_EQ(fit.summary.warnings.size(), 1U);
  EXPECT_NE(fit.summary.warnings[0].find("two sheets"), std::string::npos);
}

TEST(LeastSquares, TakesOutliersForNoSheet) {
  Net points = test::frankePoints(2000);
  for (Index r = 0; r < 2000; r += 20) points(r, 2) += r % 40 == 0 ? 1 : -1;
  const auto fit = fitLeastSquares<2>(bicubic(10), {points.leftCols(2), points.rightCols(1)});
  EXPECT_LT(twoGroups<2>(fit).share, 0.05);
  EXPECT_TRUE(fit.summary.warnings.empty());
}

TEST(LeastSquares, RefusesWhatItCannotDo) {
  const Net points = test::frankePoints(20);
  const auto fit = [&](const Net& xyz, const FitOptions<2>& options) {
    return fitLeastSquares<2>(bicubic(12), {xyz.leftCols(2), xyz.rightCols(1)}, options);
  };
  FitOptions<2> options;
  EXPECT_THROW(fit(Net(0, 3), options), InvalidInput);
  EXPECT_THROW(fit((points.array() + 5).matrix(), options), InvalidInput);
  options.smoothing = Smoothing::fixed(0);
  EXPECT_THROW(fit(points, options), InvalidInput);  // 20 points, 225 control points
  options.smoothing = Smoothing::fixed(-1);
  EXPECT_THROW(fit(points, options), InvalidInput);
  options.smoothing = Smoothing::automatic();
  const auto few = fit(points, options);
  ASSERT_FALSE(few.summary.warnings.empty());
  EXPECT_TRUE(few.spline.net().allFinite());
  // All points on a line: a plane through it may still turn about it.
  Net line = points;
  line.col(1) = line.col(0);
  EXPECT_THROW(fit(line, options), InvalidInput);
  EXPECT_THROW(fit(points.topRows(1), options), InvalidInput);
  // Squares beyond the numbers there are.
  Net extreme = points;
  extreme.col(2) *= 1e200;
  EXPECT_THROW(fit(extreme, options), InvalidInput);
  extreme.col(2) *= 1e-250;
  extreme.col(2) *= 1e-150;
  EXPECT_THROW(fit(extreme, options), InvalidInput);
}

TEST(LeastSquares, TheGraphOfAFunctionIsExact) {
  const auto knots = bicubic(4, 2, 5);
  Net net(49, 1);
  for (Index r = 0; r < 49; ++r) net(r, 0) = std::sin(static_cast<double>(r));
  const Surface function(knots, net), graph = graphOf<2>(function);
  const Point at = evaluate<2>(graph, {2.7, 4.1});
  EXPECT_NEAR(at[0], 2.7, 1e-14);
  EXPECT_NEAR(at[1], 4.1, 1e-14);
  EXPECT_EQ(at[2], evaluate<2>(function, {2.7, 4.1})[0]);
  EXPECT_THROW(graphOf<2>(graph), InvalidInput);
}

}  // namespace
}  // namespace strak
