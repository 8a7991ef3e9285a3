#pragma once
//
// Degree elevation: the same spline with a higher degree.
//
// Source: Prautzsch, "Degree elevation of B-spline curves" (1984): raised by one, a control point is the mean of
// degree + 1 control points that knot insertion gives. Convex combinations only.

#include <Eigen/SparseCore>

#include "strak/spline/spline.h"

namespace strak {

// The knots of degree + 1 on which splines on `knots` are represented: every knot once more, so that continuity stays;
// of knots outside the domain only those that are needed.
KnotVector elevatedKnots(const KnotVector& knots);

// The matrix from control points on `knots` to those on elevatedKnots(knots). Rows non-negative, with sum 1.
// Cost O(size degree^3).
Eigen::SparseMatrix<double> elevationMatrix(const KnotVector& knots);

// The same spline with its degree in `direction` raised by `steps`. Throws InvalidInput if steps is negative.
template <int D>
Spline<D> elevateDegree(const Spline<D>& spline, int direction, int steps = 1);

}  // namespace strak
