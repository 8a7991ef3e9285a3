#include "strak/fitting/domain_shape.h"

#include <algorithm>
#include <limits>

#include "strak/base/error.h"

namespace strak {

namespace {

constexpr double kElongated = 3;

}  // namespace

ParameterScale shapeFor(const std::array<KnotVector, 2>& knots, Index columns, const PointPass<2>& points,
                        const FitOptions<2>& options) {
  const double a = knots[0].length(), b = knots[1].length();
  if (std::max(a, b) < kElongated * std::min(a, b)) return ParameterScale::lengths;
  const auto expected = [&](ParameterScale scale) {
    FitOptions<2> own = options;
    own.scale = scale;
    own.smoothing = Smoothing::automatic();
    try {
      return fitLeastSquares<2>(knots, columns, points, own).summary.crossValidation;
    } catch (const InvalidInput&) {
      return std::numeric_limits<double>::infinity();
    }
  };
  return expected(ParameterScale::unit) < expected(ParameterScale::lengths) ? ParameterScale::unit
                                                                            : ParameterScale::lengths;
}

}  // namespace strak
