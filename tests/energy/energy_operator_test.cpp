#include "strak/energy/energy_operator.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "strak/base/error.h"
#include "strak/spline/basis.h"
#include "strak/spline/evaluate.h"
#include "tests/energy/hadenfeld_net.h"
#include "tests/spline/random_splines.h"

namespace strak {
namespace {

using testing::Random;

// Unit spacing without clamped ends: every function far inside is the cardinal B-spline.
KnotVector cardinalKnots(int degree, int spans) {
  std::vector<double> knots;
  for (int i = -degree; i <= spans + degree; ++i) knots.push_back(i);
  return {degree, knots};
}

// One point moves alone: factors of its neighbours in its target, Hadenfeld (8) and (9).
template <int D>
double targetFactor(const EnergyOperator<D>& op, const typename Spline<D>::Sizes& index,
                    const typename Spline<D>::Sizes& offset) {
  const auto stencil = op.row(index);
  Index place = 0;
  Index middle = 0;
  for (std::size_t k = 0; k < D; ++k) {
    place = place * stencil.count[k] + index[k] + offset[k] - stencil.first[k];
    middle = middle * stencil.count[k] + index[k] - stencil.first[k];
  }
  return -stencil.values[static_cast<std::size_t>(place)] / stencil.values[static_cast<std::size_t>(middle)];
}

template <int D>
double weightAt(const EnergyOperator<D>& op, const typename Spline<D>::Sizes& index) {
  Index row = 0;
  for (std::size_t k = 0; k < D; ++k) row = row * op.sizes()[k] + index[k];
  return op.diagonal()[row];
}

struct ExactCurve {
  int degree;
  const char* energy;
  double weight;
  std::vector<double> factors;  // gamma of the neighbours 1, 2, ... places away
};

TEST(EnergyOperator, HasTheExactRationalStencilsOfUniformCurves) {
  const std::vector<ExactCurve> cases = {
      {3, "thin-plate", 8.0 / 3, {9.0 / 16, 0, -1.0 / 16}},
      {3, "third-order", 20, {3.0 / 4, -3.0 / 10, 1.0 / 20}},
      {4, "thin-plate", 19.0 / 12, {43.0 / 95, 16.0 / 95, -11.0 / 95, -1.0 / 190}},
      {4, "third-order", 25.0 / 3, {17.0 / 25, -4.0 / 25, -1.0 / 25, 1.0 / 50}},
      {5, "thin-plate", 31.0 / 30, {43.0 / 124, 68.0 / 217, -239.0 / 1736, -29.0 / 1302, -1.0 / 5208}},
      {5, "third-order", 23.0 / 5, {55.0 / 92, 0, -25.0 / 184, 5.0 / 138, 1.0 / 552}},
  };
  for (const ExactCurve& exact : cases) {
    const EnergyOperator<1> op(energyNamed<1>(exact.energy), {cardinalKnots(exact.degree, 12)});
    const Index middle = op.sizes()[0] / 2;
    EXPECT_NEAR(weightAt<1>(op, {middle}), exact.weight, 1e-14 * exact.weight);
    for (std::size_t i = 0; i < exact.factors.size(); ++i) {
      const auto offset = static_cast<Index>(i) + 1;
      EXPECT_NEAR(targetFactor<1>(op, {middle}, {offset}), exact.factors[i], 2e-15) << exact.degree << exact.energy;
      EXPECT_NEAR(targetFactor<1>(op, {middle}, {-offset}), exact.factors[i], 2e-15) << exact.degree << exact.energy;
    }
  }
}

TEST(EnergyOperator, HasTheExactRationalStencilOfUniformBicubicThinPlates) {
  const EnergyOperator<2> op(thinPlate<2>(), {cardinalKnots(3, 9), cardinalKnots(3, 10)});
  const Spline<2>::Sizes middle{6, 6};
  EXPECT_NEAR(weightAt<2>(op, middle), 3256.0 / 945, 1e-14);
  for (Index sign : {-1, 1}) {
    EXPECT_NEAR(targetFactor<2>(op, middle, {sign, 0}), 483.0 / 6512, 1e-15);
    EXPECT_NEAR(targetFactor<2>(op, middle, {0, sign}), 483.0 / 6512, 1e-15);
    EXPECT_NEAR(targetFactor<2>(op, middle, {sign, 1}), 1863.0 / 9472, 1e-15);
    EXPECT_NEAR(targetFactor<2>(op, middle, {2 * sign, 0}), 24.0 / 407, 1e-15);
    EXPECT_NEAR(targetFactor<2>(op, middle, {2, sign}), -27.0 / 6512, 1e-15);
    EXPECT_NEAR(targetFactor<2>(op, middle, {sign, -2}), -27.0 / 6512, 1e-15);
  }
}

// The rows of free points of two matrices, compared: largest difference over largest entry.
double rowDifference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, Index size, Index held) {
  double difference = 0;
  double largest = 0;
  for (Index i = held; i < size - held; ++i) {
    for (Index j = held; j < size - held; ++j) {
      difference = std::max(difference, (a.row(i * size + j) - b.row(i * size + j)).cwiseAbs().maxCoeff());
      largest = std::max(largest, a.row(i * size + j).cwiseAbs().maxCoeff());
    }
  }
  return difference / largest;
}

TEST(EnergyOperator, ThinPlateAndLaplacianDifferByWhatTheHeldRowsFix) {
  const KnotVector knots = KnotVector::uniformClamped(4, 8);
  const Eigen::MatrixXd plate = EnergyOperator<2>(thinPlate<2>(), {knots, knots}).matrix();
  const Eigen::MatrixXd laplace = EnergyOperator<2>(laplacian<2>(), {knots, knots}).matrix();
  EXPECT_LT(rowDifference(plate, laplace, knots.size(), 2), 2e-15);
  EXPECT_NEAR(rowDifference(plate, laplace, knots.size(), 1), 0.4, 0.1);
}

TEST(EnergyOperator, ThirdDerivativesAndLaplacianGradientAgreeFromThreeHeldRowsOn) {
  const KnotVector knots(5, {0, 0, 0, 0, 0, 0, 0.1, 0.25, 0.3, 0.5, 0.6, 0.85, 1, 1, 1, 1, 1, 1});
  const Eigen::MatrixXd all = EnergyOperator<2>(thirdDerivatives<2>(), {knots, knots}).matrix();
  const Eigen::MatrixXd laplace = EnergyOperator<2>(laplacianGradient<2>(), {knots, knots}).matrix();
  EXPECT_LT(rowDifference(all, laplace, knots.size(), 3), 5e-15);
  EXPECT_GT(rowDifference(all, laplace, knots.size(), 2), 0.01);
}

TEST(EnergyOperator, WritesTheLaplacianGradientAsItsExpandedTerms) {
  using Term = EnergyTerm<2>;
  const QuadraticEnergy<2> expanded{"(16)",
                                    {Term{1, {3, 0}, {3, 0}}, Term{2, {3, 0}, {1, 2}}, Term{1, {1, 2}, {1, 2}},
                                     Term{1, {2, 1}, {2, 1}}, Term{2, {2, 1}, {0, 3}}, Term{1, {0, 3}, {0, 3}}}};
  Random random(3);
  for (int i = 0; i < 5; ++i) {
    const std::array knots{testing::randomKnots(random, testing::KnotKind::nonUniform, 4, 3),
                           testing::randomKnots(random, testing::KnotKind::repeated, 3, 4)};
    const Eigen::MatrixXd a = EnergyOperator<2>(laplacianGradient<2>(), knots).matrix();
    const Eigen::MatrixXd b = EnergyOperator<2>(expanded, knots).matrix();
    EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-14 * a.cwiseAbs().maxCoeff());
    EXPECT_GT(a.cwiseAbs().maxCoeff(), 0);
  }
}

template <int D>
Index kernelDimension(const QuadraticEnergy<D>& energy, const std::array<KnotVector, D>& knots) {
  const Eigen::MatrixXd matrix = EnergyOperator<D>(energy, knots).matrix();
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
  EXPECT_GT(values.minCoeff(), -1e-12 * values.maxCoeff());
  return (values.array() < 1e-11 * values.maxCoeff()).count();
}

TEST(EnergyOperator, HasTheKnownKernels) {
  const std::array<KnotVector, 2> knots{KnotVector::uniformClamped(3, 4, 0, 4), KnotVector::uniformClamped(3, 5, 0, 5)};
  EXPECT_EQ(kernelDimension<2>(thinPlate<2>(), knots), 3);
  EXPECT_EQ(kernelDimension<2>(laplacian<2>(), knots), 8);
  EXPECT_EQ(kernelDimension<2>(thirdOrder<2>(), knots), 9);
  EXPECT_EQ(kernelDimension<2>(laplacianGradient<2>(), knots), 9);
  EXPECT_EQ(kernelDimension<2>(thirdDerivatives<2>(), knots), 6);
  // f(u) + g(v) + c u v
  EXPECT_EQ(kernelDimension<2>(q3<2>(), knots), knots[0].size() + knots[1].size());
  EXPECT_EQ(kernelDimension<1>(thinPlate<1>(), {knots[0]}), 2);
  EXPECT_EQ(kernelDimension<1>(thirdOrder<1>(), {knots[0]}), 3);
  const std::array<KnotVector, 3> block{KnotVector::uniformClamped(3, 1), KnotVector::uniformClamped(3, 2, 0, 2),
                                        KnotVector::uniformClamped(3, 1)};
  EXPECT_EQ(kernelDimension<3>(thinPlate<3>(), block), 4);
  EXPECT_EQ(kernelDimension<3>(thirdDerivatives<3>(), block), 10);
}

TEST(EnergyOperator, ThirdOrderIsSingularWithOnlyTheBoundaryHeldAndTwoRowsCureIt) {
  const KnotVector knots = KnotVector::uniformClamped(3, 6, 0, 6);
  const Eigen::MatrixXd matrix = EnergyOperator<2>(thirdOrder<2>(), {knots, knots}).matrix();
  for (Index held : {1, 2}) {
    const Index n = knots.size() - 2 * held;
    Eigen::MatrixXd block(n * n, n * n);
    for (Index r = 0; r < n * n; ++r) {
      for (Index s = 0; s < n * n; ++s) {
        block(r, s) =
            matrix((r / n + held) * knots.size() + r % n + held, (s / n + held) * knots.size() + s % n + held);
      }
    }
    const Eigen::VectorXd values =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(block, Eigen::EigenvaluesOnly).eigenvalues();
    // The bubble u (1 - u) v (1 - v).
    EXPECT_EQ((values.array() < 1e-11 * values.maxCoeff()).count(), held == 1 ? 1 : 0);
  }
}

template <int D>
std::vector<QuadraticEnergy<D>> allEnergies() {
  std::vector<QuadraticEnergy<D>> energies{thinPlate<D>(),        laplacian<D>(),
                                           thirdOrder<D>(),       laplacianGradient<D>(),
                                           thirdDerivatives<D>(), energyNamed<D>("thin-plate+0.1*third-derivatives")};
  if constexpr (D > 1) energies.push_back(q3<D>());
  return energies;
}

// Lines and planes cost nothing: sum K_ij = 0, which is (10), and sum K_ij Greville_ij = 0.
template <int D>
void expectLinearPrecision(std::uint64_t seed) {
  Random random(seed);
  std::array<KnotVector, D> knots;
  for (auto& direction : knots) {
    direction = testing::randomKnots(random, testing::kKnotKinds[random.integer(0, 2)], random.integer(1, 5 - D), 3);
  }
  Index rows = 1;
  for (const auto& direction : knots) rows *= direction.size();
  Net linear(rows, D + 1);
  for (Index r = 0; r < rows; ++r) {
    Index rest = r;
    for (int k = D - 1; k >= 0; --k) {
      const auto& direction = knots[static_cast<std::size_t>(k)];
      linear(r, k) = direction.greville()[static_cast<std::size_t>(rest % direction.size())];
      rest /= direction.size();
    }
    linear(r, D) = 1;
  }
  for (const auto& energy : allEnergies<D>()) {
    const EnergyOperator<D> op(energy, knots);
    const double scale = std::max(op.diagonal().maxCoeff(), 1e-300) * linear.cwiseAbs().maxCoeff();
    EXPECT_LT(op.product(linear).cwiseAbs().maxCoeff(), 2e-13 * scale) << energy.name << " D = " << D;
  }
}

TEST(EnergyOperator, CostsNothingForLinearFunctions) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    expectLinearPrecision<1>(seed);
    expectLinearPrecision<2>(seed);
    if (seed <= 3) expectLinearPrecision<3>(seed);
  }
}

// E by quadrature of the evaluated derivatives, without any Gram matrix.
template <int D>
double integratedEnergy(const QuadraticEnergy<D>& energy, const Spline<D>& spline) {
  const GaussRule rule = gaussLegendre(8);
  std::array<std::vector<double>, static_cast<std::size_t>(D)> parameters;
  std::array<std::vector<double>, static_cast<std::size_t>(D)> weights;
  for (std::size_t k = 0; k < D; ++k) {
    const KnotVector& knots = spline.knots(static_cast<int>(k));
    for (Index span : knots.spans()) {
      const double half = (knots[span + 1] - knots[span]) / 2;
      for (std::size_t q = 0; q < rule.nodes.size(); ++q) {
        parameters[k].push_back(knots[span] + half * (1 + rule.nodes[q]));
        weights[k].push_back(half * rule.weights[q]);
      }
    }
  }
  const Net grid = derivativesOnGrid<D>(spline, parameters, 3);
  const Index dimension = spline.net().cols();
  // Place of a derivative in the graded order, u first.
  const auto place = [](const std::array<int, D>& orders) {
    int total = 0;
    for (int order : orders) total += order;
    Index number = total == 0 ? 0 : derivativeCount(D, total - 1);
    if constexpr (D == 2) number += orders[1];
    if constexpr (D == 3) {
      const int rest = total - orders[0];
      number += rest * (rest + 1) / 2 + orders[2];
    }
    return number;
  };
  double sum = 0;
  for (Index r = 0; r < grid.rows(); ++r) {
    double weight = 1;
    Index rest = r;
    for (std::size_t k = D; k-- > 0;) {
      const auto count = static_cast<Index>(weights[k].size());
      weight *= weights[k][static_cast<std::size_t>(rest % count)];
      rest /= count;
    }
    for (const auto& term : energy.terms) {
      const auto a = grid.row(r).segment(place(term.a) * dimension, dimension);
      const auto b = grid.row(r).segment(place(term.b) * dimension, dimension);
      sum += weight * term.coefficient * a.dot(b);
    }
  }
  return sum;
}

template <int D>
void expectAgreement(std::uint64_t seed, int maxDegree) {
  Random random(seed);
  std::array<KnotVector, static_cast<std::size_t>(D)> knots;
  for (auto& direction : knots) {
    direction = testing::randomKnots(random, testing::kKnotKinds[random.integer(0, 5)], random.integer(0, maxDegree),
                                     random.integer(1, 4));
  }
  const int dimension = random.integer(1, 4);
  const auto spline = testing::randomSpline<D>(random, knots, dimension, false);
  const Net& net = spline.net();
  for (const auto& energy : allEnergies<D>()) {
    const EnergyOperator<D> op(energy, spline.knots());
    const Eigen::MatrixXd matrix = op.matrix();
    const double scale = matrix.cwiseAbs().maxCoeff() * static_cast<double>(net.size()) + 1e-300;
    const std::string context = energy.name + ", D = " + std::to_string(D) + ", seed " + std::to_string(seed);
    EXPECT_LT((matrix - matrix.transpose()).cwiseAbs().maxCoeff(), 1e-14 * scale) << context;
    EXPECT_LT((op.product(net) - Net(matrix * net)).cwiseAbs().maxCoeff(), 1e-13 * scale) << context;
    EXPECT_LT((op.gradient(net) - 2 * op.product(net)).cwiseAbs().maxCoeff(), 1e-13 * scale) << context;
    EXPECT_NEAR(op.value(net), net.cwiseProduct(Net(matrix * net)).sum(), 1e-13 * scale) << context;
    EXPECT_LT((op.diagonal() - matrix.diagonal()).cwiseAbs().maxCoeff(), 1e-14 * scale) << context;
    EXPECT_NEAR(op.value(net), integratedEnergy(energy, spline), 1e-11 * scale) << context;
    for (int i = 0; i < 3; ++i) {
      typename Spline<D>::Sizes index{};
      for (std::size_t k = 0; k < D; ++k) index[k] = random.integer(0, static_cast<int>(op.sizes()[k]) - 1);
      const auto stencil = op.row(index);
      Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(matrix.cols());
      for (std::size_t s = 0; s < stencil.values.size(); ++s) {
        typename Spline<D>::Sizes other{};
        auto rest = static_cast<Index>(s);
        for (std::size_t k = D; k-- > 0;) {
          other[k] = stencil.first[k] + rest % stencil.count[k];
          rest /= stencil.count[k];
        }
        row[spline.row(other)] = stencil.values[s];
      }
      EXPECT_LT((row - matrix.row(spline.row(index))).cwiseAbs().maxCoeff(), 1e-15 * scale) << context;
    }
  }
}

TEST(EnergyOperator, ValueProductRowDiagonalMatrixAndIntegralAgreeOnAnyKnots) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) expectAgreement<1>(seed, 7);
  for (std::uint64_t seed = 1; seed <= 25; ++seed) expectAgreement<2>(seed, 5);
  for (std::uint64_t seed = 1; seed <= 6; ++seed) expectAgreement<3>(seed, 3);
}

TEST(EnergyOperator, GivesTheKnownEnergiesOfHadenfeldsFirstExample) {
  for (const auto& [perturbed, energy] : {std::pair{false, 2146.35217569}, std::pair{true, 3754.11852461}}) {
    const Surface surface = testing::hadenfeldSurface(perturbed);
    EXPECT_NEAR(EnergyOperator<2>(thinPlate<2>(), surface.knots()).value(surface.net()), energy, 1e-8);
  }
}

TEST(EnergyOperator, WorksWithoutTermsAndRefusesWhatItCannotDo) {
  const std::array<KnotVector, 1> knots{KnotVector::uniformClamped(3, 4)};
  const EnergyOperator<1> nothing(QuadraticEnergy<1>{"nothing", {}}, knots);
  EXPECT_EQ(nothing.sizes()[0], 7);
  EXPECT_EQ(nothing.value(Net::Ones(7, 2)), 0);
  EXPECT_THROW(nothing.product(Net::Ones(6, 2)), InvalidInput);
  EXPECT_THROW(EnergyOperator<1>(QuadraticEnergy<1>{"high", {{1, {4}, {4}}}}, knots), InvalidInput);
  EXPECT_THROW(EnergyOperator<1>(QuadraticEnergy<1>{"negative", {{1, {-1}, {2}}}}, knots), InvalidInput);
}

}  // namespace
}  // namespace strak
