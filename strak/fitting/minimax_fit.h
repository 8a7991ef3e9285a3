#pragma once
//
// Fits whose largest error is least: l-infinity with energy.
//
//   max |z_k - X(u_k)|^2  +  lambda * E(X)  -> min
//
// by Lawson's reweighting: weights of least squares grow where errors are large, until only the largest ones count.
// For any weights with sum 1 the weighted mean square is below the largest square; so the value of every least squares
// fit on the way is a lower bound, and the distance to the best fit is certified.
// Source: Hoschek and Juettler (2.6) on other norms; Lawson, Contributions to the theory of linear least maximum
// approximation (1961).

#include "strak/fitting/least_squares.h"

namespace strak {

template <int D>
struct MinimaxFitOptions {
  FitOptions<D> fit;  // a weight that is to be chosen is chosen for the first fit, by least squares
  int rounds = 1000;
  double gap = 0.02;  // of the objective: the largest error is then within half of it
};

template <int D>
struct MinimaxFit {
  Fit<D> fit;
  double objective = 0;  // as above
  double bound = 0;      // no fit has a smaller objective
  double gap = 0;        // (objective - bound) / objective
  bool converged = false;
  int rounds = 0;
};

// Points in memory; their weights say only which count (above zero) and which do not. Cost: a fit a round. Throws
// InvalidInput as fitLeastSquares does.
template <int D>
MinimaxFit<D> fitMinimax(const std::array<KnotVector, D>& knots, const FitPoints<D>& points,
                         const MinimaxFitOptions<D>& options);

}  // namespace strak
