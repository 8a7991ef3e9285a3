#include "strak/spline/knot_insertion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "strak/base/error.h"
#include "strak/spline/net_product.h"

namespace strak {

KnotVector withKnots(const KnotVector& knots, const std::vector<double>& newKnots, const char* name) {
  std::vector<double> added = newKnots;
  for (double u : added) {
    if (!std::isfinite(u) || u < knots.from() || u > knots.to()) {
      throw InvalidInput(fmt::format("the new knot {} of direction {} lies outside the domain [{}, {}]: move it inside",
                                     u, name, knots.from(), knots.to()));
    }
  }
  std::sort(added.begin(), added.end());
  std::vector<double> merged(knots.knots().size() + added.size());
  std::merge(knots.knots().begin(), knots.knots().end(), added.begin(), added.end(), merged.begin());
  return {knots.degree(), std::move(merged), name};
}

std::vector<double> missingKnots(const KnotVector& coarse, const KnotVector& fine) {
  if (coarse.degree() != fine.degree()) {
    throw InvalidInput(fmt::format("knots of degree {} cannot be refined to degree {}: raise the degree first",
                                   coarse.degree(), fine.degree()));
  }
  if (coarse.from() != fine.from() || coarse.to() != fine.to()) {
    throw InvalidInput(
        fmt::format("the domain [{}, {}] of the coarse knots is not that of the fine ones, [{}, {}]: "
                    "refine inside the domain only",
                    coarse.from(), coarse.to(), fine.from(), fine.to()));
  }
  std::vector<double> result;
  auto next = fine.knots().begin();
  for (double u : coarse.knots()) {
    while (next != fine.knots().end() && *next < u) result.push_back(*next++);
    if (next == fine.knots().end() || *next != u) {
      throw InvalidInput(
          fmt::format("the fine knots have {} {} times but the coarse ones {} times: refining only adds knots", u,
                      fine.multiplicity(u), coarse.multiplicity(u)));
    }
    ++next;
  }
  result.insert(result.end(), next, fine.knots().end());
  return result;
}

Index refinementRow(const KnotVector& coarse, double start, const double* arguments, double* row) {
  const int p = coarse.degree();
  const auto& knots = coarse.knots();
  // Before the first and after the last knot stand copies of it: they belong to control points that do not exist.
  const auto last = static_cast<Index>(knots.size()) - 1;
  const auto knot = [&](Index i) { return coarse[std::clamp<Index>(i, 0, last)]; };
  const Index span = std::upper_bound(knots.begin(), knots.end(), start) - knots.begin() - 1;
  // After step d, row[k] belongs to the coarse control point span - d + k.
  row[0] = 1;
  for (int d = 1; d <= p; ++d) {
    const double x = arguments[d - 1];
    double carried = 0;
    for (int k = 0; k < d; ++k) {
      const Index i = span - d + 1 + k;
      const double length = knot(i + d) - knot(i);
      const double weight = row[k];
      row[k] = carried + weight * ((knot(i + d) - x) / length);
      carried = weight * ((x - knot(i)) / length);
    }
    row[d] = carried;
  }
  return span;
}

Eigen::SparseMatrix<double> refinementMatrix(const KnotVector& coarse, const KnotVector& fine) {
  missingKnots(coarse, fine);
  const int p = coarse.degree();
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(fine.size() * (p + 1)));
  std::vector<double> row(static_cast<std::size_t>(p) + 1);
  for (Index j = 0; j < fine.size(); ++j) {
    const Index span = refinementRow(coarse, fine[j], fine.knots().data() + j + 1, row.data());
    for (int k = 0; k <= p; ++k) {
      const Index i = span - p + k;
      const double value = row[static_cast<std::size_t>(k)];
      if (i >= 0 && i < coarse.size() && value != 0) entries.emplace_back(j, i, value);
    }
  }
  Eigen::SparseMatrix<double> result(fine.size(), coarse.size());
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

template <int D>
Spline<D> insertKnots(const Spline<D>& spline, int direction, const std::vector<double>& newKnots) {
  if (newKnots.empty()) return spline;
  auto knots = spline.knots();
  auto& fine = knots[static_cast<std::size_t>(direction)];
  fine = withKnots(fine, newKnots, directionName(direction));
  const auto matrix = refinementMatrix(spline.knots(direction), fine);
  Net net = multiplyAlong<D>(matrix, spline.net(), spline.sizes(), direction);
  return {std::move(knots), std::move(net), spline.isRational()};
}

template <int D>
Spline<D> refine(const Spline<D>& spline, const typename Spline<D>::Knots& fine) {
  Spline<D> result = spline;
  for (int k = 0; k < D; ++k) {
    result = insertKnots(result, k, missingKnots(spline.knots(k), fine[static_cast<std::size_t>(k)]));
  }
  return result;
}

#define STRAK_INSTANTIATE(D)                                                            \
  template Spline<D> insertKnots<D>(const Spline<D>&, int, const std::vector<double>&); \
  template Spline<D> refine<D>(const Spline<D>&, const std::array<KnotVector, D>&);
STRAK_INSTANTIATE(1)
STRAK_INSTANTIATE(2)
STRAK_INSTANTIATE(3)
#undef STRAK_INSTANTIATE

}  // namespace strak
