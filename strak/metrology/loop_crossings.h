#pragma once
//
// Whether closed curves of the plane cross themselves or one another.

#include <Eigen/Core>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

// A closed loop: each piece begins where the one before it ends.
using CurveLoop = std::vector<Curve>;

// Where a piece of a loop is not proven to keep clear.
struct NearPlace {
  std::size_t piece = 0;
  Eigen::Vector2d place;
};

// For each loop the places where it does not keep clear of itself and of the others, or is not proven to; none if it is
// clear. The distance that counts as clear is `clearance`, > 0; pieces are taken apart into polygons this near to them.
// Very acute corners are not clear either. Cost: the polygons' corners, sorted into a grid. Throws InvalidInput unless
// the curves have two coordinates and are not rational.
std::vector<std::vector<NearPlace>> placesNotClear(const std::vector<CurveLoop>& loops, double clearance);

// A polygon along the loop, no farther from it than `flatness`; the last corner joins the first.
std::vector<Eigen::Vector2d> flattened(const CurveLoop& loop, double flatness);

}  // namespace strak
