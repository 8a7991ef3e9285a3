#pragma once
//
// Lengths along a curve.

#include "strak/spline/spline.h"

namespace strak {

// The length of the curve from its beginning to each parameter, a row each; parameters beyond the ends go on at the
// speed there (and are negative before the beginning). By chords, 64 a knot span: a quarter of a circle in one span is
// 3e-5 of its length too short. Cost: an evaluation a chord.
Eigen::VectorXd arcLengths(const Curve& curve, const Eigen::Ref<const Eigen::VectorXd>& parameters);

}  // namespace strak
