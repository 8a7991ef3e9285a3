#include "strak/exchange/mean_curve.h"

#include <algorithm>
#include <cmath>

#include "strak/base/error.h"
#include "strak/spline/degree_elevation.h"
#include "strak/spline/knot_insertion.h"

namespace strak {
namespace {

constexpr double kSameKnot = 1e-10;  // of the domain

// `knots` with those that `known` nearly has replaced by them.
KnotVector snapped(const KnotVector& knots, const KnotVector& known) {
  std::vector<double> values = knots.knots();
  const double slack = kSameKnot * known.length();
  for (double& value : values) {
    const auto& others = known.knots();
    const auto next = std::lower_bound(others.begin(), others.end(), value - slack);
    if (next != others.end() && std::abs(*next - value) <= slack) value = *next;
  }
  return KnotVector(knots.degree(), std::move(values));
}

// The knots that either has, each as often as the one that has it more often.
std::vector<double> missing(const KnotVector& had, const KnotVector& other) {
  std::vector<double> result;
  for (const auto& knot : other.innerKnots()) {
    const int count = knot.multiplicity - had.multiplicity(knot.value);
    result.insert(result.end(), static_cast<std::size_t>(std::max(count, 0)), knot.value);
  }
  return result;
}

}  // namespace

Curve meanCurve(std::vector<Curve> curves) {
  if (curves.empty()) throw InvalidInput("there is no curve to take the mean of");
  Curve sum = std::move(curves.front());
  if (sum.isRational()) return sum;
  double count = 1;
  for (std::size_t k = 1; k < curves.size(); ++k) {
    Curve next = std::move(curves[k]);
    if (next.isRational()) return sum;
    const double slack = kSameKnot * sum.knots(0).length();
    if (std::abs(next.knots(0).from() - sum.knots(0).from()) > slack ||
        std::abs(next.knots(0).to() - sum.knots(0).to()) > slack) {
      throw InvalidInput("curves on different domains have no mean: map them to one domain first");
    }
    next = elevateDegree(next, 0, std::max(0, sum.degree(0) - next.degree(0)));
    sum = elevateDegree(sum, 0, std::max(0, next.degree(0) - sum.degree(0)));
    next = Curve({snapped(next.knots(0), sum.knots(0))}, next.net());
    const std::vector<double> forNext = missing(next.knots(0), sum.knots(0));
    sum = insertKnots(sum, 0, missing(sum.knots(0), next.knots(0)));
    next = insertKnots(next, 0, forNext);
    sum.net() += (next.net() - sum.net()) / (count += 1);
  }
  return sum;
}

}  // namespace strak
