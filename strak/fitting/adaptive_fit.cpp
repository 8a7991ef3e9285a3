#include "strak/fitting/adaptive_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "strak/base/error.h"
#include "strak/spline/knot_insertion.h"
#include "strak/spline/knot_removal.h"

namespace strak {

namespace {

constexpr int kMostRounds = 14;
constexpr int kMostIdleRounds = 2;     // rounds that hardly help, one after another, before giving up
constexpr double kIdle = 0.95;         // ... of the points outside before
constexpr Index kLeastCellPoints = 4;  // fewer points in a cell are no reason for a knot
constexpr double kWorthwhile = 0.1;    // spans with fewer points outside than this part of the worst one's wait
constexpr double kSignificance = 2;    // standard deviations above the share that chance would leave outside
constexpr double kLeastSpan = 1e-7;    // of the domain
constexpr std::size_t kMostReported = 20;
constexpr std::array<double, 5> kRemovalTolerances{1, 0.5, 0.25, 0.1, 0.03};  // in parts of the tolerance

// The cells' numbers per direction; curves have one.
template <int D>
std::array<Index, D> cellPlace(Index cell, const std::array<std::vector<Index>, D>& spans) {
  std::array<Index, D> place;
  for (std::size_t k = D; k-- > 0;) {
    const auto n = static_cast<Index>(spans[k].size());
    place[k] = cell % n;
    cell /= n;
  }
  return place;
}

template <int D>
std::array<std::vector<Index>, D> spansOf(const Spline<D>& spline) {
  std::array<std::vector<Index>, D> spans;
  for (std::size_t k = 0; k < D; ++k) spans[k] = spline.knots()[k].spans();
  return spans;
}

// Midpoints of the spans to halve, a list a direction.
template <int D>
std::array<std::vector<double>, D> wantedKnots(const Fit<D>& fit, double share, bool significant) {
  const auto spans = spansOf<D>(fit.spline);
  std::array<std::vector<double>, D> bad;  // points outside that count, by spans
  for (std::size_t k = 0; k < D; ++k) bad[k].assign(spans[k].size(), 0);
  for (std::size_t c = 0; c < fit.cells.size(); ++c) {
    const auto& cell = fit.cells[c];
    const double expected = (1 - share) * static_cast<double>(cell.count);
    const double allowed = expected + (significant ? kSignificance * std::sqrt(expected) : 0);
    if (cell.count < kLeastCellPoints || static_cast<double>(cell.outside) <= allowed) continue;
    const auto place = cellPlace<D>(static_cast<Index>(c), spans);
    for (std::size_t k = 0; k < D; ++k) bad[k][static_cast<std::size_t>(place[k])] += static_cast<double>(cell.outside);
  }
  std::array<std::vector<double>, D> wanted;
  for (std::size_t k = 0; k < D; ++k) {
    const KnotVector& knots = fit.spline.knots()[k];
    const double worst = *std::max_element(bad[k].begin(), bad[k].end());
    for (std::size_t s = 0; s < bad[k].size(); ++s) {
      const double from = knots[spans[k][s]], to = knots[spans[k][s] + 1];
      if (bad[k][s] > 0 && bad[k][s] >= kWorthwhile * worst && to - from > kLeastSpan * knots.length()) {
        wanted[k].push_back((from + to) / 2);
      }
    }
  }
  return wanted;
}

template <int D>
Index controlPoints(const std::array<KnotVector, D>& knots) {
  Index count = 1;
  for (const auto& k : knots) count *= k.size();
  return count;
}

template <int D>
std::vector<OutsideCell<D>> worstCells(const Fit<D>& fit) {
  const auto spans = spansOf<D>(fit.spline);
  std::vector<OutsideCell<D>> result;
  for (std::size_t c = 0; c < fit.cells.size(); ++c) {
    const auto& cell = fit.cells[c];
    if (cell.outside == 0) continue;
    OutsideCell<D> entry{{}, {}, cell.outside, cell.count, cell.max};
    const auto place = cellPlace<D>(static_cast<Index>(c), spans);
    for (std::size_t k = 0; k < D; ++k) {
      const Index span = spans[k][static_cast<std::size_t>(place[k])];
      entry.from[k] = fit.spline.knots()[k][span];
      entry.to[k] = fit.spline.knots()[k][span + 1];
    }
    result.push_back(entry);
  }
  std::stable_sort(result.begin(), result.end(), [](const auto& a, const auto& b) { return a.max > b.max; });
  if (result.size() > kMostReported) result.resize(kMostReported);
  return result;
}

}  // namespace

template <int D>
AdaptiveFit<D> fitWithin(const std::array<KnotVector, D>& start, Index columns, const PointPass<D>& points,
                         const AdaptiveFitOptions<D>& options) {
  if (!(options.fit.tolerance > 0) || !std::isfinite(options.fit.tolerance)) {
    throw InvalidInput(fmt::format("the tolerance ({}) must be a finite number above zero", options.fit.tolerance));
  }
  if (!(options.share > 0 && options.share <= 1)) {
    throw InvalidInput(fmt::format("the share of points inside ({}) must be above 0 and at most 1", options.share));
  }
  const auto isReached = [&](const Fit<D>& fit) {
    const double outside = static_cast<double>(fit.summary.outsideTolerance);
    return outside <= (1 - options.share) * static_cast<double>(fit.summary.points) * (1 + 1e-12);
  };
  AdaptiveFit<D> result;
  std::array<KnotVector, D> knots = start;
  result.fit = fitLeastSquares<D>(knots, columns, points, options.fit);
  Fit<D> current = result.fit;
  Index insertedNow = 0;
  bool full = false;
  for (int idle = 0; !isReached(current) && result.rounds < kMostRounds && idle < kMostIdleRounds;) {
    if (!options.fit.progress.report(current.summary.insideShare(), "refining the knots")) {
      result.fit.summary.stopped = true;
      break;
    }
    auto wanted = wantedKnots<D>(current, options.share, true);
    const auto none = [&] {
      return std::all_of(wanted.begin(), wanted.end(), [](const auto& w) { return w.empty(); });
    };
    if (none()) wanted = wantedKnots<D>(current, options.share, false);
    if (none()) break;
    auto next = knots;
    for (std::size_t k = 0; k < D; ++k) {
      next[k] = withKnots(knots[k], wanted[k], directionName(static_cast<int>(k)));
      insertedNow += static_cast<Index>(wanted[k].size());
    }
    full = controlPoints<D>(next) > options.mostPoints;
    if (full) break;
    knots = next;
    const Index before = current.summary.outsideTolerance;
    current = fitLeastSquares<D>(knots, columns, points, options.fit);
    ++result.rounds;
    const Index now = current.summary.outsideTolerance;
    idle = static_cast<double>(now) > kIdle * static_cast<double>(before) ? idle + 1 : 0;
    if (now < result.fit.summary.outsideTolerance) {
      result.fit = current;
      result.inserted = insertedNow;
    }
  }
  result.reached = isReached(result.fit);
  if (result.reached && options.removeKnots) {
    for (const double part : kRemovalTolerances) {
      Spline<D> fewer = result.fit.spline;
      Index removed = 0;
      for (int k = 0; k < D; ++k) {
        auto removal = removeKnotsWithin<D>(fewer, k, part * options.fit.tolerance);
        fewer = std::move(removal.spline);
        removed += static_cast<Index>(removal.removed.size());
      }
      if (removed == 0) break;
      Fit<D> smaller = fitLeastSquares<D>(fewer.knots(), columns, points, options.fit);
      if (!isReached(smaller)) continue;
      result.fit = std::move(smaller);
      result.removed = removed;
      break;
    }
  }
  result.outside = worstCells<D>(result.fit);
  if (!result.reached) {
    result.fit.summary.warnings.push_back(
        fmt::format("only {:.4g} % of the points are within the tolerance {:g}, not {:g} %: {}",
                    100 * result.fit.summary.insideShare(), options.fit.tolerance, 100 * options.share,
                    full ? "more control points than the limit would be needed"
                         : "more knots do not help, the noise or outliers are larger than the tolerance"));
  }
  return result;
}

template AdaptiveFit<1> fitWithin<1>(const std::array<KnotVector, 1>&, Index, const PointPass<1>&,
                                     const AdaptiveFitOptions<1>&);
template AdaptiveFit<2> fitWithin<2>(const std::array<KnotVector, 2>&, Index, const PointPass<2>&,
                                     const AdaptiveFitOptions<2>&);

}  // namespace strak
