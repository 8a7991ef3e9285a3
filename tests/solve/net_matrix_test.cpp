#include "strak/solve/net_matrix.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <random>

namespace strak {
namespace {

using Eigen::Index;

NetMatrix randomMatrix(std::array<Index, 2> sizes, std::array<int, 2> reach) {
  std::mt19937_64 random(4);
  NetMatrix matrix(sizes, reach);
  for (Index i = 0; i < sizes[0]; ++i) {
    for (Index j = 0; j < sizes[1]; ++j) {
      const Index row = i * sizes[1] + j;
      for (int di = -reach[0]; di <= reach[0]; ++di) {
        for (int dj = -reach[1]; dj <= reach[1]; ++dj) {
          const Index k = i + di, l = j + dj;
          if (k < 0 || l < 0 || k >= sizes[0] || l >= sizes[1] || k * sizes[1] + l > row) continue;
          const double value = static_cast<double>(random() >> 11) * 0x1p-53 - 0.5;
          matrix.at(row, di, dj) = value;
          matrix.at(k * sizes[1] + l, -di, -dj) = value;
        }
      }
      matrix.at(row, 0, 0) = static_cast<double>(matrix.rowLength()) * (1 + 0.1 * static_cast<double>(row % 7));
    }
  }
  return matrix;
}

Eigen::MatrixXd dense(const NetMatrix& matrix) {
  return matrix.times(NetVectors::Identity(matrix.size(), matrix.size()));
}

TEST(NetMatrix, TimesIsSymmetric) {
  const Eigen::MatrixXd a = dense(randomMatrix({5, 8}, {2, 3}));
  EXPECT_EQ(a, a.transpose());
  EXPECT_EQ(a(3 * 8 + 4, 8 + 1) != 0, true);
  EXPECT_EQ(a(3 * 8 + 4, 8), 0);
}

TEST(NetCholesky, SolvesAndKnowsTheDeterminant) {
  for (const auto& [sizes, reach] :
       std::vector<std::pair<std::array<Index, 2>, std::array<int, 2>>>{{{1, 50}, {0, 3}},
                                                                        {{9, 7}, {3, 3}},
                                                                        {{30, 31}, {2, 4}},
                                                                        {{4, 100}, {1, 5}},
                                                                        {{20, 5}, {5, 1}},
                                                                        {{1, 1}, {0, 0}}}) {
    const NetMatrix matrix = randomMatrix(sizes, reach);
    const Eigen::LLT<Eigen::MatrixXd> exact(dense(matrix));
    NetCholesky factor(sizes, reach);
    ASSERT_TRUE(factor.factor(matrix));
    const NetVectors b = NetVectors::Random(matrix.size(), 2);
    EXPECT_LT((factor.solve(b) - exact.solve(b)).norm(), 1e-12 * b.norm());
    EXPECT_NEAR(factor.logDeterminant(), 2 * Eigen::MatrixXd(exact.matrixL()).diagonal().array().log().sum(), 1e-9);
  }
}

TEST(NetCholesky, HeldPointsAreLeftOut) {
  const NetMatrix matrix = randomMatrix({6, 7}, {2, 2});
  std::vector<char> held(42, 0);
  std::vector<Index> free;
  for (Index r = 0; r < 42; ++r) {
    held[static_cast<std::size_t>(r)] = r % 5 == 0;
    if (r % 5 != 0) free.push_back(r);
  }
  NetCholesky factor({6, 7}, {2, 2});
  ASSERT_TRUE(factor.factor(matrix, held));
  const NetVectors b = NetVectors::Random(42, 1);
  const NetVectors x = factor.solve(b);
  const Eigen::MatrixXd block = dense(matrix)(free, free);
  const Eigen::VectorXd exact = block.llt().solve(Eigen::VectorXd(b(free, 0)));
  EXPECT_LT((x(free, 0) - exact).norm(), 1e-12);
  for (Index r = 0; r < 42; r += 5) EXPECT_EQ(x(r, 0), 0);
  EXPECT_NEAR(factor.logDeterminant(), std::log(block.determinant()), 1e-9);
}

TEST(NetCholesky, SaysNoToSingularMatrices) {
  NetMatrix matrix({1, 3}, {0, 1});
  NetCholesky factor({1, 3}, {0, 1});
  EXPECT_FALSE(factor.factor(matrix));
  for (Index r = 0; r < 3; ++r) {  // int f'^2 of a polygon: constants are not seen
    matrix.at(r, 0, 0) = r == 1 ? 2 : 1;
    if (r > 0) matrix.at(r, 0, -1) = -1;
    if (r < 2) matrix.at(r, 0, 1) = -1;
  }
  EXPECT_FALSE(factor.factor(matrix));
  matrix.at(0, 0, 0) += 1e-6;
  EXPECT_TRUE(factor.factor(matrix));
}

}  // namespace
}  // namespace strak
