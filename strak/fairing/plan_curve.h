#pragma once
//
// What of a curve may move: held ends and creases, or a smooth seam that moves as a whole.

#include "strak/energy/curve_energy.h"
#include "strak/fairing/plan_face.h"

namespace strak {

struct CurvePlan {
  // What to fair: the input, perhaps with more knots. Where pieces join at a knot of multiplicity `degree` with one
  // tangent, the pieces run at one speed here and the join is C1: so it stays smooth, and its curvature can be made so.
  Curve spline;
  HeldPoints held;
  int seamContinuity = -1;  // the ends meet with this many derivatives and may move together; -1: open or held
  Index freePoints = 0;
  Index knotsInserted = 0;
  std::vector<std::string> notes;
  std::string leftAlone;  // why nothing can be done (a clause, lower case)

  // A curve that differs from `spline` in its control points, on the knots and parameters of the input (and those
  // inserted). Points that did not move keep the bits they have there.
  Curve onInput(const Curve& faired) const;

  Curve input;
  std::vector<double> breaks, inputBreaks;  // the same places in the parameters of `spline` and of the input
};

// The largest c such that position and the first c derivatives (of the homogeneous points) agree at both ends to 1e-8;
// at most degree - 1, and -1 if not even the ends meet.
int seamContinuity(const Curve& curve);

// Plans the fairing of a curve by its exact energies: rows held at the ends, and on both sides of corners, knots of
// multiplicity `degree` where the direction turns by more than 0.01 degrees (or the curve is rational). A closed curve
// with a seam of C2 (C1 for degree 2) and no such knot holds nothing. Throws InvalidInput for negative rows.
CurvePlan planCurve(const Curve& curve, const std::array<Index, 2>& rows, bool refine = true);

// The unknowns of a plan: a free point each; at a seam of continuity c >= 0 the last c + 1 points follow the first ones
// so that the seam stays as smooth as it is. `held` has an entry a control point or is empty.
// Throws InvalidInput if `held` has another length.
PointMap unknownsOf(const Curve& curve, const HeldPoints& held, int continuity);

}  // namespace strak
