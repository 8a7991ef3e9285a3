#include "strak/energy/box_energy.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

namespace strak {
namespace {

Eigen::MatrixXd dense(const std::vector<KroneckerProduct>& products) {
  Eigen::MatrixXd sum;
  for (const auto& product : products) {
    const Eigen::MatrixXd a = product.factors[0]->dense();
    const Eigen::MatrixXd b = product.factors[1]->dense();
    Eigen::MatrixXd m(a.rows() * b.rows(), a.cols() * b.cols());
    for (Index i = 0; i < a.rows(); ++i) {
      for (Index j = 0; j < a.cols(); ++j) {
        m.block(i * b.rows(), j * b.cols(), b.rows(), b.cols()) = product.coefficient * a(i, j) * b;
      }
    }
    sum = sum.size() == 0 ? m : Eigen::MatrixXd(sum + m);
  }
  return sum;
}

struct Case {
  QuadraticEnergy<2> energy;
  Index rows;
  bool provable;
};

TEST(BoxEnergy, EqualsTheBlockOfTheWholeMatrixAndItsLowerBoundIsOne) {
  const std::array knots{KnotVector(3, {0, 0, 0, 0, 0.2, 0.5, 0.6, 0.7, 1.1, 1.5, 2, 2, 2, 2}),
                         KnotVector::uniformClamped(4, 6, 0, 3)};
  for (const auto& [energy, rows, provable] :
       {Case{thinPlate<2>(), 1, true}, Case{laplacian<2>(), 0, false}, Case{laplacian<2>(), 1, true},
        Case{laplacianGradient<2>(), 1, false}, Case{laplacianGradient<2>(), 2, true}, Case{thirdOrder<2>(), 1, true},
        Case{thirdDerivatives<2>(), 2, true}, Case{energyNamed<2>("laplacian+2*third-order"), 2, true}}) {
    const EnergyOperator<2> op(energy, knots);
    const IndexBox box{{rows, rows}, {op.sizes()[0] - 2 * rows, op.sizes()[1] - 2 * rows}};
    const BoxEnergy<2> onBox(op, box);
    const Eigen::MatrixXd all = op.matrix();
    std::vector<Index> places;
    for (Index i = 0; i < box.count[0]; ++i) {
      for (Index j = 0; j < box.count[1]; ++j) places.push_back((rows + i) * op.sizes()[1] + rows + j);
    }
    const Eigen::MatrixXd expected = all(places, places);
    const Eigen::MatrixXd k = dense(onBox.products());
    EXPECT_LT((k - expected).cwiseAbs().maxCoeff(), 1e-11 * expected.cwiseAbs().maxCoeff()) << energy.name;
    EXPECT_EQ(!onBox.lowerBound().empty(), provable) << energy.name << " with " << rows;
    if (!provable) continue;
    const Eigen::MatrixXd rest = k - dense(onBox.lowerBound());
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(rest, Eigen::EigenvaluesOnly);
    EXPECT_GT(eigen.eigenvalues()[0], -1e-11 * k.cwiseAbs().maxCoeff()) << energy.name;
  }
}

}  // namespace
}  // namespace strak
