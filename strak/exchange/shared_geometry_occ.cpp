#include "strak/exchange/shared_geometry_occ.h"

#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <GeomConvert.hxx>
#include <Geom_BezierCurve.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_Circle.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Ellipse.hxx>
#include <Geom_Line.hxx>
#include <Geom_OffsetSurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_SurfaceOfLinearExtrusion.hxx>
#include <Geom_SurfaceOfRevolution.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_MapOfShape.hxx>
#include <TopoDS.hxx>

#include "strak/exchange/cad_geometry_occ.h"

namespace strak::cad {
namespace {

// A change that fails half-way is taken back.
template <typename Geometry, typename Spline>
void assignOrRestore(Geometry& live, const Geometry& original, const Spline& target, double unitLength) {
  const Spline before = toSpline(live, unitLength);
  try {
    assign(live, original, target, unitLength);
  } catch (...) {
    assign(live, original, before, unitLength);
    throw;
  }
}

template <typename Shape>
void dropMeshes(const std::vector<Shape>& shapes) {
  for (const Shape& shape : shapes) BRepTools::Clean(shape);  // drawn from the old shape
}

}  // namespace

void layUnder(const TopoDS_Face& located, const Handle(Geom_Surface) & next) {
  TopoDS_Face face = TopoDS::Face(located.Oriented(TopAbs_FORWARD));
  face.Location(TopLoc_Location());
  TopLoc_Location place;
  const Handle(Geom_Surface) old = BRep_Tool::Surface(face, place);
  const BRep_Builder builder;
  TopTools_MapOfShape done;
  for (TopExp_Explorer edges(face, TopAbs_EDGE); edges.More(); edges.Next()) {
    if (!done.Add(edges.Current())) continue;
    const TopoDS_Edge edge = TopoDS::Edge(edges.Current().Oriented(TopAbs_FORWARD));
    double from = 0, to = 0;
    const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(edge, old, place, from, to);
    if (curve.IsNull()) continue;  // handed over with another face on the same surface
    const double tolerance = BRep_Tool::Tolerance(edge);
    if (BRep_Tool::IsClosed(edge, old, place)) {
      const Handle(Geom2d_Curve) second =
          BRep_Tool::CurveOnSurface(TopoDS::Edge(edge.Reversed()), old, place, from, to);
      builder.UpdateEdge(edge, nullptr, nullptr, old, place, tolerance);
      builder.UpdateEdge(edge, curve, second, next, place, tolerance);
    } else {
      builder.UpdateEdge(edge, nullptr, old, place, tolerance);
      builder.UpdateEdge(edge, curve, next, place, tolerance);
    }
    builder.Range(edge, next, place, from, to);
  }
  builder.UpdateFace(face, next, place, BRep_Tool::Tolerance(face));
}

void SharedSurface::put(const Surface& target) {
  Handle(Geom_BSplineSurface) spline = Handle(Geom_BSplineSurface)::DownCast(live);
  if (spline.IsNull()) {
    spline = Handle(Geom_BSplineSurface)::DownCast(original->Copy());
    for (const TopoDS_Face& face : faces) layUnder(face, spline);
    live = spline;
  }
  assignOrRestore(*spline, *original, target, unitLength);
  dropMeshes(faces);
}

void SharedCurve::put(const Curve& target) {
  Handle(Geom_BSplineCurve) spline = Handle(Geom_BSplineCurve)::DownCast(live);
  if (spline.IsNull()) {
    spline = Handle(Geom_BSplineCurve)::DownCast(original->Copy());
    for (const TopoDS_Edge& edge : edges) {
      TopoDS_Edge here = edge;
      here.Location(TopLoc_Location());
      TopLoc_Location place;
      double from = 0, to = 0;
      BRep_Tool::Curve(here, place, from, to);
      BRep_Builder().UpdateEdge(here, spline, place, BRep_Tool::Tolerance(here));
    }
    live = spline;
  }
  assignOrRestore(*spline, *original, target, unitLength);
  dropMeshes(edges);
}

Handle(Geom_Surface) untrimmed(Handle(Geom_Surface) surface) {
  while (surface->IsKind(STANDARD_TYPE(Geom_RectangularTrimmedSurface))) {
    surface = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface)->BasisSurface();
  }
  return surface;
}

Handle(Geom_Curve) untrimmed(Handle(Geom_Curve) curve) {
  while (curve->IsKind(STANDARD_TYPE(Geom_TrimmedCurve))) {
    curve = Handle(Geom_TrimmedCurve)::DownCast(curve)->BasisCurve();
  }
  return curve;
}

Handle(Geom_BSplineSurface) copyAsSpline(const Handle(Geom_Surface) & surface) {
  if (surface->IsKind(STANDARD_TYPE(Geom_BSplineSurface))) {
    return Handle(Geom_BSplineSurface)::DownCast(surface->Copy());
  }
  if (surface->IsKind(STANDARD_TYPE(Geom_BezierSurface))) return GeomConvert::SurfaceToBSplineSurface(surface);
  return nullptr;
}

Handle(Geom_BSplineCurve) copyAsSpline(const Handle(Geom_Curve) & curve) {
  if (curve->IsKind(STANDARD_TYPE(Geom_BSplineCurve))) return Handle(Geom_BSplineCurve)::DownCast(curve->Copy());
  if (curve->IsKind(STANDARD_TYPE(Geom_BezierCurve))) return GeomConvert::CurveToBSplineCurve(curve);
  return nullptr;
}

std::string kindOf(const Handle(Geom_Surface) & surface) {
  if (const auto* spline = dynamic_cast<const Geom_BSplineSurface*>(surface.get())) {
    return spline->IsURational() || spline->IsVRational() ? "rational B-spline surface" : "B-spline surface";
  }
  if (const auto* bezier = dynamic_cast<const Geom_BezierSurface*>(surface.get())) {
    return bezier->IsURational() || bezier->IsVRational() ? "rational Bezier surface" : "Bezier surface";
  }
  if (surface->IsKind(STANDARD_TYPE(Geom_Plane))) return "plane";
  if (surface->IsKind(STANDARD_TYPE(Geom_CylindricalSurface))) return "cylinder";
  if (surface->IsKind(STANDARD_TYPE(Geom_ConicalSurface))) return "cone";
  if (surface->IsKind(STANDARD_TYPE(Geom_SphericalSurface))) return "sphere";
  if (surface->IsKind(STANDARD_TYPE(Geom_ToroidalSurface))) return "torus";
  if (surface->IsKind(STANDARD_TYPE(Geom_SurfaceOfRevolution))) return "surface of revolution";
  if (surface->IsKind(STANDARD_TYPE(Geom_SurfaceOfLinearExtrusion))) return "extruded surface";
  if (surface->IsKind(STANDARD_TYPE(Geom_OffsetSurface))) return "offset surface";
  return "surface of another kind";
}

std::string kindOf(const Handle(Geom_Curve) & curve) {
  if (const auto* spline = dynamic_cast<const Geom_BSplineCurve*>(curve.get())) {
    return spline->IsRational() ? "rational B-spline curve" : "B-spline curve";
  }
  if (const auto* bezier = dynamic_cast<const Geom_BezierCurve*>(curve.get())) {
    return bezier->IsRational() ? "rational Bezier curve" : "Bezier curve";
  }
  if (curve->IsKind(STANDARD_TYPE(Geom_Line))) return "line";
  if (curve->IsKind(STANDARD_TYPE(Geom_Circle))) return "circle";
  if (curve->IsKind(STANDARD_TYPE(Geom_Ellipse))) return "ellipse";
  return "curve of another kind";
}

}  // namespace strak::cad
