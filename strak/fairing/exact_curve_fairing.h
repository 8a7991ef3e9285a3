#pragma once
//
// Fairing of curves by what the eye sees: the exact curvature variation int (dk/ds)^2 ds and bending energy int k^2 ds,
// minimised inside a certified tolerance; on request with no more than a given number of curvature extrema.
//
// Source: Moreton and Sequin, "Functional optimization for fair surface design" (1992) for the functional; the
// tolerance is Hadenfeld's (12), kept on the refined difference instead of (13), which wastes a quarter to a half of
// it.

#include "strak/base/progress.h"
#include "strak/fairing/faired.h"
#include "strak/fairing/held_points.h"
#include "strak/metrology/curvature_extrema.h"
#include "strak/metrology/deviation.h"

namespace strak {

struct ExactCurveFairingOptions {
  double tolerance = kUnlimited;  // no point moves further, parameter by parameter; model units
  HeldPoints held;                // control points that stay to the bit
  int seamContinuity = -1;        // closed curves: how many derivatives agree at the seam and shall go on to (-1: open)
  Index maxExtrema = -1;          // curvature extrema wished at most; negative: no wish
  Index maxSteps = 60;            // Gauss-Newton steps, for each wish anew
  bool ballsOnPoints = false;     // no control point moves further than the tolerance, instead of no point of the curve
  bool leaveFair = true;          // a curve that is fair already is returned as it is, see below
  Progress progress;
};

struct CurveFigures {
  double length = 0, bending = 0, curvatureVariation = 0;  // of curveFairness
  Index extrema = 0;                                       // of curvatureProfile
};

struct ExactCurveFairing {
  Curve spline;
  // energy: curvature variation; gap: infinite, the problem is not convex; steps: Gauss-Newton steps. Stop reasons:
  // gain (converged), steps, cancelled, precision, nothingFree, meetsItself.
  FairingSummary summary;
  CurveFigures before, after;
  Deviation<1> deviation;
  bool alreadyFair = false;    // left as it was: nothing to gain inside the tolerance
  bool extremaReached = true;  // no more than maxExtrema extrema; false: the fewest found are in `after`
};

// Fairs a curve of the plane or of space, polynomial or rational (weights stay). Planar curves in space stay in their
// plane. Guarded: the result has no larger bending energy or curvature variation, no more curvature extrema than the
// input (rounding and the threshold of counting aside), and its certified deviation is within the tolerance; where no
// step keeps all of that the input comes back, and so it does where the result meets itself and the input does not
// (meetingAfterMove). With `leaveFair` a curve also comes back as it is if fairing neither
// removes a curvature extremum nor brings its curvature variation below a fifth: then it would only be reshaped, a nose
// made rounder.
// Knots of multiplicity `degree` are corners: hold their neighbours (plan_curve.h does).
//
// With `maxExtrema` the sign of dk/ds is prescribed on the stretches between the most significant extrema, by a penalty
// that grows until it holds; then fewer stretches are tried until the wish or the tolerance's limit is reached.
//
// Method: damped Gauss-Newton steps on log variation + theta log bending (no units, no weights to choose) with full
// displacement vectors, a small term that keeps the parameter speed as even as it was, and the control points of the
// difference, its spans halved twice, in balls; each step is a convex problem (hull_minimizer.h). The result does not
// depend on the scale of knots and units or on the place. Cost: some tens of steps of O(n p^3); 120 points 20 ms, 1400
// points 0.3 s; a wish for few extrema up to 45 times as much. Throws InvalidInput for other dimensions, degree 1, a
// negative tolerance, a curve that stands still somewhere, wrong lengths of lists, and without a tolerance unless
// points at both ends are held.
ExactCurveFairing fairCurveExactly(const Curve& curve, const ExactCurveFairingOptions& options = {});

}  // namespace strak
