#pragma once
//
// A surface of which only a part is seen, written as faces with trimming curves.

#include <filesystem>
#include <string>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

// Curves in the parameter plane (u, v), not rational and at least C1, each beginning where the one before it ends; the
// last ends where the first begins. The surface that is seen lies to the left.
using TrimLoop = std::vector<Curve>;

// One face: an outer loop and the holes in it.
struct TrimmedPart {
  TrimLoop outer;
  std::vector<TrimLoop> holes;
};

// Whether files with this ending hold trimmed faces: STEP, IGES and BREP do. Throws InvalidInput for an unknown ending.
bool holdsTrimming(const std::filesystem::path& path);

// Writes a face for each part, all on the same surface, named `name`, "`name` 2", ... Edges get a curve in space made
// from the trimming curve, at most 1e-9 of the size of the surface beside its image. Beside, then renamed. Throws
// InvalidInput if the format holds no trimming, the library was not enabled (strak/exchange/cad.h), or loops are open
// or leave the domain; Failure if the kernel's checker does not accept the faces.
void writeTrimmed(const std::filesystem::path& path, const Surface& surface, const std::vector<TrimmedPart>& parts,
                  const std::string& name, const std::string& unit = "");

}  // namespace strak
