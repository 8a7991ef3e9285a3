#pragma once
//
// The free control points' block of an energy's matrix, factored: what a tight certificate needs.

#include <Eigen/SparseCholesky>
#include <vector>

#include "strak/energy/energy_operator.h"

namespace strak {

class FreeFactor {
 public:
  // `free`: rows of the net, ascending. Cost and memory as a sparse Cholesky factorisation with minimum degree
  // ordering.
  template <int D>
  FreeFactor(const EnergyOperator<D>& energy, const std::vector<Index>& free);

  // False if the energy leaves a motion of the free points unpunished, to rounding: then nothing can be solved.
  bool usable() const { return usable_; }
  // K^-1 times columns (a row a free point), and the sum over the columns r of r^T K^-1 r.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& columns) const;
  double inverseNorm(const Eigen::MatrixXd& columns) const { return columns.cwiseProduct(solve(columns)).sum(); }

 private:
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
  Eigen::VectorXd root_;  // 1 / sqrt(K_rr): the factor is of the matrix with a unit diagonal
  bool usable_ = false;
};

}  // namespace strak
