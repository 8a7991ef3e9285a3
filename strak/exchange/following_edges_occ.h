#pragma once
//
// Edges and corners that follow their faces when borders move. Only for the *_occ.cpp files.
//
// An edge has a curve in space beside its curves in the faces' parameters. Where a face's border moves, the latter stay
// and the former is made anew from them: the isoparametric curve of the surface, exactly, or the mean of both faces'.
// The kernel's own repair would only widen tolerances until the gap hides in them.

#include <Geom_BSplineSurface.hxx>
#include <Geom_Curve.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Shape.hxx>
#include <TopoDS_Vertex.hxx>
#include <array>
#include <gp_Pnt.hxx>
#include <gp_Vec.hxx>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace strak::cad {

// The surfaces that differ from what was read, each with its copy as read (of the same parameters).
using ChangedSurfaces = std::map<const Geom_Surface*, Handle(Geom_BSplineSurface)>;

class FollowingEdges {
 public:
  FollowingEdges() = default;

  // Remembers the edges and corners of the shape as they are now, which must be as read. Lengths are the kernel's.
  FollowingEdges(const TopoDS_Shape& shape, double size);

  // Makes every edge and corner what the surfaces ask for: as read where these are as read, else moved with them.
  // Depends on the surfaces only, not on what was done before. Throws InvalidInput that names the edge, and changes
  // nothing, if its faces do not move alike within 1e-9 of the size, or the faces at a corner not within that or a
  // tenth of the corner's tolerance.
  void follow(const ChangedSurfaces& changed);

  // After surfaces have got another form of nearly the same shape, and the tolerances of edges that lie too far from
  // them have been raised: such an edge gets the curve that its faces have there, if it fits them better, and the
  // tolerances become what is measured. Corners stay in their places. Does nothing where the checker would mind.
  void settle(const ChangedSurfaces& changed);

 private:
  struct Edge {
    std::string name;
    TopoDS_Edge edge;  // in the place and sense of its TShape
    Handle(Geom_Curve) curve;
    double tolerance = 0;
    std::array<std::size_t, 2> corner{};   // at its start and end: numbers in corners_
    std::array<TopLoc_Location, 2> place;  // of the corners in the edge
    bool besideBare = false;               // bounds a plane that has no curve of it in its parameters
    bool remade = false;
  };
  struct Corner {
    TopoDS_Vertex vertex;
    gp_Pnt point;
    double tolerance = 0;
    std::vector<std::pair<std::size_t, std::size_t>> ends;  // numbers of edges, and 0 for the start or 1 for the end
  };
  struct Move;
  struct Image;

  std::vector<Image> imagesOf(const Edge& edge, const ChangedSurfaces& changed) const;
  Move moveOf(const Edge& edge, const ChangedSurfaces& changed) const;
  Handle(Geom_Curve) curveOf(const Edge& edge, const std::vector<Image>& images) const;
  std::optional<gp_Vec> cornerMove(const Corner& corner, const std::vector<Move>& moves) const;
  void noteUsed();
  double reachOf(const Corner& corner, const ChangedSurfaces& changed) const;
  void requireAlike(const std::string& what, double apart, double tolerance = 0) const;

  double size_ = 0;
  TopoDS_Shape shape_;
  std::vector<Edge> edges_;
  std::vector<Corner> corners_;
  std::set<const Geom_Surface*> used_;  // by faces
};

}  // namespace strak::cad
