#pragma once
//
// The ball problem by alternating directions (ADMM): for stiff energies on long thin or uneven nets, where projected
// gradients crawl. Every step solves with a sparse factor of K + rho W, W the diagonal of K.

#include "strak/solve/ball_minimizer.h"

namespace strak {

// Beyond this many points the factor costs more than the steps it saves.
inline constexpr Eigen::Index kMaxFactoredPoints = 40000;

// Starts from `e` (within the radius, zero at held points) and returns a field there that is no worse. The penalty rho
// balances both residuals and is found on the way. The bound is the dual one of minimizeInBalls with the exact inverse
// of K + Lambda, so that it needs no lower bound P and holds for singular K too. Memory and cost are those of a sparse
// Cholesky factor: about 30 N^1.2 numbers for bicubic nets.
BallResult minimizeByAlternatingDirections(const BallProblem& problem, const BallOptions& options, Field& e);

}  // namespace strak
