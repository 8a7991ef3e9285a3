#pragma once
//
// Points of files that are read as a whole: the vertices of meshes (OBJ, STL in text or binary form, OFF), compressed
// point clouds (PCD binary_compressed, .g2), airfoils in Lednicer's order, heights on grids (USGS DEM, .gtx),
// interferograms (MetroPro .dat) and corneal topographies (rings of radii and elevations).

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

struct ImportedPoints {
  Net points;
  std::vector<std::string> names;  // of the columns
};

// The points of a file that is of one of these kinds, by its ending or the beginning `head` (64 kB) of its contents;
// nothing if it is of none. Vertices that a mesh repeats to the bit (STL does, for each triangle) come once. Missing
// heights (DEM -32767, gtx -88.8888) and points that are not finite are left out. Throws InvalidInput, without the
// file's name, for damaged files.
std::optional<ImportedPoints> importPoints(const std::filesystem::path& path, std::string_view head);

}  // namespace strak
