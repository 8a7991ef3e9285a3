#pragma once
//
// The derivatives of a rational spline from those of its homogeneous points.

#include <array>
#include <vector>

namespace strak {

// The derivative orders per direction of the rows that evaluation gives: graded, u before v before w.
template <int D>
std::vector<std::array<int, D>> partialOrders(int order);

// X = A / w differentiated by Leibniz' rule: w D^r X = D^r A - sum over 0 < s <= r of binomial(r, s) D^s w D^(r-s) X.
// Source: Piegl, Tiller, "The NURBS Book", (4.8) and (4.20), for any number of directions.
template <int D>
class QuotientRule {
 public:
  // For all derivatives up to total order `order`.
  explicit QuotientRule(int order);

  // `homogeneous` holds a row a derivative, `columns` numbers each, the last the weight; `out` gets columns - 1 numbers
  // a row. The two must not overlap.
  void apply(int columns, const double* homogeneous, double* out) const;

 private:
  struct Term {
    int weight, point;  // rows of D^s w and D^(r-s) X
    double factor;
  };
  std::vector<std::vector<Term>> terms_;  // for each row r
};

extern template class QuotientRule<1>;
extern template class QuotientRule<2>;
extern template class QuotientRule<3>;

}  // namespace strak
