#pragma once
//
// Points and derivatives of splines: at one parameter, at many, and on grids.
//
// Derivatives up to total order 3 are written in graded order, u first:
//   curve X, X', X'', X''';  surface X, X_u, X_v, X_uu, X_uv, X_vv, X_uuu, X_uuv, X_uvv, X_vvv;
//   volume X, X_u, X_v, X_w, X_uu, X_uv, X_uw, X_vv, X_vw, X_ww, ... (lexicographic with u before v before w).
// Parameters outside the domain continue the first or last polynomial piece. Rational splines give the point of space
// and its derivatives (quotient rule). On an inner knot the piece to the right is taken.

#include "strak/spline/spline.h"

namespace strak {

// Number of partial derivatives of total order <= `order` in D variables: D = 2, order 2: 6.
constexpr int derivativeCount(int directions, int order) {
  return directions == 1   ? order + 1
         : directions == 2 ? (order + 1) * (order + 2) / 2
                           : (order + 1) * (order + 2) * (order + 3) / 6;
}

// The point X(u). Cost O((p + 1)^D).
template <int D>
Point evaluate(const Spline<D>& spline, const typename Spline<D>::Parameter& u);

// All derivatives up to total order `order` in [0, 3]: derivativeCount rows, a column a coordinate.
// Throws InvalidInput for another order.
template <int D>
Net derivatives(const Spline<D>& spline, const typename Spline<D>::Parameter& u, int order);

// The same at many parameters (a row of `parameters` each, D columns). Row r of the result holds the derivatives at
// parameter r one after another: derivativeCount * pointDimension numbers. Multi-threaded; the result does not depend
// on the number of threads.
template <int D>
Net derivativesAt(const Spline<D>& spline, const Eigen::Ref<const Net>& parameters, int order);

// The same on the grid of all combinations of the parameters given per direction, last direction fastest.
template <int D>
Net derivativesOnGrid(const Spline<D>& spline, const typename Spline<D>::Grid& parameters, int order);

}  // namespace strak
