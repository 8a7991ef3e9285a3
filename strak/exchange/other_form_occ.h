#pragma once
//
// Other splines under faces and edges: of another degree, with other knots or without weights, on the same parameters
// and nearly of the same shape. Only for the *_occ.cpp files.

#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <string>
#include <vector>

namespace strak::cad {

// Lays `next` under the faces, which lie on one surface of the same parameters. Edges and corners stay where they are;
// the tolerances of those that are farther from `next` than these say are raised to what is measured. If the kernel's
// checker then refuses a face that it accepted, everything is put back and the result says why (a clause); else empty.
std::string layForm(const std::vector<TopoDS_Face>& faces, const Handle(Geom_BSplineSurface) & next);

// The same for free edges; the ends of the curve are the same points.
void layForm(const std::vector<TopoDS_Edge>& edges, const Handle(Geom_BSplineCurve) & next);

}  // namespace strak::cad
