#pragma once
//
// The edges between the faces of a shape. Only for the *_occ.cpp files.

#include <TopoDS_Edge.hxx>
#include <TopoDS_Shape.hxx>
#include <gp_Trsf.hxx>
#include <vector>

#include "strak/exchange/model.h"

namespace strak::cad {

// All edges of the shape, each once however many instances there are, in the order in which the audit numbers them.
std::vector<TopoDS_Edge> distinctEdges(const TopoDS_Shape& shape);

// See Model::sharedEdges. The first `objects` are the shape's faces in their order, `places` where they stand; one
// length unit of the model is `unitLength`. Unsewn edges within `tolerance` (model units) are the same.
std::vector<SharedEdge> sharedEdgesOf(const TopoDS_Shape& shape, const std::vector<Object>& objects,
                                      const std::vector<gp_Trsf>& places, double unitLength, double tolerance);

}  // namespace strak::cad
