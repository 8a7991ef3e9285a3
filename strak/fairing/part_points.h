#pragma once
//
// Which control points of a part are one and the same, which are held, and which follow others: what its joints and
// planes of symmetry leave to move.

#include <map>
#include <memory>
#include <vector>

#include "strak/fairing/held_points.h"
#include "strak/fairing/joints.h"
#include "strak/solve/tied_points.h"

namespace strak {

class PartPoints {
 public:
  // Corners within `sameCorner` are one vertex of the part, whatever edges lead there.
  PartPoints(const std::vector<Surface>& surfaces, double sameCorner);

  // The borders move alike: of whole sides partners are one point; where side B is a part of side A its points are the
  // combinations BorderFit::fromA, with weights those that keep the rational borders together.
  void join(const Joint& joint);
  // The derivatives up to `order` across the face's seam in `direction` go on alike on both sides: 1 ... degree - 1.
  void smoothSeam(Index face, int direction, int order);
  // The border moves perpendicular to the normal only.
  void confine(Index face, int side, const Eigen::Vector3d& normal);
  // The row behind it moves alike within the plane: a surface that is perpendicular to it stays so.
  void keepPerpendicular(Index face, int side, const Eigen::Vector3d& normal);
  // The point stays, and with it all that are the same.
  void hold(Index face, Index row);

  struct Result {
    std::vector<std::vector<int>> pointOf;   // by faces and control points: number of the point, -1: held
    std::shared_ptr<const TiedPoints> tied;  // null: every point is an unknown of its own
    Index unknowns = 0;
  };
  // Eliminates what follows; what follows a held point takes a degree of freedom from the points it follows.
  Result solve();

 private:
  // The sum over the terms of weight * move is zero.
  struct Equation {
    Index follower;  // the point to be eliminated if nothing is in the way
    std::vector<std::pair<Index, double>> terms;
  };
  Index number(Index face, Index row) const { return first_[static_cast<std::size_t>(face)] + row; }
  Index root(Index i);
  void merge(Index a, Index b);

  const std::vector<Surface>& surfaces_;
  std::vector<Index> first_, parent_;
  std::vector<Equation> equations_;
  struct Beside {
    Index border, behind;
    Eigen::Vector3d normal;
  };
  using Row = std::map<Index, double>;  // a combination of points
  void addBeside();
  std::map<Index, Row> eliminate(const std::vector<bool>& fixed);

  std::vector<std::pair<Index, Eigen::Vector3d>> confined_;
  std::vector<Beside> beside_;
  std::vector<Index> held_;
};

}  // namespace strak
