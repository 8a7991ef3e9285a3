#pragma once
//
// Curvature combs: teeth along a curve whose lengths show its curvature.

#include <Eigen/Core>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

// Tooth i goes from points[i] to points[i] - scale * curvature[i] * normals[i], away from the centre of curvature. At
// knots where the curvature may jump there are two teeth with the same parameter, one from each side. Where a curve
// stands still (zero derivative) there is no tooth.
struct CurvatureComb {
  std::vector<double> parameters;
  std::vector<Eigen::Vector3d> points;   // a curve of the plane has z = 0
  std::vector<Eigen::Vector3d> normals;  // unit
  std::vector<double> curvature;         // with respect to the normal; 1 / length
};

// The comb of a curve of the plane (normal: the tangent turned left, signed curvature) or of space (principal normal,
// curvature >= 0; on straight parts the normal before). `samplesPerSpan` >= 1 intervals between two knots.
// Throws InvalidInput for other dimensions or fewer samples.
CurvatureComb curvatureComb(const Curve& curve, Index samplesPerSpan = 16);

// The comb of the isoline u = value (direction 0) or v = value (direction 1): the surface's normal and its signed
// normal curvature along the line. Throws InvalidInput unless the surface lies in space and `value` is inside the
// domain.
CurvatureComb curvatureComb(const Surface& surface, int direction, double value, Index samplesPerSpan = 16);

// The scale at which the longest tooth of the combs has the given length; 0 if all are straight.
double combScale(const std::vector<CurvatureComb>& combs, double longestTooth);

}  // namespace strak
