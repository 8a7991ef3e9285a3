#pragma once
//
// The tolerance on a surface or a curve as balls on linear combinations of control points: the control points of the
// refined difference. They bound the difference from above (convex hull), the closer the finer the knots.
//
// Source: Hadenfeld (12), (13), on refined knots instead of the net itself.

#include <vector>

#include "strak/energy/curve_energy.h"
#include "strak/solve/hull_minimizer.h"
#include "strak/spline/spline.h"

namespace strak {

// How often each span of both directions is halved, in the order of KnotVector::spans().
using SpanLevels = std::array<std::vector<int>, 2>;
SpanLevels evenLevels(const Surface& surface, int level);

// One row for every control point of the refined difference that a free point moves. `unknownOf` as in ShapeEnergy. Of
// a rational surface the difference has the same weights, so its points in space count. Points are unknowns, the rows'
// radius is `tolerance`. Level 0 everywhere gives balls on the control points themselves.
void appendHullRows(const Surface& surface, const std::vector<int>& unknownOf, const SpanLevels& levels,
                    double tolerance, BallRows& rows);

// The same for a curve with `map`'s unknowns; every span halved `level` times.
void appendHullRows(const Curve& curve, const PointMap& map, int level, double tolerance, BallRows& rows);

// The levels with one more halving wherever one of the rows first, ..., last - 1, made by the call above with `levels`,
// has |row x| > share * radius; at most `most`. Returns false if none has.
bool refineActive(const Surface& surface, const std::vector<int>& unknownOf, const BallRows& rows, Index first,
                  const Eigen::VectorXd& x, double share, int most, SpanLevels& levels);

}  // namespace strak
