#include "strak/solve/tied_points.h"

#include <gtest/gtest.h>

#include <random>

#include "strak/base/error.h"

namespace strak {
namespace {

using Eigen::Index;
using Term = TiedPoints::Term;

// T as a dense matrix, column by column.
Eigen::MatrixXd denseT(const TiedPoints& tied) {
  Eigen::MatrixXd t(3 * tied.points(), 3 * tied.unknowns());
  for (Index k = 0; k < t.cols(); ++k) {
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(t.cols(), k);
    for (int i = 0; i < static_cast<int>(tied.points()); ++i) t.block<3, 1>(3 * i, k) = tied.at(i, unit);
  }
  return t;
}

Eigen::MatrixXd dense(const BlockMatrix& matrix) {
  Eigen::MatrixXd d(3 * matrix.size(), 3 * matrix.size());
  for (Index k = 0; k < d.cols(); ++k) d.col(k) = matrix.times(Eigen::VectorXd::Unit(d.cols(), k));
  return d;
}

// Four unknowns: 0 free, 1 in a plane, 2 on a line, 3 free; points 4 and 5 follow, 6 is a copy of 0.
TiedPoints example() {
  TiedPoints tied(
      4, {{{0, 1}}, {{1, 1}}, {{2, 1}}, {{3, 1}}, {{0, 0.25}, {1, 0.75}}, {{1, 0.5}, {2, 0.3}, {3, 0.2}}, {{0, 1}}});
  tied.confine(1, {1, 2, -0.5});
  tied.confine(2, {0, 3, 0});
  tied.confine(2, {1, 1, 0});
  tied.confine(2, {2, 2, 0});  // nothing new
  return tied;
}

std::vector<std::vector<int>> cliques() { return {{0, 1, 4, 5}, {1, 2, 5, 6}, {3, 5, -1}, {6, 0}}; }

TEST(TiedPoints, ConfinedUnknownsMoveInTheirPlaneOrLine) {
  const TiedPoints tied = example();
  EXPECT_NEAR(tied.projection(1).trace(), 2, 1e-14);
  EXPECT_LT((tied.projection(1) * Eigen::Vector3d(1, 2, -0.5)).norm(), 1e-14);
  EXPECT_LT((tied.projection(2) - Eigen::Matrix3d(Eigen::Vector3d(0, 0, 1).asDiagonal())).norm(), 1e-14);
  const Eigen::VectorXd y = Eigen::VectorXd::LinSpaced(12, -1, 2);
  const Eigen::MatrixXd t = denseT(tied);
  EXPECT_LT((t * tied.confined(y) - t * y).norm(), 1e-14);
  const Eigen::VectorXd g = Eigen::VectorXd::LinSpaced(21, 3, -1);
  EXPECT_LT((tied.reduced(g) - t.transpose() * g).norm(), 1e-13);
  EXPECT_THROW(TiedPoints(2, {{{2, 1}}}), InvalidInput);
}

TEST(TiedPoints, MatricesAndRowsAreThoseOfTheUnknowns) {
  const TiedPoints tied = example();
  const auto full = std::make_shared<const BlockPattern>(patternOfCliques(7, cliques()));
  const auto few = std::make_shared<const BlockPattern>(patternOfCliques(4, tied.reduced(cliques())));
  BlockMatrix a(full), reduced(few);
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int j = 0; j < 7; ++j) {
    for (Index k = full->start[static_cast<std::size_t>(j)]; k < full->start[static_cast<std::size_t>(j) + 1]; ++k) {
      Eigen::Matrix<double, 3, 3, Eigen::RowMajor> block;
      for (int c = 0; c < 9; ++c) block.data()[c] = number(engine);
      if (full->rows[static_cast<std::size_t>(k)] == j) {
        block = (block * block.transpose() + 4 * Eigen::Matrix3d::Identity()).eval();
      }
      std::copy_n(block.data(), 9, a.at(k));
    }
  }
  TiedMatrix(tied, full, *few).add(a, reduced);
  const Eigen::MatrixXd t = denseT(tied), expected = t.transpose() * dense(a) * t, got = dense(reduced);
  // What confined unknowns may not do is regular, and coupled with nothing.
  Eigen::MatrixXd p = Eigen::MatrixXd::Identity(12, 12);
  for (int u : {1, 2}) p.block<3, 3>(3 * u, 3 * u) = tied.projection(u);
  EXPECT_LT((p * got * p - expected).norm(), 1e-12);
  const Eigen::MatrixXd rest = got - expected, q = Eigen::MatrixXd::Identity(12, 12) - p;
  EXPECT_LT((q * rest * q - rest).norm(), 1e-12);
  EXPECT_GT((q * rest * q).diagonal().sum(), 1);

  BallRows rows;
  rows.point = {0, 4, 5, 6, 2};
  rows.weight = {1, 2, -1, 0.5, 3};
  rows.start = {0, 3, 5};
  rows.radius = {1, 2};
  const BallRows less = tied.reduced(rows);
  EXPECT_EQ(less.radius, rows.radius);
  const Eigen::VectorXd y = tied.confined(Eigen::VectorXd::LinSpaced(12, -1, 2));
  EXPECT_LT((less.times(y) - rows.times(t * y)).norm(), 1e-14);
}

}  // namespace
}  // namespace strak
