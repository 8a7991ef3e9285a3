#include "strak/metrology/point_deviation.h"

#include <cmath>
#include <limits>

#include "strak/base/error.h"
#include "strak/metrology/closest_points.h"
#include "strak/metrology/curvature.h"
#include "strak/spline/evaluate.h"

namespace strak {

namespace {

constexpr double kGraph = 1e-9;  // of the domain's length

template <int D>
void checkColumns(const Spline<D>& spline, const Eigen::Ref<const Net>& points) {
  if (points.cols() != spline.pointDimension()) {
    throw InvalidInput("the points have another number of coordinates than the spline");
  }
}

}  // namespace

template <int D>
bool isGraph(const Spline<D>& spline) {
  if (spline.isRational() || spline.pointDimension() != D + 1) return false;
  std::array<std::vector<double>, D> places;
  for (int k = 0; k < D; ++k) places[static_cast<std::size_t>(k)] = spline.knots(k).greville();
  for (Index r = 0; r < spline.net().rows(); ++r) {
    Index rest = r;
    for (int k = D - 1; k >= 0; --k) {
      const auto& place = places[static_cast<std::size_t>(k)];
      const auto n = static_cast<Index>(place.size());
      const double wanted = place[static_cast<std::size_t>(rest % n)];
      if (!(std::abs(spline.net()(r, k) - wanted) <= kGraph * spline.knots(k).length())) return false;
      rest /= n;
    }
  }
  return true;
}

template <int D>
PointDeviation heightDeviation(const Spline<D>& graph, const Eigen::Ref<const Net>& points) {
  checkColumns(graph, points);
  if (!isGraph(graph)) throw InvalidInput("heights can be compared with the graph of a function only");
  PointDeviation result{Eigen::VectorXd(points.rows()), Net(points.rows(), D + 1), points.leftCols(D), 0};
  const Net heights = derivativesAt<D>(graph, points.leftCols(D), 0);
  result.feet = heights;
  for (Index r = 0; r < points.rows(); ++r) {
    bool inside = true;
    for (int k = 0; k < D; ++k) {
      const KnotVector& knots = graph.knots(k);
      const double slack = kGraph * knots.length();
      inside = inside && points(r, k) >= knots.from() - slack && points(r, k) <= knots.to() + slack;
    }
    result.values[r] = inside ? points(r, D) - heights(r, D) : std::numeric_limits<double>::quiet_NaN();
    if (!inside) ++result.missed;
  }
  return result;
}

template <int D>
PointDeviation normalDeviation(const Spline<D>& spline, const Eigen::Ref<const Net>& points) {
  checkColumns(spline, points);
  const ClosestPoints<D> found = closestPoints<D>(spline, points);
  PointDeviation result{found.distances, found.points, found.parameters, 0};
  const Index dimension = spline.pointDimension();
  if (D == 2 ? dimension != 3 : dimension != 2) return result;
  const Net d = derivativesAt<D>(spline, found.parameters, 1);
  for (Index r = 0; r < points.rows(); ++r) {
    const Point way = points.row(r) - found.points.row(r);
    double side = 0;
    if constexpr (D == 2) {
      const auto normal =
          unitNormal(d.row(r).template segment<3>(3).transpose(), d.row(r).template segment<3>(6).transpose());
      if (normal) side = way.dot(normal->transpose());
    } else {
      side = d(r, 2) * way[1] - d(r, 3) * way[0];
    }
    if (side < 0) result.values[r] = -result.values[r];
  }
  return result;
}

void leaveOutTrimmed(const TrimRegion& region, PointDeviation& deviation) {
  if (region.isWholeDomain()) return;
  for (Index r = 0; r < deviation.values.size(); ++r) {
    if (std::isnan(deviation.values[r]) || region.inside(deviation.parameters.row(r).transpose())) continue;
    deviation.values[r] = std::numeric_limits<double>::quiet_NaN();
    ++deviation.missed;
  }
}

template bool isGraph<1>(const Spline<1>&);
template bool isGraph<2>(const Spline<2>&);
template PointDeviation heightDeviation<1>(const Spline<1>&, const Eigen::Ref<const Net>&);
template PointDeviation heightDeviation<2>(const Spline<2>&, const Eigen::Ref<const Net>&);
template PointDeviation normalDeviation<1>(const Spline<1>&, const Eigen::Ref<const Net>&);
template PointDeviation normalDeviation<2>(const Spline<2>&, const Eigen::Ref<const Net>&);

}  // namespace strak
