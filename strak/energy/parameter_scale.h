#pragma once
//
// In which parameters an energy is measured. The energies are not invariant to the scale of u against v (18 % from scale
// alone on a 150 x 30 patch), so the scale is part of the question and always stated.

#include <string_view>

#include "strak/spline/spline.h"

namespace strak {

enum class ParameterScale {
  lengths,  // each domain is as long as its mean parameter line: results do not change when the knots are rescaled
  domain,   // the knots as they are
  unit,     // every domain is [0, 1]
};

// "lengths", "domain", "unit"; throws InvalidInput for another word.
ParameterScale parameterScaleNamed(std::string_view name);

// The knot vectors of `spline` with their domains rescaled. `lengths` uses the mean length of the parameter lines of that
// direction (exact to rounding under affine changes of the knots); a direction of zero length keeps length 1.
template <int D>
std::array<KnotVector, D> scaledKnots(const Spline<D>& spline, ParameterScale scale);

}  // namespace strak
