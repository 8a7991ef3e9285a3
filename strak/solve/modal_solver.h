#pragma once
//
// Solves with Kronecker sums that are (nearly) diagonal in the eigenbasis of all directions but the longest: fast
// diagonalisation along the short directions, banded factors along the long one.

#include <Eigen/Core>
#include <array>

#include "strak/solve/kronecker_operator.h"

namespace strak {

// Eigenvectors S of the pencils A s = lambda M s of the short axes of a layout, S^T M S = I.
struct ModalBasis {
  using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  // forward[axis] = S with its columns padded to a multiple of 8, backward[axis] = S^T likewise; axis 0 (planes)
  // unused.
  std::array<RowMatrix, 3> forward, backward;

  // `stiffness` and `mass` per direction of the box; mass must be positive definite. Cost O(n^3) in the short sizes.
  ModalBasis(const BoxLayout& layout, const std::vector<const BandMatrix*>& stiffness,
             const std::vector<const BandMatrix*>& mass);
};

// For every mode of the short axes, the banded matrix sum_t c_t F_t prod_axis (s^T V_t s) along the long axis,
// factored. Exact where every short factor is A or M of the basis; else the block diagonal of K in that basis, which is
// positive definite whenever K is: a good preconditioner. Memory (p + 1) numbers a point of the box; a solve costs one
// multiplication with S there and back.
class ModalSolver {
 public:
  ModalSolver(const BoxLayout& layout, const std::vector<KroneckerProduct>& products, const ModalBasis& basis);

  // Smallest pivot over its diagonal entry: below about 1e-13 (or negative) the matrix is singular (or indefinite).
  double conditionIndicator() const { return conditionIndicator_; }

  // x = K^-1 b; the fields have the layout; b and x may be the same.
  void solve(const Field& b, Field& x);

 private:
  BoxLayout layout_;
  const ModalBasis& basis_;
  int longAxis_;
  int bandwidth_ = 0;
  double conditionIndicator_ = 1;
  std::vector<double> factors_;  // [slab][d][row of the plane][column]
  Field work_;
};

}  // namespace strak
