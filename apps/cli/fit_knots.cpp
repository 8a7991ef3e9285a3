#include "apps/cli/fit_knots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/cli/values.h"
#include "strak/base/error.h"

namespace strak::cli {

namespace {

constexpr Index kMostPointsPerDirection = 50;  // control points, where none are asked for
constexpr Index kMostCurvePoints = 200;
constexpr double kPointsPerControlPoint = 4;  // measured ones
constexpr Index kFirstSpans = 8;              // where the tolerance decides
constexpr int kHighestDegree = 31;

}  // namespace

template <int D>
std::array<KnotVector, D> startKnots(const KnotWishes& wishes, const FitInput<D>& input, bool adaptive) {
  const auto degrees = wholeNumbers("--degree", wishes.degree, 'x', 1, kHighestDegree, D);
  std::vector<Index> sizes;
  if (!wishes.size.empty()) {
    sizes = wholeNumbers("--size", wishes.size, 'x', 2, std::numeric_limits<Index>::max(), D);
  }
  std::vector<double> domain;
  if (!wishes.domain.empty()) domain = numberList("--domain", wishes.domain, 2 * D);
  const double wished = static_cast<double>(input.count) / kPointsPerControlPoint;
  std::array<KnotVector, D> knots;
  for (std::size_t k = 0; k < D; ++k) {
    const double from = domain.empty() ? input.from[k] : domain[2 * k],
                 to = domain.empty() ? input.to[k] : domain[2 * k + 1];
    if (!(from < to)) {
      throw InvalidInput(
          domain.empty()
              ? fmt::format("all points have the same {} ({:g}): a fit needs points beside it",
                            D == 1   ? "parameter"
                            : k == 0 ? "first coordinate"
                                     : "second coordinate",
                            from)
              : fmt::format("--domain is '{}': the first number of a pair must be the smaller one", wishes.domain));
    }
    if (!std::isfinite(to - from)) {
      throw InvalidInput("the coordinates are so large that their differences are no numbers: use another unit");
    }
    const int degree = static_cast<int>(degrees[k]);
    Index size = std::max<Index>(degree + 1, std::min<Index>(D == 1 ? kMostCurvePoints : kMostPointsPerDirection,
                                                             static_cast<Index>(std::pow(wished, 1.0 / D))));
    if (adaptive) size = std::min(size, degree + kFirstSpans);
    if (!sizes.empty()) size = sizes[k];
    if (size < degree + 1) {
      throw InvalidInput(
          fmt::format("--size is '{}': degree {} needs at least {} control points", wishes.size, degree, degree + 1));
    }
    knots[k] = KnotVector::uniformClamped(degree, size - degree, from, to);
  }
  Index product = 1;
  for (const auto& k : knots) {
    if (k.size() > wholeNumber("--most-points", wishes.mostPoints, 1) / product) {
      throw InvalidInput(fmt::format(
          "--size asks for more than {} control points: raise --most-points if that is meant", wishes.mostPoints));
    }
    product *= k.size();
  }
  return knots;
}

template std::array<KnotVector, 1> startKnots<1>(const KnotWishes&, const FitInput<1>&, bool);
template std::array<KnotVector, 2> startKnots<2>(const KnotWishes&, const FitInput<2>&, bool);

}  // namespace strak::cli
