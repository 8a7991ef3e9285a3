#include "strak/fairing/exact_fairing.h"

#include <algorithm>
#include <limits>

#include "strak/base/error.h"
#include "strak/energy/shape_energy.h"
#include "strak/fairing/shape_descent.h"

namespace strak {

namespace {

constexpr double kLittle = 0.01;      // of the roughness
constexpr double kSingular = 0.9999;  // of the roughness in ...
constexpr double kFewCells = 0.05;    // ... this part of the cells at most

ShapePatch patchOf(const Surface& input, const HeldPoints& held) {
  ShapePatch patch{input, std::vector<int>(static_cast<std::size_t>(input.net().rows()), -1)};
  int unknowns = 0;
  for (std::size_t r = 0; r < patch.unknownOf.size(); ++r) {
    if (held.empty() || held[r] == 0) patch.unknownOf[r] = unknowns++;
  }
  return patch;
}

// The held points and those of the few cells that have nearly all the roughness; empty if there are none, or nothing
// else would be free.
HeldPoints holdSingularCells(const ShapePatch& patch, const HeldPoints& held) {
  auto cells = ShapeEnergy(patch.surface, patch.unknownOf).roughnessOfCells(patch.surface.euclideanNet());
  std::sort(cells.begin(), cells.end(), [](const auto& a, const auto& b) { return a.roughness > b.roughness; });
  double total = 0, sum = 0;
  for (const auto& cell : cells) total += cell.roughness;
  HeldPoints result = held;
  result.resize(patch.unknownOf.size(), 0);
  const auto few = static_cast<std::size_t>(kFewCells * static_cast<double>(cells.size()));
  for (std::size_t c = 0; c < few; ++c) {
    sum += cells[c].roughness;
    for (Index row : cells[c].points) result[static_cast<std::size_t>(row)] = 1;
    if (sum < kSingular * total) continue;
    return std::count(result.begin(), result.end(), 0) > 0 ? result : HeldPoints();
  }
  return {};
}

}  // namespace

ExactFairing fairExactly(const Surface& input, const HeldPoints& held, const ExactFairingOptions& options) {
  if (!(options.tolerance >= 0)) throw InvalidInput("the tolerance must not be negative: give a length");
  if (!held.empty() && static_cast<Index>(held.size()) != input.net().rows()) {
    throw InvalidInput("the list of held points must have one entry a control point");
  }
  ShapePatch patch = patchOf(input, options.tolerance > 0 ? held : HeldPoints(input.net().rows(), 1));
  if (!(options.tolerance < kUnlimited) &&
      std::find(patch.unknownOf.begin(), patch.unknownOf.end(), -1) == patch.unknownOf.end()) {
    throw InvalidInput(
        "without a tolerance the fairest surface is a plane: give a tolerance, or hold rows at its borders");
  }
  const ShapeDescentOptions descentOptions{.tolerance = options.tolerance,
                                           .ballsOnPoints = options.ballsOnPoints,
                                           .maxSteps = options.maxSteps,
                                           .progress = options.progress};
  ShapeDescent descent = descendShape({patch}, {}, descentOptions);
  const double gain = 1 - descent.after.front().isophoteRoughness / descent.before.front().isophoteRoughness;
  if (!(gain > kLittle) && descent.stopReason != StopReason::cancelled) {
    // A singular corner, say, whose roughness drowns all the rest: without it there may be something to gain.
    const HeldPoints calm = holdSingularCells(patch, held);
    if (!calm.empty()) {
      patch = patchOf(input, calm);
      descent = descendShape({patch}, {}, descentOptions);
    }
  }
  const Index unknowns = std::count_if(patch.unknownOf.begin(), patch.unknownOf.end(), [](int u) { return u >= 0; });
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
