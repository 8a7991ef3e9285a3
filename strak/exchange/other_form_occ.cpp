#include "strak/exchange/other_form_occ.h"

#include <BRepCheck_Analyzer.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_TEdge.hxx>
#include <BRep_TVertex.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Vertex.hxx>

#include <algorithm>
#include <map>

#include "strak/exchange/audit_occ.h"
#include "strak/exchange/cad_file_occ.h"
#include "strak/exchange/shared_geometry_occ.h"

namespace strak::cad {
namespace {

constexpr double kBetweenSamples = 1.05;  // what gaps between the measured places may be more

// The tolerances of edges and corners, to be put back.
using Tolerances = std::map<Handle(TopoDS_TShape), double>;

void raise(const TopoDS_Edge& edge, double wanted, Tolerances& before) {
  const Handle(BRep_TEdge) data = Handle(BRep_TEdge)::DownCast(edge.TShape());
  before.emplace(data, data->Tolerance());
  data->UpdateTolerance(wanted);
}

void raise(const TopoDS_Vertex& vertex, double wanted, Tolerances& before) {
  const Handle(BRep_TVertex) data = Handle(BRep_TVertex)::DownCast(vertex.TShape());
  before.emplace(data, data->Tolerance());
  data->UpdateTolerance(wanted);
}

void putBack(const Tolerances& before) {
  for (const auto& [shape, tolerance] : before) {
    if (const Handle(BRep_TEdge) edge = Handle(BRep_TEdge)::DownCast(shape); !edge.IsNull()) edge->Tolerance(tolerance);
    const Handle(BRep_TVertex) vertex = Handle(BRep_TVertex)::DownCast(shape);
    if (!vertex.IsNull()) vertex->Tolerance(tolerance);
  }
}

// A corner must hold the ends of its edges on the face, and be as wide as they are.
void raiseCorners(const TopoDS_Edge& edge, const TopoDS_Face& face, Tolerances& before) {
  double from = 0, to = 0;
  const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(edge, face, from, to);
  TopoDS_Vertex corners[2];
  TopExp::Vertices(edge, corners[0], corners[1]);
  TopLoc_Location place;
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(face, place);
  for (int end = 0; end < 2; ++end) {
    if (corners[end].IsNull()) continue;
    double wanted = BRep_Tool::Tolerance(edge);
    if (!curve.IsNull()) {
      const gp_Pnt2d at = curve->Value(end == 0 ? from : to);
      const gp_Pnt there = surface->Value(at.X(), at.Y()).Transformed(place.Transformation());
      wanted = std::max(wanted, kBetweenSamples * there.Distance(BRep_Tool::Pnt(corners[end])));
    }
    if (wanted > BRep_Tool::Tolerance(corners[end])) raise(corners[end], wanted, before);
  }
}

// Raises what `face` needs; `measured` are its edges' gaps in the order of partsOf.
void raiseEdges(const TopoDS_Face& face, const Audit& measured, Tolerances& before) {
  std::size_t next = 0;
  std::map<const TopoDS_TShape*, bool> seen;
  for (const TopoDS_Shape& shape : partsOf(face, TopAbs_EDGE)) {
    if (!seen.emplace(shape.TShape().get(), true).second) continue;
    const TopoDS_Edge edge = TopoDS::Edge(shape.Oriented(TopAbs_FORWARD));
    const EdgeFit& fit = measured.edges[next++];
    if (fit.gap > fit.tolerance) raise(edge, kBetweenSamples * fit.gap, before);
    raiseCorners(edge, face, before);
  }
}

bool accepts(const TopoDS_Face& face) {
  try {
    return BRepCheck_Analyzer(face).IsValid();
  } catch (const Standard_Failure&) {
    return false;
  }
}

}  // namespace

std::string layForm(const std::vector<TopoDS_Face>& faces, const Handle(Geom_BSplineSurface) & next) {
  TopLoc_Location ignored;
  const Handle(Geom_Surface) old = BRep_Tool::Surface(faces.front(), ignored);
  std::vector<char> wasValid;
  for (const TopoDS_Face& face : faces) wasValid.push_back(accepts(face) ? 1 : 0);
  Tolerances before;
  bool good = true;
  try {
    for (const TopoDS_Face& face : faces) layUnder(face, next);
    for (std::size_t i = 0; i < faces.size() && good; ++i) {
      raiseEdges(faces[i], auditShape(faces[i], 1), before);
      good = wasValid[i] == 0 || accepts(faces[i]);
    }
  } catch (const Standard_Failure&) {
    good = false;
  }
  if (!good) {
    putBack(before);
    for (const TopoDS_Face& face : faces) layUnder(face, old);
    return "the CAD kernel's checker no longer accepts the face with it";
  }
  for (const TopoDS_Face& face : faces) BRepTools::Clean(face);  // drawn from the old surface
  return "";
}

void layForm(const std::vector<TopoDS_Edge>& edges, const Handle(Geom_BSplineCurve) & next) {
  for (const TopoDS_Edge& edge : edges) {
    TopoDS_Edge here = edge;
    here.Location(TopLoc_Location());
    TopLoc_Location place;
    double from = 0, to = 0;
    BRep_Tool::Curve(here, place, from, to);
    BRep_Builder().UpdateEdge(here, next, place, BRep_Tool::Tolerance(here));
    BRepTools::Clean(here);
  }
}

}  // namespace strak::cad
