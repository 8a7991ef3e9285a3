#include "strak/spline/quotient_rule.h"

#include <algorithm>

namespace strak {

template <int D>
std::vector<std::array<int, D>> partialOrders(int order) {
  std::vector<std::array<int, D>> result;
  for (int total = 0; total <= order; ++total) {
    for (int a = total; a >= 0; --a) {
      if constexpr (D == 1) {
        if (a == total) result.push_back({a});
      } else if constexpr (D == 2) {
        result.push_back({a, total - a});
      } else {
        for (int b = total - a; b >= 0; --b) result.push_back({a, b, total - a - b});
      }
    }
  }
  return result;
}

template <int D>
QuotientRule<D>::QuotientRule(int order) {
  const auto orders = partialOrders<D>(order);
  for (const auto& whole : orders) {
    std::vector<Term> terms;
    for (std::size_t s = 1; s < orders.size(); ++s) {
      double factor = 1;
      auto rest = whole;
      for (std::size_t k = 0; k < D && factor != 0; ++k) {
        rest[k] -= orders[s][k];
        if (rest[k] < 0) factor = 0;
        for (int i = 1; i <= orders[s][k]; ++i) factor = factor * (rest[k] + i) / i;  // binomial(whole, s)
      }
      if (factor == 0) continue;
      const auto point = std::find(orders.begin(), orders.end(), rest) - orders.begin();
      terms.push_back({static_cast<int>(s), static_cast<int>(point), factor});
    }
    terms_.push_back(std::move(terms));
  }
}

template <int D>
void QuotientRule<D>::apply(int columns, const double* homogeneous, double* out) const {
  const int dimension = columns - 1;
  const double inverse = 1 / homogeneous[dimension];
  for (std::size_t r = 0; r < terms_.size(); ++r) {
    const double* from = homogeneous + static_cast<std::ptrdiff_t>(r) * columns;
    double* to = out + static_cast<std::ptrdiff_t>(r) * dimension;
    std::copy(from, from + dimension, to);
    for (const Term& term : terms_[r]) {
      const double weight = term.factor * homogeneous[term.weight * columns + dimension];
      const double* point = out + term.point * dimension;
      for (int c = 0; c < dimension; ++c) to[c] -= weight * point[c];
    }
    for (int c = 0; c < dimension; ++c) to[c] *= inverse;
  }
}

template std::vector<std::array<int, 1>> partialOrders<1>(int);
template std::vector<std::array<int, 2>> partialOrders<2>(int);
template std::vector<std::array<int, 3>> partialOrders<3>(int);
template class QuotientRule<1>;
template class QuotientRule<2>;
template class QuotientRule<3>;

}  // namespace strak
