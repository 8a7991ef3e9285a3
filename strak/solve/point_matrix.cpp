#include "strak/solve/point_matrix.h"

#include <algorithm>

namespace strak {

PointMatrix::PointMatrix(Index points, int dimension, const std::vector<std::vector<Index>>& cliques)
    : dimension_(dimension), neighbours_(static_cast<std::size_t>(points)) {
  for (Index i = 0; i < points; ++i) neighbours_[static_cast<std::size_t>(i)].push_back(i);
  for (const auto& clique : cliques) {
    for (const Index j : clique) {
      auto& list = neighbours_[static_cast<std::size_t>(j)];
      std::copy_if(clique.begin(), clique.end(), std::back_inserter(list), [j](Index i) { return i > j; });
    }
  }
  Index count = 0;
  for (auto& list : neighbours_) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    count += static_cast<Index>(list.size()) * dimension * dimension;
  }
  lower_.resize(points * dimension, points * dimension);
  lower_.reserve(count);
  for (Index j = 0; j < points; ++j) {
    for (int b = 0; b < dimension; ++b) {
      lower_.startVec(j * dimension + b);
      for (const Index i : neighbours_[static_cast<std::size_t>(j)]) {
        for (int a = i == j ? b : 0; a < dimension; ++a) {
          lower_.insertBack(i * dimension + a, j * dimension + b) = 0;
        }
      }
    }
  }
  lower_.finalize();
}

void PointMatrix::setZero() { std::fill(lower_.valuePtr(), lower_.valuePtr() + lower_.nonZeros(), 0.0); }

void PointMatrix::add(Index i, Index j, const Eigen::Ref<const Eigen::MatrixXd>& block) {
  const bool turned = i < j;
  if (turned) std::swap(i, j);
  const auto& list = neighbours_[static_cast<std::size_t>(j)];
  const Index place = std::lower_bound(list.begin(), list.end(), i) - list.begin();
  for (int b = 0; b < dimension_; ++b) {
    // A column holds the rest of the diagonal block from row b on, then the other blocks.
    double* column = lower_.valuePtr() + lower_.outerIndexPtr()[j * dimension_ + b] + place * dimension_ - b;
    for (int a = place == 0 ? b : 0; a < dimension_; ++a) column[a] += turned ? block(b, a) : block(a, b);
  }
}

Eigen::VectorXd PointMatrix::meanDiagonal() const {
  const Eigen::VectorXd diagonal = lower_.diagonal();
  return Eigen::Map<const Eigen::MatrixXd>(diagonal.data(), dimension_, points()).colwise().mean().transpose();
}

void PointMatrix::addToDiagonal(const Eigen::VectorXd& amount) {
  for (Index j = 0; j < points(); ++j) {
    for (int b = 0; b < dimension_; ++b) {
      lower_.valuePtr()[lower_.outerIndexPtr()[j * dimension_ + b]] += amount[j];
    }
  }
}

}  // namespace strak
