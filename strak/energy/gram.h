#pragma once
//
// Gram matrices of B-spline bases and banded matrices, the factors of every quadratic energy.

#include <Eigen/Core>

#include "strak/spline/knot_vector.h"

namespace strak {

// A square matrix whose entries (i, j) vanish for |i - j| > bandwidth; row i is stored as its 2 bandwidth + 1 diagonals,
// band(i, bandwidth + j - i) = entry (i, j); places outside the matrix hold zero.
struct BandMatrix {
  Index size = 0;
  int bandwidth = 0;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> band;

  BandMatrix() = default;
  BandMatrix(Index n, int width) : size(n), bandwidth(width), band(decltype(band)::Zero(n, 2 * width + 1)) {}

  double operator()(Index i, Index j) const {
    return std::abs(i - j) > bandwidth ? 0 : band(i, bandwidth + j - i);
  }
  double& at(Index i, Index j) { return band(i, bandwidth + j - i); }
  BandMatrix transposed() const;
  // Rows and columns first, ..., first + count - 1.
  BandMatrix block(Index first, Index count) const;
  Eigen::MatrixXd dense() const;
};

// G(i, j) = integral over the domain of N_i^(a) N_j^(b), exact up to rounding (Gauss quadrature per span).
// Bandwidth = degree. Cost O(n p^3).
BandMatrix gramMatrix(const KnotVector& knots, int a, int b);

}  // namespace strak
