#include "strak/spline/net_product.h"

#include <fmt/format.h>

#include "strak/base/error.h"

namespace strak {

template <int D>
Net multiplyAlong(const Eigen::SparseMatrix<double>& matrix, const Eigen::Ref<const Net>& net,
                  const typename Spline<D>::Sizes& sizes, int direction) {
  Index outer = 1;
  Index inner = 1;
  for (int k = 0; k < D; ++k) {
    if (k < direction) outer *= sizes[static_cast<std::size_t>(k)];
    if (k > direction) inner *= sizes[static_cast<std::size_t>(k)];
  }
  const Index from = sizes[static_cast<std::size_t>(direction)];
  const Index to = matrix.rows();
  if (matrix.cols() != from || net.rows() != outer * from * inner) {
    throw InvalidInput(fmt::format(
        "a matrix of {} x {} cannot act on direction {} of a net with {} points, {} of them in that direction: "
        "match the sizes",
        matrix.rows(), matrix.cols(), directionName(direction), net.rows(), from));
  }
  Net result = Net::Zero(outer * to * inner, net.cols());
  for (Index o = 0; o < outer; ++o) {
    for (Index j = 0; j < from; ++j) {
      const auto source = net.middleRows((o * from + j) * inner, inner);
      for (Eigen::SparseMatrix<double>::InnerIterator entry(matrix, j); entry; ++entry) {
        result.middleRows((o * to + entry.row()) * inner, inner) += entry.value() * source;
      }
    }
  }
  return result;
}

template Net multiplyAlong<1>(const Eigen::SparseMatrix<double>&, const Eigen::Ref<const Net>&, const Spline<1>::Sizes&,
                              int);
template Net multiplyAlong<2>(const Eigen::SparseMatrix<double>&, const Eigen::Ref<const Net>&, const Spline<2>::Sizes&,
                              int);
template Net multiplyAlong<3>(const Eigen::SparseMatrix<double>&, const Eigen::Ref<const Net>&, const Spline<3>::Sizes&,
                              int);

}  // namespace strak
