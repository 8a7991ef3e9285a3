#include "strak/fairing/eck_hadenfeld.h"

#include <algorithm>
#include <cmath>

#include "strak/base/cpu_time.h"
#include "strak/base/error.h"
#include "strak/energy/gram.h"

namespace strak {

Faired<1> fairByEckHadenfeld(const Curve& curve, const EckHadenfeldOptions& options) {
  const double begun = threadSeconds();
  const int l = options.derivative;
  const auto n = curve.net().rows();
  if (curve.isRational())
    throw InvalidInput("Eck and Hadenfeld's method is for polynomial curves: this one is rational");
  if (l != 2 && l != 3) throw InvalidInput("Eck and Hadenfeld's method takes the second or the third derivative");
  if (curve.degree(0) < l) throw InvalidInput("the curve's degree is below the derivative of the energy");
  if (!(options.tolerance >= 0) || !(options.gain >= 0)) throw InvalidInput("tolerance and gain must not be negative");
  if (!options.held.empty() && static_cast<Index>(options.held.size()) != n) {
    throw InvalidInput("the list of held points must have one entry a control point or be empty");
  }
  // Around the first point: the place of the curve must not cost digits.
  const Point origin = curve.net().row(0);
  const Net start = curve.net().rowwise() - origin;
  const BandMatrix gram = gramMatrix(curve.knots(0), l, l);
  const int width = gram.bandwidth;
  Net d = start, kd = Net::Zero(n, d.cols());  // K d, half the gradient
  for (Index i = 0; i < n; ++i) {
    for (Index j = std::max<Index>(0, i - width); j <= std::min(n - 1, i + width); ++j)
      kd.row(i) += gram(i, j) * d.row(j);
  }
  const auto energy = [&] { return kd.cwiseProduct(d).sum(); };

  Faired<1> result{curve, {}};
  FairingSummary& summary = result.summary;
  summary.energyBefore = energy();
  summary.gap = std::numeric_limits<double>::infinity();
  std::vector<Index> free;
  for (Index i = 0; i < n; ++i) {
    if ((options.held.empty() || options.held[static_cast<std::size_t>(i)] == 0) && gram(i, i) > 0) free.push_back(i);
  }
  summary.freePoints = static_cast<Index>(free.size());
  summary.stopReason = free.empty() || options.tolerance == 0 ? StopReason::nothingFree : StopReason::steps;
  while (summary.stopReason == StopReason::steps && summary.steps < options.maxSteps) {
    double best = options.gain * summary.energyBefore;
    Index place = -1;
    Point target, bestPoint;
    for (const Index r : free) {
      const double w = gram(r, r);
      const Point step = -kd.row(r) / w;  // to the unconstrained minimum
      target = d.row(r) + step;
      const Point away = target - start.row(r);
      const double distance = away.norm();
      if (distance > options.tolerance) target = start.row(r) + options.tolerance / distance * away;
      const double gain = w * (step.squaredNorm() - (d.row(r) + step - target).squaredNorm());
      if (gain > best) {
        best = gain;
        place = r;
        bestPoint = target;
      }
    }
    if (place < 0) {
      summary.stopReason = StopReason::gain;
      break;
    }
    const Point step = bestPoint - d.row(place);
    d.row(place) = bestPoint;
    for (Index i = std::max<Index>(0, place - width); i <= std::min(n - 1, place + width); ++i) {
      kd.row(i) += gram(i, place) * step;
    }
    ++summary.steps;
    if (summary.steps % 256 == 0 && !options.progress.report(-1, "moving points one by one")) {
      summary.stopReason = StopReason::cancelled;
    }
  }
  summary.energyAfter = energy();
  for (const Index r : free) {
    const Point move = d.row(r) - start.row(r);
    if (move.isZero(0)) continue;
    result.spline.net().row(r) += move;
    summary.largestMove = std::max(summary.largestMove, move.norm());
    if (move.norm() >= (1 - 1e-9) * options.tolerance) ++summary.activePoints;
  }
  summary.seconds = threadSeconds() - begun;
  return result;
}

}  // namespace strak
