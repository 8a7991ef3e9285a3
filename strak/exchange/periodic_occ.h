#pragma once
//
// Periodic splines made plain. Only for the *_occ.cpp files.
//
// Open CASCADE turns closed splines of a file into periodic ones and writes those with other knots than the file had;
// the next reader then replaces exact trimming curves by projections that are off by hundreds of times. Without the
// period they are what the file says, to the bit of their shape, and can be made fair like others.

#include <TopoDS_Shape.hxx>

namespace strak::cad {

// Opens periodic B-spline curves and surfaces of the shape's edges and faces where nothing uses parameters beyond one
// period. The others stay as they are.
void openPeriodic(const TopoDS_Shape& shape);

}  // namespace strak::cad
