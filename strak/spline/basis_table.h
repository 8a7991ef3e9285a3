#pragma once
//
// Basis functions prepared for evaluation at many parameters.

#include "strak/spline/evaluate_kernels.h"
#include "strak/spline/knot_vector.h"

namespace strak {

// The basis functions of a knot vector as one polynomial per span about its centre, with a table that finds the span of
// a parameter without search. A plain value, thread-safe.
//
// Above kMaxTableDegree, powers would lose digits; the functions are then evaluated by recurrence.
class BasisTable {
 public:
  static constexpr int kMaxTableDegree = 9;

  explicit BasisTable(KnotVector knots);

  const KnotVector& knots() const { return knots_; }

  // Doubles per derivative order of the weights: degree + 1 rounded up to a multiple of 4.
  int width() const { return width_; }

  // For each of `count` parameters, `stride` doubles apart: first[r], the first of the degree + 1 basis functions of
  // its span, and weights[(r * (order + 1) + k) * width + j], the k-th derivative of function first[r] + j; zero for j
  // > degree. `order` in [0, 3]. Parameters outside the domain continue the first or last polynomial. Allocates nothing
  // for degrees up to 31.
  void weights(const double* parameters, Index stride, Index count, int order, Index* first, double* weights) const;

 private:
  KnotVector knots_;
  int width_ = 4;
  std::vector<double> starts_, centres_, scales_, coefficients_;
  std::vector<Index> first_, buckets_;
  double bucketScale_ = 0;
};

}  // namespace strak
