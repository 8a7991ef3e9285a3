#include "strak/spline/net_product.h"

#include <fmt/format.h>

#include "strak/base/error.h"

namespace strak {

template <int D>
Net multiplyAlong(const Eigen::SparseMatrix<double>& matrix, const Net& net, const typename Spline<D>::Sizes& sizes,
                  int direction) {
  Index count = 1;
  for (const Index size : sizes) count *= size;
  if (matrix.cols() != sizes[static_cast<std::size_t>(direction)] || net.rows() != count) {
    throw InvalidInput(fmt::format(
        "a matrix of {} x {} cannot act on direction {} of a net with {} points, {} of them in that direction: "
        "match the sizes",
        matrix.rows(), matrix.cols(), directionName(direction), net.rows(),
        sizes[static_cast<std::size_t>(direction)]));
  }
  return mapLines<D>(net, sizes, direction, matrix.rows(), [&](const auto& lines) -> Net { return matrix * lines; });
}

template <int D>
Net sliceAlong(const Net& net, const typename Spline<D>::Sizes& sizes, int direction, Index first, Index count) {
  return mapLines<D>(net, sizes, direction, count, [&](const auto& lines) { return lines.middleRows(first, count); });
}

#define STRAK_INSTANTIATE(D)                                                                                   \
  template Net multiplyAlong<D>(const Eigen::SparseMatrix<double>&, const Net&, const Spline<D>::Sizes&, int); \
  template Net sliceAlong<D>(const Net&, const Spline<D>::Sizes&, int, Index, Index);
STRAK_INSTANTIATE(1)
STRAK_INSTANTIATE(2)
STRAK_INSTANTIATE(3)
#undef STRAK_INSTANTIATE

}  // namespace strak
