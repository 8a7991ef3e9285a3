#include "strak/fairing/simplify.h"

#include <fmt/format.h>

#include <algorithm>

#include "strak/base/error.h"
#include "strak/fairing/knot_reduction.h"
#include "strak/metrology/fairness.h"
#include "strak/spline/reparametrize.h"

namespace strak {
namespace {

constexpr Index kBigNet = 10'000;

// The figures that must not grow, all of them, or none where there is no measure.
using Figures = std::vector<double>;

double integrationError(Index points) { return points <= kBigNet ? 1e-3 : 1e-2; }

Figures figuresOf(const Curve& curve, double error) {
  if (curve.pointDimension() != 2 && curve.pointDimension() != 3) return {};
  FairnessOptions options;
  options.relativeError = error;
  const CurveFairness f = curveFairness(curve, options);
  return {f.bending, f.curvatureVariation};
}
Figures figuresOf(const Surface& surface, double error) {
  if (surface.pointDimension() != 3) return {};
  FairnessOptions options;
  options.relativeError = error;
  const SurfaceFairness f = surfaceFairness(surface, options);
  return {f.plate, f.curvatureVariation, f.isophoteRoughness};
}
Figures figuresOf(const Volume&, double) { return {}; }

// How many of the knots taken can go for good.
template <int D>
class FairSearch {
 public:
  FairSearch(const KnotReduction<D>& reduction, const Spline<D>& reference, const SimplifyOptions<D>& options)
      : reduction_(reduction), reference_(reference), options_(options) {}

  // The largest number of removals from the start of the list, found by halving, with which everything holds.
  std::size_t longestFair() const {
    if (reduction_.taken().empty()) return 0;
    if (const auto all = reduction_.fit(reduction_.taken().size());
        all && reduction_.keepsShape(*all) && reduction_.isSame(*all))
      return reduction_.taken().size();
    const double error = integrationError(reduction_.fine().net().rows());
    Figures limits = figuresOf(reduction_.fine(), error);
    const bool same = reduction_.fine() == clamped(reference_);
    const Figures had = same ? limits : figuresOf(reference_, error);
    for (std::size_t i = 0; i < limits.size(); ++i) {
      const double grown = options_.fairnessGrowth * limits[i];
      // Twice the error, one for each integral; and what rounding makes of figures that are zero.
      limits[i] = (1 + 2 * error) * (same ? grown : std::min(grown, std::max(limits[i], had[i]))) + 1e-12;
    }
    if (isFair(reduction_.taken().size(), limits)) return reduction_.taken().size();
    std::size_t good = 0, bad = reduction_.taken().size();
    while (bad - good > 1 + good / 16 && !stopped()) {
      const std::size_t middle = good + (bad - good) / 2;
      (isFair(middle, limits) ? good : bad) = middle;
    }
    return good;
  }

 private:
  bool isFair(std::size_t count, const Figures& limits) const {
    const auto coarse = reduction_.fit(count);
    if (!coarse || !reduction_.keepsShape(*coarse)) return false;
    if (reduction_.isSame(*coarse)) return true;
    const Figures now = figuresOf(*coarse, integrationError(coarse->net().rows()));
    for (std::size_t i = 0; i < now.size(); ++i) {
      if (now[i] > limits[i]) return false;
    }
    return true;
  }

  bool stopped() const { return !options_.progress.report(-1, "fewer knots"); }

  const KnotReduction<D>& reduction_;
  const Spline<D>& reference_;
  const SimplifyOptions<D>& options_;
};

}  // namespace

template <int D>
Simplified<D> simplify(const Spline<D>& spline, const Spline<D>& reference, const SimplifyOptions<D>& options) {
  if (!(options.fairnessGrowth >= 1)) {
    throw InvalidInput(fmt::format("the fairness may grow by a factor of at least 1, not {}", options.fairnessGrowth));
  }
  KnotReductionOptions<D> reducing;
  reducing.tolerance = options.tolerance;
  reducing.rows = options.rows;
  reducing.exactStrips = options.exactStrips;
  reducing.progress = options.progress;
  KnotReduction<D> reduction(spline, reference, reducing);
  reduction.collect([&](const auto& candidate) {
    return candidate.costsNothing || candidate.multiplicity < spline.degree(candidate.direction);
  });
  const std::size_t kept = FairSearch<D>(reduction, reference, options).longestFair();
  Simplified<D> result{spline, {}, 0, {}};
  const std::size_t more = reduction.taken().size() - kept;
  if (more > 0) {
    result.notes.push_back(fmt::format("{} more knot{} could go within the tolerance, but the fairness would suffer.",
                                       more, more == 1 ? "" : "s"));
  }
  if (kept > 0) {
    result.spline = *reduction.fit(kept);
    result.knotsRemoved = static_cast<Index>(kept);
  }
  result.deviation = certifyDeviation(result.spline, reference);
  return result;
}

template Simplified<1> simplify(const Spline<1>&, const Spline<1>&, const SimplifyOptions<1>&);
template Simplified<2> simplify(const Spline<2>&, const Spline<2>&, const SimplifyOptions<2>&);
template Simplified<3> simplify(const Spline<3>&, const Spline<3>&, const SimplifyOptions<3>&);

}  // namespace strak
