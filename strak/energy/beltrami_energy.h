#pragma once
//
// The data-dependent energy: how much a surface X bends, measured in the inner geometry of a reference surface,
//   Q4(X) = int |Delta X|^2 dA ,  Delta f = g^ij (f_ij - Gamma^k_ij f_k) ,
// where g, Gamma and dA belong to the reference. A quadratic form of X's control points, the same for all three
// coordinates. At the reference itself Delta X = 2 H n, so that Q4 is the integral of 4 H^2; unlike the energies in the
// parameters it depends neither on the scale of the knots nor on the parametrization.
//
// Source: Greiner, "Variational design and fairing of spline surfaces" (1994); Hoschek and Juettler (5.3), who print
// the square of the gradient. That is of first order and at the reference just twice the area; meant is Beltrami's
// operator.
//
// With free borders, as of fits, harmonic waves along them would cost nothing. The same with all second derivatives,
//   int |Hess X|^2 dA ,  Hess f = f_ij - Gamma^k_ij f_k ,
// does not forget them: at the reference it is the integral of k1^2 + k2^2, which differs from 4 H^2 by what the
// borders alone decide (the errata on (5.1)).

#include <Eigen/SparseCore>
#include <vector>

#include "strak/solve/block_matrix.h"
#include "strak/spline/spline.h"

namespace strak {

// |Delta X|^2, or |Hess X|^2.
enum class InnerBending { beltrami, hessian };

class BeltramiEnergy {
 public:
  // Of surfaces that have the knots and the weights of `reference`. `unknownOf`: for every control point the number of
  // its unknown point, or -1 if it is held; knot cells that no free point moves do not count. `nodes` Gauss nodes a
  // span and direction, 0: degree + 1. Where the reference has no regular parameters (a collapsed edge, a fold) lengths
  // count as a thousandth of the mean at least: large numbers, but no infinite ones. Cost: (p + 1)^6 operations a cell.
  // Multi-threaded, results independent of threads. Throws InvalidInput unless the reference lies in space, or if it is
  // a curve or a point everywhere.
  BeltramiEnergy(const Surface& reference, std::vector<int> unknownOf, int nodes = 0,
                 InnerBending bending = InnerBending::beltrami);

  // K, by control points, free or not: Q4(X) = sum of the three coordinates' x^T K x. Symmetric, positive semidefinite;
  // the coordinates' constants cost nothing. 1 / length^2.
  const Eigen::SparseMatrix<double, Eigen::RowMajor>& matrix() const { return matrix_; }

  // Q4; no unit. `points`: the net in space (euclideanNet).
  double value(const Net& points) const;

  // Adds weight times Q4's second derivatives by the unknowns, and its gradient. The pattern must couple the unknowns
  // of every knot cell, as the cliques of ShapeEnergy do.
  void addTo(const Net& points, double weight, BlockMatrix& matrix, Eigen::VectorXd& gradient) const;

 private:
  std::vector<int> unknownOf_;
  Eigen::SparseMatrix<double, Eigen::RowMajor> matrix_;
};

}  // namespace strak
