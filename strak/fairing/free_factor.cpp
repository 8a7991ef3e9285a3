#include "strak/fairing/free_factor.h"

#include <cmath>

namespace strak {

namespace {

// With a unit diagonal, a pivot below this is rounding: the matrix is singular.
constexpr double kSmallestPivot = 1e-12;

// The last index runs fastest.
template <std::size_t D>
std::array<Index, D> indexOf(Index row, const std::array<Index, D>& sizes) {
  std::array<Index, D> index{};
  for (std::size_t k = D; k-- > 0;) {
    index[k] = row % sizes[k];
    row /= sizes[k];
  }
  return index;
}

}  // namespace

template <int D>
FreeFactor::FreeFactor(const EnergyOperator<D>& energy, const std::vector<Index>& free) {
  const auto sizes = energy.sizes();
  Index points = 1;
  for (Index size : sizes) points *= size;
  std::vector<Index> number(static_cast<std::size_t>(points), -1);
  for (std::size_t i = 0; i < free.size(); ++i) number[static_cast<std::size_t>(free[i])] = static_cast<Index>(i);

  std::vector<Eigen::Triplet<double, Index>> lower;
  for (std::size_t i = 0; i < free.size(); ++i) {
    const auto stencil = energy.row(indexOf(free[i], sizes));
    for (std::size_t s = 0; s < stencil.values.size(); ++s) {
      const auto place = indexOf(static_cast<Index>(s), stencil.count);
      Index other = 0;
      for (std::size_t k = 0; k < D; ++k) other = other * sizes[k] + stencil.first[k] + place[k];
      const Index column = number[static_cast<std::size_t>(other)];
      if (column >= 0 && column <= static_cast<Index>(i)) {
        lower.emplace_back(static_cast<Index>(i), column, stencil.values[s]);
      }
    }
  }
  const auto count = static_cast<Index>(free.size());
  root_ = Eigen::VectorXd::Zero(count);
  for (const auto& entry : lower) {
    if (entry.row() != entry.col()) continue;
    if (!(entry.value() > 0)) return;
    root_[entry.row()] = 1 / std::sqrt(entry.value());
  }
  for (auto& entry : lower) {
    entry = {entry.row(), entry.col(), entry.value() * root_[entry.row()] * root_[entry.col()]};
  }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(lower.begin(), lower.end());
  factor_.compute(matrix);
  usable_ = factor_.info() == Eigen::Success && factor_.vectorD().minCoeff() > kSmallestPivot;
}

Eigen::MatrixXd FreeFactor::solve(const Eigen::MatrixXd& columns) const {
  const Eigen::MatrixXd scaled = root_.asDiagonal() * columns;
  return root_.asDiagonal() * factor_.solve(scaled);
}

template FreeFactor::FreeFactor(const EnergyOperator<1>&, const std::vector<Index>&);
template FreeFactor::FreeFactor(const EnergyOperator<2>&, const std::vector<Index>&);
template FreeFactor::FreeFactor(const EnergyOperator<3>&, const std::vector<Index>&);

}  // namespace strak
