#pragma once
//
// Two local methods for C2 cubic B-spline curves that need no integrals.
//
// Knot removal and reinsertion: at an inner knot of a cubic spline the slope of the curvature jumps. Taking the knot
// out and putting it back moves one control point and makes the curve C3 there. The knot with the largest jump comes
// first; a step counts only if the sum of all jumps falls. Source: Farin, Rein, Sapidis, Worsey, "Fairing cubic
// B-spline curves", CAGD 4 (1987); Sapidis, Farin, "Automatic fairing algorithm for B-spline curves", CAD 22 (1990),
// 121-129.
//
// Degree reduction and elevation: the cubic piece with the largest third difference of its Bezier points is replaced by
// the parabola with the same ends, written as a cubic again: its inner Bezier points lie on one leg of the control
// polygon, so the leg's two control points move. Source: Farin, "Degree reduction fairing of cubic B-spline curves",
// in Barnhill (ed.), Geometry Processing for Design and Manufacturing, SIAM (1992), 87-99; which leg is next, and that
// a step counts only if the sum of the squared third differences falls, is the choice made here.

#include "strak/base/progress.h"
#include "strak/fairing/faired.h"
#include "strak/fairing/held_points.h"

namespace strak {

struct CubicFairingOptions {
  double tolerance = kUnlimited;  // of every control point, so of the curve; model units
  HeldPoints held;                // stay to the bit
  Index maxSteps = 20'000;
  Progress progress;
};

// Summary of both: energy is the sum that falls (jumps of dk/ds, 1 / length^2; squared third differences, length^2).
// Stops: gain (no step lowers the sum any more by a billionth), steps, cancelled, nothingFree. Cost of a step O(n).
// Throw InvalidInput unless the curve is a polynomial cubic of the plane or of space with simple inner knots, the
// tolerance is not negative and the list of held points fits.
Faired<1> fairByKnotRemoval(const Curve& curve, const CubicFairingOptions& options = {});
Faired<1> fairByDegreeReduction(const Curve& curve, const CubicFairingOptions& options = {});

}  // namespace strak
