#pragma once
//
// A fit within a tolerance: knots are inserted where errors are larger, until the wished share of the points is inside,
// and then those removed that the tolerance does not need.
//
// Knot spans are halved whose cells have more points outside than chance would put there; a tensor product has no finer
// place for a knot than a whole line. Source: the plan is Dierckx's, Curve and Surface Fitting with Splines (1993); the
// removal is that of Lyche and Moerken (strak/spline/knot_removal.h), each time fitted anew.

#include "strak/fitting/least_squares.h"

namespace strak {

template <int D>
struct AdaptiveFitOptions {
  FitOptions<D> fit;         // its tolerance is the one that is meant
  double share = 1;          // of the points that shall be inside
  Index mostPoints = 40000;  // control points
  bool removeKnots = true;
};

// A knot cell with points outside.
template <int D>
struct OutsideCell {
  std::array<double, D> from, to;  // in the domain
  Index outside = 0, count = 0;
  double max = 0;
};

template <int D>
struct AdaptiveFit {
  Fit<D> fit;
  bool reached = false;                 // the share is inside
  int rounds = 0;                       // of refinement
  Index inserted = 0, removed = 0;      // knots
  std::vector<OutsideCell<D>> outside;  // the cells with the largest errors, at most 20, the worst first
};

// Starts on `knots` and refines. If the share cannot be reached (the noise is larger than the tolerance, a place has
// too few points to refine for, the limit of control points) the fit with the fewest points outside is returned, with a
// warning. Throws InvalidInput if the tolerance is not positive, the share not in (0, 1], and as fitLeastSquares does.
template <int D>
AdaptiveFit<D> fitWithin(const std::array<KnotVector, D>& knots, Index columns, const PointPass<D>& points,
                         const AdaptiveFitOptions<D>& options);

}  // namespace strak
