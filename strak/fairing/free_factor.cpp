#include "strak/fairing/free_factor.h"

namespace strak {

namespace {

// A pivot below this part of the largest is rounding: the matrix is singular.
constexpr double kSmallestPivot = 1e-13;

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
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(lower.begin(), lower.end());
  factor_.compute(matrix);
  if (factor_.info() != Eigen::Success) return;
  const Eigen::VectorXd pivots = factor_.vectorD();
  usable_ = pivots.minCoeff() > kSmallestPivot * pivots.cwiseAbs().maxCoeff();
}

template FreeFactor::FreeFactor(const EnergyOperator<1>&, const std::vector<Index>&);
template FreeFactor::FreeFactor(const EnergyOperator<2>&, const std::vector<Index>&);
template FreeFactor::FreeFactor(const EnergyOperator<3>&, const std::vector<Index>&);

}  // namespace strak
