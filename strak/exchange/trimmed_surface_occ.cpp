#include "strak/exchange/trimmed_surface_occ.h"

#include <Approx_CurveOnSurface.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepLib.hxx>
#include <BRep_Builder.hxx>
#include <Geom2dAdaptor_Curve.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Precision.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array1OfPnt2d.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>

#include <fmt/format.h>

#include <algorithm>

#include "strak/base/error.h"
#include "strak/exchange/cad_geometry_occ.h"
#include "strak/spline/evaluate.h"

namespace strak::cad {
namespace {

constexpr double kEdgeError = 1e-9;  // of the size: an edge's curve beside its image on the surface
constexpr double kSameEnd = 1e-9;    // of the domain: ends of pieces this near are one
constexpr int kHighestDegree = 14, kMostSegments = 4000;

Handle(Geom2d_BSplineCurve) inPlane(const Curve& curve) {
  const Handle(Geom_BSplineCurve) flat = fromSpline(curve, 1);
  TColgp_Array1OfPnt2d poles(1, flat->NbPoles());
  for (int i = 1; i <= flat->NbPoles(); ++i) poles(i) = gp_Pnt2d(flat->Pole(i).X(), flat->Pole(i).Y());
  return new Geom2d_BSplineCurve(poles, flat->Knots(), flat->Multiplicities(), flat->Degree());
}

class FaceMaker {
 public:
  FaceMaker(const Surface& surface, double unitLength) : surface_(surface), live_(fromSpline(surface, unitLength)) {
    const Net points = surface.euclideanNet();
    size_ = (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm() * unitLength;
    tolerance_ = std::max(kEdgeError * size_, Precision::Confusion());
  }

  TopoDS_Face face(const TrimmedPart& part) const {
    TopoDS_Face face;
    builder_.MakeFace(face, live_, tolerance_);
    builder_.Add(face, wire(part.outer, face));
    for (const TrimLoop& hole : part.holes) builder_.Add(face, wire(hole, face));
    BRepLib::SameParameter(face, tolerance_, true);
    BRepLib::UpdateTolerances(face);
    return face;
  }

 private:
  gp_Pnt place(const gp_Pnt2d& at) const { return live_->Value(at.X(), at.Y()); }

  void check(const TrimLoop& loop) const {
    if (loop.empty()) throw InvalidInput("a trimming loop has no curve");
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Curve& curve = loop[i];
      if (curve.net().cols() != 2 || curve.isRational() || !curve.knots(0).isClamped()) {
        throw InvalidInput("trimming curves must be clamped, with two coordinates and no weights");
      }
      const Net& next = loop[(i + 1) % loop.size()].net();
      for (int k = 0; k < 2; ++k) {
        const KnotVector& knots = surface_.knots(k);
        const double slack = kSameEnd * knots.length();
        if (std::abs(curve.net()(curve.net().rows() - 1, k) - next(0, k)) > slack) {
          throw InvalidInput("a trimming loop is open: each curve must begin where the one before it ends");
        }
        if (curve.net().col(k).minCoeff() < knots.from() - slack ||
            curve.net().col(k).maxCoeff() > knots.to() + slack) {
          throw InvalidInput("a control point of a trimming curve lies outside the domain of its surface");
        }
      }
    }
  }

  TopoDS_Wire wire(const TrimLoop& loop, const TopoDS_Face& face) const {
    check(loop);
    std::vector<TopoDS_Vertex> corners(loop.size());
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const auto first = loop[i].net().row(0);
      builder_.MakeVertex(corners[i], place({first[0], first[1]}), tolerance_);
    }
    TopoDS_Wire wire;
    builder_.MakeWire(wire);
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Handle(Geom2d_BSplineCurve) line = inPlane(loop[i]);
      const double from = line->FirstParameter(), to = line->LastParameter();
      TopoDS_Edge edge;
      builder_.MakeEdge(edge, curveOf(line, from, to), tolerance_);
      builder_.UpdateEdge(edge, line, face, tolerance_);
      builder_.Range(edge, from, to);
      builder_.Add(edge, corners[i].Oriented(TopAbs_FORWARD));
      builder_.Add(edge, corners[(i + 1) % loop.size()].Oriented(TopAbs_REVERSED));
      builder_.Add(wire, edge);
    }
    wire.Closed(true);
    return wire;
  }

  // The image of the line in space; made from it, so that nothing need be repaired.
  Handle(Geom_Curve) curveOf(const Handle(Geom2d_BSplineCurve) & line, double from, double to) const {
    const Handle(Geom2dAdaptor_Curve) path = new Geom2dAdaptor_Curve(line, from, to);
    const Handle(GeomAdaptor_Surface) ground = new GeomAdaptor_Surface(live_);
    Approx_CurveOnSurface approximation(path, ground, from, to, tolerance_ / 2);
    approximation.Perform(kMostSegments, kHighestDegree, GeomAbs_C1, true);
    if (!approximation.HasResult()) throw Failure("no edge in space comes near enough to a trimming curve");
    return approximation.Curve3d();
  }

  const Surface& surface_;
  Handle(Geom_BSplineSurface) live_;
  double size_ = 0, tolerance_ = 0;
  BRep_Builder builder_;
};

}  // namespace

std::vector<TopoDS_Face> trimmedFaces(const Surface& surface, const std::vector<TrimmedPart>& parts,
                                      double unitLength) {
  const FaceMaker maker(surface, unitLength);
  std::vector<TopoDS_Face> faces;
  for (const TrimmedPart& part : parts) {
    faces.push_back(maker.face(part));
    if (!BRepCheck_Analyzer(faces.back()).IsValid()) {
      throw Failure(
          fmt::format("Open CASCADE's checker does not accept trimmed face {}: leave the trimming out or use "
                      "a wider gap",
                      faces.size()));
    }
  }
  return faces;
}

}  // namespace strak::cad
