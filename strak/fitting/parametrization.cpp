#include "strak/fitting/parametrization.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "strak/base/error.h"

namespace strak {

namespace {

// Second moments below this part of the largest are rounding.
constexpr double kLeastMoment = 1e-13;

}  // namespace

Net chordLengthParameters(const Net& points) {
  Net parameters = Net::Zero(points.rows(), 1);
  for (Index r = 1; r < points.rows(); ++r) {
    parameters(r, 0) = parameters(r - 1, 0) + (points.row(r) - points.row(r - 1)).norm();
  }
  if (points.rows() == 0 || !(parameters(points.rows() - 1, 0) > 0)) {
    throw InvalidInput("all points are the same: a curve needs at least two different ones");
  }
  return parameters;
}

Net planeParameters(const Net& points, int plane) {
  if (points.cols() != 3) throw InvalidInput("a sheet needs points with three coordinates");
  if (points.rows() == 0) throw InvalidInput("there are no points to fit");
  if (points.rows() < 3) {
    throw InvalidInput("a surface needs at least three points beside one another, and many more to be of use");
  }
  if (plane < 0 || plane > 2) throw InvalidInput("a cloud has three planes through its axes: 0, 1 and 2");
  const Eigen::RowVector3d mean = points.colwise().mean();
  const Net centred = points.rowwise() - mean;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> moments(centred.transpose() * centred);
  if (!(moments.eigenvalues()[1] > kLeastMoment * moments.eigenvalues()[2])) {
    throw InvalidInput("all points lie on a line: a surface needs points beside it");
  }
  Eigen::Matrix<double, 3, 2> axes;
  for (int k = 0; k < 2; ++k) {
    // The axes in falling order of the extents, without the one that the plane leaves out.
    Eigen::Vector3d axis = moments.eigenvectors().col(k < 2 - plane ? 2 - k : 1 - k);
    // Eigenvectors have no sign of their own: the largest coordinate is to be positive.
    Index largest = 0;
    axis.cwiseAbs().maxCoeff(&largest);
    axes.col(k) = axis[largest] < 0 ? -axis : axis;
  }
  return centred * axes;
}

}  // namespace strak
