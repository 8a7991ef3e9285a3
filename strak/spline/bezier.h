#pragma once
//
// Bezier extraction: the polynomial pieces of a spline by their Bernstein coefficients.

#include "strak/spline/spline.h"

namespace strak {

// The same domain and breaks with clamped ends and every inner knot of multiplicity `degree`, or degree + 1 where it
// already has that.
KnotVector bezierKnots(const KnotVector& knots);

// The same spline on bezierKnots in every direction. Its piece over the spans i_k = knots(k).spans()[s_k] has the
// Bezier points (i_k - p_k, ..., i_k): a box of the net; neighbours share their border points. Only convex combinations
// are formed. Cost O(points of the result * sum of (p_k + 1)).
template <int D>
Spline<D> bezierForm(const Spline<D>& spline);

// One Bezier piece as a net of its own with the box of the domain that it covers.
template <int D>
struct BezierPiece {
  std::array<double, D> from, to;
  Net points;  // (p_k + 1) points in direction k, the last direction fastest; homogeneous if the spline is rational
};

// All pieces, the last direction fastest.
template <int D>
std::vector<BezierPiece<D>> bezierPieces(const Spline<D>& spline);

}  // namespace strak
