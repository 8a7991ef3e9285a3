#pragma once
//
// Whether closed curves of the plane cross themselves or one another.

#include <Eigen/Core>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

// A closed loop: each piece begins where the one before it ends.
using CurveLoop = std::vector<Curve>;

// For each loop whether it is proven to keep clear of itself and of all others (char, not bool: 1 is clear). The
// distance that counts as clear is `clearance`, > 0; pieces are taken apart into polygons this near to them. A loop
// that comes nearer to another, also at a very acute corner, or about which nothing is proven, is not clear.
// Cost: the polygons' corners, sorted into a grid. Throws InvalidInput unless the curves have two coordinates and are
// not rational.
std::vector<char> clearLoops(const std::vector<CurveLoop>& loops, double clearance);

// A polygon along the loop, no farther from it than `flatness`; the last corner joins the first.
std::vector<Eigen::Vector2d> flattened(const CurveLoop& loop, double flatness);

}  // namespace strak
