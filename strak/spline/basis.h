#pragma once
//
// B-spline basis functions and their derivatives.

#include "strak/spline/knot_vector.h"

namespace strak {

// The values and derivatives up to `order` of the p + 1 basis functions N_{span-p}, ..., N_span at u, where
// `span` is a span of the knots of positive length (KnotVector::findSpan). Writes row-major to out:
// out[k * (p + 1) + j] = k-th derivative of N_{span-p+j}; derivatives above the degree are zero.
// u may lie outside the span: then the polynomial of that span is continued.
// Cost O((p + 1) * (p + order)); allocates nothing for degrees up to 31. Source: de Boor's recurrence; derivatives as
// differences of the basis functions of lower degree.
void basisDerivatives(const KnotVector& knots, Index span, double u, int order, double* out);

// The same as a matrix of (order + 1) x (p + 1).
Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> basisDerivatives(const KnotVector& knots,
                                                                                        Index span, double u,
                                                                                        int order);

// Nodes and weights of the Gauss-Legendre rule with `count` >= 1 points on [-1, 1] (ascending), to full precision.
struct GaussRule {
  std::vector<double> nodes, weights;
};
GaussRule gaussLegendre(int count);

}  // namespace strak
