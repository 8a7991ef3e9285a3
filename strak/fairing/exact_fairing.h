#pragma once
//
// Fairing by the exact energies: bending, curvature variation and isophote roughness of the surface itself fall
// together inside a tolerance on the surface.
//
// Method: Gauss-Newton on the residuals of log(roughness) + log(plate), unknown are the full displacements of the free
// control points, each step a convex quadratic problem under balls on the refined difference (hull_minimizer.h). A
// small quadratic energy in arc length (ShapeEnergy::setMetric) keeps the parameter lines even, and its minimum is the
// start where the input is too rough to begin with. No step is taken that makes bending, curvature variation or
// roughness of any surface larger than its input's.
//
// Why not a quadratic energy in the parameters: it rewards sliding along the surface and changes with the scale of u
// against v; measured on a noisy 24 x 24 net within the same
// tolerance, the best quadratic optima have 28 to 36 times the roughness of this one.

#include <string>
#include <vector>

#include "strak/base/progress.h"
#include "strak/fairing/faired.h"
#include "strak/fairing/held_points.h"
#include "strak/metrology/fairness.h"

namespace strak {

struct ExactFairingOptions {
  double tolerance = kUnlimited;  // of the surface, model units; certified by the refined difference
  bool ballsOnPoints = false;     // bound the control points' moves instead, as (13) does
  int maxSteps = 40;              // Gauss-Newton steps in all
  Progress progress = {};
};

struct ExactFairing {
  Surface spline;
  SurfaceFairness before, after;  // over the knot cells that free points move, integrated adaptively
  FairingSummary summary;         // its energy is the isophote roughness; the gap is not a number: not convex
  double tolerance = 0;           // what was used: less than the given one where all of it made the surface meet itself
};

// Fairs `input`, rational or not; `held` as holdStrips gives it. The result has no larger plate energy, curvature
// variation or roughness than the input, nor a larger mean curvature jump at a knot line that is only C1, and the
// distance of the two at any parameter is at most the tolerance. If less than 1 % can be gained that way the input
// comes back unchanged. A result that meets itself where the input does not (meetingAfterMove) is thrown away: half the
// tolerance is tried, three times, and then the input comes back with StopReason::meetsItself. Invariant under rescaled
// knots and units, to 1e-9 of the tolerance. Throws InvalidInput unless the surface lies in space; or if there is no
// tolerance and no held point. Cost: 5 to 15 steps of one assembly (O((p + 1)^6) a cell) and some sparse
// factorisations, O(n^3) for n x n nets.
ExactFairing fairExactly(const Surface& input, const HeldPoints& held, const ExactFairingOptions& options = {});

}  // namespace strak
