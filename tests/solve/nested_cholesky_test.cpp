#include "strak/solve/nested_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "strak/solve/dense_kernels.h"

namespace strak {
namespace {

using Eigen::Index;

// Points of an n x m grid, each coupled with those up to two rows and columns away, and a random matrix on that.
struct Grid {
  std::shared_ptr<const BlockPattern> pattern;
  Eigen::MatrixX3d places;
  BlockMatrix matrix;
  Eigen::MatrixXd dense;

  Grid(Index n, Index m, unsigned seed) : pattern(patternOf(n, m)), places(n * m, 3), matrix(pattern) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> number(-1, 1);
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j < m; ++j) places.row(i * m + j) << static_cast<double>(i), static_cast<double>(j), 0;
    }
    dense.setZero(3 * n * m, 3 * n * m);
    for (Index j = 0; j < n * m; ++j) {
      for (Index k = pattern->start[static_cast<std::size_t>(j)]; k < pattern->start[static_cast<std::size_t>(j) + 1];
           ++k) {
        const Index i = pattern->rows[static_cast<std::size_t>(k)];
        Eigen::Matrix3d block;
        for (int c = 0; c < 9; ++c) block(c / 3, c % 3) = number(engine);
        if (i == j) block = (block + block.transpose()).eval() + 60 * Eigen::Matrix3d::Identity();
        Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix.at(k)) = block;
        dense.block<3, 3>(3 * i, 3 * j) = block;
        dense.block<3, 3>(3 * j, 3 * i) = block.transpose();
      }
    }
  }

  static std::shared_ptr<const BlockPattern> patternOf(Index n, Index m) {
    std::vector<std::vector<int>> cliques;
    for (Index i = 0; i + 2 < n; ++i) {
      for (Index j = 0; j + 2 < m; ++j) {
        std::vector<int> clique;
        for (Index a = i; a < i + 3; ++a) {
          for (Index b = j; b < j + 3; ++b) clique.push_back(static_cast<int>(a * m + b));
        }
        clique.push_back(-1);  // a held point
        cliques.push_back(clique);
      }
    }
    return std::make_shared<const BlockPattern>(patternOfCliques(n * m, cliques));
  }
};

TEST(NestedCholesky, SolvesLikeADenseFactor) {
  for (const auto& [n, m] : {std::pair<Index, Index>{3, 3}, {5, 4}, {40, 3}, {17, 23}}) {
    const Grid grid(n, m, static_cast<unsigned>(n));
    NestedCholesky factor(grid.pattern, grid.places);
    ASSERT_TRUE(factor.factor(grid.matrix));
    const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(3 * n * m, -1, 2);
    const Eigen::VectorXd expected = grid.dense.llt().solve(b);
    EXPECT_LT((factor.solve(b) - expected).norm(), 1e-12 * expected.norm()) << n << " x " << m;
    EXPECT_LT((grid.matrix.times(b) - grid.dense * b).norm(), 1e-12 * b.norm() * 60);
  }
}

TEST(NestedCholesky, SaysWhatIsNotPositive) {
  Grid grid(12, 12, 3);
  NestedCholesky factor(grid.pattern, grid.places);
  grid.matrix.block(70, 70)[4] = -100;
  EXPECT_FALSE(factor.factor(grid.matrix));
  grid.matrix.block(70, 70)[4] = 100;
  EXPECT_TRUE(factor.factor(grid.matrix)) << "and is usable again";
}

TEST(NestedCholesky, FillsLittle) {
  const Grid small(20, 20, 1), large(40, 40, 1);
  const double a = static_cast<double>(NestedCholesky(small.pattern, small.places).factorSize());
  const double b = static_cast<double>(NestedCholesky(large.pattern, large.places).factorSize());
  EXPECT_LT(b / a, 6.5) << "n log n, not n^1.5 = 8";
}

TEST(BlockPattern, CountsRepeatedPointsOnceAndSkipsHeldOnes) {
  const BlockPattern pattern = patternOfCliques(4, {{2, -1, 0, 2}, {3, 2}});
  EXPECT_EQ(pattern.size(), 4);
  EXPECT_EQ(pattern.rows, (std::vector<int>{0, 2, 1, 2, 3, 3}));
  EXPECT_EQ(pattern.place(3, 2), 4);
}

// Every instruction set of this machine against Eigen.
using Outer = decltype(&dense::generic::addOuter);
using Eliminate = decltype(&dense::generic::eliminate);

void checkKernels(Outer addOuter, Eliminate eliminate) {
  std::srand(1);
  for (Index own : {1, 3, 15, 16, 17, 64, 65, 100}) {
    for (Index more : {0, 1, 7, 8, 24, 61}) {
      const Index all = own + more;
      const Eigen::MatrixXd root = Eigen::MatrixXd::Random(all, all);
      const Eigen::MatrixXd a = root * root.transpose() + Eigen::MatrixXd::Identity(all, all);
      std::vector<double> scratch(static_cast<std::size_t>(dense::scratchSize(all)));
      Eigen::MatrixXd left = a.leftCols(own), rest = a.bottomRightCorner(more, more);
      ASSERT_TRUE(eliminate(all, own, left.data(), rest.data(), scratch.data()));
      const Eigen::MatrixXd l = a.llt().matrixL();
      const Eigen::MatrixXd gotL = left.triangularView<Eigen::Lower>();
      EXPECT_LT((gotL - l.leftCols(own)).cwiseAbs().maxCoeff(), 1e-11) << own << " of " << all;
      const Eigen::MatrixXd tail = l.bottomRightCorner(more, more);
      const Eigen::MatrixXd schur = tail * tail.transpose();
      const Eigen::MatrixXd gotRest = rest.triangularView<Eigen::Lower>();
      const Eigen::MatrixXd wantedRest = schur.triangularView<Eigen::Lower>();
      EXPECT_LT((gotRest - wantedRest).norm(), 1e-10) << own << " of " << all;

      Eigen::MatrixXd c = a;
      addOuter(all, own, root.data(), all, 2, c.data(), all, scratch.data());
      const Eigen::MatrixXd sum = a + 2 * root.leftCols(own) * root.leftCols(own).transpose();
      const Eigen::MatrixXd got = c.triangularView<Eigen::Lower>(), wanted = sum.triangularView<Eigen::Lower>();
      EXPECT_LT((got - wanted).cwiseAbs().maxCoeff(), 1e-11);
      const Eigen::MatrixXd upper = c.triangularView<Eigen::StrictlyUpper>();
      const Eigen::MatrixXd upperBefore = a.triangularView<Eigen::StrictlyUpper>();
      EXPECT_EQ(upper, upperBefore) << "the upper triangle is not touched";
    }
  }
  Eigen::MatrixXd bad = -Eigen::MatrixXd::Identity(3, 3), none;
  std::vector<double> scratch(static_cast<std::size_t>(dense::scratchSize(3)));
  EXPECT_FALSE(eliminate(3, 3, bad.data(), none.data(), scratch.data()));
}

TEST(DenseKernels, AgreeWithEigen) {
  checkKernels(dense::generic::addOuter, dense::generic::eliminate);
  checkKernels(dense::chosen().addOuter, dense::chosen().eliminate);
#ifdef STRAK_HAS_X86_SIMD
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    checkKernels(dense::avx2::addOuter, dense::avx2::eliminate);
  }
#endif
}

}  // namespace
}  // namespace strak
