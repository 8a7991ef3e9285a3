#pragma once
//
// Points that are in a file more than once.

#include "strak/spline/spline.h"

namespace strak {

// Keeps the first of points whose parameters and values are the same to the bit, in their order, with the sum of their
// weights (`weights` empty: each has 1, and it stays empty if nothing is repeated). Least squares do not change, but a
// measurement that is counted twice does not pass for two of them: cross validation would take their common error for
// shape. Returns how many points were merged into others. Cost O(n log n).
Index mergeRepeatedPoints(Net& parameters, Net& values, Eigen::VectorXd& weights);

}  // namespace strak
