#pragma once
//
// Faces of a part in a wished form, so that their joins hold.
//
// Faces that share a whole side at the same parameters get as many uniform spans along it as the one that needs the
// most, handed on from face to face: their border is then one curve, approximated once (a border of convertSpline
// depends on that border and its knots alone). Everywhere else a face stays as near to what it was along its joins as
// these may open: along its sides by spans enough for these alone, along trimmed edges by a smaller tolerance of the
// whole face, which is also what keeps angles.

#include <optional>
#include <string>
#include <vector>

#include "strak/fairing/conversion.h"

namespace strak {

struct PartFace {
  std::string name;  // for messages
  Surface surface;
};

// Where a face meets another one, which is not changed if it has no number. Lines and sides as in Model::sharedEdges.
struct PartEdge {
  Index face = 0;
  std::optional<Index> other;
  std::vector<Eigen::Vector2d> line, otherLine;
  std::optional<int> side, otherSide;    // whole sides
  std::optional<int> along, otherAlong;  // sides on which the edge lies, whole or in part
  bool samePlace = true;                 // both faces have the same coordinates
};

struct PartConversionOptions {
  ConversionOptions each;  // leastSpans and sideTolerances are not looked at
  // What a join may open by. Infinity: whole sides are kept common, and nothing else is looked at.
  double joinTolerance = std::numeric_limits<double>::infinity();
  // What the angle at a join that is no feature (up to 3 degrees) may change by, in degrees, measured at places along
  // it. Infinity: whatever comes.
  double joinAngle = std::numeric_limits<double>::infinity();
};

struct ConvertedPart {
  std::vector<Converted<2>> faces;
  Index common = 0, near = 0;      // joins that are one curve on both faces, and that are held by nearness
  std::vector<std::string> loose;  // faces whose joins may open by their deviation: mostPoints allow no more
};

// Throws as convertSpline, with the face's name. A face that does not reach the tolerance itself says so in its
// Converted. Cost: every face some times.
ConvertedPart convertPart(const std::vector<PartFace>& faces, const std::vector<PartEdge>& edges,
                          const PartConversionOptions& options);

}  // namespace strak
