#pragma once
//
// The convex problem behind fairing: minimise q(e) = e . K e + 2 g . e over point fields e, e = 0 at held points and,
// if there is a radius, |e_r| <= radius at every point r. Solved to a certified gap.

#include "strak/base/progress.h"
#include "strak/solve/modal_solver.h"

namespace strak {

struct BallProblem {
  KroneckerOperator* energy = nullptr;       // K, symmetric positive semidefinite
  const Field* linear = nullptr;             // g; its values at held points do not matter
  const Field* free = nullptr;               // scalar field: 1 at free points, 0 at held ones and in the padding
  std::vector<KroneckerProduct> products;    // the terms of K ...
  std::vector<KroneckerProduct> lowerBound;  // ... and a sum P <= K that the basis diagonalises; empty if none is known
  KroneckerProduct massProduct;              // the mass matrices of all directions
  const ModalBasis* basis = nullptr;
  double radius = 0;  // infinity: none
  double scale = 0;   // the gap is measured against scale + q (the whole energy)
  double noise = 0;   // a bound below this is rounding: the search ends there too
};

struct BallOptions {
  double gap = 1e-6;
  Eigen::Index maxIterations = 0;
  Progress progress;
};

struct BallResult {
  // unproven: nothing was done, because no lower bound P > 0 is known
  enum class Stop { gap, iterations, cancelled, precision, unproven };
  double value = 0;  // q(e)
  double bound = 0;  // q(e) - min q <= bound, proven (up to rounding)
  Eigen::Index iterations = 0;
  Stop stop = Stop::gap;
};

// Without a radius: conjugate gradients on K e = -g, preconditioned by the modal solver; the bound is r . P^-1 r.
// Stops at once as `unproven` if P is missing or singular (condition indicator below 1e-13).
BallResult minimizeFreely(const BallProblem& problem, const BallOptions& options, Field& e);

// With a radius: accelerated projected gradients (Nesterov's, metric = diagonal of K, restarted when the step turns
// against the gradient). The bound is the smaller of
//   Frank-Wolfe:  sum_r 2 (h_r . e_r + radius |h_r|),  h = K e + g, and the
//   dual bound:   sum_r lambda_r (radius^2 - |e_r|^2) + r . (K + Lambda)^-1 r,  r = h + Lambda e, any lambda >= 0,
// where the inverse is solved for approximately and its remainder bounded by P^-1. Where that does not reach the gap
// soon and the box is small enough for a sparse factor, alternating directions take over (alternating_directions.h).
BallResult minimizeInBalls(const BallProblem& problem, const BallOptions& options, Field& e);

// The value and the bound at a given field, without moving it: infinite where nothing is proven. e must be zero at held
// points and within the radius.
BallResult boundAt(const BallProblem& problem, const Field& e);

}  // namespace strak
