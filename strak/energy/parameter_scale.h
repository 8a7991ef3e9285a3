#pragma once
//
// In which parameters an energy is measured. The energies are not invariant to the scale of u against v (18 % from
// scale alone on a 150 x 30 patch), so the scale is part of the question and always stated.

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

// The knot vectors of `spline` with their domains rescaled to [0, length]; `domain` leaves them alone.
// `lengths` takes the mean over the domain of the lengths of that direction's parameter lines: Gauss quadrature with 4
// points a span along the lines, at 16 Gauss places per crossing direction. The places move with the knots, so an
// affine change of the knots changes the result by rounding only. A direction of no length (to rounding) gets the
// length of the longest other one, or 1 if there is none. Points with a single coordinate are values of a function,
// whose knots are lengths already: `lengths` leaves them alone too. Cost O(16^(D - 1) n) evaluations of first
// derivatives per direction.
template <int D>
std::array<KnotVector, D> scaledKnots(const Spline<D>& spline, ParameterScale scale);

}  // namespace strak
