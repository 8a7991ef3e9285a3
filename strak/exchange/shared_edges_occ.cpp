#include "strak/exchange/shared_edges_occ.h"

#include <BRep_Tool.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_DataMapOfShapeInteger.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "strak/exchange/cad_file_occ.h"
#include "strak/exchange/cad_geometry_occ.h"
#include "strak/exchange/face_edges.h"

namespace strak::cad {
namespace {

constexpr int kSamples = 201;       // of an edge that is not straight in the parameter plane
constexpr int kSamplesPerSpan = 8;  // of one with many spans
constexpr double kStraight = 1e-9;  // of the domain

using Polyline = std::vector<Eigen::Vector2d>;

Eigen::Vector2d pointAt(const Geom2d_Curve& curve, double t) {
  const gp_Pnt2d point = curve.Value(t);
  return {point.X(), point.Y()};
}

// Two points where these say it all.
Polyline sampled(const Geom2d_Curve& curve, double from, double to, const Surface& surface) {
  int count = kSamples;
  if (const auto* spline = dynamic_cast<const Geom2d_BSplineCurve*>(&curve)) {
    count = std::max(count, kSamplesPerSpan * (spline->NbKnots() - 1) + 1);
  }
  Polyline line;
  for (int i = 0; i < count; ++i) line.push_back(pointAt(curve, from + (to - from) * i / (count - 1)));
  const Eigen::Vector2d slack = kStraight * Eigen::Vector2d(surface.knots(0).length(), surface.knots(1).length());
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d chord = line.front() + (line.back() - line.front()) * i / (count - 1);
    const auto& point = line[static_cast<std::size_t>(i)];
    if (((point - chord).cwiseAbs().array() > slack.array()).any()) return line;
  }
  return {line.front(), line.back()};
}

bool samePlace(const gp_Trsf& a, const gp_Trsf& b) {
  for (int row = 1; row <= 3; ++row) {
    for (int column = 1; column <= 4; ++column) {
      if (a.Value(row, column) != b.Value(row, column)) return false;
    }
  }
  return true;
}

// What is in the way of changing both faces together.
std::string obstacle(const SharedEdge& edge, const std::vector<Object>& objects) {
  const auto a = static_cast<std::size_t>(edge.faceA), b = static_cast<std::size_t>(edge.faceB);
  if (!objects[a].sharedWith.empty() || !objects[b].sharedWith.empty()) return "a surface is used by several faces";
  if (!edge.samePlace) return "the faces stand in different places of an assembly";
  return "";
}

}  // namespace

std::vector<TopoDS_Edge> distinctEdges(const TopoDS_Shape& shape) {
  std::vector<TopoDS_Edge> edges;
  std::set<const TopoDS_TShape*> seen;
  for (const TopoDS_Shape& edge : partsOf(shape, TopAbs_EDGE)) {
    if (seen.insert(edge.TShape().get()).second) edges.push_back(TopoDS::Edge(edge));
  }
  return edges;
}

std::vector<SharedEdge> sharedEdgesOf(const TopoDS_Shape& shape, const std::vector<Object>& objects,
                                      const std::vector<gp_Trsf>& places, double unitLength, double tolerance) {
  std::map<const TopoDS_TShape*, int> numbers;
  for (const TopoDS_Edge& edge : distinctEdges(shape)) {
    numbers.emplace(edge.TShape().get(), static_cast<int>(numbers.size()) + 1);
  }
  // Every edge in its place with all the faces it bounds.
  struct Use {
    int faces = 0;
    std::vector<FaceEdge> splines;
    std::vector<Index> others;  // faces that are no splines, or have no curve of it in their parameters
  };
  std::vector<Use> uses;
  TopTools_DataMapOfShapeInteger known;
  const std::vector<TopoDS_Shape> faces = partsOf(shape, TopAbs_FACE);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const TopoDS_Face face = TopoDS::Face(faces[f].Oriented(TopAbs_FORWARD));
    for (TopExp_Explorer all(face, TopAbs_EDGE); all.More(); all.Next()) {
      const TopoDS_Edge& edge = TopoDS::Edge(all.Current());
      if (BRep_Tool::Degenerated(edge)) continue;
      if (!known.IsBound(edge)) {
        known.Bind(edge, static_cast<int>(uses.size()));
        uses.emplace_back();
      }
      Use& use = uses[static_cast<std::size_t>(known.Find(edge))];
      ++use.faces;
      double from = 0, to = 0;
      Handle(Geom2d_Curve) curve;
      if (objects[f].spline) curve = BRep_Tool::CurveOnSurface(edge, face, from, to);
      if (curve.IsNull()) {
        use.others.push_back(static_cast<Index>(f));
        continue;
      }
      const auto& surface = std::get<Surface>(*objects[f].spline);
      FaceEdge own;
      own.face = static_cast<Index>(f);
      own.name = fmt::format("edge {}", numbers.at(edge.TShape().get()));
      own.line = sampled(*curve, from, to, surface);
      own.left = edge.Orientation() == TopAbs_FORWARD;
      own.tolerance = std::max(BRep_Tool::Tolerance(edge) / unitLength, tolerance);
      findSide(surface, own);
      use.splines.push_back(std::move(own));
    }
  }

  std::vector<SharedEdge> result;
  std::vector<FaceEdge> single;
  for (const Use& use : uses) {
    if (use.faces == 1 && use.splines.size() == 1) single.push_back(use.splines.front());
    for (std::size_t a = 0; a < use.splines.size(); ++a) {
      for (const Index other : use.others) {
        FaceEdge unknown;
        unknown.face = other;
        result.push_back(sharedEdge(use.splines[a], unknown, false));
        result.back().notJoinable = "the other face is not a B-spline";
      }
      for (std::size_t b = a + 1; b < use.splines.size(); ++b) {
        result.push_back(sharedEdge(use.splines[a], use.splines[b], false));
        if (use.faces > 2) result.back().notJoinable = "more than two faces meet there";
      }
    }
  }
  std::vector<Surface> placedCopies;
  std::vector<const Surface*> surfaces(objects.size(), nullptr);
  placedCopies.reserve(single.size());
  for (const FaceEdge& edge : single) {
    const auto f = static_cast<std::size_t>(edge.face);
    if (surfaces[f] != nullptr) continue;
    surfaces[f] = &std::get<Surface>(*objects[f].spline);
    if (places[f].Form() == gp_Identity) continue;
    placedCopies.push_back(std::get<Surface>(placed(*objects[f].spline, places[f], unitLength)));
    surfaces[f] = &placedCopies.back();
  }
  std::vector<SharedEdge> unsewn = coincidentEdges(single, surfaces);
  markCrowded(unsewn);
  std::move(unsewn.begin(), unsewn.end(), std::back_inserter(result));
  for (SharedEdge& edge : result) {
    edge.samePlace =
        samePlace(places[static_cast<std::size_t>(edge.faceA)], places[static_cast<std::size_t>(edge.faceB)]);
    if (edge.notJoinable.empty()) edge.notJoinable = obstacle(edge, objects);
  }
  return result;
}

}  // namespace strak::cad
