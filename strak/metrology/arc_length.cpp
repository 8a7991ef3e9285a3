#include "strak/metrology/arc_length.h"

#include <algorithm>
#include <cmath>

#include "strak/spline/evaluate.h"

namespace strak {

namespace {

constexpr Index kPerSpan = 64;

}  // namespace

Eigen::VectorXd arcLengths(const Curve& curve, const Eigen::Ref<const Eigen::VectorXd>& parameters) {
  const KnotVector& knots = curve.knots(0);
  std::vector<double> places;
  for (const Index span : knots.spans()) {
    for (Index i = 0; i < kPerSpan; ++i) {
      places.push_back(std::lerp(knots[span], knots[span + 1], static_cast<double>(i) / kPerSpan));
    }
  }
  places.push_back(knots.to());
  const Net points =
      derivativesAt<1>(curve, Eigen::Map<const Net>(places.data(), static_cast<Index>(places.size()), 1), 0);
  std::vector<double> lengths(places.size(), 0);
  for (std::size_t i = 1; i < places.size(); ++i) {
    const auto r = static_cast<Index>(i);
    lengths[i] = lengths[i - 1] + (points.row(r) - points.row(r - 1)).norm();
  }
  Eigen::VectorXd result(parameters.size());
  for (Index r = 0; r < parameters.size(); ++r) {
    const auto next = std::upper_bound(places.begin() + 1, places.end() - 1, parameters[r]);
    const auto i = static_cast<std::size_t>(next - places.begin()) - 1;
    const double share = (parameters[r] - places[i]) / (places[i + 1] - places[i]);
    result[r] = lengths[i] + share * (lengths[i + 1] - lengths[i]);
  }
  return result;
}

}  // namespace strak
