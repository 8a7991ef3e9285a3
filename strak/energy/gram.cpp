#include "strak/energy/gram.h"

#include "strak/spline/basis.h"

namespace strak {

BandMatrix gramMatrix(const KnotVector& knots, int a, int b) {
  const int p = knots.degree();
  BandMatrix gram(knots.size(), p);
  if (a > p || b > p) return gram;
  // The integrand is a polynomial of degree 2p - a - b on a span: q points integrate degree 2q - 1.
  const GaussRule rule = gaussLegendre(std::max(1, (2 * p - a - b) / 2 + 1));
  const int order = std::max(a, b);
  std::vector<double> basis(static_cast<std::size_t>((order + 1) * (p + 1)));
  for (Index span : knots.spans()) {
    const double half = (knots[span + 1] - knots[span]) / 2;
    const double middle = (knots[span + 1] + knots[span]) / 2;
    for (std::size_t q = 0; q < rule.nodes.size(); ++q) {
      basisDerivatives(knots, span, middle + half * rule.nodes[q], order, basis.data());
      const double weight = half * rule.weights[q];
      const double* left = basis.data() + a * (p + 1);
      const double* right = basis.data() + b * (p + 1);
      for (int i = 0; i <= p; ++i) {
        for (int j = 0; j <= p; ++j) gram.at(span - p + i, span - p + j) += weight * left[i] * right[j];
      }
    }
  }
  return gram;
}

}  // namespace strak
