#pragma once
//
// Triangles for pictures: a trimmed parameter domain cut into triangles, and a surface sampled at their corners.

#include <array>
#include <cstdint>
#include <vector>

#include "strak/metrology/trim_region.h"

namespace strak {

// Triangles in the parameter plane; surfaces on the same domain (before and after) can be sampled on one such mesh.
struct ParameterMesh {
  std::vector<Eigen::Vector2d> parameters;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise in (u, v)
};

// A mesh of the region with about `vertices` grid points: every knot line is a mesh line where that budget allows, and
// cells are as square in space as it allows. Knots where the curvature may jump are doubled, 1e-7 of the domain apart,
// so that each side is sampled for itself. Cells at the trims are cut exactly (trapezoids), so borders are clean.
ParameterMesh meshDomain(const Surface& surface, const TrimRegion& region, Index vertices);

// Point, unit normal X_u x X_v / |.| and curvatures at parameters. Where the normal does not exist (collapsed edges) it
// is taken a little inside.
struct SurfaceSamples {
  std::vector<Eigen::Vector3d> points, normals;
  std::vector<double> gaussian, mean;
};
SurfaceSamples sampleSurface(const Surface& surface, const std::vector<Eigen::Vector2d>& parameters);

}  // namespace strak
