#include "strak/fitting/smoothing.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "strak/fitting/least_squares.h"
#include "strak/spline/basis.h"
#include "strak/spline/evaluate.h"
#include "tests/spline/random_splines.h"

namespace strak {
namespace {

// -2 log of the restricted likelihood from its definition: y = X b + Z a + e with normal e and a, X the polynomials
// that the energy does not see; V = I + Z Z^T / (N lambda), Z from the energy's other eigenvectors:
//   (N - m) log y^T P y + log det V + log det X^T V^-1 X,  P = V^-1 - V^-1 X (X^T V^-1 X)^-1 X^T V^-1.
double denseLikelihood(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& energy, const Eigen::VectorXd& y,
                       double lambda, Index unseen) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(energy);
  const Index q = energy.rows(), n = basis.rows();
  const Eigen::MatrixXd x = basis * eigen.eigenvectors().leftCols(unseen);
  const Eigen::MatrixXd z = basis * eigen.eigenvectors().rightCols(q - unseen) *
                            eigen.eigenvalues().tail(q - unseen).cwiseSqrt().cwiseInverse().asDiagonal();
  const Eigen::MatrixXd v = Eigen::MatrixXd::Identity(n, n) + z * z.transpose() / (static_cast<double>(n) * lambda);
  const Eigen::LDLT<Eigen::MatrixXd> factor(v);
  const Eigen::MatrixXd vx = factor.solve(x);
  const Eigen::LDLT<Eigen::MatrixXd> inner(Eigen::MatrixXd(x.transpose() * vx));
  const Eigen::VectorXd vy = factor.solve(y);
  const double squares = y.dot(vy) - vy.dot(x * inner.solve(x.transpose() * vy));
  return static_cast<double>(n - unseen) * std::log(squares) + factor.vectorD().array().log().sum() +
         inner.vectorD().array().log().sum();
}

TEST(Smoothing, LikeliestWeightIsThatOfTheDenseDefinition) {
  testing::Random random(71);
  for (int trial = 0; trial < 3; ++trial) {
    constexpr Index kPoints = 60;
    const std::array<KnotVector, 1> knots{KnotVector::uniformClamped(3, 9)};
    Net parameters(kPoints, 1), values(kPoints, 1);
    for (Index i = 0; i < kPoints; ++i) {
      const double t = (static_cast<double>(i) + random.uniform()) / kPoints;
      parameters(i, 0) = t;
      values(i, 0) = std::sin(6 * t) + 0.2 * (random.uniform() + random.uniform() - 1);
    }
    FitOptions<1> options;
    options.energy = thinPlate<1>();
    options.smoothing = Smoothing::likeliest();
    const double chosen = fitLeastSquares<1>(knots, {parameters, values}, options).summary.lambda;

    // The basis and the energy, a column of either from the spline that is 1 at one control point.
    const Index q = knots[0].size();
    Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(kPoints, q), energy(q, q);
    for (Index i = 0; i < kPoints; ++i) {
      const double t = parameters(i, 0);
      const Index span = knots[0].findSpan(t);
      const Net row = basisDerivatives(knots[0], span, t, 0);
      for (Index j = 0; j <= 3; ++j) basis(i, span - 3 + j) = row(0, j);
    }
    energy.setZero();
    const GaussRule rule = gaussLegendre(4);
    for (Index span : knots[0].spans()) {
      const double half = (knots[0][span + 1] - knots[0][span]) / 2;
      for (std::size_t g = 0; g < rule.nodes.size(); ++g) {
        const Net d = basisDerivatives(knots[0], span, knots[0][span] + half * (1 + rule.nodes[g]), 2);
        energy.block(span - 3, span - 3, 4, 4) += half * rule.weights[g] * d.row(2).transpose() * d.row(2);
      }
    }
    double best = 0, least = std::numeric_limits<double>::infinity();
    for (double x = std::log(chosen) - 3; x < std::log(chosen) + 3; x += 0.01) {
      const double value = denseLikelihood(basis, energy, values.col(0), std::exp(x), 2);
      if (value < least) {
        least = value;
        best = x;
      }
    }
    EXPECT_NEAR(std::log(chosen), best, 0.05) << "trial " << trial;
  }
}

// With much data both ways of choosing agree on the size of the weight, and the fit is as near to the truth.
TEST(Smoothing, LikeliestFitIsAsGoodAsTheCrossValidatedOne) {
  testing::Random random(72);
  constexpr Index kPoints = 3000;
  Net parameters(kPoints, 2), values(kPoints, 1);
  const auto truth = [](double x, double y) { return std::sin(4 * x) * std::cos(3 * y); };
  for (Index i = 0; i < kPoints; ++i) {
    const double x = random.uniform(), y = random.uniform();
    parameters.row(i) << x, y;
    values(i, 0) = truth(x, y) + 0.1 * (random.uniform() + random.uniform() + random.uniform() - 1.5);
  }
  const std::array<KnotVector, 2> knots{KnotVector::uniformClamped(3, 12), KnotVector::uniformClamped(3, 12)};
  double errors[2];
  for (const bool likeliest : {false, true}) {
    FitOptions<2> options;
    if (likeliest) options.smoothing = Smoothing::likeliest();
    const auto fit = fitLeastSquares<2>(knots, {parameters, values}, options);
    double sum = 0;
    for (int i = 0; i < 400; ++i) {
      const double x = (i % 20 + 0.5) / 20, y = (i / 20 + 0.5) / 20;
      const double error = evaluate(fit.spline, {x, y})[0] - truth(x, y);
      sum += error * error / 400;
    }
    errors[likeliest ? 1 : 0] = std::sqrt(sum);
  }
  EXPECT_LT(errors[1], 0.012);
  EXPECT_LT(errors[1], 1.3 * errors[0]);
}

}  // namespace
}  // namespace strak
