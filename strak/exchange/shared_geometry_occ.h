#pragma once
//
// The surface under one or more faces, or the curve under one or more free edges, that can be changed. Only for the
// *_occ.cpp files.
//
// A B-spline is changed in place, by moving its control points after knots have been inserted: faces, edges, names,
// colours and instances need not know. A Bezier surface or curve cannot take knots: the equal B-spline takes its place
// first.

#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <vector>

#include "strak/exchange/model.h"

namespace strak::cad {

struct SharedSurface {
  Handle(Geom_Surface) live;             // a B-spline or Bezier surface, without rectangular trimming around it
  Handle(Geom_BSplineSurface) original;  // a copy as read, as a B-spline
  std::vector<TopoDS_Face> faces;        // all that lie on it
  double unitLength = 1;                 // of one unit of our coordinates in Open CASCADE's
  std::vector<Index> objects;            // numbers of the model's objects

  // Throws Failure if the kernel does not take `target` as it is.
  void put(const Surface& target);
};

struct SharedCurve {
  Handle(Geom_Curve) live;
  Handle(Geom_BSplineCurve) original;
  std::vector<TopoDS_Edge> edges;
  double unitLength = 1;

  void put(const Curve& target);
};

// Lays `next` under the face: another object whose parameters mean the same points. The edges' curves in the parameter
// plane are kept under the name of their surface and are handed over. Faces on one surface must follow one another.
void layUnder(const TopoDS_Face& located, const Handle(Geom_Surface) & next);

// The surface or curve inside any trimming to a part of its parameters.
Handle(Geom_Surface) untrimmed(Handle(Geom_Surface) surface);
Handle(Geom_Curve) untrimmed(Handle(Geom_Curve) curve);

// The same as a B-spline with the same parameters, as a copy; null for other kinds than B-spline and Bezier.
Handle(Geom_BSplineSurface) copyAsSpline(const Handle(Geom_Surface) & surface);
Handle(Geom_BSplineCurve) copyAsSpline(const Handle(Geom_Curve) & curve);

// "plane", "rational B-spline surface", "circle", ...
std::string kindOf(const Handle(Geom_Surface) & surface);
std::string kindOf(const Handle(Geom_Curve) & curve);

}  // namespace strak::cad
