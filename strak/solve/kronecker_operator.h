#pragma once
//
// y = K x for a short sum K of Kronecker products of banded matrices, without K.

#include <vector>

#include "strak/solve/band_matrix.h"
#include "strak/solve/field.h"

namespace strak {

// coefficient * (x)_k factors[k] over the directions of a box.
struct KroneckerProduct {
  double coefficient = 1;
  std::vector<const BandMatrix*>
      factors;  // one a direction, all of the box's size; must live while the operator is made
};

// The sum of the products on the points of `layout`. K must be symmetric as a whole where a solver uses it.
// Memory O(sum of sizes), scratch O(p * one plane). Not thread-safe (the scratch is its own); copies are independent.
class KroneckerOperator {
 public:
  KroneckerOperator(const BoxLayout& layout, const std::vector<KroneckerProduct>& products);

  const BoxLayout& layout() const { return layout_; }
  // Both fields have this layout; x and y must differ. Cost O(points * p * products).
  void apply(const Field& x, Field& y);
  // K_rr as a scalar field (layout().scalar()).
  Field diagonal() const;

 private:
  // For one plane: sum over s of rowFactors[s] (x) columnBands[s].
  struct PlaneOperator {
    int planeFactor = 0;                          // index into planeFactors_
    std::vector<std::vector<double>> rowFactors;  // [s][row * (2 p + 1) + d], coefficients included
    std::vector<std::size_t> columnBands;         // indices into columnBands_
  };
  void applyPlane(const PlaneOperator& op, const double* x, double* y);

  BoxLayout layout_;
  int rowBandwidth_ = 0, columnBandwidth_ = 0, planeBandwidth_ = 0;
  std::vector<std::vector<double>> columnBands_;  // diagonal by diagonal, each `width` long
  std::vector<BandMatrix> planeFactors_;
  std::vector<PlaneOperator> planes_;
  std::vector<double> ring_, planeRing_;
  std::vector<double> factors_;
  std::vector<const double*> rows_;
};

}  // namespace strak
