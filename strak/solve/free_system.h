#pragma once
//
// A ball problem's free points as an ordinary sparse system, for the methods that factor it.

#include <Eigen/SparseCholesky>
#include <vector>

#include "strak/solve/ball_minimizer.h"

namespace strak {

// K on the free points, numbered in the order of the layout, with the linear term; a row a point.
struct FreeSystem {
  using Points = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  std::vector<Eigen::Index> number;  // of point row * columns + column of the box, or -1
  Eigen::Index count = 0;
  Eigen::SparseMatrix<double> matrix;  // lower triangle
  Points linear;

  // Memory 12 N (2p + 1)^D / 2 bytes.
  explicit FreeSystem(const BallProblem& problem);

  Points toPoints(const BoxLayout& layout, const Field& field) const;
  void toField(const BoxLayout& layout, const Points& values, Field& field) const;
  Points times(const Points& x) const { return matrix.selfadjointView<Eigen::Lower>() * x; }
};

// Sparse Cholesky factors of K + a diagonal; the pattern is analysed once.
class ShiftedFactor {
 public:
  explicit ShiftedFactor(const Eigen::SparseMatrix<double>& matrix);
  // False if the sum is not positive definite in double precision.
  bool factor(const Eigen::VectorXd& shift);
  FreeSystem::Points solve(const FreeSystem::Points& b) const { return solver_.solve(b); }

 private:
  const Eigen::SparseMatrix<double>& matrix_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower> solver_;
};

// A proven lower bound of min q under |e_r| <= radius from any multipliers lambda >= 0: with r = K z + g + Lambda z it
// is q(z) + sum lambda (|z_r|^2 - radius^2) - r . (K + Lambda)^-1 r. -infinity if K + Lambda is not positive definite.
// `factor` is left factored with the shift lambda.
double dualValue(const FreeSystem& system, double radius, const Eigen::VectorXd& lambda, const FreeSystem::Points& z,
                 ShiftedFactor& factor);

}  // namespace strak
