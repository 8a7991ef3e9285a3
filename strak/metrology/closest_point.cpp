#include "strak/metrology/closest_point.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "strak/base/error.h"
#include "strak/metrology/bezier_patch.h"
#include "strak/spline/evaluate.h"

namespace strak {

namespace {

constexpr int kMaxSteps = 60;
constexpr int kMaxBacktracks = 30;

// Smaller steps, in parts of the stretch, and smaller cosines between the residual and the tangents are rounding.
constexpr double kLeastStep = 1e-15;
constexpr double kLeastCosine = 1e-14;

// Derivatives at u, from the left where u is the end of its stretch (one place below, the polynomial is that of the
// left).
template <int D, class Stretches>
Net derivativesWithin(const Spline<D>& spline, std::array<double, D> u, const Stretches& box, int order) {
  for (std::size_t k = 0; k < D; ++k) {
    if (u[k] == box[k].to && box[k].to < spline.knots()[k].to()) u[k] = std::nextafter(u[k], box[k].from);
  }
  return derivatives<D>(spline, u, order);
}

}  // namespace

template <int D>
ClosestPointFinder<D>::ClosestPointFinder(const Spline<D>& spline, const ClosestPointOptions& options)
    : spline_(&spline), options_(options) {
  if (options.cellsPerDirection < 1 || options.maxStarts < 1) {
    throw InvalidInput(fmt::format("the cells per direction ({}) and the starts ({}) must be at least 1",
                                   options.cellsPerDirection, options.maxStarts));
  }
  Cells end;
  for (int k = 0; k < D; ++k) {
    const auto d = static_cast<std::size_t>(k);
    const KnotVector& knots = spline.knots(k);
    const auto spans = knots.spans();
    const auto count = static_cast<Index>(spans.size());
    const Index parts = (options.cellsPerDirection + count - 1) / count;
    std::size_t stretchStart = 0;
    for (std::size_t s = 0; s < spans.size(); ++s) {
      // Between two spans lie as many steps as their common knot is multiple.
      if (s > 0 && spans[s] - spans[s - 1] >= knots.degree()) stretchStart = cells_[d].size();
      const double from = knots[spans[s]], to = knots[spans[s] + 1];
      for (Index i = 0; i < parts; ++i) {
        const double a = std::lerp(from, to, static_cast<double>(i) / static_cast<double>(parts));
        const double b =
            i + 1 == parts ? to : std::lerp(from, to, static_cast<double>(i + 1) / static_cast<double>(parts));
        cells_[d].push_back({a, b, spans[s], {}});
      }
      for (std::size_t c = stretchStart; c < cells_[d].size(); ++c)
        cells_[d][c].stretch = {cells_[d][stretchStart].from, to};
    }
    end[d] = static_cast<Index>(cells_[d].size());
  }
  build(Cells{}, end);
}

template <int D>
Index ClosestPointFinder<D>::build(const Cells& first, const Cells& end) {
  const auto number = static_cast<Index>(nodes_.size());
  const auto n = nodes_.size();
  nodes_.emplace_back();
  low_.emplace_back();
  high_.emplace_back();
  nodes_[n].cell = first;
  std::size_t longest = 0;
  for (std::size_t k = 1; k < D; ++k) {
    if (end[k] - first[k] > end[longest] - first[longest]) longest = k;
  }
  if (end[longest] - first[longest] == 1) {
    // A leaf: the box of the Bezier points.
    std::array<Eigen::MatrixXd, D> maps;
    std::array<const Eigen::MatrixXd*, D> pointers;
    Index rows = 1;
    for (int k = 0; k < D; ++k) {
      const auto d = static_cast<std::size_t>(k);
      const Cell& cell = cells_[d][static_cast<std::size_t>(first[d])];
      maps[d] = spanToBezier(spline_->knots(k), cell.span, cell.from, cell.to);
      pointers[d] = &maps[d];
      rows *= spline_->degree(k) + 1;
    }
    Net block(rows, spline_->net().cols());
    for (Index r = 0; r < rows; ++r) {
      std::array<Index, D> index;
      Index rest = r;
      for (int k = D - 1; k >= 0; --k) {
        const auto d = static_cast<std::size_t>(k);
        const Index points = spline_->degree(k) + 1;
        index[d] = cells_[d][static_cast<std::size_t>(first[d])].span - spline_->degree(k) + rest % points;
        rest /= points;
      }
      block.row(r) = spline_->net().row(spline_->row(index));
    }
    Net points = applyMaps<D>(pointers, block);
    const Index dimension = spline_->pointDimension();
    if (spline_->isRational()) points.leftCols(dimension).array().colwise() /= points.col(dimension).array();
    low_[n] = points.leftCols(dimension).colwise().minCoeff().transpose();
    high_[n] = points.leftCols(dimension).colwise().maxCoeff().transpose();
    return number;
  }
  Cells middleEnd = end, middleFirst = first;
  middleEnd[longest] = middleFirst[longest] = (first[longest] + end[longest]) / 2;
  const Index a = build(first, middleEnd), b = build(middleFirst, end);
  nodes_[n].children[0] = a;
  nodes_[n].children[1] = b;
  low_[n] = low_[static_cast<std::size_t>(a)].cwiseMin(low_[static_cast<std::size_t>(b)]);
  high_[n] = high_[static_cast<std::size_t>(a)].cwiseMax(high_[static_cast<std::size_t>(b)]);
  return number;
}

template <int D>
double ClosestPointFinder<D>::boxDistance(Index node, const Point& point) const {
  const auto n = static_cast<std::size_t>(node);
  return (low_[n].transpose() - point).cwiseMax(point - high_[n].transpose()).cwiseMax(0).norm();
}

template <int D>
void ClosestPointFinder<D>::checkPoint(const Eigen::Ref<const Point>& point) const {
  if (point.size() != spline_->pointDimension()) {
    throw InvalidInput(fmt::format("the point has {} coordinates but the spline has {}: give as many", point.size(),
                                   spline_->pointDimension()));
  }
  if (!point.allFinite()) throw InvalidInput("the point is not finite: correct its coordinates");
}

// Minimizes |X - P|^2 / 2 in the box. Parameters at a bound with the derivative pointing outwards stay there.
template <int D>
ClosestPoint<D> ClosestPointFinder<D>::newton(const Point& point, Parameters u,
                                              const std::array<Stretch, D>& box) const {
  using Vector = Eigen::Matrix<double, D, 1>;
  using Matrix = Eigen::Matrix<double, D, D>;
  ClosestPoint<D> best;
  best.converged = false;
  Net d = derivativesWithin<D>(*spline_, u, box, 2);
  double value = (d.row(0) - point).squaredNorm() / 2;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Point residual = d.row(0) - point;
    Vector gradient;
    Matrix hessian, gauss;
    Index second = D + 1;
    for (int a = 0; a < D; ++a) {
      gradient[a] = residual.dot(d.row(1 + a));
      for (int b = a; b < D; ++b, ++second) {
        gauss(a, b) = gauss(b, a) = d.row(1 + a).dot(d.row(1 + b));
        hessian(a, b) = hessian(b, a) = gauss(a, b) + residual.dot(d.row(second));
      }
    }
    bool stationary = true;
    for (int a = 0; a < D; ++a) {
      const auto k = static_cast<std::size_t>(a);
      const bool held = (u[k] <= box[k].from && gradient[a] > 0) || (u[k] >= box[k].to && gradient[a] < 0);
      if (held) {
        gradient[a] = 0;
        for (Matrix* m : {&hessian, &gauss}) {
          m->row(a).setZero();
          m->col(a).setZero();
          (*m)(a, a) = 1;
        }
      }
      stationary = stationary && std::abs(gradient[a]) <= kLeastCosine * residual.norm() * d.row(1 + a).norm();
    }
    if (stationary) {
      best.converged = true;
      break;
    }
    // Where the full Hessian is not positive definite that of Gauss-Newton, a little lifted, still goes down.
    Eigen::LLT<Matrix> factor(hessian);
    if (factor.info() != Eigen::Success) {
      for (int a = 0; a < D; ++a) gauss(a, a) += 1e-12 * gauss(a, a) + std::numeric_limits<double>::min();
      factor.compute(gauss);
    }
    const Vector way = factor.info() == Eigen::Success ? Vector(-factor.solve(gradient)) : Vector(-gradient);
    double length = 1, largest = 0;
    bool lower = false;
    Parameters next;
    for (int i = 0; i < kMaxBacktracks && !lower; ++i, length /= 2) {
      largest = 0;
      double slope = 0;
      for (std::size_t k = 0; k < D; ++k) {
        next[k] = std::clamp(u[k] + length * way[static_cast<Index>(k)], box[k].from, box[k].to);
        largest = std::max(largest, std::abs(next[k] - u[k]) / (box[k].to - box[k].from));
        slope += gradient[static_cast<Index>(k)] * (next[k] - u[k]);
      }
      if (largest <= kLeastStep) break;
      Net ahead = derivativesWithin<D>(*spline_, next, box, 2);
      const double nextValue = (ahead.row(0) - point).squaredNorm() / 2;
      lower = nextValue <= value + 1e-4 * std::min(slope, 0.0);
      if (lower) {
        d = std::move(ahead);
        value = nextValue;
        u = next;
      }
    }
    if (!lower) {
      best.converged = true;  // no step of a size that counts goes down
      break;
    }
  }
  best.parameters = u;
  best.point = d.row(0);
  best.distance = (best.point - point).norm();
  return best;
}

template <int D>
ClosestPoint<D> ClosestPointFinder<D>::findFrom(const Eigen::Ref<const Point>& point, const Parameters& start) const {
  checkPoint(point);
  Parameters u = start;
  std::array<Stretch, D> box;
  for (std::size_t k = 0; k < D; ++k) {
    const KnotVector& knots = spline_->knots()[k];
    u[k] = std::clamp(u[k], knots.from(), knots.to());
    const auto next = std::upper_bound(cells_[k].begin(), cells_[k].end(), u[k],
                                       [](double value, const Cell& cell) { return value < cell.from; });
    box[k] = std::prev(next)->stretch;
  }
  return newton(point, u, box);
}

template <int D>
ClosestPoint<D> ClosestPointFinder<D>::find(const Eigen::Ref<const Point>& point) const {
  checkPoint(point);
  const Point p = point;
  ClosestPoint<D> best;
  best.distance = std::numeric_limits<double>::infinity();
  struct Entry {
    double distance;
    Index node;
  };
  const auto farther = [](const Entry& x, const Entry& y) {
    return x.distance > y.distance || (x.distance == y.distance && x.node > y.node);
  };
  std::vector<Entry> heap{{boxDistance(0, p), 0}};
  for (Index starts = 0; !heap.empty() && starts < options_.maxStarts;) {
    std::pop_heap(heap.begin(), heap.end(), farther);
    const Entry entry = heap.back();
    heap.pop_back();
    if (entry.distance >= best.distance) break;
    const Node& node = nodes_[static_cast<std::size_t>(entry.node)];
    if (node.children[0] >= 0) {
      for (const Index child : node.children) {
        heap.push_back({boxDistance(child, p), child});
        std::push_heap(heap.begin(), heap.end(), farther);
      }
      continue;
    }
    Parameters start;
    std::array<Stretch, D> box;
    for (std::size_t k = 0; k < D; ++k) {
      const Cell& cell = cells_[k][static_cast<std::size_t>(node.cell[k])];
      start[k] = (cell.from + cell.to) / 2;
      box[k] = cell.stretch;
    }
    const ClosestPoint<D> found = newton(p, start, box);
    if (found.distance < best.distance) best = found;
    ++starts;
  }
  return best;
}

template <int D>
ClosestPoint<D> closestPoint(const Spline<D>& spline, const Eigen::Ref<const Point>& point,
                             const ClosestPointOptions& options) {
  return ClosestPointFinder<D>(spline, options).find(point);
}

template class ClosestPointFinder<1>;
template class ClosestPointFinder<2>;
template ClosestPoint<1> closestPoint<1>(const Spline<1>&, const Eigen::Ref<const Point>&, const ClosestPointOptions&);
template ClosestPoint<2> closestPoint<2>(const Spline<2>&, const Eigen::Ref<const Point>&, const ClosestPointOptions&);

}  // namespace strak
