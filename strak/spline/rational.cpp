#include "strak/spline/rational.h"

#include <fmt/format.h>

#include "strak/base/error.h"

namespace strak {

template <int D>
Eigen::VectorXd weights(const Spline<D>& spline) {
  if (!spline.isRational()) return Eigen::VectorXd::Ones(spline.net().rows());
  return spline.net().col(spline.pointDimension());
}

template <int D>
Spline<D> withWeights(const Spline<D>& spline, const Eigen::Ref<const Eigen::VectorXd>& newWeights) {
  if (newWeights.size() != spline.net().rows()) {
    throw InvalidInput(fmt::format("there are {} weights for {} control points: give one each", newWeights.size(),
                                   spline.net().rows()));
  }
  Net net(spline.net().rows(), spline.pointDimension() + 1);
  net.leftCols(spline.pointDimension()) = spline.euclideanNet();
  net.leftCols(spline.pointDimension()).array().colwise() *= newWeights.array();
  net.rightCols(1) = newWeights;
  return {spline.knots(), std::move(net), true};
}

template <int D>
Spline<D> makeRational(const Spline<D>& spline) {
  return spline.isRational() ? spline : withWeights(spline, weights(spline));
}

template <int D>
Spline<D> makePolynomial(const Spline<D>& spline, double relativeTolerance) {
  const Eigen::VectorXd w = weights(spline);
  if (w.maxCoeff() - w.minCoeff() > relativeTolerance * w.maxCoeff()) {
    throw InvalidInput(
        fmt::format("the weights lie between {} and {}, so the spline is truly rational: approximate it instead",
                    w.minCoeff(), w.maxCoeff()));
  }
  return {spline.knots(), spline.euclideanNet(), false};
}

#define STRAK_INSTANTIATE(D)                                                                     \
  template Eigen::VectorXd weights<D>(const Spline<D>&);                                         \
  template Spline<D> withWeights<D>(const Spline<D>&, const Eigen::Ref<const Eigen::VectorXd>&); \
  template Spline<D> makeRational<D>(const Spline<D>&);                                          \
  template Spline<D> makePolynomial<D>(const Spline<D>&, double);
STRAK_INSTANTIATE(1)
STRAK_INSTANTIATE(2)
STRAK_INSTANTIATE(3)
#undef STRAK_INSTANTIATE

}  // namespace strak
