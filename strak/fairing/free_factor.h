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
  // Sum over the columns r (a row a free point) of r^T K^-1 r.
  double inverseNorm(const Eigen::MatrixXd& columns) const {
    return columns.cwiseProduct(factor_.solve(columns)).sum();
  }

 private:
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
  bool usable_ = false;
};

}  // namespace strak
