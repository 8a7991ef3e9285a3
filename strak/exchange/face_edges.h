#pragma once
//
// Edges of faces in their parameter planes, and which of them are the same edge of the part.

#include <string>
#include <vector>

#include "strak/exchange/model.h"

namespace strak {

// An edge as one of its faces has it.
struct FaceEdge {
  Index face = 0;  // number of the object
  std::string name;
  std::vector<Eigen::Vector2d> line;  // as in SharedEdge
  std::optional<int> side, along;     // as in SharedEdge
  bool left = true;                   // the face lies to the left of the line
  double tolerance = 0;               // another edge this near is the same one
};

// A whole side of a surface's domain, running with the other parameter.
FaceEdge sideEdge(const Surface& surface, Index face, int side);

// Sets side and along of an edge whose line is known and, if it lies along a side, also left.
void findSide(const Surface& surface, FaceEdge& edge);

// The edge between two faces whose lines run the same way, or opposite ways.
SharedEdge sharedEdge(const FaceEdge& a, const FaceEdge& b, bool oppositeWays);

// The edges that coincide in space within their tolerances, from end to end, whatever their parameters: none where an
// edge is shorter than its tolerance. Then, of those left over, whole sides that lie on a part of another side; the
// part is line A. `surfaces` are those of the objects, in one common place; none for those that do not take part. Cost
// O(n log n) plus some dozen surface points a pair of neighbours, and O(n^2) comparisons of boxes for n edges left
// over.
std::vector<SharedEdge> coincidentEdges(const std::vector<FaceEdge>& edges,
                                        const std::vector<const Surface*>& surfaces);

// Marks the edges where more than two faces meet as not joinable.
void markCrowded(std::vector<SharedEdge>& edges);

}  // namespace strak
