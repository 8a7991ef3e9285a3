#include "strak/metrology/plane_of_points.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>

#include "strak/base/error.h"

namespace strak {

std::optional<PointPlane> planeOfPoints(const Net& points, double relativeTolerance) {
  if (points.cols() != 3 || points.rows() == 0) {
    throw InvalidInput("a plane is sought for points of space: give at least one row of three numbers");
  }
  PointPlane plane;
  plane.origin = points.colwise().mean().transpose();
  const double size = (points.colwise().maxCoeff() - points.colwise().minCoeff()).stableNorm();
  plane.axes << 1, 0, 0, 0, 1, 0;
  if (!(size > 0)) return plane;
  // Scaled to the size, or squares of very small or large coordinates would be lost.
  const Net centred = (points.rowwise() - plane.origin.transpose()) / size;
  const Eigen::Matrix3d moments = centred.transpose() * centred;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moments);
  plane.axes.row(0) = solver.eigenvectors().col(2).transpose();
  plane.axes.row(1) = solver.eigenvectors().col(1).transpose();
  const Eigen::VectorXd distances = centred * plane.normal();
  if (!(distances.cwiseAbs().maxCoeff() <= relativeTolerance)) return std::nullopt;
  return plane;
}

}  // namespace strak
