#pragma once
//
// The edges of a face in the parameter plane of its surface. Only for the *_occ.cpp files.

#include <TopoDS_Face.hxx>

#include "strak/exchange/model.h"

namespace strak::cad {

struct Border {
  std::vector<std::vector<Eigen::Vector2d>> trims;  // all edges; empty if they run along the sides only
  std::array<bool, 4> naturalSide{false, false, false, false};
  std::string missing;  // why the border is not known (a clause); empty if it is
};

// `surface` is the spline under the face, in the face's own parameters.
Border borderOf(const TopoDS_Face& face, const Surface& surface);

}  // namespace strak::cad
