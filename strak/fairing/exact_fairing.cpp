#include "strak/fairing/exact_fairing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "strak/base/error.h"
#include "strak/energy/shape_energy.h"
#include "strak/energy/shape_residuals.h"
#include "strak/fairing/shape_descent.h"
#include "strak/metrology/self_intersection.h"
#include "strak/spline/evaluate.h"

namespace strak {

namespace {

constexpr int kSmallerMoves = 3;       // tried where a result meets itself
constexpr double kLittle = 0.01;       // of the figures: less is not worth a move
constexpr double kDiverges = 0.01;     // relative error of integrals that will not converge
constexpr double kBlowUp = 30;         // of the roughness: what a cell must have, by one place in it, to be singular
constexpr double kSingular = 0.9999;   // of the roughness in ...
constexpr double kMostlyRight = 0.01;  // relative error of the sum over cells that converge
constexpr double kFewCells = 0.05;     // ... this part of the cells at most

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

// The held points and those of the cells that touch a singular place: one without a normal, or where the roughness
// blows up. Its integrals diverge there, so nothing could be said of them; held, they are the same before and after.
// Empty if there is none, or nothing else would be free.
HeldPoints holdSingularPlaces(const ShapePatch& patch, const HeldPoints& held) {
  const Surface& surface = patch.surface;
  const double total = ShapeEnergy(surface, patch.unknownOf).values(surface.euclideanNet()).roughness;
  // The ends and the middles of all spans: an even number is an end.
  Surface::Grid grid;
  std::array<std::vector<Index>, 2> spans;
  for (std::size_t k = 0; k < 2; ++k) {
    const KnotVector& knots = surface.knots(static_cast<int>(k));
    spans[k] = knots.spans();
    for (Index s : spans[k]) grid[k].insert(grid[k].end(), {knots[s], (knots[s] + knots[s + 1]) / 2});
    grid[k].push_back(knots.to());
  }
  const Net all = derivativesOnGrid(surface, grid, 3);
  HeldPoints result = held;
  result.resize(patch.unknownOf.size(), 0);
  bool found = false;
  const auto hold = [&](std::size_t i, std::size_t j) {
    for (Index a = spans[0][i] - surface.degree(0); a <= spans[0][i]; ++a) {
      for (Index b = spans[1][j] - surface.degree(1); b <= spans[1][j]; ++b) {
        result[static_cast<std::size_t>(surface.row({a, b}))] = 1;
      }
    }
  };
  for (std::size_t i = 0; i < grid[0].size(); ++i) {
    for (std::size_t j = 0; j < grid[1].size(); ++j) {
      // A row a place: the point itself, then its derivatives.
      const Eigen::Map<const ShapeDerivatives> place(all.row(static_cast<Index>(i * grid[1].size() + j)).data() + 3);
      const ShapeDerivatives x = place;
      std::array<double, kShapeResiduals> r;
      double density = 0;
      const bool regular = shapeResiduals(x, r);
      for (int k = 0; k < kRoughnessResiduals; ++k)
        density += r[static_cast<std::size_t>(k)] * r[static_cast<std::size_t>(k)];
      for (std::size_t a = i > 0 ? (i - 1) / 2 : 0; a <= i / 2 && a < spans[0].size(); ++a) {
        for (std::size_t b = j > 0 ? (j - 1) / 2 : 0; b <= j / 2 && b < spans[1].size(); ++b) {
          const KnotVector &u = surface.knots(0), &v = surface.knots(1);
          const double cell = (u[spans[0][a] + 1] - u[spans[0][a]]) * (v[spans[1][b] + 1] - v[spans[1][b]]);
          if (regular && !(density * cell > kBlowUp * total)) continue;
          hold(a, b);
          found = true;
        }
      }
    }
  }
  return found && std::count(result.begin(), result.end(), 0) > 0 ? result : HeldPoints();
}

// The held points and those of the cells whose roughness finer quadratures do not agree on: there the integral
// diverges, at a cusp inside a cell, say, and drowns the rest. As few cells as leave a sum that is mostly right; `held`
// itself if all converge or nothing else would be free.
HeldPoints holdDivergingCells(const Surface& surface, HeldPoints held) {
  const int least = std::max(surface.degree(0), surface.degree(1)) + 1;
  for (int nodes : {least, 2 * least}) {
    const ShapePatch patch = patchOf(surface, held);
    const Net net = surface.euclideanNet();
    auto cells = ShapeEnergy(surface, patch.unknownOf, nodes).roughnessOfCells(net);
    const auto finer = ShapeEnergy(surface, patch.unknownOf, 2 * nodes).roughnessOfCells(net);
    std::vector<std::size_t> order(cells.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto error = [&](std::size_t c) { return std::abs(finer[c].roughness - cells[c].roughness); };
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return error(a) < error(b); });
    double sum = 0, errors = 0;
    std::size_t calm = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
      sum += finer[order[i]].roughness;
      errors += error(order[i]);
      if (errors <= kMostlyRight * sum) calm = i + 1;
    }
    HeldPoints more = held;
    more.resize(patch.unknownOf.size(), 0);
    for (std::size_t i = calm; i < order.size(); ++i) {
      for (Index row : cells[order[i]].points) more[static_cast<std::size_t>(row)] = 1;
    }
    if (std::count(more.begin(), more.end(), 0) > 0) held = std::move(more);
  }
  return held;
}

struct Attempt {
  ShapeDescent descent;
  Index unknowns = 0;
};

Attempt attempt(const Surface& input, const HeldPoints& held, const ShapeDescentOptions& options) {
  HeldPoints calm = held;
  ShapePatch patch = patchOf(input, calm);
  Attempt result{descendShape({patch}, {}, options)};
  ShapeDescent& descent = result.descent;
  const auto gainsLittle = [&] {
    const SurfaceFairness &before = descent.before.front(), &after = descent.after.front();
    return !(after.isophoteRoughness < (1 - kLittle) * before.isophoteRoughness) &&
           !(after.plate < (1 - kLittle) * before.plate);
  };
  const auto again = [&](HeldPoints more) {
    if (more.empty() || descent.stopReason == StopReason::cancelled) return;
    calm = std::move(more);
    patch = patchOf(input, calm);
    descent = descendShape({patch}, {}, options);
  };
  const auto diverges = [&] { return descent.after.front().relativeError > kDiverges; };
  if (diverges()) again(holdSingularPlaces(patch, held));
  if (diverges()) again(holdDivergingCells(input, calm));
  // A singular corner, say, whose roughness drowns all the rest: without it there may be something to gain.
  if (gainsLittle()) again(holdSingularCells(patch, calm));
  if (diverges()) again(holdDivergingCells(input, calm));
  if (gainsLittle()) {
    // Not worth a move: where one rough place has most of the roughness, a little less there may cost waves elsewhere.
    descent.surfaces.front() = input;
    descent.after = descent.before;
  }
  result.unknowns = std::count_if(patch.unknownOf.begin(), patch.unknownOf.end(), [](int u) { return u >= 0; });
  return result;
}

double largestMove(const Surface& a, const Surface& b) {
  return (a.euclideanNet() - b.euclideanNet()).rowwise().norm().maxCoeff();
}

}  // namespace

ExactFairing fairExactly(const Surface& input, const HeldPoints& held, const ExactFairingOptions& options) {
  if (!(options.tolerance >= 0)) throw InvalidInput("the tolerance must not be negative: give a length");
  if (!held.empty() && static_cast<Index>(held.size()) != input.net().rows()) {
    throw InvalidInput("the list of held points must have one entry a control point");
  }
  const HeldPoints all = options.tolerance > 0 ? held : HeldPoints(static_cast<std::size_t>(input.net().rows()), 1);
  if (!(options.tolerance < kUnlimited) && std::find(all.begin(), all.end(), 1) == all.end()) {
    throw InvalidInput(
        "without a tolerance the fairest surface is a plane: give a tolerance, or hold rows at its borders");
  }
  ShapeDescentOptions descentOptions{.tolerance = options.tolerance,
                                     .ballsOnPoints = options.ballsOnPoints,
                                     .maxSteps = options.maxSteps,
                                     .progress = options.progress};
  Attempt best = attempt(input, all, descentOptions);
  ShapeDescent& descent = best.descent;
  for (int smaller = 0; meetingAfterMove(input, descent.surfaces.front()).isNew; ++smaller) {
    if (smaller == kSmallerMoves || descent.stopReason == StopReason::cancelled) {
      descent.surfaces.front() = input;
      descent.after = descent.before;
      descent.stopReason = StopReason::meetsItself;
      break;
    }
    descentOptions.tolerance = std::min(descentOptions.tolerance, largestMove(input, descent.surfaces.front())) / 2;
    best = attempt(input, all, descentOptions);
  }
  ExactFairing result{
      std::move(descent.surfaces.front()), descent.before.front(), descent.after.front(), {}, descentOptions.tolerance};
  FairingSummary& summary = result.summary;
  summary.energyBefore = result.before.isophoteRoughness;
  summary.energyAfter = result.after.isophoteRoughness;
  summary.gap = std::numeric_limits<double>::quiet_NaN();
  summary.steps = descent.steps;
  summary.stopReason = descent.stopReason;
  summary.seconds = descent.seconds;
  summary.freePoints = best.unknowns;
  summary.activePoints = descent.activeRows;
  summary.largestMove = largestMove(input, result.spline);
  return result;
}

}  // namespace strak
