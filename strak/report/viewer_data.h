#pragma once
//
// What the viewer page needs to draw: meshes with exact normals and curvatures, borders and combs, as compact JSON.

#include <string>
#include <vector>

#include "strak/report/drawing.h"
#include "strak/report/edge_joins.h"
#include "strak/report/picture.h"

namespace strak {

struct ViewerModel {
  std::string unit;
  std::vector<Object> before;
  std::vector<Object> after;    // empty: only one state is shown; else a partner for each, without spline if unchanged
  std::vector<EdgeJoin> joins;  // edges that can be coloured by how smoothly their faces join
  RenderOptions start;          // what is shown first
};

// JSON, safe inside a <script> element. Numbers of meshes are 16-bit fractions of their range in base64, so a mesh
// point costs about 60 bytes for both states. Camera, light and ranges are those of `picture` (of the state before).
std::string viewerData(const ViewerModel& model, const Picture& picture);

}  // namespace strak
