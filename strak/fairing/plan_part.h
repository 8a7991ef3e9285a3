#pragma once
//
// What must be settled before several faces are made fair together: which of their control points are one and the
// same, which are held, and which knots are needed for that.

#include "strak/fairing/joints.h"
#include "strak/fairing/plan_face.h"

namespace strak {

struct PartFace {
  Surface surface;
  FaceBorder border;
};

struct PartPlan {
  std::vector<Surface> surfaces;            // with the knots needed: the same shapes to rounding
  std::vector<std::vector<int>> unknownOf;  // by faces and control points: the number of the unknown, -1: held
  Index unknowns = 0;
  std::vector<Joint> joints;                    // along which the faces move together
  std::vector<std::vector<std::string>> notes;  // by faces
  std::vector<std::string> leftAlone;           // by faces: why nothing of it moves; empty if something does
};

// `pairs`: sides that meet, whole, both natural sides of their faces. Those that are smooth (no feature edge) and whose
// borders fit, if need be after knots are inserted, are joined: their border points move together and no row behind
// them is held. Along all other sides `options.rows` are held. Corners that also touch a side that is not joined stay.
// `joints.gapLimit`: how far partners may be apart (they stay as far apart as they are).
// Throws InvalidInput as planFace and measureJoints do. Cost as theirs, a few times.
PartPlan planPart(const std::vector<PartFace>& faces, const std::vector<SidePair>& pairs, const PlanOptions& options,
                  const JointOptions& jointOptions = {});

}  // namespace strak
