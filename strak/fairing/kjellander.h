#pragma once
//
// Kjellander's smoothing of cubic spline curves and bicubic surfaces: the curve is seen as the interpolating spline of
// its points at the knots; one of them is replaced by the point that the cubic piece between its two neighbours, with
// their tangents, has at its parameter, and the spline is drawn anew through all points. On a surface the mean of the
// points from both directions is taken.
//
// Source: Kjellander, "Smoothing of cubic parametric splines", CAD 15 (1983), 175-179; "Smoothing of bicubic parametric
// surfaces", CAD 15 (1983), 288-293. There a person chooses the points; here the one that moves farthest comes first,
// and a move counts only if the sum of the squared jumps of the third derivatives falls.

#include "strak/base/progress.h"
#include "strak/fairing/faired.h"
#include "strak/fairing/held_points.h"

namespace strak {

struct KjellanderOptions {
  double tolerance = kUnlimited;  // of the curve or surface, certified; model units
  HeldPoints held;                // control points that stay to the bit
  Index maxSteps = 5'000;
  Progress progress;
};

// End points and end tangents (of a surface: borders and cross-border tangents) stay. The new spline goes through all
// points again, so a move spreads, ever smaller, over the whole; control points in `held` are put back in the end, and
// if the certified deviation is then larger than the tolerance all moves are shortened alike.
// Summary: energy is the sum of the squared jumps. Stops: gain, steps, cancelled, nothingFree. Cost of a step:
// O(points). Throws InvalidInput unless the spline is cubic (bicubic), polynomial, clamped, with simple inner knots,
// the tolerance is not negative and the list of held points fits, and for curves of more than 2000 points and surfaces
// of more than 400 rows in a direction.
template <int D>
Faired<D> fairByKjellander(const Spline<D>& spline, const KjellanderOptions& options = {});

extern template Faired<1> fairByKjellander(const Spline<1>&, const KjellanderOptions&);
extern template Faired<2> fairByKjellander(const Spline<2>&, const KjellanderOptions&);

}  // namespace strak
