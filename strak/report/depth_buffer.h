#pragma once
//
// Which parts of a drawing are behind something else.

#include <array>
#include <cstdint>
#include <vector>

#include "strak/report/camera.h"

namespace strak {

// The nearest depth at each of a fine raster of points of the picture (two by two a pixel).
class DepthBuffer {
 public:
  DepthBuffer(int width, int height);

  // Corners as the camera projects them.
  void add(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

  // Whether a projected point is in front of everything, up to `slack` pixels of depth and half a pixel sideways: a
  // line on a surface is not hidden by that surface.
  bool visible(const Eigen::Vector3d& point, double slack = 0.75) const;

 private:
  int width_, height_;
  std::vector<float> depth_;
};

// The visible pieces of a projected polyline as lines in the picture; ends are found to a hundredth of a pixel. Pieces
// and gaps of less than a pixel are errors of the raster and vanish.
std::vector<std::vector<Eigen::Vector2d>> visiblePieces(const std::vector<Eigen::Vector3d>& line,
                                                        const DepthBuffer& buffer);

}  // namespace strak
