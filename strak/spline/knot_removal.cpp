#include "strak/spline/knot_removal.h"

#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "strak/base/error.h"
#include "strak/spline/knot_insertion.h"
#include "strak/spline/net_product.h"

namespace strak {

namespace {

using Sparse = Eigen::SparseMatrix<double>;

KnotVector withoutKnots(const KnotVector& knots, std::vector<double> removed, const char* name) {
  std::sort(removed.begin(), removed.end());
  std::vector<double> left;
  auto next = removed.begin();
  for (const double u : knots.knots()) {
    if (next != removed.end() && *next == u && u > knots.from() && u < knots.to()) {
      ++next;
    } else {
      left.push_back(u);
    }
    if (next != removed.end() && !(*next >= u)) break;
  }
  if (next != removed.end()) {
    throw InvalidInput(
        fmt::format("direction {} has no inner knot {} left to remove (it stands there {} times): name inner "
                    "knots",
                    name, *next, knots.multiplicity(*next)));
  }
  return {knots.degree(), std::move(left), name};
}

// Solves min |R c - d| for all lines of a direction at once; a clamped end keeps its point.
class Approximation {
 public:
  Approximation(const KnotVector& coarse, const KnotVector& fine) : refinement_(refinementMatrix(coarse, fine)) {
    const bool points = coarse.degree() > 0;  // pieces of degree 0 have no end points to hold
    first_ = points && coarse.knots().front() == coarse.from() ? 1 : 0;
    const Index last = coarse.size() - (points && coarse.knots().back() == coarse.to() ? 1 : 0);
    free_ = last - first_;
    if (free_ > 0) {
      const Sparse inner = refinement_.middleCols(first_, free_);
      const Sparse normal = inner.transpose() * inner;
      factor_.compute(normal);
      if (factor_.info() != Eigen::Success)
        throw Failure("knot removal met a singular system: remove fewer knots at once");
    }
  }

  const Sparse& refinement() const { return refinement_; }

  // `old`: a row a point of the line, the columns are independent.
  Net solve(const Eigen::Map<const Net>& old) const {
    Net result = Net::Zero(refinement_.cols(), old.cols());
    if (first_ == 1) result.row(0) = old.row(0);
    if (first_ + free_ < result.rows()) result.bottomRows(1) = old.bottomRows(1);
    // The second pass repairs what the normal equations lost.
    for (int pass = 0; pass < 2 && free_ > 0; ++pass) {
      const Net residual = old - refinement_ * result;
      const Net right = (refinement_.transpose() * residual).middleRows(first_, free_);
      result.middleRows(first_, free_) += factor_.solve(right);
    }
    return result;
  }

 private:
  Sparse refinement_;
  Eigen::SimplicialLDLT<Sparse, Eigen::Lower, Eigen::NaturalOrdering<int>> factor_;
  Index first_ = 0, free_ = 0;
};

// How far the points of space can lie apart, given homogeneous nets on the same knots. X - Y = (A - B - Y (v - w)) / w
// with X = A / v and Y = B / w, all seen from the middle of the points so that it does not matter where the model lies.
template <int D>
double boundOf(const Net& before, const Net& after, bool rational) {
  if (!rational) return (before - after).rowwise().norm().maxCoeff();
  const Index dimension = before.cols() - 1;
  const auto points = [&](const Net& net) -> Net {
    return (net.leftCols(dimension).array().colwise() / net.col(dimension).array()).matrix();
  };
  const Point middle = points(before).colwise().mean();
  const Eigen::VectorXd weightChange = before.col(dimension) - after.col(dimension);
  const Net pointChange = before.leftCols(dimension) - after.leftCols(dimension) - weightChange * middle;
  const double radius = (points(after).rowwise() - middle).rowwise().norm().maxCoeff();
  return (pointChange.rowwise().norm().maxCoeff() + radius * weightChange.cwiseAbs().maxCoeff()) /
         before.col(dimension).minCoeff();
}

}  // namespace

// The part of the net that is orthogonal to the splines without a knot is one vector z over degree + 2 neighbours,
// because refinement by one knot, d_j = (1 - a_j) c_{j-1} + a_j c_j, leaves one dimension out.
template <int D>
std::vector<KnotCost> knotRemovalCosts(const Spline<D>& spline, int direction) {
  const KnotVector& knots = spline.knots(direction);
  const int p = knots.degree();
  std::vector<KnotCost> result;
  std::vector<double> z(static_cast<std::size_t>(p) + 2);
  for (const auto& inner : knots.innerKnots()) {
    const double t = inner.value;
    const Index span = std::upper_bound(knots.knots().begin(), knots.knots().end(), t) - knots.knots().begin() - 2;
    const auto coarse = [&](Index i) { return knots[i <= span ? i : i + 1]; };
    const auto ratio = [&](Index j) {
      return j <= span - p ? 1.0 : j > span ? 0.0 : (t - coarse(j)) / (coarse(j + p) - coarse(j));
    };
    std::fill(z.begin(), z.end(), 0.0);
    z[0] = 1;
    double square = 1;
    double longest = 1;
    for (int i = 0; i <= p; ++i) {
      const auto at = static_cast<std::size_t>(i);
      z[at + 1] = -z[at] * ratio(span - p + i) / (1 - ratio(span - p + i + 1));
      square += z[at + 1] * z[at + 1];
      longest = std::max(longest, std::abs(z[at + 1]));
    }
    Sparse row(1, knots.size());
    for (int i = 0; i <= p + 1; ++i) row.insert(0, span - p + i) = z[static_cast<std::size_t>(i)] * longest / square;
    const Net parts = multiplyAlong<D>(row, spline.net(), spline.sizes(), direction);
    result.push_back({parts.rowwise().norm().maxCoeff(), t});
  }
  std::sort(result.begin(), result.end(), [](const KnotCost& a, const KnotCost& b) {
    return a.cost < b.cost || (a.cost == b.cost && a.knot < b.knot);
  });
  return result;
}

template <int D>
KnotRemoval<D> removeKnots(const Spline<D>& spline, int direction, const std::vector<double>& knots) {
  KnotRemoval<D> result{spline, 0, knots};
  std::sort(result.removed.begin(), result.removed.end());
  if (knots.empty()) return result;
  const KnotVector& fine = spline.knots(direction);
  const KnotVector coarse = withoutKnots(fine, knots, directionName(direction));
  const Approximation approximation(coarse, fine);
  Net net = mapLines<D>(spline.net(), spline.sizes(), direction, coarse.size(),
                        [&](const auto& lines) { return approximation.solve(lines); });
  if (spline.isRational() && !(net.rightCols(1).minCoeff() > 0)) {
    throw Failure(fmt::format("without these knots of direction {} a weight would not stay positive: remove fewer",
                              directionName(direction)));
  }
  auto sizes = spline.sizes();
  sizes[static_cast<std::size_t>(direction)] = coarse.size();
  result.bound = boundOf<D>(spline.net(), multiplyAlong<D>(approximation.refinement(), net, sizes, direction),
                            spline.isRational());
  auto allKnots = spline.knots();
  allKnots[static_cast<std::size_t>(direction)] = coarse;
  result.spline = Spline<D>(std::move(allKnots), std::move(net), spline.isRational());
  return result;
}

template <int D>
KnotRemoval<D> removeKnotsWithin(const Spline<D>& spline, int direction, double tolerance) {
  if (!(tolerance >= 0)) {
    throw InvalidInput(fmt::format("the tolerance of knot removal is {}: give 0 or more", tolerance));
  }
  KnotRemoval<D> best{spline, 0, {}};
  while (true) {
    const auto costs = knotRemovalCosts(best.spline, direction);
    bool improved = false;
    for (std::size_t count = costs.size(); count > 0 && !improved; count /= 2) {
      std::vector<double> attempt = best.removed;
      for (std::size_t i = 0; i < count; ++i) attempt.push_back(costs[i].knot);
      try {
        auto candidate = removeKnots(spline, direction, attempt);
        if (!(candidate.bound <= tolerance)) continue;
        best = std::move(candidate);
        improved = true;
      } catch (const Failure&) {
        continue;  // a weight would have gone: fewer knots may do
      }
    }
    if (!improved) return best;
  }
}

#define STRAK_INSTANTIATE(D)                                                                 \
  template KnotRemoval<D> removeKnots<D>(const Spline<D>&, int, const std::vector<double>&); \
  template KnotRemoval<D> removeKnotsWithin<D>(const Spline<D>&, int, double);               \
  template std::vector<KnotCost> knotRemovalCosts<D>(const Spline<D>&, int);
STRAK_INSTANTIATE(1)
STRAK_INSTANTIATE(2)
STRAK_INSTANTIATE(3)
#undef STRAK_INSTANTIATE

}  // namespace strak
