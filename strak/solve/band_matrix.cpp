#include "strak/solve/band_matrix.h"

#include <algorithm>

namespace strak {

using Eigen::Index;

BandMatrix BandMatrix::block(Index first, Index count) const {
  BandMatrix result(count, bandwidth);
  for (Index i = 0; i < count; ++i) {
    for (Index j = std::max<Index>(0, i - bandwidth); j <= std::min(count - 1, i + bandwidth); ++j) {
      result.at(i, j) = (*this)(first + i, first + j);
    }
  }
  return result;
}

Eigen::MatrixXd BandMatrix::dense() const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(size, size);
  for (Index i = 0; i < size; ++i) {
    for (Index j = std::max<Index>(0, i - bandwidth); j <= std::min(size - 1, i + bandwidth); ++j) {
      result(i, j) = (*this)(i, j);
    }
  }
  return result;
}

}  // namespace strak
