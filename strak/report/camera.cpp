#include "strak/report/camera.h"

#include <limits>

#include "strak/base/error.h"

namespace strak {

Camera::Camera(const Eigen::Vector3d& view, const std::optional<Eigen::Vector3d>& up,
               const std::vector<Eigen::Vector3d>& points, double width, double height, double margin) {
  const double length = view.stableNorm();
  if (!(length > 0 && std::isfinite(length)))
    throw InvalidInput("The view direction is zero or not finite: give a vector from the model to the eye");
  if (up && !(up->stableNorm() > 0 && std::isfinite(up->stableNorm())))
    throw InvalidInput("The upright direction is zero or not finite: give another vector");
  const Eigen::Vector3d eye = view / length;
  Eigen::Vector3d upright = up ? Eigen::Vector3d(up->stableNormalized()) : Eigen::Vector3d::UnitZ();
  if (upright.cross(eye).norm() < 1e-6) upright = Eigen::Vector3d::UnitZ();
  if (upright.cross(eye).norm() < 1e-6) upright = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d right = upright.cross(eye).normalized();
  axes_ << right.transpose(), -eye.cross(right).transpose(), eye.transpose();

  origin_ = points.empty() ? Eigen::Vector3d::Zero() : points.front();
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) box.extend(Eigen::Vector3d(axes_ * (p - origin_)));
  if (box.isEmpty()) box.extend(Eigen::Vector3d::Zero().eval());
  const Eigen::Vector3d size = box.sizes();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const double across = std::max(width - 2 * margin, 1.0), down = std::max(height - 2 * margin, 1.0);
  const double fit = std::min(size.x() > 0 ? across / size.x() : infinity, size.y() > 0 ? down / size.y() : infinity);
  scale_ = fit < infinity ? fit : 1;
  centre_ = Eigen::Vector3d(width / 2, height / 2, 0) - scale_ * box.center();
}

}  // namespace strak
