#include "strak/exchange/audit_occ.h"

#include <BRepCheck_Analyzer.hxx>
#include <BRep_CurveRepresentation.hxx>
#include <BRep_GCurve.hxx>
#include <BRep_TEdge.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>
#include <Standard_Failure.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <set>

#include "strak/exchange/cad_file_occ.h"
#include "strak/exchange/signal_guard_occ.h"

namespace strak::cad {
namespace {

constexpr int kSamples = 201;

// Points of an edge by one of its descriptions, parameter t in [0, 1].
using Trace = std::function<gp_Pnt(double)>;

double largestDistance(const Trace& a, const Trace& b) {
  double largest = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double t = static_cast<double>(i) / (kSamples - 1);
    largest = std::max(largest, a(t).Distance(b(t)));
  }
  return largest;
}

Trace onSurface(const Handle(Geom2d_Curve) & curve, const Handle(Geom_Surface) & surface, const TopLoc_Location& place,
                double from, double to) {
  const gp_Trsf move = place.Transformation();
  return [=](double t) {
    const gp_Pnt2d at = curve->Value(from + (to - from) * t);
    return surface->Value(at.X(), at.Y()).Transformed(move);
  };
}

EdgeFit fitOf(const TopoDS_Edge& edge, const std::set<const Geom_Surface*>& used) {
  EdgeFit fit;
  fit.tolerance = BRep_Tool::Tolerance(edge);
  std::vector<Trace> curves, images;
  const auto* data = static_cast<const BRep_TEdge*>(edge.TShape().get());
  for (const Handle(BRep_CurveRepresentation) & way : data->Curves()) {
    const auto* range = dynamic_cast<const BRep_GCurve*>(way.get());
    if (range == nullptr) continue;
    const double from = range->First(), to = range->Last();
    if (way->IsCurve3D()) {
      if (way->Curve3D().IsNull()) continue;
      const gp_Trsf move = way->Location().Transformation();
      curves.push_back([curve = way->Curve3D(), move, from, to](double t) {
        return curve->Value(from + (to - from) * t).Transformed(move);
      });
    } else if (way->IsCurveOnSurface() && used.count(way->Surface().get()) != 0 && !way->PCurve().IsNull()) {
      images.push_back(onSurface(way->PCurve(), way->Surface(), way->Location(), from, to));
      if (way->IsCurveOnClosedSurface() && !way->PCurve2().IsNull()) {
        images.push_back(onSurface(way->PCurve2(), way->Surface(), way->Location(), from, to));
      }
    }
  }
  for (const Trace& curve : curves) {
    for (const Trace& image : images) fit.gap = std::max(fit.gap, largestDistance(curve, image));
  }
  for (std::size_t i = 0; i < images.size(); ++i) {
    for (std::size_t j = i + 1; j < images.size(); ++j) {
      fit.faceGap = std::max(fit.faceGap, largestDistance(images[i], images[j]));
    }
  }
  // An edge shrunk to a point (a pole) has no curve: its image must stay there.
  if (curves.empty() && !images.empty()) {
    const gp_Pnt there = images.front()(0);
    for (const Trace& image : images) {
      fit.gap = std::max(fit.gap, largestDistance(image, [&](double) { return there; }));
    }
  }
  return fit;
}

}  // namespace

Audit auditShape(const TopoDS_Shape& shape, double unitLength) {
  Audit audit;
  const std::vector<TopoDS_Shape> faces = partsOf(shape, TopAbs_FACE);
  std::set<const Geom_Surface*> used;
  for (const TopoDS_Shape& face : faces) {
    TopLoc_Location ignored;
    const Handle(Geom_Surface) surface = BRep_Tool::Surface(TopoDS::Face(face), ignored);
    if (!surface.IsNull()) used.insert(surface.get());
  }
  std::set<const TopoDS_TShape*> seen;
  int number = 0;
  for (const TopoDS_Shape& edge : partsOf(shape, TopAbs_EDGE)) {
    if (!seen.insert(edge.TShape().get()).second) continue;
    ++number;
    EdgeFit fit = fitOf(TopoDS::Edge(edge), used);
    fit.name = fmt::format("edge {}", number);
    fit.gap /= unitLength;
    fit.faceGap /= unitLength;
    fit.tolerance /= unitLength;
    audit.largestGap = std::max(audit.largestGap, fit.gap);
    audit.largestTolerance = std::max(audit.largestTolerance, fit.tolerance);
    audit.edges.push_back(std::move(fit));
  }

  // Shapes of damaged files make the checker stumble: they are not valid.
  try {
    const std::lock_guard lock(readerMutex());
    const bool survived = survives([&] {
      const BRepCheck_Analyzer checker(shape);
      audit.valid = checker.IsValid();
      if (audit.valid) return;
      for (const TopoDS_Shape& face : faces) audit.invalidFaces += checker.IsValid(face) ? 0 : 1;
    });
    audit.valid = audit.valid && survived;
  } catch (const Standard_Failure&) {
    audit.valid = false;
  }
  return audit;
}

}  // namespace strak::cad
