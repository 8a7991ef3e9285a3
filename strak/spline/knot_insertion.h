#pragma once
//
// Knot insertion: the same spline on finer knots.
//
// Source: Cohen, Lyche, Riesenfeld, "Discrete B-splines and subdivision techniques" (the Oslo algorithm). Only convex
// combinations are formed, so nothing is lost in rounding, and control points that do not change keep their bits.

#include <Eigen/SparseCore>

#include "strak/spline/spline.h"

namespace strak {

// `knots` with `newKnots` (in any order, repeated at will) sorted in.
// Throws InvalidInput if a new knot lies outside the domain or a multiplicity would exceed degree + 1; `name` ("u",
// ...) is used in the message.
KnotVector withKnots(const KnotVector& knots, const std::vector<double>& newKnots, const char* name = "u");

// The knots of `fine` that `coarse` has not, ascending, each as often as it is missing.
// Throws InvalidInput if the degrees differ, the domains differ, or `coarse` has a knot more often than `fine`.
std::vector<double> missingKnots(const KnotVector& coarse, const KnotVector& fine);

// The matrix R, fine.size() x coarse.size(), that takes control points on `coarse` to control points of the same spline
// on `fine`: N_i^coarse = sum_j R_ji N_j^fine. Its rows are non-negative and, for clamped knots, sum to 1; at most
// degree + 1 entries a row; structural zeros are not stored.
// Throws InvalidInput like missingKnots. Cost O(fine.size() * degree^2).
Eigen::SparseMatrix<double> refinementMatrix(const KnotVector& coarse, const KnotVector& fine);

// One row of such a matrix: the weights row[0 .. degree] of the coarse control points span - degree, ..., span in the
// fine one that lies between fine knots start = V[j] and V[j + degree + 1], where arguments[0 .. degree - 1] = V[j +
// 1], ... . Returns span; it may lie up to `degree` outside the control points, whose weights are then meaningless.
// Cost O(degree^2).
Index refinementRow(const KnotVector& coarse, double start, const double* arguments, double* row);

// The same spline with more knots in one direction. Throws InvalidInput like withKnots.
// Cost O((degree + 1) * points of the result).
template <int D>
Spline<D> insertKnots(const Spline<D>& spline, int direction, const std::vector<double>& newKnots);

// The same spline on finer knots in all directions. Throws InvalidInput like missingKnots.
template <int D>
Spline<D> refine(const Spline<D>& spline, const typename Spline<D>::Knots& fine);

}  // namespace strak
