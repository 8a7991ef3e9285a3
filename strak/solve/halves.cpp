#include "strak/solve/halves.h"

#include <algorithm>

namespace strak {

std::ptrdiff_t halveByPlace(std::vector<int>& points, const Eigen::Ref<const Eigen::MatrixX3d>& places) {
  Eigen::RowVector3d low = places.row(points.front()), high = low;
  for (int p : points) {
    low = low.cwiseMin(places.row(p));
    high = high.cwiseMax(places.row(p));
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const auto half = static_cast<std::ptrdiff_t>(points.size() / 2);
  std::nth_element(points.begin(), points.begin() + half, points.end(), [&](int a, int b) {
    return places(a, axis) < places(b, axis) || (places(a, axis) == places(b, axis) && a < b);
  });
  return half;
}

}  // namespace strak
