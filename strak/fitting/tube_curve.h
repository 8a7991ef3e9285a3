#pragma once
//
// Fair curves of the plane near points in their order: open ones between two given ends, and closed ones.
//
// A cubic spline of least squares with the energy of bending. Points that are too far away get more weight, the others
// keep theirs, so that the curve is as stiff everywhere as the points there allow (an active set by reweighting); where
// weights do not help there are too few knots: spans with a bad point are halved between their points. In the end every
// span has one point, which is the interpolating spline, so that any tolerance is kept that rounding lets keep.
// Source: Reinsch, "Smoothing by spline functions" (1967), with a bound for each point in place of one for the sum.

#include <Eigen/Geometry>

#include "strak/spline/spline.h"

namespace strak {

struct TubeLimits {
  double tolerance = 0;  // of every point
  double noise = 0;      // root mean square of all
};

// From `from` to `to`, to the bit, near the rows of `between`; parameters are lengths along the points, from 0 to 1.
// Control points stay inside the domain unless that is empty. Clamped, simple inner knots. Where the limits cannot be
// kept (the domain forbids it, corners sharper than rounding sees) the nearest curve found. No points: a line. Cost:
// some ten to a hundred sparse factors. Throws Failure if rounding leaves no curve at all.
Curve tubeBetween(const Eigen::Vector2d& from, const Net& between, const Eigen::Vector2d& to, const TubeLimits& limits,
                  const Eigen::AlignedBox2d& domain);

// Closed, with continuous curvature, beginning near the first row; otherwise as above. At least three points.
Curve tubeAround(const Net& points, const TubeLimits& limits, const Eigen::AlignedBox2d& domain);

}  // namespace strak
