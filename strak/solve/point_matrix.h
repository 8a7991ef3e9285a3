#pragma once
//
// Symmetric sparse matrices over points: a small dense block for every pair of points that know each other.

#include <Eigen/SparseCore>
#include <vector>

namespace strak {

// A matrix of points() x points() blocks of dimension() x dimension() numbers with a pattern that is fixed at the
// start. The unknown (point i, coordinate a) is number i * dimension + a.
class PointMatrix {
 public:
  using Index = Eigen::Index;

  PointMatrix() = default;
  // The pattern holds all pairs within each clique. Cost O(sum of squared clique sizes).
  PointMatrix(Index points, int dimension, const std::vector<std::vector<Index>>& cliques);

  Index points() const { return static_cast<Index>(neighbours_.size()); }
  int dimension() const { return dimension_; }

  void setZero();

  // Adds `block` at (i, j) and, for i != j, its transpose at (j, i); of a block on the diagonal, which must be
  // symmetric, once. The pair must be in the pattern.
  void add(Index i, Index j, const Eigen::Ref<const Eigen::MatrixXd>& block);

  // The lower triangle, for Eigen's sparse Cholesky; product() uses both.
  const Eigen::SparseMatrix<double>& lower() const { return lower_; }
  Eigen::VectorXd product(const Eigen::VectorXd& x) const { return lower_.selfadjointView<Eigen::Lower>() * x; }

  // The mean of each point's diagonal entries.
  Eigen::VectorXd meanDiagonal() const;
  // Adds amount[i] to all diagonal entries of point i.
  void addToDiagonal(const Eigen::VectorXd& amount);

 private:
  int dimension_ = 1;
  std::vector<std::vector<Index>> neighbours_;  // of point j: itself and the larger ones, ascending
  Eigen::SparseMatrix<double> lower_;
};

}  // namespace strak
