#pragma once
//
// How far measured points are from curves and surfaces, with a sign.

#include "strak/metrology/trim_region.h"

namespace strak {

// Whether the spline is the graph of a function, as fits of functions are written: its first D coordinates are the
// parameters themselves (1e-9 of the domain's length).
template <int D>
bool isGraph(const Spline<D>& spline);

struct PointDeviation {
  Eigen::VectorXd values;  // of each point; not a number where there is none
  Net feet;                // the spline's points that they are measured from
  Net parameters;          // of the feet
  Index missed = 0;        // points without a value
};

// Takes the values of the points whose feet the trims of a surface leave away: what it was drawn from has no more to
// say there. Points straddle a border, so some next to it go, too.
void leaveOutTrimmed(const TrimRegion& region, PointDeviation& deviation);

// The point's height minus the graph's there; points beyond the domain have none. Throws InvalidInput if the spline is
// no graph or the points have other columns.
template <int D>
PointDeviation heightDeviation(const Spline<D>& graph, const Eigen::Ref<const Net>& points);

// The distance to the closest point of the spline: positive on the side of the normal (surfaces: X_u x X_v; curves of
// the plane: the left), without a sign from curves in space. Points beyond an edge are measured from the edge. Throws
// InvalidInput if the points have other columns or are not finite.
template <int D>
PointDeviation normalDeviation(const Spline<D>& spline, const Eigen::Ref<const Net>& points);

}  // namespace strak
