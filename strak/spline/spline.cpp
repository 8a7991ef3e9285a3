#include "strak/spline/spline.h"

#include <fmt/format.h>

#include <cmath>

#include "strak/base/error.h"

namespace strak {

template <int D>
Spline<D>::Spline(std::array<KnotVector, D> knots, Net net, bool rational)
    : knots_(std::move(knots)), net_(std::move(net)), rational_(rational) {
  Index expected = 1;
  for (const auto& direction : knots_) expected *= direction.size();
  if (net_.rows() != expected) {
    throw InvalidInput(fmt::format(
        "the control net has {} points but the knots need {}: give one point a basis function", net_.rows(), expected));
  }
  if (pointDimension() < 1) throw InvalidInput("the control points have no coordinates: give at least one column");
  for (Index r = 0; r < net_.rows(); ++r) {
    if (!net_.row(r).allFinite()) {
      throw InvalidInput(fmt::format("control point {} is not finite: correct its coordinates", r));
    }
    if (rational_ && !(net_(r, net_.cols() - 1) > 0)) {
      throw InvalidInput(
          fmt::format("the weight of control point {} is {}: weights must be positive", r, net_(r, net_.cols() - 1)));
    }
  }
}

template <int D>
typename Spline<D>::Sizes Spline<D>::sizes() const {
  Sizes result;
  for (int k = 0; k < D; ++k) result[static_cast<std::size_t>(k)] = size(k);
  return result;
}

template <int D>
Index Spline<D>::row(const Sizes& index) const {
  Index result = 0;
  for (int k = 0; k < D; ++k) result = result * size(k) + index[static_cast<std::size_t>(k)];
  return result;
}

template <int D>
Net Spline<D>::euclideanNet() const {
  if (!rational_) return net_;
  Net points = net_.leftCols(pointDimension());
  points.array().colwise() /= net_.col(pointDimension()).array();
  return points;
}

template class Spline<1>;
template class Spline<2>;
template class Spline<3>;

const char* directionName(int direction) {
  static constexpr const char* kNames[] = {"u", "v", "w"};
  return kNames[direction];
}

}  // namespace strak
