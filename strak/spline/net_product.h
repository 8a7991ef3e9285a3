#pragma once
//
// Maps that act on one direction of a control net, line by line, and parts of a net.

#include <Eigen/SparseCore>

#include "strak/spline/spline.h"

namespace strak {

// Replaces every bundle of lines of control points in `direction`. `map` gets matrices of sizes[direction] rows, whose
// columns are the coordinates of all neighbouring lines, and returns matrices of `newSize` rows with the same columns.
template <int D, class Map>
Net mapLines(const Net& net, const typename Spline<D>::Sizes& sizes, int direction, Index newSize, const Map& map) {
  // The net is row-major: what lies behind a direction is contiguous, and so is one bundle as a row-major matrix.
  Index outer = 1;
  Index behind = 1;
  for (int k = 0; k < D; ++k) {
    if (k < direction) outer *= sizes[static_cast<std::size_t>(k)];
    if (k > direction) behind *= sizes[static_cast<std::size_t>(k)];
  }
  const Index size = sizes[static_cast<std::size_t>(direction)];
  const Index inner = behind * net.cols();
  Net result(outer * newSize * behind, net.cols());
  for (Index o = 0; o < outer; ++o) {
    const Eigen::Map<const Net> lines(net.data() + o * size * inner, size, inner);
    Eigen::Map<Net>(result.data() + o * newSize * inner, newSize, inner) = map(lines);
  }
  return result;
}

// The net with `matrix` applied along `direction`: every line of control points in that direction, a column vector of
// sizes[direction] points, is replaced by matrix * line. The result has matrix.rows() points there.
// Throws InvalidInput if the sizes do not fit. Cost: the matrix's non-zeros times the points of the other directions.
template <int D>
Net multiplyAlong(const Eigen::SparseMatrix<double>& matrix, const Net& net, const typename Spline<D>::Sizes& sizes,
                  int direction);

// The part of the net with indices first .. first + count - 1 in `direction`, which must lie inside it.
template <int D>
Net sliceAlong(const Net& net, const typename Spline<D>::Sizes& sizes, int direction, Index first, Index count);

}  // namespace strak
