#include "strak/fairing/exact_fairing.h"

#include <algorithm>
#include <limits>

#include "strak/base/error.h"
#include "strak/fairing/shape_descent.h"

namespace strak {

ExactFairing fairExactly(const Surface& input, const HeldPoints& held, const ExactFairingOptions& options) {
  if (!(options.tolerance >= 0)) throw InvalidInput("the tolerance must not be negative: give a length");
  if (!held.empty() && static_cast<Index>(held.size()) != input.net().rows()) {
    throw InvalidInput("the list of held points must have one entry a control point");
  }
  ShapePatch patch{input, std::vector<int>(static_cast<std::size_t>(input.net().rows()), -1)};
  int unknowns = 0;
  for (std::size_t r = 0; r < patch.unknownOf.size(); ++r) {
    if (options.tolerance > 0 && (held.empty() || held[r] == 0)) patch.unknownOf[r] = unknowns++;
  }
  if (!(options.tolerance < kUnlimited) && unknowns == input.net().rows()) {
    throw InvalidInput(
        "without a tolerance the fairest surface is a plane: give a tolerance, or hold rows at its borders");
  }
  ShapeDescent descent = descendShape({patch}, {},
                                      {.tolerance = options.tolerance,
                                       .ballsOnPoints = options.ballsOnPoints,
                                       .maxSteps = options.maxSteps,
                                       .progress = options.progress});
  ExactFairing result{std::move(descent.surfaces.front()), descent.before.front(), descent.after.front(), {}};
  FairingSummary& summary = result.summary;
  summary.energyBefore = result.before.isophoteRoughness;
  summary.energyAfter = result.after.isophoteRoughness;
  summary.gap = std::numeric_limits<double>::quiet_NaN();
  summary.steps = descent.steps;
  summary.stopReason = descent.stopReason;
  summary.seconds = descent.seconds;
  summary.freePoints = unknowns;
  summary.activePoints = descent.activeRows;
  const Net before = input.euclideanNet(), after = result.spline.euclideanNet();
  summary.largestMove = (after - before).rowwise().norm().maxCoeff();
  return result;
}

}  // namespace strak
