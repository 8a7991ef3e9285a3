#pragma once
//
// Knot removal: a spline near the given one on fewer knots, with a bound of the distance.
//
// The new control points c are the best for the discrete norm |R c - d|, where R refines to the old knots and d are the
// old control points. Because the basis functions are non-negative with sum 1, no point moves further than the longest
// row of R c - d. Source: Lyche, Moerken, "Knot removal for parametric B-spline curves and surfaces" (1987).

#include "strak/spline/spline.h"

namespace strak {

template <int D>
struct KnotRemoval {
  Spline<D> spline;
  double bound = 0;             // |old(u) - new(u)| <= bound for every u of the domain, up to rounding
  std::vector<double> removed;  // ascending, each as often as it was removed
};

// Removes the named inner knots of one direction, each as often as it is named; what was representable without them
// stays as it is (bound at rounding level). At a clamped end the end point, the border curve of a surface, stays to the
// bit. Rational splines are treated in homogeneous space; the bound is that in space. Throws InvalidInput if a knot is
// not an inner one or not there often enough; Failure if a weight would not stay positive. Cost O(size degree^2) plus
// O(degree) a point.
template <int D>
KnotRemoval<D> removeKnots(const Spline<D>& spline, int direction, const std::vector<double>& knots);

// Removes as many inner knots of one direction as it finds while the bound stays <= tolerance: the knots whose own
// removal costs least first, as many together as the tolerance lets pass. Tolerance 0 removes nothing but what costs
// nothing even in rounding: give a small one to undo insertions. Throws InvalidInput if the tolerance is negative or
// not a number. Cost: that of removeKnots some tens of times.
template <int D>
KnotRemoval<D> removeKnotsWithin(const Spline<D>& spline, int direction, double tolerance);

// How far the removal of one copy of each inner knot alone would move the farthest control point in homogeneous space:
// the part of the net orthogonal to the splines without that knot. Ascending by the cost. Cost O(size degree) a line.
struct KnotCost {
  double cost;
  double knot;
};
template <int D>
std::vector<KnotCost> knotRemovalCosts(const Spline<D>& spline, int direction);

}  // namespace strak
