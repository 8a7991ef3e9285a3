#pragma once
//
// How smoothly the faces of a model join at their edges, before and after.

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "strak/exchange/model.h"
#include "strak/fairing/joints.h"
#include "strak/report/before_after.h"

namespace strak {

// The figures of one edge: the largest along it, and root mean squares over its length.
struct EdgeJoin {
  std::string name;            // as in SharedEdge
  Index faceA = 0, faceB = 0;  // numbers of the objects; the same for a seam
  BeforeAfter gap;             // of the faces, model units
  BeforeAfter angle;           // between the tangent planes, degrees
  BeforeAfter curvature;       // jump of the normal curvature across the edge, 1 / length
  BeforeAfter angleMean, curvatureMean;
  double length = 0;  // before
  JointKind kindBefore = JointKind::g0, kindAfter = JointKind::g0;
  std::vector<Eigen::Vector3d> lineBefore, lineAfter;  // the edge on face A
};

// Measures all edges between two spline faces that stand in the same place; `before` and `after` are the surfaces of
// the objects, null for others. Multi-threaded; the result does not depend on the number of threads. Cost: about 0.2 ms
// an edge and state.
std::vector<EdgeJoin> measureJoins(const std::vector<SharedEdge>& edges, const std::vector<const Surface*>& before,
                                   const std::vector<const Surface*>& after, const JointOptions& options = {});

// The edges whose faces can be changed together and that are the whole side of at least one of them, as pairs of object
// numbers; `part` is set where they are only a part of the other's side.
std::vector<SidePair> joinableSides(const std::vector<SharedEdge>& edges);

// The surfaces of all objects for measureJoins, null for the others.
std::vector<const Surface*> surfacesOf(const std::vector<Object>& objects);

struct JoinSummary {
  std::array<Index, 4> before{}, after{};  // how many of each JointKind
  BeforeAfter gap;                         // the largest of all
  BeforeAfter angle, curvature;            // the largest where the edge was no feature before
  BeforeAfter angleMean, curvatureMean;    // root mean squares over the length of all those
};

JoinSummary summaryOf(const std::vector<EdgeJoin>& joins);

}  // namespace strak
