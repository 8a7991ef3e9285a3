#pragma once
//
// Outliers among points along a curve, told apart before parameters are looked for: chord lengths lead to them and
// back, and no robust loss mends a curve that has room for the way.

#include <vector>

#include "strak/spline/spline.h"

namespace strak {

// Of points along a curve, in their order: the rows of those that stay near the running median of five neighbours. At
// least half of the points stay.
std::vector<Index> steadyPoints(const Net& points);

// Parameters for `count` points from those of the `rows` (rising, at least one): between them by the rows' numbers.
Net spreadParameters(const std::vector<Index>& rows, const Net& parameters, Index count);

}  // namespace strak
