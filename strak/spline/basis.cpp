#include "strak/spline/basis.h"

#include <cmath>
#include <numbers>

#include "strak/base/error.h"

namespace strak {

namespace {

constexpr int kStackDegree = 31;

}  // namespace

void basisDerivatives(const KnotVector& knots, Index span, double u, int order, double* out) {
  const int p = knots.degree();
  const Index columns = p + 1;
  // left[j] = u - U[span + 1 - j], right[j] = U[span + j] - u; table row d holds the basis functions of degree d at u
  // (d + 1 numbers), and the knot differences that their recurrence divides by are kept for the derivatives.
  double stack[(kStackDegree + 1) * (kStackDegree + 1) + 4 * (kStackDegree + 1)];
  std::vector<double> heap;
  double* memory = stack;
  if (p > kStackDegree) {
    heap.resize(static_cast<std::size_t>(columns * columns + 4 * columns));
    memory = heap.data();
  }
  double* table = memory;
  double* left = table + columns * columns;
  double* right = left + columns;
  double* now = right + columns;
  double* next = now + columns;

  table[0] = 1;
  for (int d = 1; d <= p; ++d) {
    left[d] = u - knots[span + 1 - d];
    right[d] = knots[span + d] - u;
    const double* lower = table + (d - 1) * columns;
    double* upper = table + d * columns;
    double saved = 0;
    for (int r = 0; r < d; ++r) {
      const double t = lower[r] / (right[r + 1] + left[d - r]);
      upper[r] = saved + right[r + 1] * t;
      saved = left[d - r] * t;
    }
    upper[d] = saved;
  }
  for (int j = 0; j <= p; ++j) out[j] = table[p * columns + j];

  // N_{i,p}' = p (N_{i,p-1} / (U[i+p] - U[i]) - N_{i+1,p-1} / (U[i+p+1] - U[i+1])), applied k times to the functions of
  // degree p - k; inside one span no denominator vanishes.
  for (int k = 1; k <= order; ++k) {
    double* row = out + k * columns;
    if (k > p) {
      for (int j = 0; j <= p; ++j) row[j] = 0;
      continue;
    }
    for (int j = 0; j <= p - k; ++j) now[j] = table[(p - k) * columns + j];
    for (int d = p - k + 1; d <= p; ++d) {
      for (int j = 0; j <= d; ++j) {
        const Index i = span - d + j;
        double value = 0;
        if (j > 0) value += now[j - 1] / (knots[i + d] - knots[i]);
        if (j < d) value -= now[j] / (knots[i + d + 1] - knots[i + 1]);
        next[j] = d * value;
      }
      std::swap(now, next);
    }
    for (int j = 0; j <= p; ++j) row[j] = now[j];
  }
}

Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> basisDerivatives(const KnotVector& knots,
                                                                                        Index span, double u,
                                                                                        int order) {
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> result(order + 1, knots.degree() + 1);
  basisDerivatives(knots, span, u, order, result.data());
  return result;
}

GaussRule gaussLegendre(int count) {
  if (count < 1) throw InvalidInput("a Gauss rule needs at least one point");
  GaussRule rule;
  rule.nodes.resize(static_cast<std::size_t>(count));
  rule.weights.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    // Newton from Chebyshev's guess, on the Legendre polynomial by its three-term recurrence.
    double x = -std::cos(std::numbers::pi * (i + 0.75) / (count + 0.5));
    double derivative = 1;
    for (int iteration = 0; iteration < 100; ++iteration) {
      double p0 = 1;
      double p1 = x;
      for (int k = 2; k <= count; ++k) {
        const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
        p0 = p1;
        p1 = p2;
      }
      derivative = count * (x * p1 - p0) / (x * x - 1);
      const double step = p1 / derivative;
      x -= step;
      if (std::abs(step) < 1e-16) break;
    }
    if (count % 2 == 1 && i == count / 2) x = 0;
    rule.nodes[static_cast<std::size_t>(i)] = x;
    double p0 = 1;
    double p1 = x;
    for (int k = 2; k <= count; ++k) {
      const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
      p0 = p1;
      p1 = p2;
    }
    derivative = count * (x * p1 - p0) / (x * x - 1);
    rule.weights[static_cast<std::size_t>(i)] = 2 / ((1 - x * x) * derivative * derivative);
  }
  return rule;
}

}  // namespace strak
