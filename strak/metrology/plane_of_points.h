#pragma once
//
// The plane in which points of space lie, if they lie in one.

#include <Eigen/Geometry>
#include <optional>

#include "strak/spline/spline.h"

namespace strak {

struct PointPlane {
  Eigen::Vector3d origin;            // the mean of the points
  Eigen::Matrix<double, 2, 3> axes;  // orthonormal rows
  Eigen::Vector3d normal() const { return axes.row(0).cross(axes.row(1)).transpose(); }
};

// The least-squares plane of the rows of `points` (three columns), or nothing if a point is farther from it than
// `relativeTolerance` times the diagonal of their box. Points on one line lie in many planes: any of them is given.
// Throws InvalidInput for another number of columns or no points.
std::optional<PointPlane> planeOfPoints(const Net& points, double relativeTolerance = 1e-9);

}  // namespace strak
