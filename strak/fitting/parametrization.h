#pragma once
//
// First parameters for points in space that come without.

#include "strak/spline/spline.h"

namespace strak {

// Of points along a curve, in their order: the length of the polygon up to each of them; one column. Equal neighbours
// get equal parameters. Throws InvalidInput if all points are the same.
Net chordLengthParameters(const Net& points);

// Of points of a sheet: their coordinates in the plane of least squares, along the directions of the largest and the
// second largest extent; two columns. `plane`: 0 for that plane, 1 or 2 for the plane that leaves out the direction of
// the second largest or of the largest extent instead (a cloud bent beyond a half circle may need it). Source: Hoschek
// and Juettler, section 5 (Dietz). Throws InvalidInput unless there are three columns, and if the points lie on a line.
Net planeParameters(const Net& points, int plane = 0);

}  // namespace strak
