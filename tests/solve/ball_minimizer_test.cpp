#include "strak/solve/ball_minimizer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "strak/solve/alternating_directions.h"

namespace strak {
namespace {

using Eigen::Index;

// Fourth differences: the stiffness of a clamped beam, so ill-conditioned that projected gradients have work to do.
BandMatrix beam(Index n) {
  BandMatrix m(n, 2);
  for (Index i = 0; i < n; ++i) {
    m.at(i, i) = 6;
    if (i > 0) m.at(i, i - 1) = m.at(i - 1, i) = -4;
    if (i > 1) m.at(i, i - 2) = m.at(i - 2, i) = 1;
  }
  return m;
}

BandMatrix massOf(Index n) {
  BandMatrix m(n, 2);
  for (Index i = 0; i < n; ++i) {
    m.at(i, i) = 0.6;
    if (i > 0) m.at(i, i - 1) = m.at(i - 1, i) = 0.2;
  }
  return m;
}

// min q on an n x m box with a random linear term, some points held.
struct Plate {
  BandMatrix stiffnessU, stiffnessV, massU, massV;
  BoxLayout layout;
  KroneckerOperator op;
  ModalBasis basis;
  Field linear, isFree;
  BallProblem problem;

  Plate(Index n, Index m, double radius)
      : stiffnessU(beam(n)),
        stiffnessV(beam(m)),
        massU(massOf(n)),
        massV(massOf(m)),
        layout({n, m}, {0, 0}, {n, m}, 3, 2),
        op(layout, products()),
        basis(layout, {&stiffnessU, &stiffnessV}, {&massU, &massV}),
        linear(layout),
        isFree(layout.scalar()) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    std::bernoulli_distribution held(0.05);
    for (Index r = 0; r < layout.rows(); ++r) {
      for (Index j = 0; j < layout.size[2]; ++j) {
        isFree.row(r, 0)[j] = held(random) ? 0 : 1;
        for (int c = 0; c < 3; ++c) linear.row(r, c)[j] = normal(random);
      }
    }
    problem.energy = &op;
    problem.linear = &linear;
    problem.free = &isFree;
    problem.products = products();
    problem.lowerBound = products();
    problem.massProduct = {1, {&massU, &massV}};
    problem.basis = &basis;
    problem.radius = radius;
    problem.scale = 1000;
  }
  Plate(const Plate&) = delete;

  std::vector<KroneckerProduct> products() const { return {{1, {&stiffnessU, &massV}}, {1, {&massU, &stiffnessV}}}; }
};

BallOptions upTo(double gap) {
  BallOptions options;
  options.gap = gap;
  options.maxIterations = 100000;
  return options;
}

TEST(BallMinimizer, AlternatingDirectionsAndProjectedGradientsMeet) {
  for (double radius : {0.05, 0.4, 3.0}) {
    Plate plate(23, 9, radius);
    Field a(plate.layout), b(plate.layout);
    const BallResult gradients = minimizeInBalls(plate.problem, upTo(1e-9), a);
    const BallResult alternating = minimizeByAlternatingDirections(plate.problem, upTo(1e-9), b);
    const double scale = plate.problem.scale;
    EXPECT_EQ(gradients.stop, BallResult::Stop::gap) << radius;
    EXPECT_EQ(alternating.stop, BallResult::Stop::gap) << radius;
    EXPECT_LE(gradients.value - gradients.bound, alternating.value + 1e-10 * scale);
    EXPECT_LE(alternating.value - alternating.bound, gradients.value + 1e-10 * scale);
    for (const Field* e : {&a, &b}) {
      for (Index r = 0; r < plate.layout.rows(); ++r) {
        for (Index j = 0; j < plate.layout.size[2]; ++j) {
          double square = 0;
          for (int c = 0; c < 3; ++c) square += e->row(r, c)[j] * e->row(r, c)[j];
          EXPECT_LE(std::sqrt(square), radius * (1 + 1e-14));
          if (plate.isFree.row(r, 0)[j] == 0) {
            EXPECT_EQ(square, 0);
          }
        }
      }
    }
  }
}

TEST(BallMinimizer, AlternatingDirectionsNeedNoLowerBound) {
  Plate plate(12, 10, 0.3);
  Field known(plate.layout), e(plate.layout);
  const BallResult reference = minimizeInBalls(plate.problem, upTo(1e-9), known);
  plate.problem.lowerBound.clear();
  const BallResult result = minimizeByAlternatingDirections(plate.problem, upTo(1e-8), e);
  EXPECT_EQ(result.stop, BallResult::Stop::gap);
  EXPECT_NEAR(result.value, reference.value, 2e-8 * std::abs(plate.problem.scale + reference.value));
}

TEST(BallMinimizer, AStartIsNeverMadeWorse) {
  Plate plate(15, 8, 0.2);
  Field e(plate.layout);
  const BallResult best = minimizeInBalls(plate.problem, upTo(1e-10), e);
  BallOptions one = upTo(0);
  one.maxIterations = 1;
  const BallResult again = minimizeByAlternatingDirections(plate.problem, one, e);
  EXPECT_LE(again.value, best.value + 1e-9);
}

TEST(BallMinimizer, TheBoundAtAnyFieldHolds) {
  Plate plate(14, 9, 0.25);
  Field best(plate.layout), e(plate.layout);
  const BallResult optimum = minimizeInBalls(plate.problem, upTo(1e-11), best);
  for (double part : {0.0, 0.3, 0.9, 1.0}) {
    e.setZero();
    addScaled(e, part, best);
    const BallResult result = boundAt(plate.problem, e);
    EXPECT_GE(result.value, optimum.value - 1e-9);
    EXPECT_GE(result.bound, result.value - optimum.value - 1e-8) << part;
  }
}

TEST(BallMinimizer, WithoutARadiusTheGradientVanishes) {
  Plate plate(31, 12, std::numeric_limits<double>::infinity());
  Field e(plate.layout), h(plate.layout);
  const BallResult result = minimizeFreely(plate.problem, upTo(1e-12), e);
  EXPECT_EQ(result.stop, BallResult::Stop::gap);
  plate.op.apply(e, h);
  addScaled(h, 1, plate.linear);
  for (Index r = 0; r < plate.layout.rows(); ++r) {
    for (Index j = 0; j < plate.layout.size[2]; ++j) {
      for (int c = 0; c < 3; ++c) {
        if (plate.isFree.row(r, 0)[j] > 0) {
          EXPECT_NEAR(h.row(r, c)[j], 0, 1e-3);
        }
      }
    }
  }
  plate.problem.lowerBound.clear();
  EXPECT_EQ(minimizeFreely(plate.problem, upTo(1e-6), e).stop, BallResult::Stop::unproven);
}

}  // namespace
}  // namespace strak
