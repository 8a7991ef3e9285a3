#include "strak/spline/evaluate.h"

#include <fmt/format.h>

#include <algorithm>

#include "strak/base/error.h"
#include "strak/spline/basis.h"
#include "strak/spline/evaluator.h"
#include "strak/spline/quotient_rule.h"

namespace strak {

namespace {

void checkOrder(int order) {
  if (order < 0 || order > 3) {
    throw InvalidInput(fmt::format("derivatives of order {} are not offered: ask for 0 to 3", order));
  }
}

// Evaluation without preparation: basis functions by recurrence, then one pass over the (p + 1)^D control points.
template <int D>
class OneByOne {
 public:
  OneByOne(const Spline<D>& spline, int order) : spline_(spline), order_(order), orders_(partialOrders<D>(order)) {
    std::size_t total = 0;
    for (int k = 0; k < D; ++k) total += static_cast<std::size_t>((order + 1) * (spline.degree(k) + 1));
    basis_.resize(total);
    if (spline.isRational()) {
      quotient_.emplace_back(order);
      homogeneous_.resize(orders_.size() * static_cast<std::size_t>(spline.net().cols()));
    }
  }

  void derivatives(const std::array<double, D>& u, double* out) {
    std::array<Index, D> first;
    std::array<const double*, D> basis;
    double* memory = basis_.data();
    for (int k = 0; k < D; ++k) {
      const auto d = static_cast<std::size_t>(k);
      const Index span = spline_.knots(k).findSpan(u[d]);
      basisDerivatives(spline_.knots(k), span, u[d], order_, memory);
      first[d] = span - spline_.degree(k);
      basis[d] = memory;
      memory += (order_ + 1) * (spline_.degree(k) + 1);
    }
    if (spline_.isRational()) {
      sum(first, basis, homogeneous_.data());
      quotient_.front().apply(static_cast<int>(spline_.net().cols()), homogeneous_.data(), out);
    } else {
      sum(first, basis, out);
    }
  }

 private:
  void sum(const std::array<Index, D>& first, const std::array<const double*, D>& basis, double* out) const {
    const Index columns = spline_.net().cols();
    const double* points = spline_.net().data();
    std::fill_n(out, static_cast<Index>(orders_.size()) * columns, 0.0);
    std::array<Index, D> at{};
    while (true) {
      Index row = 0;
      for (int k = 0; k < D; ++k) {
        const auto d = static_cast<std::size_t>(k);
        row = row * spline_.size(k) + first[d] + at[d];
      }
      const double* point = points + row * columns;
      double* to = out;
      for (const auto& order : orders_) {
        double weight = 1;
        for (std::size_t k = 0; k < D; ++k) {
          weight *= basis[k][order[k] * (spline_.degree(static_cast<int>(k)) + 1) + at[k]];
        }
        for (Index c = 0; c < columns; ++c) to[c] += weight * point[c];
        to += columns;
      }
      int k = D - 1;
      while (k >= 0 && at[static_cast<std::size_t>(k)] == spline_.degree(k)) at[static_cast<std::size_t>(k--)] = 0;
      if (k < 0) return;
      ++at[static_cast<std::size_t>(k)];
    }
  }

  const Spline<D>& spline_;
  const int order_;
  const std::vector<std::array<int, D>> orders_;
  std::vector<double> basis_, homogeneous_;
  std::vector<QuotientRule<D>> quotient_;
};

}  // namespace

template <int D>
Net derivatives(const Spline<D>& spline, const typename Spline<D>::Parameter& u, int order) {
  checkOrder(order);
  Net result(derivativeCount(D, order), spline.pointDimension());
  OneByOne<D>(spline, order).derivatives(u, result.data());
  return result;
}

template <int D>
Point evaluate(const Spline<D>& spline, const typename Spline<D>::Parameter& u) {
  return derivatives<D>(spline, u, 0).row(0);
}

template <int D>
Net derivativesAt(const Spline<D>& spline, const Eigen::Ref<const Net>& parameters, int order) {
  // Few points of a big net are not worth a copy of it.
  if (parameters.cols() != D || parameters.rows() > 16 + spline.net().rows() / 16) {
    return Evaluator<D>(spline).derivativesAt(parameters, order);
  }
  checkOrder(order);
  Net result(parameters.rows(), derivativeCount(D, order) * spline.pointDimension());
  OneByOne<D> evaluation(spline, order);
  for (Index r = 0; r < parameters.rows(); ++r) {
    std::array<double, D> u;
    for (int k = 0; k < D; ++k) u[static_cast<std::size_t>(k)] = parameters(r, k);
    evaluation.derivatives(u, &result(r, 0));
  }
  return result;
}

template <int D>
Net derivativesOnGrid(const Spline<D>& spline, const typename Spline<D>::Grid& parameters, int order) {
  return Evaluator<D>(spline).derivativesOnGrid(parameters, order);
}

#define STRAK_INSTANTIATE(D)                                                          \
  template Point evaluate<D>(const Spline<D>&, const std::array<double, D>&);         \
  template Net derivatives<D>(const Spline<D>&, const std::array<double, D>&, int);   \
  template Net derivativesAt<D>(const Spline<D>&, const Eigen::Ref<const Net>&, int); \
  template Net derivativesOnGrid<D>(const Spline<D>&, const std::array<std::vector<double>, D>&, int);
STRAK_INSTANTIATE(1)
STRAK_INSTANTIATE(2)
STRAK_INSTANTIATE(3)
#undef STRAK_INSTANTIATE

}  // namespace strak
