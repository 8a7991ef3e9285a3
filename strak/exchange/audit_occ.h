#pragma once
//
// How well the edges of a shape fit its faces. Only for the *_occ.cpp files.
//
// The kernel's own checker is no proof: it calls a model valid whose edges are 1.5 mm off with a tolerance of 0.4 mm.

#include <TopoDS_Shape.hxx>

#include "strak/exchange/model.h"

namespace strak::cad {

// Gaps by dense sampling of every edge (once for all instances), and the checker's verdict. Lengths are divided by
// `unitLength`. Cost: some hundred curve and surface points an edge, plus the checker.
Audit auditShape(const TopoDS_Shape& shape, double unitLength);

}  // namespace strak::cad
