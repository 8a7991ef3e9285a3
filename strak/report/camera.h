#pragma once
//
// Parallel projection to a picture.

#include <Eigen/Geometry>
#include <optional>
#include <vector>

namespace strak {

// Maps points of space to pixels: x to the right, y downwards, and a depth in pixels that grows towards the eye.
class Camera {
 public:
  // `view` points from the model to the eye; `up` is upright in the picture (where it is along the view: z, then y).
  // The points fill the picture up to `margin` pixels. Throws InvalidInput if a direction is zero or not finite.
  Camera(const Eigen::Vector3d& view, const std::optional<Eigen::Vector3d>& up,
         const std::vector<Eigen::Vector3d>& points, double width, double height, double margin);

  Eigen::Vector3d project(const Eigen::Vector3d& point) const { return scale_ * (axes_ * (point - origin_)) + centre_; }

  Eigen::Vector3d right() const { return axes_.row(0); }
  Eigen::Vector3d up() const { return -axes_.row(1); }
  Eigen::Vector3d view() const { return axes_.row(2); }
  double scale() const { return scale_; }  // pixels per model unit

 private:
  Eigen::Matrix3d axes_;  // rows: right, down, to the eye
  Eigen::Vector3d origin_, centre_;
  double scale_ = 1;
};

}  // namespace strak
