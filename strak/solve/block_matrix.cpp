#include "strak/solve/block_matrix.h"

#include <algorithm>

namespace strak {

using Eigen::Index;

Index BlockPattern::place(int i, int j) const {
  const auto from = rows.begin() + start[static_cast<std::size_t>(j)];
  const auto to = rows.begin() + start[static_cast<std::size_t>(j) + 1];
  return std::lower_bound(from, to, i) - rows.begin();
}

BlockPattern patternOfCliques(Index size, const std::vector<std::vector<int>>& cliques) {
  std::vector<std::vector<int>> columns(static_cast<std::size_t>(size));
  for (std::size_t j = 0; j < columns.size(); ++j) columns[j].push_back(static_cast<int>(j));
  const auto tidy = [](std::vector<int>& column) {
    std::sort(column.begin(), column.end());
    column.erase(std::unique(column.begin(), column.end()), column.end());
  };
  for (const auto& clique : cliques) {
    for (int j : clique) {
      if (j < 0) continue;
      auto& column = columns[static_cast<std::size_t>(j)];
      // Neighbouring cells repeat nearly all pairs: tidied before the vector would grow.
      if (column.size() + clique.size() > column.capacity()) tidy(column);
      for (int i : clique) {
        if (i > j) column.push_back(i);
      }
    }
  }
  BlockPattern pattern;
  pattern.start.push_back(0);
  for (auto& column : columns) {
    tidy(column);
    pattern.rows.insert(pattern.rows.end(), column.begin(), column.end());
    pattern.start.push_back(static_cast<Index>(pattern.rows.size()));
    std::vector<int>().swap(column);
  }
  return pattern;
}

Eigen::VectorXd BlockMatrix::times(const Eigen::VectorXd& x) const {
  using Block = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
  Eigen::VectorXd y = Eigen::VectorXd::Zero(x.size());
  for (Index j = 0; j < size(); ++j) {
    const Eigen::Vector3d xj = x.segment<3>(3 * j);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (Index k = pattern_->start[static_cast<std::size_t>(j)]; k < pattern_->start[static_cast<std::size_t>(j) + 1];
         ++k) {
      const Index i = pattern_->rows[static_cast<std::size_t>(k)];
      const Block block(at(k));
      y.segment<3>(3 * i) += block * xj;
      if (i != j) sum += block.transpose() * x.segment<3>(3 * i);
    }
    y.segment<3>(3 * j) += sum;
  }
  return y;
}

Eigen::VectorXd BlockMatrix::pointDiagonal() const {
  Eigen::VectorXd d(size());
  for (Index j = 0; j < size(); ++j) {
    const double* block = at(pattern_->start[static_cast<std::size_t>(j)]);
    d[j] = (block[0] + block[4] + block[8]) / 3;
  }
  return d;
}

void BlockMatrix::addDiagonal(const Eigen::VectorXd& d) {
  for (Index j = 0; j < size(); ++j) {
    double* block = at(pattern_->start[static_cast<std::size_t>(j)]);
    for (int c : {0, 4, 8}) block[c] += d[j];
  }
}

}  // namespace strak
