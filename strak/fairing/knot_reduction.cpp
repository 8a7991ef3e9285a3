#include "strak/fairing/knot_reduction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "strak/base/error.h"
#include "strak/spline/knot_insertion.h"
#include "strak/spline/knot_removal.h"
#include "strak/spline/net_product.h"
#include "strak/spline/reparametrize.h"

namespace strak {
namespace {

constexpr double kFree = 1e-13;      // of the size: a knot that costs no more was only inserted
constexpr double kSamePoint = 1e-9;  // of the size: points closer than this are one
constexpr double kReach = 2;         // of the tolerance: knots that cost more alone are not tried
constexpr double kHopeless = 8;      // of the tolerance: the certificate is not this much below the bound

KnotVector without(const KnotVector& knots, double knot) {
  std::vector<double> left = knots.knots();
  left.erase(std::find(left.begin(), left.end(), knot));
  return {knots.degree(), std::move(left)};
}

// No more than there are control points; where that is too little for the held rows, their check says so.
KeptEnds cut(KeptEnds ends, Index points) {
  while (ends.low + ends.high > points) --(ends.low > ends.high ? ends.low : ends.high);
  return ends;
}

}  // namespace

template <int D>
KnotReduction<D>::KnotReduction(const Spline<D>& spline, const Spline<D>& reference,
                                const KnotReductionOptions<D>& options)
    : options_(options), fine_(clamped(spline)), reference_(reference) {
  if (!(options.tolerance >= 0)) {
    throw InvalidInput(fmt::format("the tolerance for fewer knots is {}: give 0 or more", options.tolerance));
  }
  for (Index rows : options.rows) {
    if (rows < 0) throw InvalidInput(fmt::format("cannot hold {} rows: give 0 or more", rows));
  }
  if (spline.pointDimension() != reference.pointDimension()) {
    throw InvalidInput(fmt::format("the splines have points of {} and {} coordinates: they cannot be compared",
                                   spline.pointDimension(), reference.pointDimension()));
  }
  const Net points = fine_.euclideanNet();
  size_ = (points.colwise().maxCoeff() - points.colwise().minCoeff()).stableNorm();
  weight_ = fine_.isRational() ? fine_.net().rightCols(1).maxCoeff() : 1;
  for (int k = 0; k < D; ++k) ends_[static_cast<std::size_t>(k)] = endsOf(k, points);
  noteHeldRows();
  // The reference on the knots of the fine spline, where it fits there: then a difference of nets says a lot at once.
  if (reference_.isRational() || fine_.isRational()) return;
  try {
    fineReference_ = refine(clamped(reference_), fine_.knots());
  } catch (const InvalidInput&) {
    fineReference_.reset();  // other degrees or knots: the certificate alone decides
  }
}

template <int D>
KeptEnds KnotReduction<D>::endsOf(int k, const Net& points) const {
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
template <int D>
void KnotReduction<D>::noteHeldRows() {
  held_.assign(static_cast<std::size_t>(fine_.net().rows()), 0);
  if (!options_.exactStrips) return;
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

template <int D>
std::optional<Spline<D>> KnotReduction<D>::fit(std::size_t count) const {
  auto knots = fine_.knots();
  for (std::size_t i = 0; i < count; ++i) {
    KnotVector& direction = knots[static_cast<std::size_t>(taken_[i].direction)];
    direction = without(direction, taken_[i].knot);
  }
  auto ends = ends_;
  for (std::size_t k = 0; k < D; ++k) ends[k] = cut(ends[k], knots[k].size());
  try {
    return projectOnto(fine_, knots, ends);
  } catch (const Failure&) {
    return {};  // a weight would have gone, or the knots lie too unevenly
  }
}

template <int D>
bool KnotReduction<D>::isSame(const Spline<D>& coarse) const {
  const Net moved = refine(coarse, fine_.knots()).net() - fine_.net();
  return moved.rowwise().norm().maxCoeff() <= kRounding * size_ * weight_;
}

template <int D>
bool KnotReduction<D>::keepsShape(const Spline<D>& coarse) const {
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

// Ascending. What was taken already went at no cost to the strips.
template <int D>
std::vector<double> KnotReduction<D>::stuckKnots(int direction, const KnotVector& knots) const {
  const auto at = static_cast<std::size_t>(direction);
  std::vector<double> needed;
  if (!strips_[at]) return needed;
  const Curve strips = projectOnto(*strips_[at], {knots}, {cut(ends_[at], knots.size())});
  for (const KnotCost& cost : knotRemovalCosts(strips, 0)) {
    if (cost.cost > kRounding / 4 * size_ * weight_) needed.push_back(cost.knot);
  }
  std::sort(needed.begin(), needed.end());
  return needed;
}

template <int D>
bool KnotReduction<D>::neededByStrips(int direction, const KnotVector& knots, double knot) const {
  const auto needed = stuckKnots(direction, knots);
  return std::binary_search(needed.begin(), needed.end(), knot);
}

// What one round may take out together, cheapest first: no two neighbours, so that a smooth stretch thins out evenly
// instead of losing one end.
template <int D>
std::vector<TakenKnot> KnotReduction<D>::round(const Spline<D>& now, const Rule& mayGo) const {
  const double reach = std::max(kReach * options_.tolerance, kFree * size_) * weight_;
  std::vector<Candidate> all;
  for (int k = 0; k < D; ++k) {
    const auto& refused = refused_[static_cast<std::size_t>(k)];
    const KnotVector& knots = now.knots(k);
    if (knots.size() <= knots.degree() + 1) continue;
    const auto stuck = stuckKnots(k, knots);
    for (const KnotCost& cost : knotRemovalCosts(now, k)) {
      if (cost.cost > reach) break;
      if (std::find(refused.begin(), refused.end(), cost.knot) != refused.end()) continue;
      if (std::binary_search(stuck.begin(), stuck.end(), cost.knot)) continue;
      const Candidate candidate{k, cost.knot, cost.cost, knots.multiplicity(cost.knot),
                                cost.cost <= kFree * size_ * weight_};
      if (mayGo(candidate)) all.push_back(candidate);
    }
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
  std::vector<TakenKnot> result;
  std::array<std::vector<double>, D> blocked;
  std::array<Index, D> room{};
  for (int k = 0; k < D; ++k) room[static_cast<std::size_t>(k)] = now.size(k) - now.degree(k) - 1;
  for (const Candidate& candidate : all) {
    const auto at = static_cast<std::size_t>(candidate.direction);
    const double knot = candidate.knot;
    if (room[at] == 0 || std::find(blocked[at].begin(), blocked[at].end(), knot) != blocked[at].end()) continue;
    const auto& knots = now.knots()[at].knots();
    const auto below = std::lower_bound(knots.begin(), knots.end(), knot);
    const auto above = std::upper_bound(knots.begin(), knots.end(), knot);
    if (below != knots.begin()) blocked[at].push_back(*(below - 1));
    if (above != knots.end()) blocked[at].push_back(*above);
    result.push_back({candidate.direction, knot});
    --room[at];
  }
  return result;
}

template <int D>
void KnotReduction<D>::collect(const Rule& mayGo) {
  std::size_t refusals = 0;
  while (refusals < options_.mostRefusals) {
    const auto now = fit(taken_.size());
    if (!now || stopped()) return;
    const std::vector<TakenKnot> next = round(*now, mayGo);
    if (next.empty()) return;
    const std::size_t had = taken_.size();
    bool accepted = false;
    for (std::size_t count = next.size(); count > 0 && !accepted; count = (count * 2) / 3) {
      taken_.resize(had);
      taken_.insert(taken_.end(), next.begin(), next.begin() + static_cast<std::ptrdiff_t>(count));
      const auto coarse = fit(taken_.size());
      accepted = coarse && keepsShape(*coarse);
      if (stopped()) break;
    }
    if (accepted) continue;
    taken_.resize(had);
    refused_[static_cast<std::size_t>(next.front().direction)].push_back(next.front().knot);
    ++refusals;
  }
}

template class KnotReduction<1>;
template class KnotReduction<2>;
template class KnotReduction<3>;

}  // namespace strak
