#include "strak/metrology/hausdorff.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>

#include "strak/base/error.h"
#include "strak/metrology/closest_point.h"
#include "strak/spline/evaluate.h"

namespace strak {

namespace {

using Inside = std::function<bool(double, double)>;

// Rounds of sharpening and the points of each in one direction; every round looks at half the width of the one before.
constexpr int kRounds = 20;
constexpr int kRoundPoints = 5;

std::vector<double> samplesOf(const KnotVector& knots, const HausdorffOptions& options) {
  const auto spans = knots.spans();
  const auto count = static_cast<Index>(spans.size());
  Index parts = std::max(options.samplesPerSpan - 1, (options.minSamples + count - 1) / count);
  parts = std::max<Index>(1, std::min(parts, options.maxSamples / count));
  std::vector<double> result;
  for (const Index s : spans) {
    for (Index i = 0; i < parts; ++i)
      result.push_back(std::lerp(knots[s], knots[s + 1], static_cast<double>(i) / static_cast<double>(parts)));
  }
  result.push_back(knots.to());
  return result;
}

// Looks around the worst sample, in a window that halves.
void sharpen(const Surface& from, const ClosestPointFinder<2>& to, const Inside& inside, std::array<double, 2> window,
             DirectedDistance& worst) {
  for (int round = 0; round < kRounds; ++round) {
    const std::array<double, 2> centre = worst.place;
    for (int i = 0; i < kRoundPoints; ++i) {
      for (int j = 0; j < kRoundPoints; ++j) {
        const int steps[2] = {i - kRoundPoints / 2, j - kRoundPoints / 2};
        std::array<double, 2> u;
        for (std::size_t k = 0; k < 2; ++k) {
          u[k] = std::clamp(centre[k] + 2.0 * steps[k] / (kRoundPoints - 1) * window[k], from.knots()[k].from(),
                            from.knots()[k].to());
        }
        if (inside && !inside(u[0], u[1])) continue;
        const Point point = evaluate<2>(from, u);
        const ClosestPoint<2> nearest = to.find(point);
        if (nearest.distance > worst.max) {
          worst.max = nearest.distance;
          worst.place = u;
          worst.point = point;
          worst.nearest = nearest.point;
        }
      }
    }
    window[0] /= 2;
    window[1] /= 2;
  }
}

DirectedDistance directedDistance(const Surface& from, const ClosestPointFinder<2>& to, const Inside& inside,
                                  const HausdorffOptions& options, double done, std::atomic<bool>& cancelled) {
  const auto us = samplesOf(from.knots(0), options), vs = samplesOf(from.knots(1), options);
  struct Row {
    DirectedDistance worst;
    double squares = 0;
  };
  std::vector<Row> rows(us.size());
  std::size_t finished = 0;
  std::mutex reporting;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, us.size(), 1), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end() && !cancelled; ++i) {
      Row& row = rows[i];
      for (const double v : vs) {
        if (inside && !inside(us[i], v)) continue;
        const Point point = evaluate<2>(from, {us[i], v});
        const ClosestPoint<2> nearest = to.find(point);
        row.squares += nearest.distance * nearest.distance;
        if (row.worst.samples++ == 0 || nearest.distance > row.worst.max) {
          row.worst.max = nearest.distance;
          row.worst.place = {us[i], v};
          row.worst.point = point;
          row.worst.nearest = nearest.point;
        }
      }
      const std::lock_guard lock(reporting);
      const double fraction = static_cast<double>(++finished) / static_cast<double>(us.size());
      if (!options.progress.report(done + fraction / 2, "measuring the distance of the surfaces")) cancelled = true;
    }
  });
  DirectedDistance result;
  double squares = 0;
  for (const Row& row : rows) {
    if (row.worst.samples == 0) continue;
    const Index samples = result.samples + row.worst.samples;
    if (result.samples == 0 || row.worst.max > result.max) result = row.worst;
    result.samples = samples;
    squares += row.squares;
  }
  if (result.samples == 0) return result;
  result.rms = std::sqrt(squares / static_cast<double>(result.samples));
  if (!cancelled) {
    sharpen(from, to, inside,
            {from.knots(0).length() / static_cast<double>(us.size()),
             from.knots(1).length() / static_cast<double>(vs.size())},
            result);
  }
  return result;
}

}  // namespace

HausdorffDistance hausdorffDistance(const Surface& a, const Surface& b, const HausdorffOptions& options) {
  if (a.pointDimension() != b.pointDimension()) {
    throw InvalidInput(fmt::format("the points have {} and {} coordinates: compare surfaces of the same space",
                                   a.pointDimension(), b.pointDimension()));
  }
  if (options.samplesPerSpan < 1 || options.minSamples < 1 || options.maxSamples < 1) {
    throw InvalidInput("the numbers of samples must be positive");
  }
  std::atomic<bool> cancelled{false};
  HausdorffDistance result;
  result.fromA = directedDistance(a, ClosestPointFinder<2>(b), options.insideA, options, 0, cancelled);
  result.fromB = directedDistance(b, ClosestPointFinder<2>(a), options.insideB, options, 0.5, cancelled);
  result.distance = std::max(result.fromA.max, result.fromB.max);
  result.complete = !cancelled;
  return result;
}

}  // namespace strak
