#pragma once
//
// Which control points of a surface the border of a face depends on, and which its visible part.

#include <array>
#include <utility>
#include <vector>

#include "strak/fairing/held_points.h"

namespace strak {

// The border of a face in the parameter plane of its surface, as strak::Object has it.
struct FaceBorder {
  // Every edge of the face as a dense polyline, those along the sides of the domain included; empty for a whole
  // surface.
  std::vector<std::vector<Eigen::Vector2d>> trims;
  // Sides (u low, u high, v low, v high) that are wholly edges of the face.
  std::array<bool, 4> naturalSide{true, true, true, true};
};

// The edges that run along the sides of the domain, wholly or in part: strips suffice for them.
struct SideEdges {
  std::vector<bool> along;                  // for every polyline of the border
  std::array<bool, 4> bordered{};           // sides with such an edge, and natural ones
  std::array<double, 4> stray{0, 0, 0, 0};  // how far those of each side leave it at most, in parameters
};
SideEdges edgesAlongSides(const Surface& surface, const FaceBorder& border);

// The least and the largest coordinate `direction` of the border's edges.
std::pair<double, double> borderExtent(const FaceBorder& border, int direction);

// Holds every control point with influence on a cell of the knot grid that is touched by an edge not `along` a side,
// and every one without influence on the visible part. Holds none for a border without trims.
HeldPoints holdTrimmed(const Surface& surface, const FaceBorder& border, const std::vector<bool>& along);

}  // namespace strak
