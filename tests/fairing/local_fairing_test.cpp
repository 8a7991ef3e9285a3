#include "strak/fairing/local_fairing.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "strak/base/error.h"
#include "strak/energy/energy_operator.h"
#include "strak/fairing/optimal_fairing.h"
#include "tests/fairing/within_balls.h"
#include "tests/spline/random_splines.h"

namespace strak {
namespace {

using testing::expectWithinBalls;
using testing::Random;

// A spline of degree 2 or more with a strip held at every end.
template <int D>
struct Task {
  Spline<D> spline;
  HeldPoints held;
};

template <int D>
Task<D> randomTask(std::uint64_t seed, int dimension, int spans = D == 3 ? 3 : 6) {
  Random random(seed);
  std::array<KnotVector, static_cast<std::size_t>(D)> knots;
  for (auto& direction : knots) {
    const auto kind = testing::kKnotKinds[std::array{0, 1, 2, 4}[static_cast<std::size_t>(random.integer(0, 3))]];
    direction = testing::randomKnots(random, kind, random.integer(2, D == 3 ? 3 : 5), spans);
  }
  Task<D> task{testing::randomSpline<D>(random, knots, dimension, false), {}};
  std::array<Index, 2 * D> rows;
  rows.fill(1);
  task.held = holdStrips<D>(task.spline, rows);
  for (auto& entry : task.held) entry |= random.integer(0, 9) == 0;  // and some points anywhere
  return task;
}

// The ranking numbers and the best move by their definitions, everything computed anew.
struct BruteForce {
  Eigen::MatrixXd matrix;
  Net start, now;
  HeldPoints held;
  double tolerance;

  double energy() const { return now.cwiseProduct(Net(matrix * now)).sum(); }
  Point target(Index r, bool clipped) const {
    const Point t = now.row(r) - (matrix.row(r) * now) / matrix(r, r);
    const Point move = t - start.row(r);
    return clipped && move.norm() > tolerance ? Point(start.row(r) + tolerance / move.norm() * move) : t;
  }
  double gain(Index r) const {
    const Point t = target(r, false);
    return matrix(r, r) * ((now.row(r) - t).squaredNorm() - (target(r, true) - t).squaredNorm());
  }
  Index best() const {
    Index best = -1;
    for (Index r = 0; r < now.rows(); ++r) {
      if (held[static_cast<std::size_t>(r)] == 0 && (best < 0 || gain(r) > gain(best))) best = r;
    }
    return best;
  }
};

template <int D>
void expectEqualsBruteForce(std::uint64_t seed, int dimension, double tolerance) {
  const Task<D> task = randomTask<D>(seed, dimension, D == 3 ? 2 : 4);
  const EnergyOperator<D> op(thinPlate<D>(), task.spline.knots());
  BruteForce brute{op.matrix(), task.spline.net(), task.spline.net(), task.held, tolerance};
  const double before = brute.energy();
  double energy = before;
  Index steps = 0;
  for (; steps < 40; ++steps) {
    const Index r = brute.best();
    if (r < 0 || brute.gain(r) < 1e-8 * before) break;
    const double gain = brute.gain(r);
    brute.now.row(r) = brute.target(r, true);
    EXPECT_NEAR(brute.energy(), energy - gain, 1e-12 * before);  // (5.9) is the true gain
    energy = brute.energy();
  }
  LocalFairingOptions options;
  options.tolerance = tolerance;
  options.held = task.held;
  options.scale = ParameterScale::domain;
  options.gap = 0;
  options.maxSteps = steps;
  const auto result = fairLocally<D>(task.spline, thinPlate<D>(), options);
  EXPECT_EQ(result.summary.steps, steps);
  EXPECT_NEAR(result.summary.energyAfter, energy, 1e-12 * before);
  EXPECT_LT((result.spline.net() - brute.now).cwiseAbs().maxCoeff(), 1e-9) << "D = " << D << ", seed " << seed;
  EXPECT_NEAR(result.summary.energyAfter, op.value(result.spline.net()), 1e-12 * before);
}

TEST(LocalFairing, MovesTheSamePointsToTheSamePlacesAsBruteForce) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    for (double tolerance : {kUnlimited, 0.2}) {
      const int dimension = static_cast<int>(seed % 4) + 1;
      expectEqualsBruteForce<1>(seed, dimension, tolerance);
      expectEqualsBruteForce<2>(seed, dimension, tolerance);
      if (seed <= 3) expectEqualsBruteForce<3>(seed, dimension, tolerance);
    }
  }
}

// The least energy of the free points without tolerance, by a dense factor.
template <int D>
double denseMinimum(const EnergyOperator<D>& op, const Task<D>& task) {
  const Eigen::MatrixXd matrix = op.matrix();
  std::vector<Index> free;
  for (Index r = 0; r < matrix.rows(); ++r) {
    if (task.held[static_cast<std::size_t>(r)] == 0) free.push_back(r);
  }
  if (free.empty()) return op.value(task.spline.net());
  Net net = task.spline.net();
  const Eigen::MatrixXd block = matrix(free, free);
  const Eigen::MatrixXd gradient = (matrix * net)(free, Eigen::all);
  const Eigen::MatrixXd step = block.ldlt().solve(gradient);
  for (std::size_t i = 0; i < free.size(); ++i) net.row(free[i]) -= step.row(static_cast<Index>(i));
  return op.value(net);
}

// The least eigenvalue of the free points' matrix, scaled to a unit diagonal: tells a motion that the energy does not
// see.
template <int D>
double leastEigenvalue(const EnergyOperator<D>& op, const Task<D>& task) {
  const Eigen::MatrixXd matrix = op.matrix();
  std::vector<Index> free;
  for (Index r = 0; r < matrix.rows(); ++r) {
    if (task.held[static_cast<std::size_t>(r)] == 0 && matrix(r, r) > 0) free.push_back(r);
  }
  if (free.empty()) return 1;
  const Eigen::MatrixXd block = matrix(free, free);
  const Eigen::VectorXd root = block.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = root.asDiagonal() * block * root.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

template <int D>
void expectMinimum(std::uint64_t seed) {
  const Task<D> task = randomTask<D>(seed, static_cast<int>(seed % 4) + 1);
  LocalFairingOptions options;
  options.held = task.held;
  options.gap = 1e-8;
  options.scale = ParameterScale::unit;
  const auto result = fairLocally<D>(task.spline, thinPlate<D>(), options);
  const EnergyOperator<D> op(thinPlate<D>(), scaledKnots(task.spline, ParameterScale::unit));
  if (leastEigenvalue(op, task) < 1e-11) {
    // Singular: the held points lie where no function meets the domain. Then nothing may be claimed.
    EXPECT_GT(result.summary.gap, 1e-8) << "D = " << D << ", seed " << seed;
    return;
  }
  const double least = denseMinimum(op, task);
  EXPECT_EQ(result.summary.stopReason, StopReason::gap) << "D = " << D << ", seed " << seed;
  EXPECT_LE(result.summary.gap, 1e-8);
  const double rounding = 1e-13 * result.summary.energyBefore;
  EXPECT_LE(result.summary.energyAfter - least, result.summary.gap * result.summary.energyAfter + rounding);
  EXPECT_GE(result.summary.energyAfter - least, -rounding);
  expectWithinBalls(task.spline, result.spline, task.held, kUnlimited);
}

TEST(LocalFairing, ReachesTheMinimumWithinTheCertifiedGapWithoutTolerance) {
  for (std::uint64_t seed = 21; seed <= 28; ++seed) {
    expectMinimum<1>(seed);
    expectMinimum<2>(seed);
    if (seed <= 23) expectMinimum<3>(seed);
  }
}

template <int D>
void expectKeepsTolerance(std::uint64_t seed) {
  const Task<D> task = randomTask<D>(seed, static_cast<int>(seed % 4) + 1);
  const EnergyOperator<D> op(thirdDerivatives<D>(), task.spline.knots());
  double before = kUnlimited;
  for (double tolerance : {1e-9, 0.01, 0.3}) {
    LocalFairingOptions options;
    options.tolerance = tolerance;
    options.held = task.held;
    options.scale = ParameterScale::domain;
    options.gap = 1e-5;
    options.pointsPerList = seed % 2 == 0 ? 1 : 4;
    auto energy = thirdDerivatives<D>();
    if (task.spline.degree(0) < 3) energy = thinPlate<D>();
    const auto result = fairLocally<D>(task.spline, energy, options);
    expectWithinBalls(task.spline, result.spline, task.held, tolerance);
    EXPECT_LE(result.summary.largestMove, tolerance);
    EXPECT_EQ(result.summary.stopReason, StopReason::gap) << "D = " << D << ", seed " << seed;
    EXPECT_LE(result.summary.energyAfter, result.summary.energyBefore);
    EXPECT_LE(result.summary.energyAfter, before * (1 + 2e-5));  // a larger ball costs no energy
    before = result.summary.energyAfter;
  }
}

TEST(LocalFairing, NeverMovesAPointFurtherThanTheToleranceNorAHeldOneAtAll) {
  for (std::uint64_t seed = 31; seed <= 38; ++seed) {
    expectKeepsTolerance<1>(seed);
    expectKeepsTolerance<2>(seed);
    if (seed <= 33) expectKeepsTolerance<3>(seed);
  }
}

TEST(LocalFairing, KeepsTheBallWhereTheCoordinatesRoundMoreCoarselyThanTheMoves) {
  Task<2> task = randomTask<2>(5, 3);
  Net net = task.spline.net();
  net.array() += 1e9;
  const Surface far(task.spline.knots(), net);
  for (double tolerance : {1e-3, 1e-6, 1e-7, 1e-9}) {
    LocalFairingOptions options;
    options.tolerance = tolerance;
    options.held = task.held;
    expectWithinBalls(far, fairLocally<2>(far, thinPlate<2>(), options).spline, task.held, tolerance);
  }
}

TEST(LocalFairing, LosesEnergyWithEveryStepWhateverTheListLength) {
  const Task<2> task = randomTask<2>(8, 3);
  for (Index perList : {1, 3, 1000}) {
    double energy = kUnlimited;
    for (Index steps = 0; steps <= 60; ++steps) {
      LocalFairingOptions options;
      options.tolerance = 0.3;
      options.held = task.held;
      options.gap = 0;
      options.maxSteps = steps;
      options.pointsPerList = perList;
      const auto result = fairLocally<2>(task.spline, thinPlate<2>(), options);
      EXPECT_LE(result.summary.energyAfter, energy);
      EXPECT_EQ(result.summary.steps, steps);
      EXPECT_EQ(result.summary.stopReason, StopReason::steps);
      energy = result.summary.energyAfter;
    }
  }
}

TEST(LocalFairing, WithoutToleranceTheLiteralRankingIsTheTrueGain) {
  const Task<2> task = randomTask<2>(13, 3);
  LocalFairingOptions options;
  options.held = task.held;
  options.maxSteps = 100;
  options.gap = 0;
  const auto gain = fairLocally<2>(task.spline, thinPlate<2>(), options);
  options.ranking = RankingNumber::literal;
  EXPECT_EQ(fairLocally<2>(task.spline, thinPlate<2>(), options).spline, gain.spline);
}

TEST(LocalFairing, ChangesNoPointMoreOftenThanAllowed) {
  const Task<2> task = randomTask<2>(14, 2);
  LocalFairingOptions options;
  options.held = task.held;
  options.gap = 0;
  options.maxChangesPerPoint = 1;
  const auto once = fairLocally<2>(task.spline, thinPlate<2>(), options);
  EXPECT_EQ(once.summary.stopReason, StopReason::gain);
  EXPECT_EQ(once.summary.steps, once.summary.freePoints);
  options.maxChangesPerPoint = 3;
  options.pointsPerList = 7;
  EXPECT_EQ(fairLocally<2>(task.spline, thinPlate<2>(), options).summary.steps, 3 * once.summary.freePoints);
}

TEST(LocalFairing, StopsOnceNoPointGainsEnough) {
  const Task<2> task = randomTask<2>(15, 3);
  LocalFairingOptions options;
  options.held = task.held;
  options.gap = 0;
  options.tolerance = 0.5;
  options.scale = ParameterScale::domain;
  options.minGain = 0.1;
  const auto result = fairLocally<2>(task.spline, thinPlate<2>(), options);
  EXPECT_EQ(result.summary.stopReason, StopReason::gain);
  const EnergyOperator<2> op(thinPlate<2>(), task.spline.knots());
  const BruteForce brute{op.matrix(), task.spline.net(), result.spline.net(), task.held, 0.5};
  EXPECT_LE(brute.gain(brute.best()), 0.1 * (1 + 1e-9));
  EXPECT_GT(result.summary.steps, 0);
}

template <int D>
void expectAgreesWithOptimal(const char* name, std::uint64_t seed, double tolerance) {
  const Task<D> task = randomTask<D>(seed, 3, 4);
  auto energy = energyNamed<D>(name);
  for (int k = 0; k < D; ++k) {
    if (energy.order() > task.spline.degree(k)) return;  // no such derivatives
  }
  LocalFairingOptions local;
  OptimalFairingOptions optimal;
  local.held = optimal.held = task.held;
  local.tolerance = optimal.tolerance = tolerance;
  local.gap = optimal.gap = 1e-7;
  const auto a = fairLocally<D>(task.spline, energy, local).summary;
  const auto b = fairOptimally<D>(task.spline, energy, optimal).summary;
  const std::string context = std::string(name) + ", D = " + std::to_string(D) + ", seed " + std::to_string(seed);
  EXPECT_EQ(a.stopReason, StopReason::gap) << context;
  const double rounding = 1e-12 * a.energyBefore;
  EXPECT_NEAR(a.energyBefore, b.energyBefore, rounding) << context;
  EXPECT_LE(a.energyAfter - b.energyAfter, a.gap * std::abs(a.energyAfter) + rounding) << context;
  EXPECT_LE(b.energyAfter - a.energyAfter, b.gap * std::abs(b.energyAfter) + rounding) << context;
}

// The laplacian with one row held has no lower bound that can be diagonalised: then a factor certifies.
TEST(LocalFairing, AgreesWithOptimalFairingToTheCertificates) {
  for (std::uint64_t seed = 51; seed <= 53; ++seed) {
    for (const char* name : {"thin-plate", "laplacian", "thin-plate+0.01*third-derivatives"}) {
      for (double tolerance : {kUnlimited, 0.2}) {
        expectAgreesWithOptimal<1>(name, seed, tolerance);
        expectAgreesWithOptimal<2>(name, seed, tolerance);
      }
    }
    expectAgreesWithOptimal<3>("thin-plate", seed, 0.2);
  }
}

TEST(LocalFairing, LeavesTheNetAloneWhereNothingIsFree) {
  const Task<2> task = randomTask<2>(16, 3);
  LocalFairingOptions options;
  options.tolerance = 0;
  const auto noRoom = fairLocally<2>(task.spline, thinPlate<2>(), options);
  EXPECT_EQ(noRoom.summary.stopReason, StopReason::nothingFree);
  EXPECT_EQ(noRoom.spline, task.spline);
  EXPECT_EQ(noRoom.summary.energyBefore, noRoom.summary.energyAfter);
  EXPECT_EQ(noRoom.summary.gap, 0);
  options.tolerance = 1;
  options.held.assign(static_cast<std::size_t>(task.spline.net().rows()), 1);
  const auto allHeld = fairLocally<2>(task.spline, thinPlate<2>(), options);
  EXPECT_EQ(allHeld.summary.stopReason, StopReason::nothingFree);
  EXPECT_EQ(allHeld.summary.freePoints, 0);
  EXPECT_EQ(allHeld.spline, task.spline);
}

// A plane has energy of rounding only: the run must end soon and not wander off.
TEST(LocalFairing, EndsSoonOnWhatIsFairAlready) {
  const KnotVector knots = KnotVector::uniformClamped(4, 30);
  Net net(knots.size() * knots.size(), 3);
  for (Index i = 0; i < knots.size(); ++i) {
    for (Index j = 0; j < knots.size(); ++j) {
      net.row(i * knots.size() + j) << knots.greville()[static_cast<std::size_t>(i)] / 3,
          knots.greville()[static_cast<std::size_t>(j)] / 7, 0.1;
    }
  }
  const Surface plane({knots, knots}, net);
  for (double tolerance : {kUnlimited, 0.1}) {
    LocalFairingOptions options;
    options.tolerance = tolerance;
    options.held = holdStrips<2>(plane, {1, 1, 1, 1});
    const auto result = fairLocally<2>(plane, thinPlate<2>(), options);
    EXPECT_LT(result.summary.seconds, 5);
    EXPECT_LT((result.spline.net() - net).cwiseAbs().maxCoeff(), 1e-13);
  }
}

TEST(LocalFairing, WorksWithEveryDimensionOfThePoints) {
  for (int dimension = 1; dimension <= 6; ++dimension) {
    const Task<2> task = randomTask<2>(41, dimension);
    LocalFairingOptions options;
    options.held = task.held;
    options.tolerance = 0.25;
    const auto result = fairLocally<2>(task.spline, thinPlate<2>(), options);
    EXPECT_EQ(result.summary.stopReason, StopReason::gap) << dimension;
    expectWithinBalls(task.spline, result.spline, task.held, 0.25);
  }
}

// Components do not interact without tolerance.
TEST(LocalFairing, SeparatesIntoItsCoordinatesWithoutTolerance) {
  const Task<2> task = randomTask<2>(42, 3);
  LocalFairingOptions options;
  options.held = task.held;
  options.gap = 1e-12;
  options.scale = ParameterScale::unit;
  const auto all = fairLocally<2>(task.spline, thinPlate<2>(), options);
  for (Index c = 0; c < 3; ++c) {
    const Surface one(task.spline.knots(), Net(task.spline.net().col(c)));
    const auto alone = fairLocally<2>(one, thinPlate<2>(), options);
    EXPECT_LT((alone.spline.net() - all.spline.net().col(c)).cwiseAbs().maxCoeff(), 1e-4);
  }
}

TEST(LocalFairing, DoesNotDependOnUnitPlaceOrKnotScale) {
  const Task<2> task = randomTask<2>(43, 3);
  LocalFairingOptions options;
  options.held = task.held;
  options.tolerance = 0.25;
  options.gap = 1e-10;
  const auto reference = fairLocally<2>(task.spline, thinPlate<2>(), options);
  for (double unit : {1e-6, 1e6}) {
    LocalFairingOptions scaled = options;
    scaled.tolerance *= unit;
    const Surface other(task.spline.knots(), Net(unit * task.spline.net()));
    const auto result = fairLocally<2>(other, thinPlate<2>(), scaled);
    EXPECT_EQ(result.summary.stopReason, StopReason::gap);
    EXPECT_LT((result.spline.net() / unit - reference.spline.net()).cwiseAbs().maxCoeff(), 1e-4);
  }
  const Surface rescaled({task.spline.knots(0).rescaled(3, 300), task.spline.knots(1).rescaled(-1, -0.9)},
                         task.spline.net());
  const auto result = fairLocally<2>(rescaled, thinPlate<2>(), options);
  EXPECT_NEAR(result.summary.energyAfter, reference.summary.energyAfter, 1e-9 * reference.summary.energyAfter);
  EXPECT_LT((result.spline.net() - reference.spline.net()).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(LocalFairing, LeavesFunctionsOutsideTheDomainAlone) {
  // The first function ends where the domain begins.
  const KnotVector knots(2, {0, 0, 1, 1, 2, 3, 4, 5, 6, 6, 6});
  Net net(knots.size(), 2);
  for (Index r = 0; r < knots.size(); ++r) net.row(r) << static_cast<double>(r), r % 2 == 0 ? 1 : -1;
  const Curve curve({knots}, net);
  LocalFairingOptions options;
  options.tolerance = 0.5;
  const auto result = fairLocally<1>(curve, thinPlate<1>(), options);
  EXPECT_EQ(result.summary.freePoints, knots.size() - 1);
  EXPECT_EQ(result.spline.net().row(0), net.row(0));
  EXPECT_LT(result.summary.energyAfter, result.summary.energyBefore);
}

TEST(LocalFairing, RefusesWhatCannotBeFaired) {
  const Task<2> task = randomTask<2>(17, 3);
  const auto refuses = [&](void (*change)(LocalFairingOptions&)) {
    LocalFairingOptions options;
    change(options);
    EXPECT_THROW(fairLocally<2>(task.spline, thinPlate<2>(), options), InvalidInput);
  };
  refuses([](auto& options) { options.tolerance = -1; });
  refuses([](auto& options) { options.tolerance = std::nan(""); });
  refuses([](auto& options) { options.held = HeldPoints(3, 1); });
  refuses([](auto& options) { options.gap = -1; });
  refuses([](auto& options) { options.gap = std::nan(""); });
  refuses([](auto& options) { options.minGain = std::nan(""); });
  refuses([](auto& options) { options.maxSteps = -1; });
  refuses([](auto& options) { options.maxChangesPerPoint = 0; });
  refuses([](auto& options) { options.pointsPerList = 0; });
  EXPECT_THROW(fairLocally<2>(task.spline, QuadraticEnergy<2>{"nothing", {}}), InvalidInput);
  const KnotVector quadratic = KnotVector::uniformClamped(2, 5);
  const Surface low({quadratic, quadratic}, Net::Random(49, 3));
  try {
    fairLocally<2>(low, thirdOrder<2>());
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("does not see control point 0"), std::string::npos) << error.what();
  }
  const Surface huge({quadratic, quadratic}, Net(1e200 * low.net()));
  EXPECT_THROW(fairLocally<2>(huge, thinPlate<2>()), InvalidInput);
}

TEST(LocalFairing, CertifiesNothingWhereTheEnergyLeavesAMotionFree) {
  const KnotVector knots = KnotVector::uniformClamped(3, 5);
  const Surface surface({knots, knots}, Net::Random(64, 3));
  LocalFairingOptions options;
  options.maxSteps = 5000;
  const auto result = fairLocally<2>(surface, thinPlate<2>(), options);
  EXPECT_EQ(result.summary.gap, kUnlimited);
  EXPECT_EQ(result.summary.stopReason, StopReason::steps);
  EXPECT_LT(result.summary.energyAfter, 0.1 * result.summary.energyBefore);
}

TEST(LocalFairing, HandlesNetsWithASinglePointOrRow) {
  const KnotVector point = KnotVector::uniformClamped(2, 1);
  Net net = Net::Random(3 * 40, 3);
  const Surface strip({point, KnotVector::uniformClamped(3, 37)}, net);
  LocalFairingOptions options;
  options.tolerance = 0.1;
  const auto result = fairLocally<2>(strip, thinPlate<2>(), options);
  EXPECT_EQ(result.summary.stopReason, StopReason::gap);
  expectWithinBalls(strip, result.spline, {}, 0.1);
  const Curve curve({point}, Net::Random(3, 2));
  options.held = {1, 0, 1};
  options.tolerance = kUnlimited;
  const auto middle = fairLocally<1>(curve, thinPlate<1>(), options);
  EXPECT_LE(middle.summary.steps, 5);  // one, and rounding
  const Point mean = (curve.net().row(0) + curve.net().row(2)) / 2;
  EXPECT_LT((middle.spline.net().row(1) - mean).norm(), 1e-15);
}

}  // namespace
}  // namespace strak
