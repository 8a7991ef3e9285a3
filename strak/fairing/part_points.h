#pragma once
//
// Which control points of a part are one and the same, which are held, and which follow others: what its joints and
// planes of symmetry leave to move.

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
  // The border moves perpendicular to the normal only.
  void confine(Index face, int side, const Eigen::Vector3d& normal);
  // The point stays, and with it all that are the same.
  void hold(Index face, Index row);

  struct Result {
    std::vector<std::vector<int>> pointOf;   // by faces and control points: number of the point, -1: held
    std::shared_ptr<const TiedPoints> tied;  // null: every point is an unknown of its own
    Index unknowns = 0;
  };
  // Eliminates: what follows a held point takes a degree of freedom from the points it follows.
  Result solve();

 private:
  struct Follower {
    Index point;
    std::vector<std::pair<Index, double>> terms;
  };
  Index number(Index face, Index row) const { return first_[static_cast<std::size_t>(face)] + row; }
  Index root(Index i);
  void merge(Index a, Index b);

  const std::vector<Surface>& surfaces_;
  std::vector<Index> first_, parent_;
  std::vector<Follower> followers_;
  std::vector<std::pair<Index, Eigen::Vector3d>> confined_;
  std::vector<Index> held_;
};

}  // namespace strak
