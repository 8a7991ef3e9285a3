#include "apps/cli/fair_knots.h"

#include <algorithm>
#include <numeric>

#include "strak/energy/join_energy.h"
#include "strak/fairing/trimmed_face.h"

namespace strak::cli {

namespace {

constexpr double kSmoothingShare = 0.5;   // of the tolerance
constexpr double kFairnessGrowth = 1.02;  // of the faired figures; never above those of the input
constexpr double kFairingShare = 0.8;     // of what is left, if knots are to be removed afterwards

constexpr double kSmoothAngle = 1e-5;  // sine, mean: no angle at a knot line

template <int D>
SmoothKnotsOptions<D> smoothingBy(const KnotRules<D>& rules) {
  SmoothKnotsOptions<D> smoothing;
  smoothing.tolerance = kSmoothingShare * rules.tolerance;
  smoothing.creaseAngle = rules.options.creaseAngle;
  smoothing.rows = rules.rows;
  smoothing.exactStrips = rules.exact;
  if (!rules.onlySides) smoothing.tolerance = 0;  // only what is smooth already to rounding
  return smoothing;
}

}  // namespace

bool onlySidesMatter(const Object& object) {
  const auto* surface = object.spline ? std::get_if<Surface>(&*object.spline) : nullptr;
  if (surface == nullptr || object.trims.empty()) return true;
  const SideEdges edges = edgesAlongSides(*surface, {object.trims, object.naturalSide});
  return std::all_of(edges.along.begin(), edges.along.end(), [](bool along) { return along; });
}

bool mayHaveNeighbours(const Model& model) { return model.format() != "g2" && model.format() != "JSON"; }

bool rougherThanInput(const Surface& original, const FairedObject& entry) {
  if (!entry.fairnessBefore || !entry.fairnessAfter) return false;
  const SurfaceFairness &before = *entry.fairnessBefore, &after = *entry.fairnessAfter;
  std::vector<int> unknownOf(static_cast<std::size_t>(original.net().rows()));
  std::iota(unknownOf.begin(), unknownOf.end(), 0);
  const Net points = original.euclideanNet();
  double lines = 0;
  bool angles = false;
  for (int k = 0; k < 2; ++k) {
    for (const auto& knot : original.knots(k).innerKnots()) {
      if (knot.multiplicity < original.degree(k) - 1) continue;
      const JoinEnergy line(original, unknownOf, {k, knot.value, false}, original, unknownOf, {k, knot.value, true},
                            false);
      const JoinFigures figures = line.figures(points, points);
      lines += figures.ofAngle + figures.ofJump;
      angles = angles || figures.meanAngle > kSmoothAngle;
    }
  }
  const double limit = 1 + before.relativeError + after.relativeError;
  return (!angles && after.plate > limit * before.plate) ||
         after.curvatureVariation > limit * (before.curvatureVariation + lines) ||
         after.isophoteRoughness > limit * (before.isophoteRoughness + lines);
}

bool rougherThanInput(const Curve&, const FairedObject& entry) {
  constexpr double kIntegration = 2e-3;
  return entry.curve && (entry.curve->after.bending > (1 + kIntegration) * entry.curve->before.bending ||
                         entry.curve->extremaAfter > entry.curve->extremaBefore);
}

bool needsBorders(const Surface& surface, const KnotRules<2>& rules) {
  if (rules.options.simplifyBorders) return true;
  if (!rules.options.smooth || !rules.onlySides) return false;
  SmoothKnotsOptions<2> exact = smoothingBy(rules);
  exact.exactStrips = true;
  const auto lines = smoothKnots(surface, exact).lines;
  return std::any_of(lines.begin(), lines.end(), [](const auto& line) { return line.kept == kNeededByBorders; });
}

template <int D>
Spline<D> withSmoothKnots(const Spline<D>& spline, const KnotRules<D>& rules, FairedObject& entry) {
  if (!rules.options.smooth) return spline;
  SmoothedKnots<D> result = smoothKnots(spline, smoothingBy(rules));
  entry.notes.insert(entry.notes.end(), result.notes.begin(), result.notes.end());
  entry.smoothed.emplace();
  entry.smoothed->deviation = result.deviation.upper;
  for (const SmoothedKnot& line : result.lines) {
    ++(line.multiplicityAfter < line.multiplicityBefore ? entry.smoothed->smoothed : entry.smoothed->kept);
  }
  return result.spline;
}

double toleranceForFairing(const KnotOptions& options, double tolerance, double smoothed) {
  if (!(tolerance < kUnlimited)) return tolerance;
  return (options.simplify ? kFairingShare : 1) * std::max(0.0, tolerance - smoothed);
}

template <int D>
Spline<D> withFewerKnots(const Spline<D>& faired, const Spline<D>& original, const KnotRules<D>& rules,
                         const Progress& progress, FairedObject& entry) {
  if (!rules.options.simplify) return faired;
  SimplifyOptions<D> simplifying;
  simplifying.tolerance = rules.onlySides ? rules.tolerance : 0;
  simplifying.rows = rules.rows;
  simplifying.exactStrips = rules.exact || !rules.options.simplifyBorders;
  simplifying.fairnessGrowth = faired == original ? 1 : kFairnessGrowth;
  simplifying.progress = progress;
  // Trimmed: what comes out must be the faired one to rounding, so it is measured from there.
  Simplified<D> result = simplify(faired, rules.onlySides ? original : faired, simplifying);
  entry.simplified = FairedObject::Simplified{result.knotsRemoved, faired.net().rows(), result.spline.net().rows()};
  if (!rules.onlySides) {
    entry.notes.push_back("Trimmed: only knots that change nothing were removed.");
  } else {
    entry.notes.insert(entry.notes.end(), result.notes.begin(), result.notes.end());
  }
  return std::move(result.spline);
}

#define STRAK_INSTANTIATE(D)                                                                                  \
  template Spline<D> withSmoothKnots(const Spline<D>&, const KnotRules<D>&, FairedObject&);                   \
  template Spline<D> withFewerKnots(const Spline<D>&, const Spline<D>&, const KnotRules<D>&, const Progress&, \
                                    FairedObject&);
STRAK_INSTANTIATE(1)
STRAK_INSTANTIATE(2)
STRAK_INSTANTIATE(3)
#undef STRAK_INSTANTIATE

}  // namespace strak::cli
