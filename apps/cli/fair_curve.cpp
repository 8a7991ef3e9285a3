#include "apps/cli/fair_curve.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/cli/describe_result.h"
#include "strak/base/error.h"
#include "strak/fairing/eck_hadenfeld.h"
#include "strak/fairing/exact_curve_fairing.h"
#include "strak/fairing/farin_sapidis.h"
#include "strak/fairing/kjellander.h"
#include "strak/fairing/plan_curve.h"

namespace strak::cli {

namespace {

// A spline that did not move stays the input to the bit.
template <int D>
void enter(const Object& object, const Spline<D>& input, Spline<D> result, const FairingSummary& summary,
           FairedObject& entry) {
  const bool moved = summary.largestMove > 0;
  const auto deviation = moved ? certifyDeviation(input, result) : Deviation<D>{};
  describeResult(object, input, moved ? std::move(result) : input, summary, deviation, entry);
}

void fairExactly(const Object& object, const Curve& curve, const std::array<Index, 2>& rows,
                 const FairModelOptions& options, const Progress& progress, FairedObject& entry) {
  const CurvePlan plan = planCurve(curve, rows, options.refine);
  entry.notes.insert(entry.notes.end(), plan.notes.begin(), plan.notes.end());
  if (!plan.leftAlone.empty()) {
    entry.leftAlone = plan.leftAlone;
    return;
  }
  ExactCurveFairingOptions exact;
  exact.tolerance = options.fairing.tolerance;
  exact.held = plan.held;
  exact.ballsOnPoints = options.fairing.toleranceKind == ToleranceKind::points;
  exact.seamContinuity = plan.seamContinuity;
  exact.maxExtrema = options.maxExtrema;
  if (options.fairing.maxSteps < kUnlimitedSteps) exact.maxSteps = options.fairing.maxSteps;
  exact.progress = progress;
  const ExactCurveFairing faired = fairCurveExactly(plan.spline, exact);
  entry.energyName = kExactEnergy;
  if (faired.alreadyFair) {
    entry.notes = {
        fmt::format("already fair: within the tolerance none of its {} curvature extrema disappears and its "
                    "curvature variation does not fall below a fifth; left as it was",
                    faired.before.extrema)};
  }
  if (faired.summary.stopReason == StopReason::meetsItself) {
    entry.notes = {"fairing makes it intersect itself: left as it was"};
  }
  enter(object, curve, plan.onInput(faired.spline), faired.summary, entry);
  if (!faired.extremaReached) {
    entry.notes.push_back(
        fmt::format("the tolerance does not allow {} curvature extrema: {} are the fewest that were reached",
                    options.maxExtrema, faired.after.extrema));
  }
}

template <int D>
FairingPlan<D> classicalPlan(const Spline<D>& spline, const std::array<Index, 2 * D>& rows, FairedObject& entry) {
  FairingPlanOptions<D> planOptions;
  planOptions.rows = rows;
  planOptions.refine = false;
  auto plan = planFairing(spline, planOptions);
  entry.notes.insert(entry.notes.end(), plan.notes.begin(), plan.notes.end());
  return plan;
}

template <class Options>
Options common(const HeldPoints& held, const FairModelOptions& options, const Progress& progress) {
  Options result;
  result.tolerance = options.fairing.tolerance;
  result.held = held;
  if (options.fairing.maxSteps < kUnlimitedSteps) result.maxSteps = options.fairing.maxSteps;
  result.progress = progress;
  return result;
}

}  // namespace

bool isClassicalMethod(const std::string& name) {
  return name == "eck-hadenfeld" || name == "eck-hadenfeld-3" || name == "farin-sapidis" || name == "farin-degree" ||
         name == "kjellander";
}

bool fairOtherwise(const Object& object, const Curve& spline, const std::array<Index, 2>& rows,
                   const FairModelOptions& options, const Progress& progress, FairedObject& entry) {
  const std::string& method = options.curveMethod;
  if (method.empty()) {
    const bool exact = options.energy == kExactEnergy && spline.degree(0) > 1 &&
                       (spline.pointDimension() == 2 || spline.pointDimension() == 3);
    if (exact) fairExactly(object, spline, rows, options, progress, entry);
    return exact;
  }
  const auto plan = classicalPlan<1>(spline, rows, entry);
  if (!plan.leftAlone.empty()) {
    entry.leftAlone = plan.leftAlone;
    return true;
  }
  Faired<1> faired;
  if (method == "kjellander") {
    entry.energyName = "squared jumps of X'''";
    faired = fairByKjellander(plan.spline, common<KjellanderOptions>(plan.held, options, progress));
  } else if (method == "farin-sapidis") {
    entry.energyName = "jumps of dk/ds";
    faired = fairByKnotRemoval(plan.spline, common<CubicFairingOptions>(plan.held, options, progress));
  } else if (method == "farin-degree") {
    entry.energyName = "squared third differences";
    faired = fairByDegreeReduction(plan.spline, common<CubicFairingOptions>(plan.held, options, progress));
  } else {
    auto eck = common<EckHadenfeldOptions>(plan.held, options, progress);
    eck.derivative = method == "eck-hadenfeld" ? 2 : 3;
    entry.energyName = eck.derivative == 2 ? "squared X''" : "squared X'''";
    faired = fairByEckHadenfeld(plan.spline, eck);
  }
  enter(object, spline, std::move(faired.spline), faired.summary, entry);
  return true;
}

bool fairOtherwise(const Object& object, const Surface& spline, const std::array<Index, 4>& rows,
                   const FairModelOptions& options, const Progress& progress, FairedObject& entry) {
  if (options.curveMethod.empty()) return false;
  if (options.curveMethod != "kjellander") {
    throw InvalidInput(
        fmt::format("--method {} is for curves: surfaces have kjellander, optimal and local", options.curveMethod));
  }
  if (!entry.trims.empty()) {
    entry.leftAlone = "Kjellander's method redraws whole surfaces, and this face has edges of its own";
    return true;
  }
  const auto plan = classicalPlan<2>(spline, rows, entry);
  if (!plan.leftAlone.empty()) {
    entry.leftAlone = plan.leftAlone;
    return true;
  }
  entry.energyName = "squared jumps of X'''";
  auto faired = fairByKjellander(plan.spline, common<KjellanderOptions>(plan.held, options, progress));
  enter(object, spline, std::move(faired.spline), faired.summary, entry);
  return true;
}

void measureCurve(const Curve& before, const Curve& after, FairedObject& entry) {
  if (before.pointDimension() != 2 && before.pointDimension() != 3) return;
  const CurveChange change{curveFairness(before), curveFairness(after), countCurvatureExtrema(before),
                           countCurvatureExtrema(after)};
  entry.plate = {change.before.bending, change.after.bending};
  entry.curve = change;
}

}  // namespace strak::cli
