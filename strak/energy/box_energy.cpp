#include "strak/energy/box_energy.h"

#include <algorithm>
#include <utility>

namespace strak {

template <int D>
BoxEnergy<D>::BoxEnergy(const EnergyOperator<D>& op, const IndexBox& box) {
  // Factor by factor: the block on the box, and for N^(a) N^(b) with a + b = 2 c the sign with which it equals
  // N^(c) N^(c): integration by parts, exact where the box's functions vanish to sufficient order at the ends. That
  // turns the cross terms of (16) and of the Laplacian into squares.
  struct Factor {
    const BandMatrix* matrix;
    int order;  // c, or -1 for a factor that is no square
    double sign;
  };
  std::array<std::vector<Factor>, D> factors;
  for (std::size_t k = 0; k < D; ++k) {
    const auto& orders = op.factorOrders(static_cast<int>(k));
    const auto& all = op.factors(static_cast<int>(k));
    for (std::size_t i = 0; i < all.size(); ++i) {
      matrices_.push_back(all[i].block(box.first[k], box.count[k]));
      factors[k].push_back({&matrices_.back(), orders[i].first == orders[i].second ? orders[i].first : -1, 1});
    }
    for (std::size_t i = 0; i < all.size(); ++i) {
      const int total = orders[i].first + orders[i].second;
      if (factors[k][i].order >= 0 || total % 2 != 0) continue;
      const double sign = (orders[i].first - total / 2) % 2 == 0 ? 1 : -1;
      for (std::size_t j = 0; j < all.size(); ++j) {
        if (orders[j] != std::pair(total / 2, total / 2)) continue;
        const double difference =
            (factors[k][i].matrix->band - sign * factors[k][j].matrix->band).cwiseAbs().maxCoeff();
        if (difference <= 1e-12 * factors[k][j].matrix->band.cwiseAbs().maxCoeff()) {
          factors[k][i] = {factors[k][j].matrix, total / 2, sign};
        }
      }
    }
  }
  std::array<BandMatrix, D> pure;
  bool squares = true;
  for (const auto& term : op.terms()) {
    KroneckerProduct product{term.coefficient, {}};
    int directions = 0;
    std::size_t along = 0;
    for (std::size_t k = 0; k < D; ++k) {
      const Factor& factor = factors[k][static_cast<std::size_t>(term.factor[k])];
      product.coefficient *= factor.sign;
      product.factors.push_back(factor.matrix);
      if (factor.order != 0) {
        ++directions;
        along = k;
      }
      squares = squares && factor.order >= 0;
    }
    squares = squares && product.coefficient >= 0;
    if (directions == 1) {
      BandMatrix& sum = pure[along];
      const BandMatrix& matrix = *product.factors[along];
      if (sum.size == 0) sum = BandMatrix(matrix.size, matrix.bandwidth);
      sum.band += product.coefficient * matrix.band;
    }
    products_.push_back(std::move(product));
  }
  mass_.coefficient = 1;
  for (std::size_t k = 0; k < D; ++k) {
    mass_.factors.push_back(factors[k].front().matrix);  // EnergyOperator puts the mass matrix first
  }
  for (std::size_t k = 0; k < D; ++k) {
    const bool hasPure = pure[k].size > 0;
    const auto highest = std::max_element(factors[k].begin(), factors[k].end(),
                                          [](const Factor& a, const Factor& b) { return a.order < b.order; });
    matrices_.push_back(hasPure ? pure[k] : *highest->matrix);
    stiffness_.push_back(&matrices_.back());
    if (!hasPure || !squares) continue;
    KroneckerProduct product = mass_;
    product.factors[k] = stiffness_.back();
    lowerBound_.push_back(std::move(product));
  }
}

template class BoxEnergy<1>;
template class BoxEnergy<2>;
template class BoxEnergy<3>;

}  // namespace strak
