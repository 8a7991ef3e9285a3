#include "strak/exchange/periodic_occ.h"

#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Precision.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>

#include <map>

#include "strak/exchange/cad_file_occ.h"

namespace strak::cad {
namespace {

constexpr int kSamples = 50;  // of every trimming curve on a periodic surface

bool within(double from, double to, double low, double high) {
  const double slack = Precision::PConfusion();
  return low >= from - slack && high <= to + slack;
}

// Whether all trimming curves of the face keep to the first period.
bool staysInside(const TopoDS_Face& face, const Geom_BSplineSurface& surface) {
  double u0 = 0, u1 = 0, v0 = 0, v1 = 0;
  surface.Bounds(u0, u1, v0, v1);
  for (TopExp_Explorer edges(face, TopAbs_EDGE); edges.More(); edges.Next()) {
    double from = 0, to = 0;
    const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(TopoDS::Edge(edges.Current()), face, from, to);
    if (curve.IsNull()) return false;
    for (int i = 0; i <= kSamples; ++i) {
      const gp_Pnt2d point = curve->Value(from + (to - from) * i / kSamples);
      if (!within(u0, u1, point.X(), point.X()) || !within(v0, v1, point.Y(), point.Y())) return false;
    }
  }
  return true;
}

}  // namespace

void openPeriodic(const TopoDS_Shape& shape) {
  std::map<Handle(Geom_BSplineCurve), bool> curves;  // and whether they may be opened
  for (const TopoDS_Shape& edge : partsOf(shape, TopAbs_EDGE)) {
    TopLoc_Location place;
    double from = 0, to = 0;
    const auto curve = Handle(Geom_BSplineCurve)::DownCast(BRep_Tool::Curve(TopoDS::Edge(edge), place, from, to));
    if (curve.IsNull() || !curve->IsPeriodic()) continue;
    const bool inside = within(curve->FirstParameter(), curve->LastParameter(), from, to);
    curves.emplace(curve, true).first->second &= inside;
  }
  for (const auto& [curve, inside] : curves) {
    if (!inside) continue;
    curve->SetNotPeriodic();
    curve->Segment(curve->FirstParameter(), curve->LastParameter());  // with full knots at the ends
  }

  std::map<Handle(Geom_BSplineSurface), bool> surfaces;
  for (const TopoDS_Shape& part : partsOf(shape, TopAbs_FACE)) {
    const TopoDS_Face face = TopoDS::Face(part.Oriented(TopAbs_FORWARD));
    TopLoc_Location place;
    const auto surface = Handle(Geom_BSplineSurface)::DownCast(BRep_Tool::Surface(face, place));
    if (surface.IsNull() || !(surface->IsUPeriodic() || surface->IsVPeriodic())) continue;
    surfaces.emplace(surface, true).first->second &= staysInside(face, *surface);
  }
  for (const auto& [surface, inside] : surfaces) {
    if (!inside) continue;
    if (surface->IsUPeriodic()) surface->SetUNotPeriodic();
    if (surface->IsVPeriodic()) surface->SetVNotPeriodic();
    double u0 = 0, u1 = 0, v0 = 0, v1 = 0;
    surface->Bounds(u0, u1, v0, v1);
    surface->Segment(u0, u1, v0, v1);
  }
}

}  // namespace strak::cad
