#include "strak/fairing/joint_fairing.h"

#include <algorithm>
#include <limits>

#include "strak/base/error.h"
#include "strak/fairing/shape_descent.h"
#include "strak/metrology/self_intersection.h"

namespace strak {

JointFairing fairJointly(const PartPlan& plan, const JointFairingOptions& options) {
  if (!(options.tolerance >= 0)) throw InvalidInput("the tolerance must not be negative: give a length");
  std::vector<ShapePatch> patches;
  for (std::size_t f = 0; f < plan.surfaces.size(); ++f) {
    patches.push_back({plan.surfaces[f], plan.unknownOf[f], plan.tied});
    if (options.tolerance > 0) continue;
    std::fill(patches.back().unknownOf.begin(), patches.back().unknownOf.end(), -1);
    patches.back().tied.reset();
  }
  std::vector<ShapeJoin> joins;
  for (const Joint& joint : plan.joints) {
    const auto a = static_cast<std::size_t>(joint.a), b = static_cast<std::size_t>(joint.b);
    JoinBank bankA = bankOfSide(plan.surfaces[a], joint.sideA);
    bankA.part = joint.part;
    // The border that is a part of the other has all of its knots there.
    joins.push_back(
        {b, a, bankOfSide(plan.surfaces[b], joint.sideB), bankA, joint.fit.reversed, options.aim == JoinAim::g2});
  }
  for (const MirrorSide& mirror : plan.mirrors) {
    const auto face = static_cast<std::size_t>(mirror.face);
    const JoinBank bank = bankOfSide(plan.surfaces[face], mirror.side);
    joins.push_back({face, face, bank, bank, false, false, mirror.plane.normal});
  }
  ShapeDescent descent = descendShape(patches, joins,
                                      {.tolerance = options.tolerance,
                                       .ballsOnPoints = options.ballsOnPoints,
                                       .maxSteps = options.maxSteps,
                                       .progress = options.progress});
  for (std::size_t f = 0; f < plan.surfaces.size(); ++f) {
    if (!meetingAfterMove(plan.surfaces[f], descent.surfaces[f]).isNew) continue;
    descent.surfaces = plan.surfaces;
    descent.after = descent.before;
    descent.joinsAfter = descent.joinsBefore;
    descent.stopReason = StopReason::meetsItself;
    break;
  }
  JointFairing result{std::move(descent.surfaces),    std::move(descent.before),     std::move(descent.after),
                      std::move(descent.joinsBefore), std::move(descent.joinsAfter), {}};
  FairingSummary& summary = result.summary;
  summary.gap = std::numeric_limits<double>::quiet_NaN();
  summary.steps = descent.steps;
  summary.stopReason = descent.stopReason;
  summary.seconds = descent.seconds;
  summary.freePoints = plan.unknowns;
  summary.activePoints = descent.activeRows;
  for (std::size_t f = 0; f < result.surfaces.size(); ++f) {
    summary.energyBefore += result.before[f].isophoteRoughness;
    summary.energyAfter += result.after[f].isophoteRoughness;
    const Net moved = result.surfaces[f].euclideanNet() - plan.surfaces[f].euclideanNet();
    summary.largestMove = std::max(summary.largestMove, moved.rowwise().norm().maxCoeff());
  }
  return result;
}

}  // namespace strak
