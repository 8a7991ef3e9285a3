#pragma once
//
// In which shape of its domain the energy of a function is measured. Where x and y are lengths on the same ground, the
// shape is theirs; where they are millimetres and seconds, it means nothing. Cross validation sees the difference.

#include "strak/fitting/least_squares.h"

namespace strak {

// ParameterScale::lengths, or ParameterScale::unit if the domain is elongated (three times as long as wide or more) and
// cross validation expects smaller errors in a square one, or no fit is possible in the long one. Cost: two fits of
// elongated domains.
ParameterScale shapeFor(const std::array<KnotVector, 2>& knots, Index columns, const PointPass<2>& points,
                        const FitOptions<2>& options);

}  // namespace strak
