#include "apps/cli/describe_result.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "apps/cli/fair_curve.h"
#include "strak/base/error.h"
#include "strak/metrology/self_intersection.h"
#include "strak/metrology/trim_region.h"
#include "strak/spline/knot_insertion.h"

namespace strak::cli {

namespace {

// Looser on big nets: the figure must not cost more than the fairing. Of a trimmed face only the visible part counts.
FairnessOptions fairnessOptions(Index points, const TrimRegion* visible) {
  constexpr Index kBigNet = 10'000;
  FairnessOptions options;
  options.relativeError = points <= kBigNet ? 1e-3 : 1e-2;
  if (visible != nullptr) {
    options.context = visible;
    options.inside = [](double u, double v, const void* region) {
      return static_cast<const TrimRegion*>(region)->inside({u, v});
    };
  }
  return options;
}

void measure(const Object&, const Curve& before, const Curve& after, FairedObject& entry) {
  measureCurve(before, after, entry);
}

// The same surface with the other's knots if it has them all, else as it is.
template <int D>
Spline<D> onKnotsOf(const Spline<D>& spline, const Spline<D>& other) {
  try {
    return refine(spline, other.knots());
  } catch (const InvalidInput&) {
    return spline;
  }
}

void measure(const Object& object, const Surface& original, const Surface& after, FairedObject& entry) {
  // Both on the same cells, or the borders of a trimmed face would count differently.
  const Surface before = onKnotsOf(original, after);
  if (before.pointDimension() != 3) return;
  const bool whole = std::all_of(object.naturalSide.begin(), object.naturalSide.end(), [](bool side) { return side; });
  std::optional<TrimRegion> visible;
  if (!whole) visible.emplace(before, object.trims);
  const TrimRegion* region = visible && !visible->isWholeDomain() ? &*visible : nullptr;
  entry.fairnessBefore = surfaceFairness(before, fairnessOptions(before.net().rows(), region));
  const bool same = before.knots() == after.knots() && before.net() == after.net();
  entry.fairnessAfter =
      same ? entry.fairnessBefore : surfaceFairness(after, fairnessOptions(after.net().rows(), region));
  entry.plate = {entry.fairnessBefore->plate, entry.fairnessAfter->plate};
}

void measure(const Object&, const Volume&, const Volume&, FairedObject&) {}

// Only what has moved is looked at; that needs the same knots.
template <int D>
void lookForMeeting(const Spline<D>& before, const Spline<D>& after, FairedObject& entry) {
  if constexpr (D < 3) {
    const Index dimension = after.pointDimension();
    if (dimension != 3 && (D == 2 || dimension != 2)) return;
    const auto meeting = meetingAfterMove(onKnotsOf(before, after), after);
    entry.meeting = meeting.found.answer;
    entry.newMeeting = meeting.isNew;
  }
}

}  // namespace

template <int D>
void describeResult(const Object& object, const Spline<D>& before, Spline<D> after, const FairingSummary& summary,
                    const Deviation<D>& deviation, FairedObject& entry) {
  entry.summary = summary;
  entry.deviationLower = deviation.lower;
  entry.deviationUpper = deviation.upper;
  entry.controlPointMove = summary.largestMove;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  entry.plate = {kNone, kNone};
  measure(object, before, after, entry);
  lookForMeeting(before, after, entry);
  for (int k = 0; k < D; ++k) entry.points[static_cast<std::size_t>(k)] = after.size(k);
  entry.after = std::move(after);
}

template void describeResult(const Object&, const Curve&, Curve, const FairingSummary&, const Deviation<1>&,
                             FairedObject&);
template void describeResult(const Object&, const Surface&, Surface, const FairingSummary&, const Deviation<2>&,
                             FairedObject&);
template void describeResult(const Object&, const Volume&, Volume, const FairingSummary&, const Deviation<3>&,
                             FairedObject&);

}  // namespace strak::cli
