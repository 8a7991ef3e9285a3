#include "strak/energy/projection.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "strak/base/error.h"
#include "strak/spline/basis.h"
#include "strak/spline/evaluate.h"
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

Samples samplesBetween(const KnotVector& a, const KnotVector& b, int perCell) {
  const std::vector<double> breaks = commonBreaks(a, b);
  const GaussRule rule = gaussLegendre(perCell);
  Samples samples{{a.from()}, {0}};
  for (std::size_t s = 0; s + 1 < breaks.size(); ++s) {
    const double half = (breaks[s + 1] - breaks[s]) / 2;
    for (std::size_t g = 0; g < rule.nodes.size(); ++g) {
      samples.places.push_back(breaks[s] + half * (1 + rule.nodes[g]));
      samples.weights.push_back(half * rule.weights[g]);
    }
  }
  samples.places.push_back(a.to());
  samples.weights.push_back(0);
  return samples;
}

Sparse basisMatrix(const KnotVector& knots, const std::vector<double>& parameters) {
  const int p = knots.degree();
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> values(static_cast<std::size_t>(p) + 1);
  for (std::size_t r = 0; r < parameters.size(); ++r) {
    const Index span = knots.findSpan(parameters[r]);
    basisDerivatives(knots, span, parameters[r], 0, values.data());
    for (int j = 0; j <= p; ++j) {
      entries.emplace_back(static_cast<Index>(r), span - p + j, values[static_cast<std::size_t>(j)]);
    }
  }
  Sparse matrix(static_cast<Index>(parameters.size()), knots.size());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

Projection::Projection(const Samples& samples, const KnotVector& to) {
  if (!to.isClamped() || to.size() < 2) throw InvalidInput("a projection needs clamped knots of degree 1 or more");
  const auto weights =
      Eigen::Map<const Eigen::VectorXd>(samples.weights.data(), static_cast<Index>(samples.weights.size()));
  mixed_ = Sparse(basisMatrix(to, samples.places).transpose()) * weights.asDiagonal();
  gram_ = mixedGram(to, to);
  low_ = high_ = Eigen::MatrixXd::Ones(1, 1);
  factor(to);
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
  factor(to);
}

void Projection::factor(const KnotVector& to) {
  const Index low = low_.rows(), free = to.size() - low - high_.rows();
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

template <int D>
Spline<D> polynomialOnto(const Spline<D>& spline, const typename Spline<D>::Knots& knots) {
  // Seen from the middle of the points, so that it does not matter where the model lies.
  const Point middle = spline.euclideanNet().colwise().mean();
  const auto back = [&](Net net) -> Spline<D> {
    net.rowwise() += middle;
    return {knots, std::move(net)};
  };
  if (!spline.isRational()) {
    std::array<KeptEnds, static_cast<std::size_t>(D)> ends;
    ends.fill({1, 1});
    return back(projectOnto<D>({spline.knots(), Net(spline.net().rowwise() - middle)}, knots, ends).net());
  }
  constexpr double kMostValues = 1e7;
  std::array<Samples, static_cast<std::size_t>(D)> samples;
  typename Spline<D>::Grid grid;
  typename Spline<D>::Sizes sizes;
  double values = 1;
  for (std::size_t k = 0; k < D; ++k) {
    const KnotVector& from = spline.knots()[k];
    samples[k] = samplesBetween(from, knots[k], (from.degree() + knots[k].degree()) / 2 + 3);
    grid[k] = samples[k].places;
    sizes[k] = static_cast<Index>(grid[k].size());
    values *= static_cast<double>(sizes[k]);
  }
  if (values > kMostValues) {
    throw InvalidInput("a rational spline of this size cannot be approximated in one piece: cut it into parts");
  }
  Net net = derivativesOnGrid(spline, grid, 0).rowwise() - middle;
  for (std::size_t k = 0; k < D; ++k) {
    const Projection projection(samples[k], knots[k]);
    net = mapLines<D>(net, sizes, static_cast<int>(k), projection.toSize(),
                      [&](const auto& lines) { return projection.apply(lines); });
    sizes[k] = projection.toSize();
  }
  return back(std::move(net));
}

template Spline<1> polynomialOnto(const Spline<1>&, const Spline<1>::Knots&);
template Spline<2> polynomialOnto(const Spline<2>&, const Spline<2>::Knots&);
template Spline<3> polynomialOnto(const Spline<3>&, const Spline<3>::Knots&);

template Spline<1> projectOnto(const Spline<1>&, const Spline<1>::Knots&, const std::array<KeptEnds, 1>&);
template Spline<2> projectOnto(const Spline<2>&, const Spline<2>::Knots&, const std::array<KeptEnds, 2>&);
template Spline<3> projectOnto(const Spline<3>&, const Spline<3>::Knots&, const std::array<KeptEnds, 3>&);

}  // namespace strak
