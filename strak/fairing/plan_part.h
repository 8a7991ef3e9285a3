#pragma once
//
// What must be settled before several faces are made fair together: which of their control points are one and the
// same, which are held, and which knots are needed for that.

#include <memory>

#include "strak/fairing/joints.h"
#include "strak/fairing/plan_face.h"
#include "strak/solve/tied_points.h"

namespace strak {

struct PartFace {
  Surface surface;
  FaceBorder border;
  // Planes of symmetry in which sides without a neighbour move.
  std::array<std::optional<SymmetryPlane>, 4> mirror = {};
};

// A side that lies in a plane of symmetry.
struct MirrorSide {
  Index face = 0;
  int side = 0;
  SymmetryPlane plane;
};

struct PartPlan {
  std::vector<Surface> surfaces;            // with the knots needed: the same shapes to rounding
  std::vector<std::vector<int>> unknownOf;  // by faces and control points: the number of the unknown, -1: held
  // How the points numbered there follow from fewer unknowns; null: they are the unknowns.
  std::shared_ptr<const TiedPoints> tied;
  Index unknowns = 0;
  std::vector<Joint> joints;                    // along which the faces move together
  std::vector<MirrorSide> mirrors;              // that move in their planes
  std::vector<std::vector<std::string>> notes;  // by faces
  std::vector<std::string> leftAlone;           // by faces: why nothing of it moves; empty if something does
};

// `pairs`: sides that meet, both natural sides of their faces, or a whole one and a part of one; a face may meet itself
// (a seam, which stays as smooth as it is). Those that are smooth (no feature edge) and whose borders fit, if need be
// after knots are inserted, are joined: their border points move together (along a part, those of the whole side
// follow), and no row behind them is held. Sides in a plane of symmetry move in it, nothing behind them is held either.
// Along all other sides, and what of a side no joined part covers, `options.rows` are held. Corners that also touch a
// side that is not joined stay. `joints.gapLimit`: how far partners may be apart (they stay as far apart as they are).
// Throws InvalidInput as planFace and measureJoints do. Cost as theirs, a few times.
PartPlan planPart(const std::vector<PartFace>& faces, const std::vector<SidePair>& pairs, const PlanOptions& options,
                  const JointOptions& jointOptions = {});

// The faces that move together: sets that share no unknown with one another, each ascending, of faces with a joint or a
// mirror. The others gain nothing from the part. Cost O(control points).
std::vector<std::vector<Index>> facesThatMoveTogether(const PartPlan& plan);

}  // namespace strak
