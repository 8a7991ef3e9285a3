#pragma once
//
// Between polynomial and rational splines.

#include "strak/spline/spline.h"

namespace strak {

// The weight of every control point; ones for a polynomial spline.
template <int D>
Eigen::VectorXd weights(const Spline<D>& spline);

// The rational spline with the same points of space (euclideanNet) and the given weights, one a control point.
// Throws InvalidInput if their number differs or one is not positive.
template <int D>
Spline<D> withWeights(const Spline<D>& spline, const Eigen::Ref<const Eigen::VectorXd>& newWeights);

// The same geometry as a rational spline; weights 1 for a polynomial one, else unchanged.
template <int D>
Spline<D> makeRational(const Spline<D>& spline);

// The same geometry without weights. Throws InvalidInput unless all weights are equal to `relativeTolerance`.
template <int D>
Spline<D> makePolynomial(const Spline<D>& spline, double relativeTolerance = 1e-12);

}  // namespace strak
