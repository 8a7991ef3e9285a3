#pragma once
//
// How far a faired net is from the best one: a certificate for any method's result, or anybody's.

#include "strak/energy/parameter_scale.h"
#include "strak/energy/quadratic_energy.h"
#include "strak/fairing/held_points.h"

namespace strak {

// (E(faired) - E*) / |E(faired)| is at most the returned number, E* the least energy of all nets whose free points lie
// within `tolerance` of those of `input` (infinity: anywhere). The smaller of the Frank-Wolfe and the dual bound
// (ball_minimizer.h); infinity where neither proves anything: no tolerance, and no diagonalisable lower bound of the
// energy or a singular one. Points outside their ball are an error. Cost: one product with the energy's matrix and one
// modal solve, O(N n) for an n x n net; no iteration. Throws InvalidInput if the splines differ in knots, size or a
// held point, or a point lies outside its ball.
template <int D>
double optimalityGap(const Spline<D>& input, const Spline<D>& faired, const QuadraticEnergy<D>& energy,
                     const HeldPoints& held, double tolerance, ParameterScale scale);

}  // namespace strak
