#pragma once
//
// Outliers while a curve or a sheet is drawn (curve_drawing.h, deep_drawing.h): they weigh little and do not enlarge
// the domain.

#include "strak/fitting/least_squares.h"

namespace strak {

// Huber's weights, times the `given` ones (none: all 1), for points at these distances. `parameters`, a row a point and
// a column a direction, of all points are moved into the box of those that count and are no outliers (kOutlier scales).
// Points of weight 0 have no say. If no distance is above zero for most, nothing changes.
Eigen::VectorXd drawingWeights(const Eigen::VectorXd& given, const Eigen::VectorXd& distances, Net& parameters);

}  // namespace strak
