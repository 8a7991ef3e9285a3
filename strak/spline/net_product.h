#pragma once
//
// Linear maps that act on one direction of a control net.

#include <Eigen/SparseCore>

#include "strak/spline/spline.h"

namespace strak {

// The net with `matrix` applied along `direction`: every line of control points in that direction, a column vector of
// sizes[direction] points, is replaced by matrix * line. The result has matrix.rows() points there.
// Throws InvalidInput if the sizes do not fit. Cost: the matrix's non-zeros times the points of the other directions.
template <int D>
Net multiplyAlong(const Eigen::SparseMatrix<double>& matrix, const Eigen::Ref<const Net>& net,
                  const typename Spline<D>::Sizes& sizes, int direction);

}  // namespace strak
