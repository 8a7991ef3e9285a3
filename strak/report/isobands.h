#pragma once
//
// Filled regions between the contour lines of a function on a mesh, as seen in a picture.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "strak/report/depth_buffer.h"

namespace strak {

// A mesh as the camera projects it, with a value at each corner (linear on triangles).
struct PictureMesh {
  std::vector<Eigen::Vector3d> corners;
  std::vector<double> values;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

// SVG path data (to be filled with the even-odd rule) of the visible part of each of the levels.size() + 1 bands that
// the ascending levels cut the values into; empty where nothing of a band is seen. Pieces of a band that touch are one
// polygon, so the paths are as short as their outlines.
std::vector<std::string> visibleBands(PictureMesh mesh, const std::vector<double>& levels, const DepthBuffer& buffer);

}  // namespace strak
