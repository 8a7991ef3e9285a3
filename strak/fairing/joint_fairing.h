#pragma once
//
// Fairing of several faces at once, with the joins between them: shared border curves move inside the tolerance, the
// faces on both sides with them, and angle and curvature across the joins get smaller together with the roughness of
// the faces.
//
// Borders in a plane of symmetry move in it, and the angle to the mirrored face gets smaller like that of a join.
//
// Method: the descent of exact_fairing.h with all faces in one system; a join's angle and curvature jump count as
// roughness (JoinEnergy) and are guarded like every other figure.

#include "strak/base/progress.h"
#include "strak/energy/join_energy.h"
#include "strak/fairing/faired.h"
#include "strak/fairing/plan_part.h"
#include "strak/metrology/fairness.h"

namespace strak {

// What the joins are to become inside the tolerance.
enum class JoinAim {
  g1,  // tangent planes agree as well as they can
  g2,  // tangent planes and curvatures
};

struct JointFairingOptions {
  double tolerance = kUnlimited;
  bool ballsOnPoints = false;
  JoinAim aim = JoinAim::g2;
  int maxSteps = 100;
  Progress progress = {};
};

struct JointFairing {
  std::vector<Surface> surfaces;                     // in the order of the plan
  std::vector<SurfaceFairness> before, after;        // over the knot cells that free points move
  std::vector<JoinFigures> joinsBefore, joinsAfter;  // of the plan's joints, then its mirrors
  FairingSummary summary;                            // of all together; its energy is the isophote roughness
};

// Fairs the faces of a plan. Guarantees for every face those of fairExactly, and that no joint gets a larger mean
// angle or mean curvature jump; the largest angle at one place of a joint may rise to 0.1 degrees. Faces
// for which that cannot be had keep still, and the others move around them. Where a face meets
// itself that did not before (meetingAfterMove) all come back as they were, with StopReason::meetsItself. Throws
// InvalidInput as fairExactly does.
JointFairing fairJointly(const PartPlan& plan, const JointFairingOptions& options = {});

}  // namespace strak
