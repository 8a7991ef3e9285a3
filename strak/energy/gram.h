#pragma once
//
// Gram matrices of B-spline bases, the 1D factors of every quadratic energy.

#include "strak/solve/band_matrix.h"
#include "strak/spline/knot_vector.h"

namespace strak {

// G(i, j) = integral over the domain of N_i^(a) N_j^(b), exact up to rounding (Gauss quadrature per span).
// Bandwidth = degree. Cost O(n p^3).
BandMatrix gramMatrix(const KnotVector& knots, int a, int b);

}  // namespace strak
