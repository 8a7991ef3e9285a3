#include "strak/fairing/simplify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "strak/base/error.h"
#include "strak/energy/projection.h"
#include "strak/metrology/fairness.h"
#include "strak/spline/knot_insertion.h"
#include "strak/spline/knot_removal.h"
#include "strak/spline/net_product.h"
#include "strak/spline/reparametrize.h"

namespace strak {
namespace {

constexpr double kFree = 1e-13;      // of the size: a knot that costs no more was only inserted
constexpr double kRounding = 1e-12;  // of the size: what held rows may move
constexpr double kSamePoint = 1e-9;  // of the size: points closer than this are one
constexpr Index kBigNet = 10'000;

// One knot taken out of one direction.
struct Removal {
  int direction;
  double knot;
};

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

// No more than there are control points; where that is too little for the held rows, their check says so.
KeptEnds cut(KeptEnds ends, Index points) {
  while (ends.low + ends.high > points) --(ends.low > ends.high ? ends.low : ends.high);
  return ends;
}

KnotVector without(const KnotVector& knots, double knot) {
  std::vector<double> left = knots.knots();
  left.erase(std::find(left.begin(), left.end(), knot));
  return {knots.degree(), std::move(left)};
}

template <int D>
class Simplifier {
 public:
  Simplifier(const Spline<D>& spline, const Spline<D>& reference, const SimplifyOptions<D>& options)
      : options_(options), fine_(clamped(spline)), reference_(reference) {
    const Net points = fine_.euclideanNet();
    size_ = (points.colwise().maxCoeff() - points.colwise().minCoeff()).stableNorm();
    weight_ = fine_.isRational() ? fine_.net().rightCols(1).maxCoeff() : 1;
    for (int k = 0; k < D; ++k) ends_[static_cast<std::size_t>(k)] = endsOf(k, points);
    noteHeldRows();
    noteReference();
  }

  Simplified<D> run(const Spline<D>& input) {
    collect();
    const std::size_t kept = longestFair();
    Simplified<D> result{input, {}, 0, {}};
    if (kept < removals_.size()) {
      result.notes.push_back(fmt::format("{} more knots could go within the tolerance, but the fairness would suffer.",
                                         removals_.size() - kept));
    }
    if (kept == 0) {
      result.deviation = certifyDeviation(input, reference_);
      return result;
    }
    result.spline = *fit(kept);
    result.deviation = certifyDeviation(result.spline, reference_);
    result.knotsRemoved = static_cast<Index>(kept);
    return result;
  }

 private:
  KeptEnds endsOf(int k, const Net& points) const {
    const auto at = 2 * static_cast<std::size_t>(k);
    KeptEnds ends{options_.rows[at], options_.rows[at + 1]};
    const Index n = fine_.size(k);
    const Net low = sliceAlong<D>(points, fine_.sizes(), k, 0, 1);
    const Net high = sliceAlong<D>(points, fine_.sizes(), k, n - 1, 1);
    if ((low - high).cwiseAbs().maxCoeff() <= kSamePoint * size_) {
      ends.low = ends.high = std::max<Index>({1, ends.low, ends.high});
    }
    const auto shrunk = [&](const Net& rows) {
      return rows.rows() > 1 && (rows.rowwise() - rows.row(0)).cwiseAbs().maxCoeff() <= kSamePoint * size_;
    };
    if (shrunk(low)) ends.low = std::max<Index>(1, ends.low);
    if (shrunk(high)) ends.high = std::max<Index>(1, ends.high);
    const Index most = fine_.degree(k) + 1;
    return {std::min({ends.low, most, n}), std::min({ends.high, most, n})};
  }

  // Which rows are held, and all lines of each direction that lie in a strip of another one.
  void noteHeldRows() {
    held_.assign(static_cast<std::size_t>(fine_.net().rows()), 0);
    std::array<std::vector<Index>, D> lines;
    for (Index r = 0; r < fine_.net().rows(); ++r) {
      std::array<bool, D> inStrip{};
      std::array<Index, D> place{};
      Index rest = r;
      for (int k = D - 1; k >= 0; --k) {
        const auto at = static_cast<std::size_t>(k);
        place[at] = rest % fine_.size(k);
        rest /= fine_.size(k);
        inStrip[at] = place[at] < ends_[at].low || place[at] >= fine_.size(k) - ends_[at].high;
        if (inStrip[at]) held_[static_cast<std::size_t>(r)] = 1;
      }
      for (std::size_t k = 0; k < D; ++k) {
        bool other = false;
        for (std::size_t l = 0; l < D; ++l) other = other || (l != k && inStrip[l]);
        if (other && place[k] == 0) lines[k].push_back(r);
      }
    }
    for (int k = 0; k < D; ++k) {
      const auto at = static_cast<std::size_t>(k);
      Index step = 1;
      for (int l = k + 1; l < D; ++l) step *= fine_.size(l);
      const Index columns = fine_.net().cols();
      Net strip(fine_.size(k), static_cast<Index>(lines[at].size()) * columns);
      for (Index i = 0; i < fine_.size(k); ++i) {
        for (std::size_t c = 0; c < lines[at].size(); ++c) {
          strip.block(i, static_cast<Index>(c) * columns, 1, columns) = fine_.net().row(lines[at][c] + i * step);
        }
      }
      if (strip.cols() > 0) strips_[at].emplace(std::array<KnotVector, 1>{fine_.knots(k)}, std::move(strip));
    }
  }

  // The reference on the knots of the fine spline, where it fits there: then a difference of nets says a lot at once.
  void noteReference() {
    if (reference_.isRational() || fine_.isRational()) return;
    try {
      fineReference_ = refine(clamped(reference_), fine_.knots());
    } catch (const InvalidInput&) {
      fineReference_.reset();  // other degrees or knots: the certificate alone decides
    }
  }

  typename Spline<D>::Knots knotsAfter(std::size_t count) const {
    auto knots = fine_.knots();
    for (std::size_t i = 0; i < count; ++i) {
      KnotVector& direction = knots[static_cast<std::size_t>(removals_[i].direction)];
      direction = without(direction, removals_[i].knot);
    }
    return knots;
  }

  // The best approximation without the first `count` knots of the list; nothing where there is none.
  std::optional<Spline<D>> fit(std::size_t count) const {
    try {
      const auto knots = knotsAfter(count);
      auto ends = ends_;
      for (std::size_t k = 0; k < D; ++k) ends[k] = cut(ends[k], knots[k].size());
      return projectOnto(fine_, knots, ends);
    } catch (const Failure&) {
      return {};  // a weight would have gone, or the knots lie too unevenly
    }
  }

  // Whether the held rows stay and the deviation is proven to keep the tolerance.
  bool keepsShape(const Spline<D>& coarse) const {
    const Spline<D> again = refine(coarse, fine_.knots());
    const Net difference = again.net() - fine_.net();
    for (Index r = 0; r < difference.rows(); ++r) {
      if (held_[static_cast<std::size_t>(r)] && difference.row(r).norm() > kRounding * size_ * weight_) return false;
    }
    if (fineReference_) {
      // No point moves further than the farthest control point: cheap, and nearly always enough for a verdict.
      const double bound = (again.net() - fineReference_->net()).rowwise().norm().maxCoeff();
      if (bound <= std::max(options_.tolerance, kRounding * size_)) return true;
      if (bound > kHopeless * options_.tolerance) return false;
    } else if (options_.tolerance <= kRounding * size_) {
      return difference.rowwise().norm().maxCoeff() <= kRounding * size_ * weight_;
    }
    DeviationOptions rough;
    rough.relativeWidth = 1e-2;
    return certifyDeviation(coarse, reference_, rough).upper <= options_.tolerance;
  }

  // The knots that one round may take out together, cheapest first: no two neighbours, so that a smooth stretch thins
  // out evenly instead of losing one end.
  std::vector<Removal> candidates(const Spline<D>& now, double reach) const {
    struct Candidate {
      double cost;
      Removal removal;
    };
    std::vector<Candidate> all;
    for (int k = 0; k < D; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const KnotVector& knots = now.knots(k);
      if (knots.size() <= knots.degree() + 1) continue;
      const auto stuck = neededByStrips(k, knots);
      for (const KnotCost& cost : knotRemovalCosts(now, k)) {
        if (cost.cost > reach) break;
        const auto& refused = refused_[at];
        if (std::find(refused.begin(), refused.end(), cost.knot) != refused.end()) continue;
        if (std::binary_search(stuck.begin(), stuck.end(), cost.knot)) continue;
        if (knots.multiplicity(cost.knot) >= knots.degree() && cost.cost > kFree * size_ * weight_) continue;
        all.push_back({cost.cost, {k, cost.knot}});
      }
    }
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
    std::vector<Removal> result;
    std::array<std::vector<double>, D> blocked;
    std::array<Index, D> room{};
    for (int k = 0; k < D; ++k) room[static_cast<std::size_t>(k)] = now.size(k) - now.degree(k) - 1;
    for (const Candidate& candidate : all) {
      const auto at = static_cast<std::size_t>(candidate.removal.direction);
      const double knot = candidate.removal.knot;
      if (room[at] == 0 || std::find(blocked[at].begin(), blocked[at].end(), knot) != blocked[at].end()) continue;
      const auto& knots = now.knots()[at].knots();
      const auto below = std::lower_bound(knots.begin(), knots.end(), knot);
      const auto above = std::upper_bound(knots.begin(), knots.end(), knot);
      if (below != knots.begin()) blocked[at].push_back(*(below - 1));
      if (above != knots.end()) blocked[at].push_back(*above);
      result.push_back(candidate.removal);
      --room[at];
    }
    return result;
  }

  // The knots of direction k that the held strips need, ascending. What went already went at no cost to them.
  std::vector<double> neededByStrips(int k, const KnotVector& knots) const {
    const auto at = static_cast<std::size_t>(k);
    std::vector<double> needed;
    if (!strips_[at]) return needed;
    for (const KnotCost& cost :
         knotRemovalCosts(projectOnto(*strips_[at], {knots}, {cut(ends_[at], knots.size())}), 0)) {
      if (cost.cost > kRounding / 4 * size_ * weight_) needed.push_back(cost.knot);
    }
    std::sort(needed.begin(), needed.end());
    return needed;
  }

  bool stopped() const { return !options_.progress.report(-1, "fewer knots"); }

  void collect() {
    const double reach = std::max(kReach * options_.tolerance, kFree * size_) * weight_;
    std::size_t refusals = 0;
    while (refusals < kMostRefusals) {
      const auto now = fit(removals_.size());
      if (!now || stopped()) return;
      const std::vector<Removal> round = candidates(*now, reach);
      if (round.empty()) return;
      const std::size_t had = removals_.size();
      bool taken = false;
      for (std::size_t count = round.size(); count > 0 && !taken; count = (count * 2) / 3) {
        removals_.resize(had);
        removals_.insert(removals_.end(), round.begin(), round.begin() + static_cast<std::ptrdiff_t>(count));
        const auto coarse = fit(removals_.size());
        taken = coarse && keepsShape(*coarse);
        if (stopped()) break;
      }
      if (taken) continue;
      removals_.resize(had);
      refused_[static_cast<std::size_t>(round.front().direction)].push_back(round.front().knot);
      ++refusals;
    }
  }

  bool isSame(const Spline<D>& coarse) const {
    const Net moved = refine(coarse, fine_.knots()).net() - fine_.net();
    return moved.rowwise().norm().maxCoeff() <= kRounding * size_ * weight_;
  }

  bool isFair(std::size_t count, const Figures& limits) const {
    const auto coarse = fit(count);
    if (!coarse || !keepsShape(*coarse)) return false;
    if (isSame(*coarse)) return true;
    const Figures now = figuresOf(*coarse, integrationError(coarse->net().rows()));
    for (std::size_t i = 0; i < now.size(); ++i) {
      if (now[i] > limits[i]) return false;
    }
    return true;
  }

  // The largest number of removals from the start of the list, found by halving, with which everything holds.
  std::size_t longestFair() const {
    if (removals_.empty()) return 0;
    if (const auto all = fit(removals_.size()); all && keepsShape(*all) && isSame(*all)) return removals_.size();
    const double error = integrationError(fine_.net().rows());
    Figures limits = figuresOf(fine_, error);
    const bool same = fine_ == clamped(reference_);
    const Figures had = same ? limits : figuresOf(reference_, error);
    for (std::size_t i = 0; i < limits.size(); ++i) {
      const double grown = options_.fairnessGrowth * limits[i];
      // Twice the error, one for each integral; and what rounding makes of figures that are zero.
      limits[i] = (1 + 2 * error) * (same ? grown : std::min(grown, std::max(limits[i], had[i]))) + 1e-12;
    }
    if (isFair(removals_.size(), limits)) return removals_.size();
    std::size_t good = 0, bad = removals_.size();
    while (bad - good > 1 + good / 16 && !stopped()) {
      const std::size_t middle = good + (bad - good) / 2;
      (isFair(middle, limits) ? good : bad) = middle;
    }
    return good;
  }

  static constexpr std::size_t kMostRefusals = 8;  // single knots that may fail before the search ends
  static constexpr double kReach = 2;              // of the tolerance: knots that cost more alone are not tried
  static constexpr double kHopeless = 8;           // of the tolerance: the certificate is not this much below the bound

  const SimplifyOptions<D>& options_;
  Spline<D> fine_;
  const Spline<D>& reference_;
  std::optional<Spline<D>> fineReference_;
  double size_ = 0, weight_ = 1;
  std::array<KeptEnds, static_cast<std::size_t>(D)> ends_;
  std::vector<std::uint8_t> held_;
  std::array<std::optional<Curve>, static_cast<std::size_t>(D)> strips_;
  std::vector<Removal> removals_;
  std::array<std::vector<double>, D> refused_;
};

}  // namespace

template <int D>
Simplified<D> simplify(const Spline<D>& spline, const Spline<D>& reference, const SimplifyOptions<D>& options) {
  if (!(options.tolerance >= 0)) {
    throw InvalidInput(fmt::format("the tolerance for fewer knots is {}: give 0 or more", options.tolerance));
  }
  if (!(options.fairnessGrowth >= 1)) {
    throw InvalidInput(fmt::format("the fairness may grow by a factor of at least 1, not {}", options.fairnessGrowth));
  }
  for (Index rows : options.rows) {
    if (rows < 0) throw InvalidInput(fmt::format("cannot hold {} rows: give 0 or more", rows));
  }
  if (spline.pointDimension() != reference.pointDimension()) {
    throw InvalidInput(fmt::format("the splines have points of {} and {} coordinates: they cannot be compared",
                                   spline.pointDimension(), reference.pointDimension()));
  }
  return Simplifier<D>(spline, reference, options).run(spline);
}

template Simplified<1> simplify(const Spline<1>&, const Spline<1>&, const SimplifyOptions<1>&);
template Simplified<2> simplify(const Spline<2>&, const Spline<2>&, const SimplifyOptions<2>&);
template Simplified<3> simplify(const Spline<3>&, const Spline<3>&, const SimplifyOptions<3>&);

}  // namespace strak
