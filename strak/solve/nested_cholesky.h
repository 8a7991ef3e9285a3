#pragma once
//
// Sparse Cholesky factorisation of block matrices whose points lie on a surface or along a curve: nested dissection by
// place, dense fronts.
//
// Source: George, "Nested dissection of a regular finite element mesh" (1973); Duff and Reid, "The multifrontal
// solution of indefinite sparse symmetric linear equations" (1983). Why not the library's: its factor of one column at
// a time takes 305 ms where this takes 15 (6348 unknowns of a 52 x 52 net, bench/bench_exact_fairing.cpp), and one
// fairing needs a hundred of them.

#include <memory>

#include "strak/solve/block_matrix.h"

namespace strak {

class NestedCholesky {
 public:
  // `places`: a row a point of the pattern, where it lies in space, in the net or along a curve; only the quality of
  // the elimination order depends on it. Cost O(blocks log size).
  NestedCholesky(std::shared_ptr<const BlockPattern> pattern, const Eigen::Ref<const Eigen::MatrixX3d>& places);
  ~NestedCholesky();
  NestedCholesky(NestedCholesky&&) noexcept;
  NestedCholesky& operator=(NestedCholesky&&) noexcept;

  // Factors the matrix, which must have the pattern given above. Returns false if it is not positive definite (to
  // rounding). For n x n nets O(n^3) operations and O(n^2 log n) memory, along a curve both O(n). Multi-threaded; the
  // result does not depend on the number of threads.
  bool factor(const BlockMatrix& matrix);

  // A^-1 b, after factor() returned true.
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;

  // The diagonal of the factor L in the order of the unknowns, after factor() returned true: log det A is twice the sum
  // of its logarithms.
  Eigen::VectorXd factorDiagonal() const;

  // Numbers in the factor.
  Eigen::Index factorSize() const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace strak
