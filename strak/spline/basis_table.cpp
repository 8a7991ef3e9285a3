#include "strak/spline/basis_table.h"

#include <algorithm>
#include <cmath>

#include "strak/base/cpu.h"
#include "strak/spline/basis.h"

namespace strak {

BasisTable::BasisTable(KnotVector knots) : knots_(std::move(knots)) {
  const int p = knots_.degree();
  width_ = (p + 4) / 4 * 4;
  if (p > kMaxTableDegree) return;

  const auto spans = knots_.spans();
  const auto count = spans.size();
  const auto functions = static_cast<std::size_t>(p) + 1;
  coefficients_.assign(count * functions * static_cast<std::size_t>(width_), 0.0);
  std::vector<double> derivatives(functions * functions);
  double* coefficient = coefficients_.data();
  for (const Index span : spans) {
    const double half = (knots_[span + 1] - knots_[span]) / 2;
    const double centre = knots_[span] + half;
    starts_.push_back(knots_[span]);
    centres_.push_back(centre);
    scales_.push_back(1 / half);
    first_.push_back(span - p);
    basisDerivatives(knots_, span, centre, p, derivatives.data());
    double factor = 1;  // half^k / k!
    for (int k = 0; k <= p; ++k) {
      if (k > 0) factor *= half / k;
      for (int j = 0; j <= p; ++j)
        coefficient[j] = factor * derivatives[static_cast<std::size_t>(k) * functions + static_cast<std::size_t>(j)];
      coefficient += width_;
    }
  }
  starts_.push_back(knots_.to());

  // Four buckets a span. A span is placed by the same arithmetic as a parameter, which is monotone, so a span of an
  // earlier bucket begins before every parameter of a later one, whatever the rounding.
  const auto buckets = static_cast<Index>(4 * count);
  bucketScale_ = static_cast<double>(buckets) / knots_.length();
  buckets_.assign(static_cast<std::size_t>(buckets) + 1, 0);
  std::size_t begun = 0;  // spans of earlier buckets
  for (Index b = 0; b <= buckets; ++b) {
    while (begun < count && std::min((starts_[begun] - knots_.from()) * bucketScale_,
                                     static_cast<double>(buckets - 1)) < static_cast<double>(b)) {
      ++begun;
    }
    buckets_[static_cast<std::size_t>(b)] = begun == 0 ? 0 : static_cast<Index>(begun) - 1;
  }
}

void BasisTable::weights(const double* parameters, Index stride, Index count, int order, Index* first,
                         double* weights) const {
  const int p = knots_.degree();
  if (p <= kMaxTableDegree) {
    const BasisView view{p,
                         width_,
                         starts_.data(),
                         first_.data(),
                         centres_.data(),
                         scales_.data(),
                         coefficients_.data(),
                         knots_.from(),
                         bucketScale_,
                         static_cast<Index>(buckets_.size()) - 1,
                         buckets_.data()};
    STRAK_SIMD_CHOOSE(basisWeights)(view, parameters, stride, count, order, first, weights);
    return;
  }
  const Index functions = p + 1;
  const Index width = width_;
  for (Index r = 0; r < count; ++r) {
    const double u = parameters[r * stride];
    const Index span = knots_.findSpan(u);
    first[r] = span - p;
    double* rows = weights + r * (order + 1) * width;
    basisDerivatives(knots_, span, u, order, rows);
    // From rows of p + 1 numbers to rows of `width`, the last first.
    for (Index k = order; k >= 0; --k) {
      std::copy_backward(rows + k * functions, rows + (k + 1) * functions, rows + k * width + functions);
      std::fill(rows + k * width + functions, rows + (k + 1) * width, 0.0);
    }
  }
}

}  // namespace strak
