#include "strak/spline/degree_elevation.h"

#include <fmt/format.h>

#include <algorithm>

#include "strak/base/error.h"
#include "strak/spline/knot_insertion.h"
#include "strak/spline/net_product.h"

namespace strak {

KnotVector elevatedKnots(const KnotVector& knots) {
  std::vector<double> raised;
  for (std::size_t i = 0; i < knots.knots().size(); ++i) {
    raised.push_back(knots.knots()[i]);
    if (i + 1 == knots.knots().size() || knots.knots()[i] != knots.knots()[i + 1]) raised.push_back(knots.knots()[i]);
  }
  // With all knots outside the domain doubled, the domain would begin too early: keep what is alive inside it.
  const int p = knots.degree() + 1;
  const auto lastFrom = std::upper_bound(raised.begin(), raised.end(), knots.from()) - 1;
  const auto firstTo = std::lower_bound(raised.begin(), raised.end(), knots.to());
  return {p, {lastFrom - p, firstTo + p + 1}};
}

Eigen::SparseMatrix<double> elevationMatrix(const KnotVector& knots) {
  const int p = knots.degree();
  const KnotVector raised = elevatedKnots(knots);
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> arguments(static_cast<std::size_t>(p));
  std::vector<double> row(static_cast<std::size_t>(p) + 1);
  for (Index j = 0; j < raised.size(); ++j) {
    for (int left = 1; left <= p + 1; ++left) {
      // Without one of its doubled knots the raised knot vector still holds all old ones.
      auto to = arguments.begin();
      for (int i = 1; i <= p + 1; ++i) {
        if (i != left) *to++ = raised[j + i];
      }
      const Index span = refinementRow(knots, raised[j], arguments.data(), row.data());
      for (int k = 0; k <= p; ++k) {
        const Index i = span - p + k;
        const double value = row[static_cast<std::size_t>(k)] / (p + 1);
        if (i >= 0 && i < knots.size() && value != 0) entries.emplace_back(j, i, value);
      }
    }
  }
  Eigen::SparseMatrix<double> result(raised.size(), knots.size());
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

template <int D>
Spline<D> elevateDegree(const Spline<D>& spline, int direction, int steps) {
  if (steps < 0) {
    throw InvalidInput(fmt::format("the degree of direction {} cannot be raised by {}: give 0 or more",
                                   directionName(direction), steps));
  }
  Spline<D> result = spline;
  for (int step = 0; step < steps; ++step) {
    auto knots = result.knots();
    auto& raised = knots[static_cast<std::size_t>(direction)];
    const auto matrix = elevationMatrix(raised);
    raised = elevatedKnots(raised);
    Net net = multiplyAlong<D>(matrix, result.net(), result.sizes(), direction);
    result = Spline<D>(std::move(knots), std::move(net), spline.isRational());
  }
  return result;
}

template Spline<1> elevateDegree<1>(const Spline<1>&, int, int);
template Spline<2> elevateDegree<2>(const Spline<2>&, int, int);
template Spline<3> elevateDegree<3>(const Spline<3>&, int, int);

}  // namespace strak
