#pragma once
//
// Fairing by the data-dependent energy (beltrami_energy.h): the surface that bends least in the inner geometry of the
// one before, again and again, inside a tolerance. Every step is a convex quadratic problem, whose energy, unlike those
// in the parameters, depends on the surfaces alone.
//
// What it is not: a way to the least int H^2. Where the steps come to rest, Delta Delta X = 0 in the surface's own
// geometry, which is not the condition of Willmore's surfaces; and curvature variation is not in it at all. Hence the
// guard. Source: Greiner (1994), Hoschek and Juettler, sections 3 and 5; the inner problem as in exact_fairing.h.

#include "strak/base/progress.h"
#include "strak/fairing/faired.h"
#include "strak/fairing/held_points.h"
#include "strak/metrology/fairness.h"

namespace strak {

struct DataDependentFairingOptions {
  double tolerance = kUnlimited;  // of the surface, model units; certified by the refined difference
  bool ballsOnPoints = false;     // bound the control points' moves instead, as (13) does
  // The first reference: the least metric energy (shape_energy.h) within the tolerance, if that bends less than the
  // input, or always the input. In the geometry of a noisy surface the noise of its parameters costs nothing.
  bool evenStart = true;
  int maxSteps = 40;  // quadratic problems solved
  Progress progress = {};
};

struct DataDependentFairing {
  Surface spline;
  SurfaceFairness before, after;  // over the knot cells that free points move, integrated adaptively
  FairingSummary summary;         // its energy is int 4 H^2; the gap is not a number: not convex
  int takenBack = 0;              // the last steps, where they made one of these figures larger
};

// Fairs `input`, rational or not; `held` as holdStrips gives it. The steps end where int 4 H^2 falls by less than
// 0.3 %. The result is the last of them whose energy, bending, curvature variation and roughness are not larger
// than the input's, nor the jumps of the curvature at knot lines that are only C1, taken together; if there is none,
// half or a quarter of the first one, or the input itself. The distance of the two at any parameter is at most the
// tolerance. Throws InvalidInput unless the surface lies in space; or if there is no tolerance and no held point. Cost:
// 2 to 8 steps of one assembly (O((p + 1)^6) a cell) and some 5 to 15 sparse factorisations, O(n^3) for n x n nets.
DataDependentFairing fairDataDependently(const Surface& input, const HeldPoints& held,
                                         const DataDependentFairingOptions& options = {});

}  // namespace strak
