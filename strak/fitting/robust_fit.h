#pragma once
//
// Fits that outliers do not move: Huber's and Tukey's losses with a robust scale, and l1.
//
// The mean of w s^2 rho(r) takes the place of the mean square (strak/fitting/loss.h),
// so that lambda keeps its meaning. Minimised by iteratively reweighted least squares. For l1 a dual solution comes
// with every step and bounds how far the fit is from the best one. Source: Hoschek and Juettler (2.6) on other norms.
// For vector errors the norm is the Euclidean one, as the errata ask.

#include "strak/fitting/least_squares.h"
#include "strak/fitting/loss.h"

namespace strak {

template <int D>
struct RobustFitOptions {
  FitOptions<D> fit;  // with its smoothing; a weight that is to be chosen is chosen without the outliers
  Loss loss = Loss::huber;
  double scale = 0;       // of the noise; 0: from the median of the errors
  Eigen::VectorXd first;  // weights of the first fit, like 0 for likely outliers; empty: all 1
  int rounds = 1000;
  double gap = 1e-3;  // l1: stop when the objective is certified to be this near to the least one, relatively
};

template <int D>
struct RobustFit {
  Fit<D> fit;            // its rms and max are those of all points, outliers too
  double scale = 0;      // s
  double lambda = 0;     // as above: against the mean of w s^2 rho
  double objective = 0;  // mean of w s^2 rho + lambda E
  double gap = 0;        // l1: (objective - lower bound) / objective; else the last relative change of the objective
  bool converged = false;
  int rounds = 0;
  Index outliers = 0;       // points farther off than 4.685 s
  Eigen::VectorXd weights;  // of the last least squares, 1 where the error is small
};

// Points in memory. Cost: some ten to a hundred fits. Throws InvalidInput as fitLeastSquares, and for a negative scale.
template <int D>
RobustFit<D> fitRobustly(const std::array<KnotVector, D>& knots, const FitPoints<D>& points,
                         const RobustFitOptions<D>& options);

}  // namespace strak
