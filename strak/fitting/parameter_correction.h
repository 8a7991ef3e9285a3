#pragma once
//
// Parameter correction: the parameters of points in space become those of their closest points on the fit, then the fit
// is made anew, until neither changes. The errors are distances then.
//
// Source: Hoschek and Juettler (5.12), (5.13) as corrected by the errata: full Newton with the second derivatives, and
// conditions of sign at the edges of the domain (strak/metrology/closest_points.h).

#include "strak/fitting/least_squares.h"

namespace strak {

struct CorrectionOptions {
  int rounds = 20;
  // Settled when a round lowers the root mean square by less than this part.
  double settled = 1e-3;
  Progress progress;
};

template <int D>
struct CorrectedFit {
  Fit<D> fit;
  Net parameters;           // of the points, on the fit
  int rounds = 0;           // of correction
  std::vector<double> rms;  // of the first fit and of every round
  bool settled = false;     // or the rounds were used up
};

// Makes a fit of the given parameters; `previous` is that of the round before, null at first.
template <int D>
using FitMaker = std::function<Fit<D>(const FitPoints<D>& points, const Fit<D>* previous)>;

// Fits points in space again and again by `make`. The parameters stay in the domain of the fit. A round that makes the
// errors larger ends the search and is forgotten. Cost a round: one fit and 0.3 microseconds a point. Throws
// InvalidInput for functions (their points have the parameters they have) and as `make` does.
template <int D>
CorrectedFit<D> fitWithCorrection(const FitPoints<D>& points, const FitMaker<D>& make,
                                  const CorrectionOptions& options = {});

}  // namespace strak
