#pragma once
//
// Splines of this library to and from Open CASCADE's. Only for the *_occ.cpp files. `unitLength` is the length of one
// unit of our coordinates in theirs.

#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <gp_Trsf.hxx>

#include "strak/exchange/model.h"

namespace strak::cad {

// Periodic ones come out clamped. Throw InvalidInput if a rule of Spline is broken.
Curve toSpline(const Geom_BSplineCurve& curve, double unitLength);
Surface toSpline(const Geom_BSplineSurface& surface, double unitLength);

// Points with fewer than 3 coordinates get zeros. Throw InvalidInput for more than 3 coordinates.
Handle(Geom_BSplineCurve) fromSpline(const Curve& curve, double unitLength);
Handle(Geom_BSplineSurface) fromSpline(const Surface& surface, double unitLength);

// Changes `live` in place to `target`, which has the degrees and the domain of `original`: knots that `target` lacks
// are removed, new ones inserted, control points and weights set where they differ from what `live` has. A target equal
// to toSpline(original) gives the poles and weights of `original` to the bit. Throws Failure if the knots or the
// weights do not come out as asked.
void assign(Geom_BSplineCurve& live, const Geom_BSplineCurve& original, const Curve& target, double unitLength);
void assign(Geom_BSplineSurface& live, const Geom_BSplineSurface& original, const Surface& target, double unitLength);

// The spline (coordinates in units) moved by `placement` (in Open CASCADE's lengths).
AnySpline placed(const AnySpline& spline, const gp_Trsf& placement, double unitLength);

}  // namespace strak::cad
