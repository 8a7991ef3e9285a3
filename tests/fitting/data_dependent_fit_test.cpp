#include "strak/fitting/data_dependent_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "strak/base/error.h"
#include "strak/fitting/robust_fit.h"
#include "strak/spline/evaluate.h"
#include "tests/fitting/franke.h"

namespace strak {
namespace {

constexpr InnerBending kBoth[] = {InnerBending::beltrami, InnerBending::hessian};

std::array<KnotVector, 2> bicubic(Index size, double to = 1) {
  const KnotVector line = KnotVector::uniformClamped(3, size - 3, 0, to);
  return {line, line};
}

DataDependentOptions with(InnerBending bending) {
  DataDependentOptions options;
  options.bending = bending;
  return options;
}

struct Cloud {
  Net parameters, values;
};

// Franke's hills in space with noise in all coordinates; the parameters are x and y, or for a power above 1 uneven and
// oblique.
Cloud hills(Index count, double power, double noise) {
  const Net places = test::frankePoints(count);
  Cloud cloud{places.leftCols(2), Net(count, 3)};
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal(0, 1);
  for (Index r = 0; r < count; ++r) {
    const double x = std::pow(places(r, 0), power), y = places(r, 1) + (power - 1) * 0.3 * std::sin(3 * places(r, 0));
    cloud.values.row(r) << x, y, 0.3 * test::franke(x, y);
    for (Index c = 0; c < 3; ++c) cloud.values(r, c) += noise * normal(random);
  }
  return cloud;
}

double error(const Surface& surface) {
  double sum = 0;
  for (int i = 0; i < 50; ++i) {
    for (int j = 0; j < 50; ++j) {
      const Point p = evaluate<2>(surface, {i / 49.0, j / 49.0});
      sum += std::pow(p[2] - 0.3 * test::franke(p[0], p[1]), 2);
    }
  }
  return std::sqrt(sum / 2500);
}

TEST(DataDependentFit, KeepsPlanes) {
  const Cloud cloud = hills(500, 1, 0);
  for (const InnerBending bending : kBoth) {
    FitOptions<2> options;
    options.smoothing = Smoothing::fixed(1e-2);
    Net heights(500, 1), places(500, 3);
    for (Index r = 0; r < 500; ++r) {
      const double x = cloud.parameters(r, 0), y = cloud.parameters(r, 1);
      heights(r, 0) = 1 + 2 * x - y;
      places.row(r) << x + y, 3 * y - x, 1 + 2 * x - y;
    }
    const auto function =
        fitDataDependently(bicubic(10), 1, passOf<2>({cloud.parameters, heights}), options, with(bending));
    EXPECT_LT(function.fit.summary.max, 1e-9);
    EXPECT_TRUE(function.settled);
    const auto sheet =
        fitDataDependently(bicubic(10), 3, passOf<2>({cloud.parameters, places}), options, with(bending));
    EXPECT_LT(sheet.fit.summary.max, 1e-9);
    EXPECT_TRUE(sheet.settled);
    EXPECT_EQ(sheet.fit.summary.energyName, sheet.options.energy.name);
  }
}

// Over a graph that is as good as flat the energies are the Laplacian's and the plate's.
TEST(DataDependentFit, OfAFlatGraphIsThatOfThePlane) {
  const Net points = test::frankePoints(2000);
  const Net parameters = 2 * points.leftCols(2), values = 1e-5 * points.rightCols(1);
  for (const InnerBending bending : kBoth) {
    FitOptions<2> options;
    options.smoothing = Smoothing::fixed(1e-4);
    const auto followed =
        fitDataDependently(bicubic(12, 2), 1, passOf<2>({parameters, values}), options, with(bending));
    options.energy = bending == InnerBending::beltrami ? laplacian<2>() : thinPlate<2>();
    const auto flat = fitLeastSquares<2>(bicubic(12, 2), {parameters, values}, options);
    EXPECT_LT((followed.fit.spline.net() - flat.spline.net()).cwiseAbs().maxCoeff(), 1e-9 * 1e-5 + 1e-12);
    EXPECT_NEAR(followed.fit.summary.energy, flat.summary.energy, 1e-6 * flat.summary.energy);
  }
}

TEST(DataDependentFit, DependsNeitherOnUnitsNorOnKnots) {
  const Cloud cloud = hills(1500, 1, 0.005);
  for (const InnerBending bending : kBoth) {
    FitOptions<2> options;
    options.smoothing = Smoothing::fixed(1e-5);
    const Net net =
        fitDataDependently(bicubic(10), 3, passOf<2>({cloud.parameters, cloud.values}), options, with(bending))
            .fit.spline.net();
    const Net wide = 50 * cloud.parameters, large = 1000 * cloud.values;
    const Net other =
        fitDataDependently(bicubic(10, 50), 3, passOf<2>({wide, large}), options, with(bending)).fit.spline.net();
    EXPECT_LT((other / 1000 - net).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(DataDependentFit, ChoosesItsWeightAndSettles) {
  const Cloud even = hills(5000, 1, 0.01);
  for (const InnerBending bending : kBoth) {
    const auto fit = fitDataDependently(bicubic(20), 3, passOf<2>({even.parameters, even.values}), {}, with(bending));
    EXPECT_TRUE(fit.settled);
    EXPECT_EQ(static_cast<std::size_t>(fit.rounds), fit.changes.size());
    EXPECT_NEAR(fit.fit.summary.rms, 0.01 * std::sqrt(3), 5e-4);
    EXPECT_LT(error(fit.fit.spline), 0.003);
  }
}

// Where the parameters are uneven the plate in the parameters is uneven, too.
TEST(DataDependentFit, IsNearerWhereParametersAreUneven) {
  const Cloud uneven = hills(5000, 2, 0.01);
  FitOptions<2> options;
  options.energy = thinPlate<2>();
  const auto plate = fitLeastSquares<2>(bicubic(25), {uneven.parameters, uneven.values}, options);
  DataDependentOptions iteration = with(InnerBending::hessian);
  iteration.settled = 0.01;
  const auto inner = fitDataDependently(bicubic(25), 3, passOf<2>({uneven.parameters, uneven.values}), {}, iteration);
  EXPECT_LT(error(inner.fit.spline), 0.95 * error(plate.spline));
}

TEST(DataDependentFit, FollowsOtherLossesToo) {
  Net points = test::frankePoints(2000);
  for (Index r = 0; r < 50; ++r) points(40 * r, 2) += 3;
  const Net parameters = points.leftCols(2), values = points.rightCols(1);
  RobustFitOptions<2> robust;
  robust.fit.energy = thinPlate<2>();
  const auto make = [&](const FitOptions<2>& options, const Fit<2>&) {
    robust.fit = options;
    return fitRobustly<2>(bicubic(15), {parameters, values}, robust).fit;
  };
  const FitOptions<2> start = robust.fit;
  const auto fit = followDataDependentEnergy(make(start, {}), start, make, with(InnerBending::hessian));
  EXPECT_TRUE(fit.settled);
  EXPECT_LT(test::frankeError(fit.fit.spline), 0.01);
}

TEST(DataDependentFit, RefusesWhatHasNoGeometry) {
  const Cloud cloud = hills(500, 1, 0);
  const auto pass = passOf<2>({cloud.parameters, cloud.values});
  const KnotVector line = KnotVector::uniformClamped(1, 4, 0, 1);
  EXPECT_THROW(fitDataDependently({line, line}, 3, pass), InvalidInput);
  const Net flat = cloud.values.leftCols(2);
  EXPECT_THROW(fitDataDependently(bicubic(8), 2, passOf<2>({cloud.parameters, flat})), InvalidInput);
  Net broken = cloud.values;
  broken(7, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(fitDataDependently(bicubic(8), 3, passOf<2>({cloud.parameters, broken})), InvalidInput);
  // The matrix of other knots.
  FitOptions<2> options;
  options.energy = thinPlate<2>();
  options.energyMatrix = fitDataDependently(bicubic(8), 3, pass).options.energyMatrix;
  EXPECT_THROW(fitLeastSquares<2>(bicubic(9), 3, pass, options), InvalidInput);
}

}  // namespace
}  // namespace strak
