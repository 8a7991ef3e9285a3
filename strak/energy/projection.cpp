#include "strak/energy/projection.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "strak/base/error.h"
#include "strak/spline/basis.h"
#include "strak/spline/knot_insertion.h"
#include "strak/spline/net_product.h"

namespace strak {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

std::vector<double> commonBreaks(const KnotVector& a, const KnotVector& b) {
  std::vector<double> breaks{a.from(), a.to()};
  for (const auto* knots : {&a, &b}) {
    for (const auto& inner : knots->innerKnots()) breaks.push_back(inner.value);
  }
  std::sort(breaks.begin(), breaks.end());
  breaks.erase(std::unique(breaks.begin(), breaks.end()), breaks.end());
  return breaks;
}

// The outermost `count` control points on `to` that give the end the derivatives 0 .. count - 1 of a line on `from`, as
// a matrix on the outermost degree + 1 control points there; both in the order of the net.
Eigen::MatrixXd keptEnd(const KnotVector& from, const KnotVector& to, bool high, Index count) {
  const Index p = from.degree(), q = to.degree();
  if (count == 0) return Eigen::MatrixXd(0, p + 1);
  const double end = high ? to.to() : to.from();
  const int order = static_cast<int>(count) - 1;
  const Eigen::MatrixXd had = basisDerivatives(from, from.findSpan(end), end, order);
  const Eigen::MatrixXd has = basisDerivatives(to, to.findSpan(end), end, order);
  // The k-th derivative at a clamped end sees the outermost k + 1 points only: a triangular system, solved from the
  // end.
  Eigen::MatrixXd points = Eigen::MatrixXd::Zero(count, p + 1);
  for (Index k = 0; k < count; ++k) {
    const Index row = high ? count - 1 - k : k;
    Eigen::RowVectorXd rest = had.row(k);
    for (Index i = 0; i < k; ++i) {
      rest -= has(k, high ? q - i : i) * points.row(high ? count - 1 - i : i);
    }
    points.row(row) = rest / has(k, high ? q - k : k);
  }
  return points;
}

}  // namespace

// Gauss rules between all breaks of both.
Sparse mixedGram(const KnotVector& a, const KnotVector& b) {
  const int p = a.degree(), q = b.degree();
  const std::vector<double> breaks = commonBreaks(a, b);
  const GaussRule rule = gaussLegendre((p + q) / 2 + 1);
  std::vector<double> left(static_cast<std::size_t>(p) + 1), right(static_cast<std::size_t>(q) + 1);
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t s = 0; s + 1 < breaks.size(); ++s) {
    const double half = (breaks[s + 1] - breaks[s]) / 2, middle = breaks[s] + half;
    const Index spanA = a.findSpan(middle), spanB = b.findSpan(middle);
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(p + 1, q + 1);
    for (std::size_t g = 0; g < rule.nodes.size(); ++g) {
      const double u = middle + half * rule.nodes[g];
      basisDerivatives(a, spanA, u, 0, left.data());
      basisDerivatives(b, spanB, u, 0, right.data());
      sum += half * rule.weights[g] * Eigen::Map<const Eigen::VectorXd>(left.data(), p + 1) *
             Eigen::Map<const Eigen::RowVectorXd>(right.data(), q + 1);
    }
    for (int i = 0; i <= p; ++i) {
      for (int j = 0; j <= q; ++j) entries.emplace_back(spanA - p + i, spanB - q + j, sum(i, j));
    }
  }
  Sparse gram(a.size(), b.size());
  gram.setFromTriplets(entries.begin(), entries.end());
  return gram;
}

Projection::Projection(const KnotVector& from, const KnotVector& to, KeptEnds ends) {
  if (!from.isClamped() || !to.isClamped() || from.from() != to.from() || from.to() != to.to()) {
    throw InvalidInput("a projection needs clamped knots on one domain: clamp both first");
  }
  const Index most = to.degree() + 1;
  const Index low = std::clamp<Index>(ends.low, 0, most), high = std::clamp<Index>(ends.high, 0, most);
  if (low + high > to.size()) {
    throw InvalidInput(fmt::format("{} control points cannot keep {} derivatives at the ends: give more spans",
                                   to.size(), low + high));
  }
  mixed_ = mixedGram(to, from);
  gram_ = mixedGram(to, to);
  low_ = keptEnd(from, to, false, low);
  high_ = keptEnd(from, to, true, high);
  const Index free = to.size() - low - high;
  if (free == 0) return;
  Sparse inner = gram_.block(low, low, free, free);
  scale_ = inner.diagonal().cwiseSqrt().cwiseInverse();
  inner = scale_.asDiagonal() * inner * scale_.asDiagonal();
  factor_.compute(inner);
  if (factor_.info() != Eigen::Success || !(factor_.vectorD().minCoeff() > 0)) {
    throw Failure("the best approximation is not determined on these knots: they lie too unevenly");
  }
}

// `kept` holds the kept control points in place and zeros elsewhere.
Net Projection::solve(const Eigen::Ref<const Net>& right, Net kept) const {
  const Index free = scale_.size();
  // The second pass repairs what the normal equations lost.
  for (int pass = 0; pass < 2 && free > 0; ++pass) {
    const Net residual = scale_.asDiagonal() * (right - gram_ * kept).middleRows(low_.rows(), free);
    kept.middleRows(low_.rows(), free) += scale_.asDiagonal() * factor_.solve(residual);
  }
  return kept;
}

Net Projection::apply(const Eigen::Ref<const Net>& lines) const {
  Net kept = Net::Zero(toSize(), lines.cols());
  if (low_.rows() > 0) kept.topRows(low_.rows()) = low_ * lines.topRows(low_.cols());
  if (high_.rows() > 0) kept.bottomRows(high_.rows()) = high_ * lines.bottomRows(high_.cols());
  return solve(mixed_ * lines, std::move(kept));
}

template <int D>
Spline<D> projectOnto(const Spline<D>& spline, const typename Spline<D>::Knots& knots,
                      const std::array<KeptEnds, static_cast<std::size_t>(D)>& ends) {
  Net net = spline.net();
  auto sizes = spline.sizes();
  for (int k = 0; k < D; ++k) {
    const auto at = static_cast<std::size_t>(k);
    if (knots[at] == spline.knots(k)) continue;
    const Projection projection(spline.knots(k), knots[at], ends[at]);
    net = mapLines<D>(net, sizes, k, projection.toSize(), [&](const auto& lines) { return projection.apply(lines); });
    sizes[at] = projection.toSize();
  }
  if (spline.isRational() && !(net.rightCols(1).minCoeff() > 0)) {
    throw Failure("on these knots a weight would not stay positive: give more spans");
  }
  return {knots, std::move(net), spline.isRational()};
}

template Spline<1> projectOnto(const Spline<1>&, const Spline<1>::Knots&, const std::array<KeptEnds, 1>&);
template Spline<2> projectOnto(const Spline<2>&, const Spline<2>::Knots&, const std::array<KeptEnds, 2>&);
template Spline<3> projectOnto(const Spline<3>&, const Spline<3>::Knots&, const std::array<KeptEnds, 3>&);

}  // namespace strak
