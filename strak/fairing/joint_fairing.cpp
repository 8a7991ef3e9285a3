#include "strak/fairing/joint_fairing.h"

#include <algorithm>
#include <limits>

#include "strak/base/error.h"
#include "strak/fairing/shape_descent.h"

namespace strak {

JointFairing fairJointly(const PartPlan& plan, const JointFairingOptions& options) {
  if (!(options.tolerance >= 0)) throw InvalidInput("the tolerance must not be negative: give a length");
  std::vector<ShapePatch> patches;
  for (std::size_t f = 0; f < plan.surfaces.size(); ++f) patches.push_back({plan.surfaces[f], plan.unknownOf[f]});
  if (options.tolerance == 0) {
    for (ShapePatch& patch : patches) std::fill(patch.unknownOf.begin(), patch.unknownOf.end(), -1);
  }
  std::vector<ShapeJoin> joins;
  for (const Joint& joint : plan.joints) {
    const auto a = static_cast<std::size_t>(joint.a), b = static_cast<std::size_t>(joint.b);
    joins.push_back({a, b, bankOfSide(plan.surfaces[a], joint.sideA), bankOfSide(plan.surfaces[b], joint.sideB),
                     joint.fit.reversed, options.aim == JoinAim::g2});
  }
  ShapeDescent descent = descendShape(patches, joins,
                                      {.tolerance = options.tolerance,
                                       .ballsOnPoints = options.ballsOnPoints,
                                       .maxSteps = options.maxSteps,
                                       .progress = options.progress});
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
