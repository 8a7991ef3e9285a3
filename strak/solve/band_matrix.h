#pragma once
//
// Banded square matrices: the 1D factors of every Kronecker sum.

#include <Eigen/Core>

namespace strak {

// A square matrix whose entries (i, j) vanish for |i - j| > bandwidth; row i is stored as its 2 bandwidth + 1
// diagonals, band(i, bandwidth + j - i) = entry (i, j); places outside the matrix hold zero.
struct BandMatrix {
  Eigen::Index size = 0;
  int bandwidth = 0;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> band;

  BandMatrix() = default;
  BandMatrix(Eigen::Index n, int width) : size(n), bandwidth(width), band(decltype(band)::Zero(n, 2 * width + 1)) {}

  double operator()(Eigen::Index i, Eigen::Index j) const {
    return std::abs(i - j) > bandwidth ? 0 : band(i, bandwidth + j - i);
  }
  double& at(Eigen::Index i, Eigen::Index j) { return band(i, bandwidth + j - i); }

  // Rows and columns first, ..., first + count - 1.
  BandMatrix block(Eigen::Index first, Eigen::Index count) const;
  Eigen::MatrixXd dense() const;
};

}  // namespace strak
