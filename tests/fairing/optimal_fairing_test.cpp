#include "strak/fairing/optimal_fairing.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "strak/base/error.h"
#include "strak/energy/energy_operator.h"

namespace strak {
namespace {

// Random knots: uniform, non-uniform or with repeated inner knots, clamped or not.
KnotVector randomKnots(int degree, Index spans, std::mt19937& random) {
  std::uniform_real_distribution<double> gap(0.3, 1.7);
  std::uniform_int_distribution<int> kind(0, 3);
  const int chosen = kind(random);
  std::vector<double> knots;
  double u = -1;
  const bool clamped = chosen != 3;
  for (int i = 0; i < degree; ++i) knots.push_back(clamped ? u : u += gap(random));
  for (Index i = 0; i <= spans; ++i) {
    const bool inner = i > 0 && i < spans;
    const int multiplicity = inner && chosen == 2 && i % 3 == 1 ? std::max(1, degree - 2) : 1;
    for (int k = 0; k < multiplicity; ++k) knots.push_back(u);
    if (i < spans) u += chosen == 0 ? 1 : gap(random);
  }
  for (int i = 0; i < degree; ++i) knots.push_back(clamped ? u : u += gap(random));
  return {degree, knots};
}

template <int D>
Spline<D> randomSpline(const std::array<int, D>& degrees, const std::array<Index, D>& spans, int dimension,
                       std::mt19937& random) {
  std::array<KnotVector, D> knots;
  Index points = 1;
  for (std::size_t k = 0; k < D; ++k) {
    knots[k] = randomKnots(degrees[k], spans[k], random);
    points *= knots[k].size();
  }
  std::uniform_real_distribution<double> uniform(-1, 1);
  return Spline<D>(knots, Net::NullaryExpr(points, dimension, [&] { return uniform(random); }));
}

template <int D>
std::array<Index, 2 * D> rowsEverywhere(Index rows) {
  std::array<Index, 2 * D> result;
  result.fill(rows);
  return result;
}

// The free points' minimum by a dense factorization: an independent way to the answer without tolerance.
template <int D>
double denseMinimum(const EnergyOperator<D>& op, const Net& net, const HeldPoints& held) {
  const Eigen::MatrixXd all = op.matrix();
  std::vector<Index> place;
  for (std::size_t r = 0; r < held.size(); ++r) {
    if (!held[r]) place.push_back(static_cast<Index>(r));
  }
  const Net gradient = all * net;
  const Eigen::MatrixXd block = all(place, place);
  const Eigen::MatrixXd right = gradient(place, Eigen::all);
  return net.cwiseProduct(gradient).sum() - right.cwiseProduct(block.ldlt().solve(right)).sum();
}

template <int D>
void checkWithoutTolerance(const Spline<D>& input, const QuadraticEnergy<D>& energy, Index rows) {
  OptimalFairingOptions options;
  options.held = holdStrips<D>(input, rowsEverywhere<D>(rows));
  options.scale = ParameterScale::domain;
  const auto faired = fairOptimally<D>(input, energy, options);
  const EnergyOperator<D> op(energy, input.knots());
  const double least = denseMinimum<D>(op, input.net(), options.held);
  const double reached = op.value(faired.spline.net());
  const double before = op.value(input.net());
  EXPECT_LE(reached - least, 1e-6 * std::abs(reached) + 1e-11 * before) << energy.name;
  EXPECT_NEAR(reached, faired.summary.energyAfter, 1e-9 * before);
  EXPECT_NEAR(before, faired.summary.energyBefore, 1e-10 * before);
  EXPECT_EQ(faired.summary.stopReason, StopReason::gap);
  for (std::size_t r = 0; r < options.held.size(); ++r) {
    if (options.held[r]) {
      EXPECT_EQ(faired.spline.net().row(static_cast<Index>(r)), input.net().row(static_cast<Index>(r)));
    }
  }
}

TEST(OptimalFairing, WithoutToleranceEqualsADenseSolve) {
  std::mt19937 random(1);
  for (int round = 0; round < 4; ++round) {
    for (int degree = 2; degree <= 5; ++degree) {
      checkWithoutTolerance<1>(randomSpline<1>({degree}, {9}, 3, random), thinPlate<1>(), 2);
      checkWithoutTolerance<2>(randomSpline<2>({degree, 3}, {5, 8}, 3, random), thinPlate<2>(), 2);
      checkWithoutTolerance<2>(randomSpline<2>({degree, 4}, {7, 5}, 2, random), laplacian<2>(), 2);
      if (degree < 3) continue;
      checkWithoutTolerance<1>(randomSpline<1>({degree}, {9}, 2, random), thirdOrder<1>(), 3);
      checkWithoutTolerance<2>(randomSpline<2>({degree, 3}, {7, 8}, 3, random), thirdDerivatives<2>(), 3);
      checkWithoutTolerance<2>(randomSpline<2>({degree, 3}, {7, 8}, 1, random), laplacianGradient<2>(), 3);
      checkWithoutTolerance<2>(randomSpline<2>({3, degree}, {8, 6}, 3, random), thirdOrder<2>(), 3);
      checkWithoutTolerance<2>(randomSpline<2>({3, degree}, {8, 6}, 3, random),
                               energyNamed<2>("thin-plate + 0.1*third-derivatives"), 2);
    }
  }
  checkWithoutTolerance<3>(randomSpline<3>({2, 3, 2}, {4, 3, 5}, 3, random), thinPlate<3>(), 1);
  checkWithoutTolerance<3>(randomSpline<3>({3, 2, 3}, {3, 4, 3}, 2, random), thinPlate<3>(), 2);
}

TEST(OptimalFairing, LaplacianWithTwoFreeSidesIsSolvedByAFactor) {
  // Sides without a held row leave the cross term in place, so that no diagonalisable lower bound is known.
  std::mt19937 random(5);
  const auto input = randomSpline<2>({3, 3}, {6, 7}, 3, random);
  OptimalFairingOptions options;
  options.scale = ParameterScale::domain;
  options.held = holdStrips<2>(input, {2, 2, 0, 0});
  const auto faired = fairOptimally<2>(input, laplacian<2>(), options);
  const EnergyOperator<2> op(laplacian<2>(), input.knots());
  const double least = denseMinimum<2>(op, input.net(), options.held);
  EXPECT_NEAR(op.value(faired.spline.net()), least, 1e-8 * op.value(input.net()));
}

TEST(OptimalFairing, FixedCornersAreEnoughForTheThinPlate) {
  std::mt19937 random(9);
  const auto input = randomSpline<2>({3, 3}, {6, 5}, 3, random);
  OptimalFairingOptions options;
  options.scale = ParameterScale::domain;
  options.held.assign(static_cast<std::size_t>(input.net().rows()), 0);
  const Index n = input.size(0), m = input.size(1);
  for (Index r : {Index{0}, m - 1, (n - 1) * m, n * m - 1}) options.held[static_cast<std::size_t>(r)] = 1;
  const auto faired = fairOptimally<2>(input, thinPlate<2>(), options);
  const EnergyOperator<2> op(thinPlate<2>(), input.knots());
  EXPECT_NEAR(op.value(faired.spline.net()), denseMinimum<2>(op, input.net(), options.held),
              1e-8 * op.value(input.net()));
}

// The conditions of Karush, Kuhn and Tucker, up to what the certified gap allows, and the certificate itself against
// random feasible nets.
template <int D>
void checkWithTolerance(const Spline<D>& input, const QuadraticEnergy<D>& energy, const HeldPoints& held,
                        double tolerance) {
  OptimalFairingOptions options;
  options.held = held;
  options.tolerance = tolerance;
  options.gap = 1e-9;
  options.scale = ParameterScale::domain;
  const auto faired = fairOptimally<D>(input, energy, options);
  const EnergyOperator<D> op(energy, input.knots());
  const double reached = op.value(faired.spline.net());
  EXPECT_LE(faired.summary.gap, 1e-9) << energy.name;
  EXPECT_NEAR(reached, faired.summary.energyAfter, 1e-9 * faired.summary.energyBefore);
  const Net gradient = op.product(faired.spline.net());
  const Net moves = faired.spline.net() - input.net();
  const Eigen::VectorXd diagonal = op.diagonal();
  const double lowest = reached * (1 - faired.summary.gap) - 1e-12 * faired.summary.energyBefore;
  double worst = 0;
  for (Index r = 0; r < moves.rows(); ++r) {
    if (!held.empty() && held[static_cast<std::size_t>(r)]) {
      EXPECT_EQ(moves.row(r).norm(), 0);
      continue;
    }
    EXPECT_LE(moves.row(r).norm(), tolerance);
    // The gain this point still has to offer (5.9) cannot exceed the gap.
    const Point target = moves.row(r) - gradient.row(r) / diagonal[r];
    const Point best = target.norm() > tolerance ? Point(target * (tolerance / target.norm())) : target;
    const double gain = diagonal[r] * ((moves.row(r) - target).squaredNorm() - (best - target).squaredNorm());
    worst = std::max(worst, gain);
  }
  EXPECT_LE(worst, 1e-9 * reached + 1e-11 * faired.summary.energyBefore) << energy.name;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int trial = 0; trial < 20; ++trial) {
    Net other = faired.spline.net();
    for (Index r = 0; r < other.rows(); ++r) {
      if (!held.empty() && held[static_cast<std::size_t>(r)]) continue;
      Point step = Point::NullaryExpr(other.cols(), [&] { return 0.02 * tolerance * uniform(random); });
      Point e = moves.row(r) + step;
      if (e.norm() > tolerance) e *= tolerance / e.norm();
      other.row(r) = input.net().row(r) + e;
    }
    EXPECT_GE(op.value(other), lowest);
  }
}

TEST(OptimalFairing, WithToleranceMeetsTheOptimalityConditions) {
  std::mt19937 random(2);
  for (double tolerance : {0.01, 0.2, 3.0}) {
    const auto curve = randomSpline<1>({3}, {12}, 2, random);
    checkWithTolerance<1>(curve, thinPlate<1>(), holdStrips<1>(curve, {2, 2}), tolerance);
    const auto surface = randomSpline<2>({3, 4}, {7, 6}, 3, random);
    checkWithTolerance<2>(surface, thinPlate<2>(), holdStrips<2>(surface, {2, 2, 2, 2}), tolerance);
    checkWithTolerance<2>(surface, thirdDerivatives<2>(), holdStrips<2>(surface, {3, 3, 3, 3}), tolerance);
    const auto volume = randomSpline<3>({2, 2, 3}, {4, 4, 3}, 3, random);
    checkWithTolerance<3>(volume, thinPlate<3>(), holdStrips<3>(volume, {1, 1, 1, 1, 1, 1}), tolerance);
  }
}

TEST(OptimalFairing, AnySetOfPointsMayBeHeld) {
  std::mt19937 random(4);
  const auto surface = randomSpline<2>({3, 3}, {10, 9}, 3, random);
  HeldPoints held = holdStrips<2>(surface, {1, 2, 3, 1});
  std::bernoulli_distribution also(0.2);
  for (auto& h : held) h = h || also(random);
  checkWithTolerance<2>(surface, thinPlate<2>(), held, 0.1);
  OptimalFairingOptions options;
  options.held = held;
  options.scale = ParameterScale::domain;
  const auto faired = fairOptimally<2>(surface, thinPlate<2>(), options);
  const EnergyOperator<2> op(thinPlate<2>(), surface.knots());
  EXPECT_NEAR(op.value(faired.spline.net()), denseMinimum<2>(op, surface.net(), held), 1e-8 * op.value(surface.net()));
}

TEST(OptimalFairing, NothingHeldWithinATolerance) {
  std::mt19937 random(6);
  const auto surface = randomSpline<2>({3, 2}, {5, 6}, 3, random);
  OptimalFairingOptions options;
  options.tolerance = 0.05;
  options.gap = 1e-5;
  const auto faired = fairOptimally<2>(surface, thinPlate<2>(), options);
  EXPECT_LT(faired.summary.energyAfter, faired.summary.energyBefore);
  EXPECT_LE(faired.summary.gap, 1e-5);
  EXPECT_LE(faired.summary.largestMove, 0.05);
}

// Hadenfeld's first example as re-made (the recipe is in README of the example): reference minima by independent
// programs.
Surface firstExample() {
  Net net(52 * 52, 3);
  for (Index i = 0; i < 52; ++i) {
    for (Index j = 0; j < 52; ++j) {
      const double lon = -0.6 + 1.2 * static_cast<double>(i) / 51, lat = -0.6 + 1.2 * static_cast<double>(j) / 51;
      net.row(i * 52 + j) << std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat);
    }
  }
  std::mt19937_64 random(1995);
  const auto draw = [&] { return 2 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1; };
  for (Index j = 6; j <= 45; ++j) {
    for (Index i = 6; i <= 45; ++i) {
      Eigen::RowVector3d r;
      do {
        r[0] = draw();
        r[1] = draw();
        r[2] = draw();
      } while (r.squaredNorm() > 1);
      net.row(i * 52 + j) += 0.02 * r;
    }
  }
  const auto knots = KnotVector::uniformClamped(4, 48);
  return Surface({knots, knots}, net);
}

TEST(OptimalFairing, FirstExampleOfThePaperReachesItsKnownMinima) {
  const Surface input = firstExample();
  OptimalFairingOptions options;
  options.held = holdStrips<2>(input, {5, 5, 5, 5});
  options.scale = ParameterScale::domain;
  EXPECT_NEAR(fairOptimally<2>(input, thinPlate<2>(), options).summary.energyAfter, 2144.19063398, 1e-6);
  options.tolerance = 0.02;
  options.gap = 1e-10;
  const auto faired = fairOptimally<2>(input, thinPlate<2>(), options);
  EXPECT_NEAR(faired.summary.energyBefore, 3754.11852461, 1e-7);
  EXPECT_NEAR(faired.summary.energyAfter, 2144.68158900, 1e-6);
  EXPECT_EQ(faired.summary.activePoints, 96);
  options.gap = 1e-9;
  EXPECT_NEAR(fairOptimally<2>(input, thirdDerivatives<2>(), options).summary.energyAfter, 19291510.6101, 0.05);
}

TEST(OptimalFairing, DoesNotDependOnThePlaceOfTheModelOrTheScaleOfTheKnots) {
  const Surface input = firstExample();
  OptimalFairingOptions options;
  options.held = holdStrips<2>(input, {5, 5, 5, 5});
  options.tolerance = 0.02;
  const auto faired = fairOptimally<2>(input, thinPlate<2>(), options);
  Surface far = input;
  far.net().rowwise() += Eigen::RowVector3d(1000, -2000, 500);
  const auto farFaired = fairOptimally<2>(far, thinPlate<2>(), options);
  const Net difference = farFaired.spline.net().rowwise() - Eigen::RowVector3d(1000, -2000, 500);
  EXPECT_LT((difference - faired.spline.net()).cwiseAbs().maxCoeff(), 1e-8);
  const Surface rescaled({input.knots(0).rescaled(-3, 4.3), input.knots(1).rescaled(0, 0.11)}, input.net());
  const auto rescaledFaired = fairOptimally<2>(rescaled, thinPlate<2>(), options);
  EXPECT_LT((rescaledFaired.spline.net() - faired.spline.net()).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(OptimalFairing, RefusesWhatTheEnergyDoesNotSee) {
  std::mt19937 random(8);
  const auto surface = randomSpline<2>({3, 3}, {6, 6}, 3, random);
  OptimalFairingOptions options;
  options.held = holdStrips<2>(surface, {1, 1, 1, 1});
  // (15) does not see u (1 - u) v (1 - v).
  try {
    fairOptimally<2>(surface, thirdOrder<2>(), options);
    FAIL() << "a singular problem was solved";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("third-order"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("hold"), std::string::npos);
  }
  EXPECT_THROW(fairOptimally<2>(surface, thinPlate<2>(), {}), InvalidInput);  // nothing held at all
  options.held = holdStrips<2>(surface, {2, 2, 2, 2});
  EXPECT_NO_THROW(fairOptimally<2>(surface, thirdOrder<2>(), options));
}

TEST(OptimalFairing, BadOptionsAreRefused) {
  const Surface input = firstExample();
  OptimalFairingOptions options;
  options.tolerance = -1;
  EXPECT_THROW(fairOptimally<2>(input, thinPlate<2>(), options), InvalidInput);
  options.tolerance = std::nan("");
  EXPECT_THROW(fairOptimally<2>(input, thinPlate<2>(), options), InvalidInput);
  options.tolerance = 1;
  options.gap = -1;
  EXPECT_THROW(fairOptimally<2>(input, thinPlate<2>(), options), InvalidInput);
  options.gap = 1e-6;
  options.held = {1, 0};
  EXPECT_THROW(fairOptimally<2>(input, thinPlate<2>(), options), InvalidInput);
}

TEST(OptimalFairing, WithNothingFreeTheInputComesBack) {
  const Surface input = firstExample();
  OptimalFairingOptions options;
  options.tolerance = 0;
  auto faired = fairOptimally<2>(input, thinPlate<2>(), options);
  EXPECT_EQ(faired.spline, input);
  EXPECT_EQ(faired.summary.stopReason, StopReason::nothingFree);
  options.tolerance = 1;
  options.held.assign(52 * 52, 1);
  faired = fairOptimally<2>(input, thinPlate<2>(), options);
  EXPECT_EQ(faired.spline, input);
  EXPECT_EQ(faired.summary.stopReason, StopReason::nothingFree);
}

TEST(OptimalFairing, ACancelledRunReturnsItsBestNet) {
  const Surface input = firstExample();
  OptimalFairingOptions options;
  options.held = holdStrips<2>(input, {5, 5, 5, 5});
  options.tolerance = 0.02;
  int reports = 0;
  options.progress = Progress([&](double fraction, std::string_view) {
    EXPECT_GE(fraction, 0);
    EXPECT_LE(fraction, 1);
    return ++reports < 4;
  });
  const auto faired = fairOptimally<2>(input, thinPlate<2>(), options);
  EXPECT_EQ(faired.summary.stopReason, StopReason::cancelled);
  EXPECT_LT(faired.summary.energyAfter, 0.6 * faired.summary.energyBefore);
  EXPECT_LE(faired.summary.largestMove, 0.02);
  EXPECT_GT(faired.summary.gap, 1e-6);
}

TEST(OptimalFairing, AFairInputStaysAsItIs) {
  // A plane patch has no energy: nothing moves, and the gap is proven.
  const auto knots = KnotVector::uniformClamped(3, 7);
  const auto greville = knots.greville();
  Net net(100, 3);
  for (Index i = 0; i < 10; ++i) {
    for (Index j = 0; j < 10; ++j) {
      net.row(i * 10 + j) << greville[static_cast<std::size_t>(i)], greville[static_cast<std::size_t>(j)], 0;
    }
  }
  const Surface plane({knots, knots}, net);
  OptimalFairingOptions options;
  options.held = holdStrips<2>(plane, {2, 2, 2, 2});
  for (double tolerance : {0.1, kUnlimited}) {
    options.tolerance = tolerance;
    const auto faired = fairOptimally<2>(plane, thinPlate<2>(), options);
    EXPECT_LT((faired.spline.net() - net).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_LT(faired.summary.energyAfter, 1e-10);
    EXPECT_LE(faired.summary.steps, 10);  // rounding is recognised as such
  }
}

}  // namespace
}  // namespace strak
