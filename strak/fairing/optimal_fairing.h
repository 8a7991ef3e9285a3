#pragma once
//
// Optimal fairing: the least quadratic energy that any net within the tolerance can have, found at once and certified.
//
// It is the limit that local fairing (local_fairing.h) converges to: minimise E(d) = sum K_pq d_p . d_q over the free
// control points under |d_p - d0_p| <= tolerance (Hadenfeld (13)). Convex, so the limit is unique in energy; the result
// comes with an upper bound of its distance to it.

#include "strak/base/progress.h"
#include "strak/energy/parameter_scale.h"
#include "strak/energy/quadratic_energy.h"
#include "strak/fairing/faired.h"
#include "strak/fairing/held_points.h"

namespace strak {

struct OptimalFairingOptions {
  double tolerance = kUnlimited;  // radius of each control point's ball, in the model's unit
  HeldPoints held;                // points that stay where they are, to the bit; default: none
  double gap = 1e-6;              // stop once (E - E*) / E is certified to be at most this
  ParameterScale scale = ParameterScale::lengths;
  Index maxIterations = kUnlimitedSteps;
  Progress progress;
};

// Fairs `input` with respect to `energy`. Any degree, knots, number of directions and dimension of the points; a
// rational spline's homogeneous points are treated as plain points. Cost without tolerance: some ten conjugate-gradient
// steps at any size; with tolerance: accelerated projected gradients, some 10 n steps for an n x n net, O(N p) each.
// Memory O(N). One thread. Throws InvalidInput if the tolerance or the gap is negative or NaN, or if there is no
// tolerance and the held points leave a motion free that the energy does not see (the message says how many rows to
// hold).
template <int D>
Faired<D> fairOptimally(const Spline<D>& input, const QuadraticEnergy<D>& energy,
                        const OptimalFairingOptions& options = {});

}  // namespace strak
