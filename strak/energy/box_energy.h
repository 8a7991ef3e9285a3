#pragma once
//
// A quadratic energy restricted to a box of control points, in the form the solvers take, with what is provable of it.

#include <deque>
#include <vector>

#include "strak/energy/energy_operator.h"
#include "strak/solve/kronecker_operator.h"

namespace strak {

// Control points first[k] .. first[k] + count[k] - 1 of every direction k.
struct IndexBox {
  std::vector<Index> first, count;
};

// K on the box as Kronecker products. Made once and not copied, because the products point into its matrices.
template <int D>
class BoxEnergy {
 public:
  // Cross terms are turned into squares by partial integration wherever that is exact on the box, that is where its
  // functions vanish to sufficient order at the ends (the Laplacian with 1, (16) with 2 clamped rows held).
  BoxEnergy(const EnergyOperator<D>& op, const IndexBox& box);
  BoxEnergy(const BoxEnergy&) = delete;
  BoxEnergy& operator=(const BoxEnergy&) = delete;

  const std::vector<KroneckerProduct>& products() const { return products_; }
  // P <= K: the terms with derivatives in one direction only, one product a direction; the others are squares and can
  // only add. Diagonal in the eigenbases of stiffness against mass. Empty where cross terms remain.
  const std::vector<KroneckerProduct>& lowerBound() const { return lowerBound_; }
  // The mass matrices of all directions.
  const KroneckerProduct& mass() const { return mass_; }
  // A stiffness matrix a direction: the sum of its pure terms, or the highest derivative's where there is none.
  const std::vector<const BandMatrix*>& stiffness() const { return stiffness_; }

 private:
  std::deque<BandMatrix> matrices_;  // a deque, so that they never move
  std::vector<KroneckerProduct> products_, lowerBound_;
  KroneckerProduct mass_;
  std::vector<const BandMatrix*> stiffness_;
};

}  // namespace strak
