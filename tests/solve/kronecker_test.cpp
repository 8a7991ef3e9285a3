#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "strak/solve/ball_minimizer.h"
#include "strak/solve/kernels.h"
#include "strak/solve/kronecker_operator.h"
#include "strak/solve/modal_solver.h"

namespace strak {
namespace {

using Eigen::Index;
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A random symmetric band matrix; positive definite if `definite`.
BandMatrix randomBand(Index n, int bandwidth, bool definite, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  BandMatrix m(n, bandwidth);
  for (Index i = 0; i < n; ++i) {
    for (Index j = std::max<Index>(0, i - bandwidth); j < i; ++j) m.at(i, j) = m.at(j, i) = uniform(random);
    m.at(i, i) = definite ? 2.5 * bandwidth + 1 + uniform(random) : uniform(random);
  }
  return m;
}

RowMatrix randomNet(Index rows, Index columns, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  return RowMatrix::NullaryExpr(rows, columns, [&] { return uniform(random); });
}

Eigen::MatrixXd kronecker(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd result(a.rows() * b.rows(), a.cols() * b.cols());
  for (Index i = 0; i < a.rows(); ++i) {
    for (Index j = 0; j < a.cols(); ++j) result.block(i * b.rows(), j * b.cols(), b.rows(), b.cols()) = a(i, j) * b;
  }
  return result;
}

Eigen::MatrixXd denseSum(const std::vector<KroneckerProduct>& products) {
  Eigen::MatrixXd sum;
  for (const auto& product : products) {
    Eigen::MatrixXd m = Eigen::MatrixXd::Constant(1, 1, product.coefficient);
    for (const BandMatrix* factor : product.factors) m = kronecker(m, factor->dense());
    sum = sum.size() == 0 ? m : Eigen::MatrixXd(sum + m);
  }
  return sum;
}

struct Box {
  std::vector<Index> sizes;
  std::vector<int> bandwidths;
  int components;
};

class KroneckerBoxes : public testing::TestWithParam<Box> {};

TEST_P(KroneckerBoxes, ProductAndDiagonalEqualTheDenseMatrix) {
  const Box& box = GetParam();
  std::mt19937 random(7);
  std::vector<std::vector<BandMatrix>> factors;
  int halo = 0;
  Index points = 1;
  for (std::size_t k = 0; k < box.sizes.size(); ++k) {
    factors.push_back({randomBand(box.sizes[k], box.bandwidths[k], true, random),
                       randomBand(box.sizes[k], box.bandwidths[k], false, random)});
    halo = std::max(halo, box.bandwidths[k]);
    points *= box.sizes[k];
  }
  std::vector<KroneckerProduct> products;
  for (int t = 0; t < 3; ++t) {
    KroneckerProduct product{0.5 + t, {}};
    for (std::size_t k = 0; k < box.sizes.size(); ++k) product.factors.push_back(&factors[k][(t >> k) & 1 ? 0 : 1]);
    products.push_back(product);
  }
  const BoxLayout layout(box.sizes, std::vector<Index>(box.sizes.size(), 0), box.sizes, box.components, halo);
  const RowMatrix net = randomNet(points, box.components, random);
  Field x(layout), y(layout);
  packBox(layout, net, Eigen::RowVectorXd::Zero(box.components), x);
  KroneckerOperator op(layout, products);
  op.apply(x, y);
  RowMatrix result = RowMatrix::Zero(points, box.components);
  addBox(layout, y, result);
  const Eigen::MatrixXd dense = denseSum(products);
  const RowMatrix expected = dense * net;
  EXPECT_LT((result - expected).cwiseAbs().maxCoeff(), 1e-11 * expected.cwiseAbs().maxCoeff());

  const Field diagonal = op.diagonal();
  RowMatrix diagonalNet = RowMatrix::Zero(points, 1);
  addBox(layout.scalar(), diagonal, diagonalNet);
  EXPECT_LT((diagonalNet.col(0) - dense.diagonal()).cwiseAbs().maxCoeff(), 1e-11 * dense.cwiseAbs().maxCoeff());
}

TEST_P(KroneckerBoxes, ModalSolverInvertsSumsOfStiffnessAndMass) {
  const Box& box = GetParam();
  std::mt19937 random(11);
  std::vector<BandMatrix> stiffness, mass;
  int halo = 0;
  Index points = 1;
  for (std::size_t k = 0; k < box.sizes.size(); ++k) {
    stiffness.push_back(randomBand(box.sizes[k], box.bandwidths[k], true, random));
    mass.push_back(randomBand(box.sizes[k], box.bandwidths[k], true, random));
    halo = std::max(halo, box.bandwidths[k]);
    points *= box.sizes[k];
  }
  std::vector<KroneckerProduct> products;
  std::vector<const BandMatrix*> stiffnessList, massList;
  for (std::size_t k = 0; k < box.sizes.size(); ++k) {
    stiffnessList.push_back(&stiffness[k]);
    massList.push_back(&mass[k]);
    KroneckerProduct product{1.0 + static_cast<double>(k), {}};
    for (std::size_t l = 0; l < box.sizes.size(); ++l) product.factors.push_back(k == l ? &stiffness[l] : &mass[l]);
    products.push_back(product);
  }
  const BoxLayout layout(box.sizes, std::vector<Index>(box.sizes.size(), 0), box.sizes, box.components, halo);
  const ModalBasis basis(layout, stiffnessList, massList);
  ModalSolver solver(layout, products, basis);
  EXPECT_GT(solver.conditionIndicator(), 1e-8);
  const RowMatrix net = randomNet(points, box.components, random);
  Field b(layout), x(layout);
  packBox(layout, net, Eigen::RowVectorXd::Zero(box.components), b);
  solver.solve(b, x);
  RowMatrix result = RowMatrix::Zero(points, box.components);
  addBox(layout, x, result);
  const RowMatrix expected = denseSum(products).ldlt().solve(net);
  EXPECT_LT((result - expected).cwiseAbs().maxCoeff(), 1e-9 * expected.cwiseAbs().maxCoeff());
}

INSTANTIATE_TEST_SUITE_P(Shapes, KroneckerBoxes,
                         testing::Values(Box{{9}, {2}, 2}, Box{{1}, {3}, 1}, Box{{12, 5}, {3, 2}, 3},
                                         Box{{5, 12}, {2, 4}, 3}, Box{{7, 7}, {1, 1}, 4}, Box{{1, 10}, {2, 2}, 3},
                                         Box{{4, 6, 5}, {2, 3, 1}, 3}, Box{{3, 2, 9}, {2, 2, 2}, 1},
                                         Box{{40, 17}, {4, 3}, 5}));

TEST(ModalSolver, TellsASingularMatrix) {
  // Second differences with free ends: constants are in the kernel.
  const Index n = 8;
  BandMatrix stiffness(n, 1), mass(n, 1);
  for (Index i = 0; i < n; ++i) {
    mass.at(i, i) = 1;
    stiffness.at(i, i) = i == 0 || i == n - 1 ? 1 : 2;
    if (i > 0) stiffness.at(i, i - 1) = stiffness.at(i - 1, i) = -1;
  }
  const BoxLayout layout({n, n}, {0, 0}, {n, n}, 1, 1);
  const std::vector<KroneckerProduct> products{{1, {&stiffness, &mass}}, {1, {&mass, &stiffness}}};
  const ModalBasis basis(layout, {&stiffness, &stiffness}, {&mass, &mass});
  EXPECT_LT(ModalSolver(layout, products, basis).conditionIndicator(), 1e-13);
}

// All instruction sets of this machine give the same numbers up to rounding.
template <class Function>
void onEveryLevel(const Function& check) {
  check(kernels::generic::bandTimesRow, kernels::generic::combineRows, kernels::generic::multiply, "generic");
#ifdef STRAK_HAS_X86_SIMD
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    check(kernels::avx2::bandTimesRow, kernels::avx2::combineRows, kernels::avx2::multiply, "avx2");
  }
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) {
    check(kernels::avx512::bandTimesRow, kernels::avx512::combineRows, kernels::avx512::multiply, "avx512");
  }
#endif
}

TEST(Kernels, EveryInstructionSetMultipliesAlike) {
  std::mt19937 random(3);
  const Index m = 11, k = 150, n = 72;
  const RowMatrix a = randomNet(m, k, random);
  const RowMatrix b = randomNet(k, n, random);
  const RowMatrix expected = a * b;
  onEveryLevel([&](auto band, auto combine, auto multiply, const char* level) {
    RowMatrix c = RowMatrix::Constant(m, n, 99);
    multiply(m, n, k, a.data(), k, b.data(), n, c.data(), n);
    EXPECT_LT((c - expected).cwiseAbs().maxCoeff(), 1e-12) << level;

    std::vector<const double*> rows;
    for (Index i = 0; i < k; ++i) rows.push_back(b.row(i).data());
    Eigen::RowVectorXd y(n);
    combine(k, a.row(0).data(), rows.data(), y.data(), n);
    EXPECT_LT((y - expected.row(0)).cwiseAbs().maxCoeff(), 1e-12) << level;

    const int p = 3;
    RowMatrix bands = randomNet(2 * p + 1, n, random);
    Eigen::RowVectorXd x = Eigen::RowVectorXd::Zero(n + 16);
    x.segment(8, n) = b.row(0);
    band(bands.data(), n, p, x.data() + 8, y.data(), n);
    for (Index j = 0; j < n; ++j) {
      double sum = 0;
      for (int d = 0; d <= 2 * p; ++d) sum += bands(d, j) * x[8 + j + d - p];
      EXPECT_NEAR(y[j], sum, 1e-13) << level;
    }
  });
}

}  // namespace
}  // namespace strak
