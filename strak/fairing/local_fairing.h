#pragma once
//
// Local energy fairing: one control point at a time moves to where a quadratic energy is least, always the point that
// gains most, inside a ball around its original place. Converges to the constrained minimum of the energy, which
// optimal_fairing.h finds at once; this way one can watch, stop early, and change only what gains most.
//
// Source: Hadenfeld, "Local Energy Fairing of B-Spline Surfaces", sections 2-7; ranking number as in Hoschek and
// Juettler (5.9), because (6) stalls at points on their ball.

#include "strak/base/progress.h"
#include "strak/energy/parameter_scale.h"
#include "strak/energy/quadratic_energy.h"
#include "strak/fairing/faired.h"
#include "strak/fairing/held_points.h"

namespace strak {

// By which number the next point is chosen.
enum class RankingNumber {
  gain,     // (5.9): what the energy really loses, the ball included; always progresses
  literal,  // (6), (11) as printed: what it would lose without the ball. For study: a point on its ball may stay first
            // for ever (the paper's hang-up), and a cap on the changes per point then ends short of the minimum
};

struct LocalFairingOptions {
  double tolerance = kUnlimited;     // radius of each point's ball (13), in the model's unit
  HeldPoints held;                   // points that stay where they are, to the bit; default: none
  double gap = 1e-6;                 // stop once (E - E*) / E is certified to be at most this
  double minGain = 0;                // stop once the largest ranking number is at most this; in the energy's own unit
  Index maxSteps = kUnlimitedSteps;  // point moves
  Index maxChangesPerPoint = kUnlimitedSteps;  // a point moved so often leaves the list (section 7)
  RankingNumber ranking = RankingNumber::gain;
  Index pointsPerList = 1;  // points moved, each to its fresh target, before the list is sorted again
  ParameterScale scale = ParameterScale::lengths;
  Progress progress;  // told the certified gap; may cancel
};

// Fairs `input` with respect to `energy` and returns the new spline with what happened on the way.
// Any degree, knots and number of parameter directions; points of any dimension (one ball radius for all); the
// homogeneous points of a rational spline are treated as plain points. The energy falls with every step, so that a run
// stopped early returns the best net so far. Control points whose basis function vanishes on the whole domain are left
// alone.
//
// The gap is certified by the gradient that the method holds anyway (Frank and Wolfe's bound) and, from 8 moves a free
// point on, by the dual bound of ball_minimizer.h. For energies of which that knows no lower bound (the laplacian and
// others with cross terms where few rows are held) one sparse factor serves instead, for up to 10,000 free points of a
// surface and 1,000 of a volume. Where all of this says nothing, the gap is `infinity`: not certified.
//
// Stops: gap, gain (minGain), steps, cancelled, precision (moves below the rounding of the coordinates), stalled
// (literal ranking without cap only: the list's first points do not move any more), nothingFree. Cost: O((2p+1)^D) per
// step after one O(n (2p+1)) pass; memory O(n). One thread. Throws InvalidInput if `energy` does not see a free point
// (its weight is zero), an option is negative or not a number, or the list of held points has not one entry a control
// point.
template <int D>
Faired<D> fairLocally(const Spline<D>& input, const QuadraticEnergy<D>& energy,
                      const LocalFairingOptions& options = {});

}  // namespace strak
