#pragma once
//
// Trimmed faces for Open CASCADE. Only for the *_occ.cpp files.

#include <TopoDS_Face.hxx>

#include "strak/exchange/trimmed_surface.h"

namespace strak::cad {

// The faces of the parts, on one surface. Throws InvalidInput for loops that are open or leave the domain, Failure if
// the kernel's checker does not accept a face.
std::vector<TopoDS_Face> trimmedFaces(const Surface& surface, const std::vector<TrimmedPart>& parts, double unitLength);

}  // namespace strak::cad
