#pragma once
//
// The certified distance, parameter by parameter, of two splines on the same domain.

#include "strak/spline/spline.h"

namespace strak {

template <int D>
struct Deviation {
  double lower = 0;               // |A(place) - B(place)|, really reached
  double upper = 0;               // no parameter has a larger distance: proven, rounding included
  std::array<double, D> place{};  // where `lower` was measured
};

struct DeviationOptions {
  double relativeWidth = 1e-4;   // stop once upper - lower <= relativeWidth * upper
  Index maxPatches = 2'000'000;  // or once so many Bezier pieces have been looked at: the bounds stay valid
};

// max over the domain of |A(u) - B(u)|. The splines may have different degrees and knots but must have the same domain
// (to 1e-12 of its length) and dimension; else InvalidInput says which differs.
// Method: the difference in a common spline space, its Bezier pieces, subdivision of those whose control points lie far
// out (convex hull property: Hadenfeld (12), (13) made sharp). Rational splines: bound of the homogeneous difference
// over the least weight, refined likewise.
template <int D>
Deviation<D> certifyDeviation(const Spline<D>& a, const Spline<D>& b, const DeviationOptions& options = {});

}  // namespace strak
