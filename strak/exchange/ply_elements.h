#pragma once
//
// PLY files whose vertices are not records of one length in the first place: they have lists among their properties, or
// other elements come first. Such files are read as a whole; others by cloud_layout.h.

#include <string>
#include <string_view>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

struct PlyVertices {
  Net points;                      // the numbers of each vertex that are no lists
  std::vector<std::string> names;  // of the columns
};

// Whether `head`, the beginning of a file, is the header of such a PLY file.
bool isIrregularPly(std::string_view head);

// The vertices of such a file; those that are not finite are left out. Throws InvalidInput, without the file's name,
// for a damaged file and for types that are not understood.
PlyVertices irregularPlyVertices(std::string_view bytes);

}  // namespace strak
