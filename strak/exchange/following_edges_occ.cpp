#include "strak/exchange/following_edges_occ.h"

#include <Approx_CurveOnSurface.hxx>
#include <BRep_CurveRepresentation.hxx>
#include <BRep_GCurve.hxx>
#include <BRep_TEdge.hxx>
#include <BRep_TVertex.hxx>
#include <BRep_Tool.hxx>
#include <Geom2dAdaptor_Curve.hxx>
#include <Geom2d_Curve.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "strak/base/error.h"
#include "strak/exchange/audit_occ.h"
#include "strak/exchange/cad_file_occ.h"
#include "strak/exchange/cad_geometry_occ.h"
#include "strak/exchange/mean_curve.h"
#include "strak/exchange/shared_edges_occ.h"
#include "strak/spline/reparametrize.h"

namespace strak::cad {
namespace {

constexpr int kSamples = 65;            // of an edge
constexpr double kStays = 1e-12;        // of the size: moves below are rounding
constexpr double kAlike = 1e-9;         // of the size: how much the moves of two faces may differ
constexpr double kAlikeAtCorner = 0.1;  // of its tolerance: edges of real files end a little beside their corners
constexpr double kStraight = 1e-9;      // of the domain: curves in the parameter plane this straight are isoparametric
constexpr double kApproximate = 1e-10;  // of the size: error of a curve that is not
constexpr double kBetweenSamples = 1.05;  // what gaps between the measured places may be more
constexpr int kMostSegments = 2000, kHighestDegree = 9;

BRep_TEdge& dataOf(const TopoDS_Edge& edge) { return static_cast<BRep_TEdge&>(*edge.TShape()); }
BRep_TVertex& dataOf(const TopoDS_Vertex& vertex) { return static_cast<BRep_TVertex&>(*vertex.TShape()); }

// The description of an edge by a curve in space, or null.
BRep_GCurve* spaceCurve(const TopoDS_Edge& edge) {
  for (const Handle(BRep_CurveRepresentation) & way : dataOf(edge).ChangeCurves()) {
    if (way->IsCurve3D() && !way->Curve3D().IsNull()) return dynamic_cast<BRep_GCurve*>(way.get());
  }
  return nullptr;
}

// The isoparametric curve over the other direction where `direction` is `value`; its control points to the bit on a
// clamped side.
Curve isoCurve(const Geom_BSplineSurface& surface, int direction, double value) {
  const bool u = direction == 0;
  const int last = u ? surface.NbUKnots() : surface.NbVKnots();
  const int full = (u ? surface.UDegree() : surface.VDegree()) + 1;
  for (const int knot : {1, last}) {
    const int multiplicity = u ? surface.UMultiplicity(knot) : surface.VMultiplicity(knot);
    const double side = u ? surface.UKnot(knot) : surface.VKnot(knot);
    const double length = u ? surface.UKnot(last) - surface.UKnot(1) : surface.VKnot(last) - surface.VKnot(1);
    if (multiplicity != full || std::abs(value - side) > kStraight * length) continue;
    const Surface spline = toSpline(surface, 1);
    const Index across = knot == 1 ? 0 : spline.size(direction) - 1;
    Net net(spline.size(1 - direction), spline.net().cols());
    for (Index i = 0; i < net.rows(); ++i) {
      net.row(i) = spline.net().row(u ? spline.row({across, i}) : spline.row({i, across}));
    }
    return Curve({spline.knots(1 - direction)}, std::move(net), spline.isRational());
  }
  const Handle(Geom_Curve) iso = u ? surface.UIso(value) : surface.VIso(value);
  return toSpline(*Handle(Geom_BSplineCurve)::DownCast(iso), 1);
}

}  // namespace

// An edge as one face has it.
struct FollowingEdges::Image {
  Handle(Geom_Surface) surface;
  Handle(Geom_BSplineSurface) original;  // null where the surface is as read
  Handle(Geom2d_Curve) line;
  double from = 0, to = 0;
  TopLoc_Location place;

  gp_Pnt2d parameters(double t) const { return line->Value(from + (to - from) * t); }
  gp_Vec move(double t) const {
    if (original.IsNull()) return {0, 0, 0};
    const gp_Pnt2d at = parameters(t);
    return gp_Vec(original->Value(at.X(), at.Y()), surface->Value(at.X(), at.Y())).Transformed(place.Transformation());
  }
  gp_Pnt point(double t) const {
    const gp_Pnt2d at = parameters(t);
    return surface->Value(at.X(), at.Y()).Transformed(place.Transformation());
  }
  // As a curve over [low, high] if it is an isoparametric one that is run through evenly.
  std::optional<Curve> iso(double low, double high) const;
};

std::optional<Curve> FollowingEdges::Image::iso(double low, double high) const {
  const Handle(Geom_BSplineSurface) spline = Handle(Geom_BSplineSurface)::DownCast(surface);
  if (spline.IsNull()) return {};
  double u0 = 0, u1 = 0, v0 = 0, v1 = 0;
  spline->Bounds(u0, u1, v0, v1);
  const gp_Pnt2d start = parameters(0), end = parameters(1);
  const double slackU = kStraight * (u1 - u0), slackV = kStraight * (v1 - v0);
  for (int i = 1; i + 1 < kSamples; ++i) {
    const double t = static_cast<double>(i) / (kSamples - 1);
    const gp_Pnt2d at = parameters(t);
    if (std::abs(at.X() - std::lerp(start.X(), end.X(), t)) > slackU) return {};
    if (std::abs(at.Y() - std::lerp(start.Y(), end.Y(), t)) > slackV) return {};
  }
  const bool alongV = std::abs(end.X() - start.X()) <= slackU;
  if (!alongV && std::abs(end.Y() - start.Y()) > slackV) return {};
  const double value = alongV ? (start.X() + end.X()) / 2 : (start.Y() + end.Y()) / 2;
  Curve curve = isoCurve(*spline, alongV ? 0 : 1, std::clamp(value, alongV ? u0 : v0, alongV ? u1 : v1));
  // The part that the edge covers, in its sense. Ends that miss a side by rounding are on it.
  const KnotVector& knots = curve.knots(0);
  const double slack = kStraight * knots.length();
  const auto near = [&](double at) {
    if (std::abs(at - knots.from()) <= slack) return knots.from();
    if (std::abs(at - knots.to()) <= slack) return knots.to();
    return at;
  };
  const double first = near(alongV ? start.Y() : start.X()), last = near(alongV ? end.Y() : end.X());
  const double smaller = std::min(first, last), larger = std::max(first, last);
  if (smaller < knots.from() || larger > knots.to() || !(smaller < larger)) return {};
  if (smaller > knots.from() || larger < knots.to()) curve = subPatch(curve, 0, smaller, larger);
  if (first > last) curve = reversed(curve, 0);
  return withDomain(curve, 0, low, high);
}

// What becomes of an edge.
struct FollowingEdges::Move {
  bool known = false;  // false: nothing of it has changed
  bool moves = false;
  Handle(Geom_Curve) curve;  // null if it stays as read, or has none
  double tolerance = 0;
  std::vector<std::array<gp_Vec, 2>> ends;  // how far either end goes on each of its faces, where the edge is at home
};

FollowingEdges::FollowingEdges(const TopoDS_Shape& shape, double size) : size_(size), shape_(shape) {
  std::map<const TopoDS_TShape*, std::size_t> numbers;
  for (const TopoDS_Edge& located : distinctEdges(shape)) {
    Edge record;
    record.name = fmt::format("edge {}", edges_.size() + 1);
    record.edge = TopoDS::Edge(located.Oriented(TopAbs_FORWARD));
    record.edge.Location(TopLoc_Location());
    if (const auto* curve = spaceCurve(record.edge)) record.curve = curve->Curve3D();
    record.tolerance = dataOf(record.edge).Tolerance();
    TopoDS_Vertex vertices[2];
    TopExp::Vertices(record.edge, vertices[0], vertices[1]);
    for (std::size_t end = 0; end < 2; ++end) {
      if (vertices[end].IsNull()) {
        record.corner[end] = static_cast<std::size_t>(-1);
        continue;
      }
      record.place[end] = vertices[end].Location();
      const auto [at, fresh] = numbers.emplace(vertices[end].TShape().get(), corners_.size());
      if (fresh) {
        const auto& data = dataOf(vertices[end]);
        corners_.push_back({vertices[end], data.Pnt(), data.Tolerance(), {}});
      }
      record.corner[end] = at->second;
      corners_[at->second].ends.emplace_back(edges_.size(), end);
    }
    edges_.push_back(std::move(record));
  }
  std::map<const TopoDS_TShape*, std::size_t> edgeNumbers;
  for (std::size_t e = 0; e < edges_.size(); ++e) edgeNumbers.emplace(edges_[e].edge.TShape().get(), e);
  for (const TopoDS_Shape& part : partsOf(shape, TopAbs_FACE)) {
    TopoDS_Face face = TopoDS::Face(part);
    face.Location(TopLoc_Location());
    TopLoc_Location place;
    const Handle(Geom_Surface) surface = BRep_Tool::Surface(face, place);
    if (surface.IsNull()) continue;
    for (TopExp_Explorer all(face, TopAbs_EDGE); all.More(); all.Next()) {
      Edge& edge = edges_[edgeNumbers.at(all.Current().TShape().get())];
      const auto& ways = dataOf(edge.edge).Curves();
      const bool known = std::any_of(ways.begin(), ways.end(), [&](const Handle(BRep_CurveRepresentation) & way) {
        return way->IsCurveOnSurface() && way->Surface() == surface;
      });
      edge.besideBare = edge.besideBare || !known;
    }
  }
}

void FollowingEdges::requireAlike(const std::string& what, double apart, double tolerance) const {
  if (apart <= std::max(kAlike * size_, kAlikeAtCorner * tolerance)) return;
  throw InvalidInput(
      fmt::format("{} would be torn: the faces there move apart by {:.3g} of the model's size; move "
                  "their borders alike or not at all",
                  what, apart / size_));
}

std::vector<FollowingEdges::Image> FollowingEdges::imagesOf(const Edge& edge, const ChangedSurfaces& changed) const {
  std::vector<Image> images;
  for (const Handle(BRep_CurveRepresentation) & way : dataOf(edge.edge).Curves()) {
    const auto* range = dynamic_cast<const BRep_GCurve*>(way.get());
    if (range == nullptr || !way->IsCurveOnSurface() || way->PCurve().IsNull()) continue;
    if (used_.count(way->Surface().get()) == 0) continue;
    const auto original = changed.find(way->Surface().get());
    Image image{way->Surface(), nullptr, way->PCurve(), range->First(), range->Last(), way->Location()};
    if (original != changed.end()) image.original = original->second;
    images.push_back(image);
    if (way->IsCurveOnClosedSurface() && !way->PCurve2().IsNull()) {
      image.line = way->PCurve2();
      images.push_back(image);
    }
  }
  return images;
}

Handle(Geom_Curve) FollowingEdges::curveOf(const Edge& edge, const std::vector<Image>& images) const {
  const BRep_GCurve* range = spaceCurve(edge.edge);
  const double low = range->First(), high = range->Last();
  const gp_Trsf home = range->Location().Transformation();
  std::vector<Curve> curves;
  for (const Image& image : images) {
    auto curve = image.iso(low, high);
    if (!curve) continue;
    gp_Trsf place = image.place.Transformation();
    if (image.place != range->Location()) {
      place.PreMultiply(home.Inverted());
      curve = std::get<Curve>(placed(*curve, place, 1));
    }
    curves.push_back(std::move(*curve));
  }
  // The mean is nowhere farther from a face than the farther of two faces that lie as far apart as before.
  if (!curves.empty()) return fromSpline(meanCurve(std::move(curves)), 1);
  const auto face = std::find_if(images.begin(), images.end(), [](const Image& i) { return !i.original.IsNull(); });
  if (face->from != low || face->to != high) {
    throw InvalidInput(
        fmt::format("{} cannot follow its face: its curves have different parameters; hold the border "
                    "there",
                    edge.name));
  }
  const Handle(Geom2dAdaptor_Curve) line = new Geom2dAdaptor_Curve(face->line, low, high);
  const Handle(GeomAdaptor_Surface) surface = new GeomAdaptor_Surface(face->surface);
  Approx_CurveOnSurface approximation(line, surface, low, high, kApproximate * size_);
  approximation.Perform(kMostSegments, kHighestDegree, GeomAbs_C1, true);
  if (!approximation.HasResult()) {
    throw InvalidInput(
        fmt::format("{} cannot follow its face: no curve comes near enough; hold the border there", edge.name));
  }
  Handle(Geom_Curve) curve = approximation.Curve3d();
  gp_Trsf place = face->place.Transformation();
  place.PreMultiply(home.Inverted());
  curve->Transform(place);
  return curve;
}

FollowingEdges::Move FollowingEdges::moveOf(const Edge& edge, const ChangedSurfaces& changed) const {
  Move move;
  const std::vector<Image> images = imagesOf(edge, changed);
  move.known = std::any_of(images.begin(), images.end(), [](const Image& i) { return !i.original.IsNull(); });
  if (!move.known) return move;
  const bool point = edge.curve.IsNull();  // a pole: all of it must move the same way
  gp_Vec first;
  double farthest = 0, apart = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double t = static_cast<double>(i) / (kSamples - 1);
    for (std::size_t k = 0; k < images.size(); ++k) {
      const gp_Vec step = images[k].move(t);
      farthest = std::max(farthest, step.Magnitude());
      if (k == 0 && (i == 0 || !point)) first = step;
      apart = std::max(apart, (step - first).Magnitude());
      if (i == 0) move.ends.push_back({step, step});
      if (i == kSamples - 1) move.ends[k][1] = step;
    }
  }
  if (farthest <= kStays * size_) {
    move.ends.clear();
    return move;
  }
  requireAlike(edge.name, edge.besideBare ? farthest : apart);
  move.moves = true;
  move.tolerance = edge.tolerance;
  if (point) return move;
  move.curve = curveOf(edge, images);
  const BRep_GCurve* range = spaceCurve(edge.edge);
  for (int i = 0; i < kSamples; ++i) {
    const double t = static_cast<double>(i) / (kSamples - 1);
    const gp_Pnt here = move.curve->Value(range->First() + (range->Last() - range->First()) * t)
                            .Transformed(range->Location().Transformation());
    for (const Image& image : images) move.tolerance = std::max(move.tolerance, here.Distance(image.point(t)));
  }
  return move;
}

std::optional<gp_Vec> FollowingEdges::cornerMove(const Corner& corner, const std::vector<Move>& moves) const {
  gp_Vec sum(0, 0, 0), first(0, 0, 0);
  int count = 0;
  bool moved = false;
  for (const auto& [e, end] : corner.ends) {
    const gp_Trsf home = edges_[e].place[end].Transformation().Inverted();
    std::vector<std::array<gp_Vec, 2>> still{{gp_Vec(0, 0, 0), gp_Vec(0, 0, 0)}};
    for (const auto& ends : moves[e].ends.empty() ? still : moves[e].ends) {
      const gp_Vec step = ends[end].Transformed(home);
      if (count == 0) first = step;
      moved = moved || step.Magnitude() > kStays * size_;
      requireAlike("the corner of " + edges_[e].name, (step - first).Magnitude(), corner.tolerance);
      sum += step;
      ++count;
    }
  }
  if (!moved) return {};
  return sum / count;
}

void FollowingEdges::noteUsed() {
  used_.clear();
  for (const TopoDS_Shape& face : partsOf(shape_, TopAbs_FACE)) {
    TopLoc_Location ignored;
    const Handle(Geom_Surface) surface = BRep_Tool::Surface(TopoDS::Face(face), ignored);
    if (!surface.IsNull()) used_.insert(surface.get());
  }
}

// How far the ends of its edges lie from a corner, in space and on their faces.
double FollowingEdges::reachOf(const Corner& corner, const ChangedSurfaces& changed) const {
  double reach = 0;
  for (const auto& [e, end] : corner.ends) {
    const gp_Trsf home = edges_[e].place[end].Transformation().Inverted();
    const auto hold = [&](const gp_Pnt& point) {
      reach = std::max(reach, corner.point.Distance(point.Transformed(home)));
    };
    for (const Image& image : imagesOf(edges_[e], changed)) hold(image.point(static_cast<double>(end)));
    const BRep_GCurve* curve = spaceCurve(edges_[e].edge);
    if (curve == nullptr) continue;
    hold(curve->Curve3D()
             ->Value(end == 0 ? curve->First() : curve->Last())
             .Transformed(curve->Location().Transformation()));
  }
  return reach;
}

void FollowingEdges::settle(const ChangedSurfaces& changed) {
  noteUsed();
  const Audit before = auditShape(shape_, 1);
  std::vector<Handle(Geom_Curve)> had(edges_.size());
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    BRep_GCurve* curve = spaceCurve(edges_[e].edge);
    if (curve == nullptr || edges_[e].besideBare || before.edges[e].gap <= edges_[e].tolerance) continue;
    const std::vector<Image> images = imagesOf(edges_[e], changed);
    if (std::all_of(images.begin(), images.end(), [](const Image& i) { return i.original.IsNull(); })) continue;
    try {
      const Handle(Geom_Curve) next = curveOf(edges_[e], images);
      had[e] = curve->Curve3D();
      curve->Curve3D(next);
    } catch (const InvalidInput&) {
      continue;
    } catch (const Standard_Failure&) {
      continue;
    }
  }
  const Audit now = auditShape(shape_, 1);
  std::vector<double> edgeTolerances, cornerTolerances;
  for (const Edge& edge : edges_) edgeTolerances.push_back(dataOf(edge.edge).Tolerance());
  for (const Corner& corner : corners_) cornerTolerances.push_back(dataOf(corner.vertex).Tolerance());
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    if (had[e].IsNull()) continue;
    if (now.edges[e].gap < before.edges[e].gap) {
      dataOf(edges_[e].edge).Tolerance(std::max(edges_[e].tolerance, kBetweenSamples * now.edges[e].gap));
    } else {
      spaceCurve(edges_[e].edge)->Curve3D(had[e]);
      had[e].Nullify();
    }
  }
  for (const Corner& corner : corners_) {
    double tolerance = std::max(corner.tolerance, kBetweenSamples * reachOf(corner, changed));
    for (const auto& [e, end] : corner.ends) tolerance = std::max(tolerance, dataOf(edges_[e].edge).Tolerance());
    dataOf(corner.vertex).Tolerance(tolerance);
  }
  if (!before.valid || auditShape(shape_, 1).valid) return;
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    if (!had[e].IsNull()) spaceCurve(edges_[e].edge)->Curve3D(had[e]);
    dataOf(edges_[e].edge).Tolerance(edgeTolerances[e]);
  }
  for (std::size_t c = 0; c < corners_.size(); ++c) dataOf(corners_[c].vertex).Tolerance(cornerTolerances[c]);
}

void FollowingEdges::follow(const ChangedSurfaces& changed) {
  noteUsed();
  std::vector<Move> moves;
  moves.reserve(edges_.size());
  for (const Edge& edge : edges_) moves.push_back(moveOf(edge, changed));
  std::vector<std::optional<gp_Vec>> corners;
  corners.reserve(corners_.size());
  for (const Corner& corner : corners_) corners.push_back(cornerMove(corner, moves));

  // From here on nothing fails.
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    Edge& edge = edges_[e];
    if (!moves[e].moves && !edge.remade) continue;
    edge.remade = moves[e].moves;
    dataOf(edge.edge).Tolerance(edge.remade ? moves[e].tolerance : edge.tolerance);
    if (BRep_GCurve* curve = spaceCurve(edge.edge)) curve->Curve3D(edge.remade ? moves[e].curve : edge.curve);
  }
  for (std::size_t c = 0; c < corners_.size(); ++c) {
    auto& data = dataOf(corners_[c].vertex);
    data.Pnt(corners[c] ? corners_[c].point.Translated(*corners[c]) : corners_[c].point);
    data.Tolerance(corners_[c].tolerance);
    if (!corners[c]) continue;
    for (const auto& [e, end] : corners_[c].ends) {
      const BRep_GCurve* curve = spaceCurve(edges_[e].edge);
      if (curve == nullptr) continue;
      const gp_Pnt there = curve->Curve3D()
                               ->Value(end == 0 ? curve->First() : curve->Last())
                               .Transformed(curve->Location().Transformation())
                               .Transformed(edges_[e].place[end].Transformation().Inverted());
      data.UpdateTolerance(data.Pnt().Distance(there));
    }
  }
}

}  // namespace strak::cad
