#pragma once
//
// Planes, cylinders, cones, spheres, tori, extruded and revolved surfaces as B-splines. Only for the *_occ.cpp files.
//
// The usual exact conversion to rational arcs has other parameters than the surface it replaces, so that every edge's
// curve in the parameter plane must be made anew; measured on nine public models, a third of them came out invalid that
// way. Here the parameters stay and the circle gives way: splines of degree 7 with a span for every 8.6 degrees or
// less, as smooth as they can be, follow it to 4e-11 of the radius. All edges stay as they are, and there are no
// weights and no double knots in the way of fairing.

#include <Geom_BSplineSurface.hxx>
#include <Geom_Surface.hxx>
#include <TopoDS_Face.hxx>
#include <optional>
#include <string>
#include <vector>

#include "strak/exchange/model.h"

namespace strak::cad {

// The part of a parameter plane that faces need.
struct ParameterBox {
  std::array<double, 2> from{}, to{};
};

// That of all the faces, which lie on one surface; cut to whole turns. Nothing if it is not bounded.
std::optional<ParameterBox> boxOf(const std::vector<TopoDS_Face>& faces, const Geom_Surface& surface);

struct AnalyticSpline {
  std::optional<Surface>
      spline;           // in Open CASCADE's lengths; clamped, degree at least 3 along lines and 7 round circles
  std::string refused;  // why not (a clause)
};

// `surface` over the box, with its own parameters: equal where it is a plane, a line or a spline in that direction, to
// 4e-11 of the radius where it is a circle. Refused are offset surfaces and profiles that are hyperbolas, parabolas or
// offsets, boxes beyond one turn, and (there is nothing to convert) splines.
AnalyticSpline analyticSpline(const Handle(Geom_Surface) & surface, const ParameterBox& box);

// Lays the spline of their surface under the faces, each of which lies on it; `made` is that. Demands that points
// inside differ by no more than `tolerance` (in Open CASCADE's lengths), that the kernel's checker accepts every face
// that it accepted, and that no edge is farther from its image than it was (plus `tolerance`) or than its own
// tolerance: an edge on a plane has no image before. Else everything is put back and the result says why (a clause);
// empty if it is done.
std::string convertFaces(const std::vector<TopoDS_Face>& faces, double tolerance, Handle(Geom_BSplineSurface) & made);

}  // namespace strak::cad
