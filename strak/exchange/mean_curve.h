#pragma once
//
// The curve in the middle of several curves with the same domain.

#include <vector>

#include "strak/spline/spline.h"

namespace strak {

// X(t) = mean of the curves' points at t: with the highest degree and all their knots, so it is exact. Knots within
// 1e-10 of the domain are taken as the same. Of rational curves the first alone, as the mean is no such curve. Throws
// InvalidInput if there is none or the domains differ by more than that.
Curve meanCurve(std::vector<Curve> curves);

}  // namespace strak
