#include "strak/metrology/deviation.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "strak/base/error.h"
#include "strak/metrology/bezier_patch.h"

namespace strak {

namespace {

// A box is not halved more often than this in one direction.
constexpr int kMaxHalvings = 40;

// Cells refined before their results are put together and the next ones are chosen.
constexpr std::size_t kLargestBatch = 4096;

// Rounding: a Bezier point is made from control points of size M by convex combinations: at most 7 p + 4 roundings per
// direction for the extraction (knot differences, blossom, degree elevation or product), p for each halving, some for
// the difference and the norm. In units of the last place of M, the allowance below is larger than all of them.
template <int D>
double roundingAllowance(const std::array<int, D>& degrees) {
  int sum = 4;
  for (const int p : degrees) sum += p;
  return 32 * sum * std::numeric_limits<double>::epsilon();
}

// The pieces of one direction: the spans of one operand on the cells between the breakpoints of both.
struct CellMap {
  Index first;  // control point
  Eigen::MatrixXd toBezier;
};

std::vector<CellMap> cellMaps(const KnotVector& knots, const std::vector<double>& breakpoints, int raisedDegree) {
  std::vector<CellMap> result;
  const Eigen::MatrixXd elevation = bezierElevation(knots.degree(), raisedDegree);
  for (std::size_t c = 0; c + 1 < breakpoints.size(); ++c) {
    const Index span = knots.findSpan(breakpoints[c]);
    Eigen::MatrixXd map = spanToBezier(knots, span, breakpoints[c], breakpoints[c + 1]);
    result.push_back({span - knots.degree(), raisedDegree == knots.degree() ? std::move(map) : elevation * map});
  }
  return result;
}

std::vector<double> breakpoints(const KnotVector& a, const KnotVector& b) {
  std::vector<double> result{a.from(), a.to()};
  for (const KnotVector* knots : {&a, &b}) {
    for (const auto& inner : knots->innerKnots()) result.push_back(inner.value);
  }
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

// One spline on the common cells.
template <int D>
struct Operand {
  Spline<D> spline;
  std::array<std::vector<CellMap>, D> cells;

  Operand(Spline<D> s, const std::array<std::vector<double>, D>& breaks, const std::array<int, D>& degrees)
      : spline(std::move(s)) {
    for (std::size_t k = 0; k < D; ++k) cells[k] = cellMaps(spline.knots()[k], breaks[k], degrees[k]);
  }

  // The rows of the net that a cell needs, in their order.
  Net block(const std::array<Index, D>& cell) const {
    Index rows = 1;
    for (int k = 0; k < D; ++k) rows *= spline.degree(k) + 1;
    Net result(rows, spline.net().cols());
    for (Index r = 0; r < rows; ++r) {
      std::array<Index, D> index;
      Index rest = r;
      for (int k = D - 1; k >= 0; --k) {
        const auto d = static_cast<std::size_t>(k);
        const Index count = spline.degree(k) + 1;
        index[d] = cells[d][static_cast<std::size_t>(cell[d])].first + rest % count;
        rest /= count;
      }
      result.row(r) = spline.net().row(spline.row(index));
    }
    return result;
  }

  Net bezier(const std::array<Index, D>& cell, const Net& points) const {
    std::array<const Eigen::MatrixXd*, D> maps;
    for (std::size_t k = 0; k < D; ++k) maps[k] = &cells[k][static_cast<std::size_t>(cell[k])].toBezier;
    return applyMaps<D>(maps, points);
  }
};

double largestNorm(const Net& points, bool rational) {
  const Index dimension = points.cols() - (rational ? 1 : 0);
  double largest = 0;
  for (Index r = 0; r < points.rows(); ++r)
    largest = std::max(largest, points.row(r).head(dimension).norm() / (rational ? points(r, dimension) : 1));
  return largest;
}

// The farthest corner that counts; norm 0 if none does.
template <int D>
typename BezierPatch<D>::Corner countedCorner(const BezierPatch<D>& patch, const DeviationOptions& options) {
  if (options.counts == nullptr) return patch.farthestCorner();
  typename BezierPatch<D>::Corner best;
  for (unsigned number = 0; number < (1U << D); ++number) {
    const auto corner = patch.corner(number);
    if (corner.norm > best.norm && options.counts(corner.place.data(), corner.place.data(), options.context)) {
      best = corner;
    }
  }
  return best;
}

// The difference of two splines, cell by cell. `magnitude` is the size of the numbers that it was made from, which
// rounding is relative to.
template <int D>
class Difference {
 public:
  struct Piece {
    BezierPatch<D> patch;
    double magnitude = 0;
  };

  Difference(const Spline<D>& a, const Spline<D>& b) {
    rational_ = a.isRational() || b.isRational();
    std::array<int, D> degreesA, degreesB;
    for (int k = 0; k < D; ++k) {
      const auto d = static_cast<std::size_t>(k);
      breaks_[d] = breakpoints(a.knots(k), b.knots(k));
      degreesA[d] = a.degree(k);
      degreesB[d] = b.degree(k);
    }
    if (a.knots() == b.knots() && sameWeights(a, b)) {
      // The difference of the nets has no rounding but its own.
      Net net = a.net();
      const Index dimension = a.pointDimension();
      net.leftCols(dimension) -= b.net().leftCols(dimension);
      degrees_ = degreesA;
      first_.emplace(Spline<D>(a.knots(), std::move(net), rational_), breaks_, degreesA);
    } else if (rational_) {
      for (std::size_t k = 0; k < D; ++k) degrees_[k] = degreesA[k] + degreesB[k];
      first_.emplace(homogeneous(a), breaks_, degreesA);
      second_.emplace(homogeneous(b), breaks_, degreesB);
    } else {
      for (std::size_t k = 0; k < D; ++k) degrees_[k] = std::max(degreesA[k], degreesB[k]);
      first_.emplace(a, breaks_, degrees_);
      second_.emplace(b, breaks_, degrees_);
    }
  }

  const std::array<int, D>& degrees() const { return degrees_; }

  Index cells() const {
    Index count = 1;
    for (const auto& b : breaks_) count *= static_cast<Index>(b.size()) - 1;
    return count;
  }

  Piece piece(Index number) const {
    const auto cell = cellIndex(number);
    Piece result;
    result.patch.degrees = degrees_;
    result.patch.rational = rational_;
    for (std::size_t k = 0; k < D; ++k) {
      result.patch.from[k] = breaks_[k][static_cast<std::size_t>(cell[k])];
      result.patch.to[k] = breaks_[k][static_cast<std::size_t>(cell[k]) + 1];
    }
    Net a = first_->block(cell);
    if (!second_) {
      result.magnitude = largestNorm(a, rational_);
      result.patch.points = first_->bezier(cell, a);
      return result;
    }
    Net b = second_->block(cell);
    if (!rational_) {
      // Around the origin there are more digits; the subtraction loses none that count.
      const Point origin = a.row(0);
      a.rowwise() -= origin;
      b.rowwise() -= origin;
    }
    result.magnitude = largestNorm(a, rational_) + largestNorm(b, rational_);
    a = first_->bezier(cell, a);
    b = second_->bezier(cell, b);
    if (!rational_) {
      result.patch.points = a - b;
      return result;
    }
    // A / v - B / w = (w A - v B) / (v w)
    std::array<int, D> degreesA, degreesB;
    for (int k = 0; k < D; ++k) {
      degreesA[static_cast<std::size_t>(k)] = first_->spline.degree(k);
      degreesB[static_cast<std::size_t>(k)] = second_->spline.degree(k);
    }
    const Index last = a.cols() - 1;
    result.patch.points = bezierProduct<D>(a, degreesA, b.col(last), degreesB);
    result.patch.points.leftCols(last) -= bezierProduct<D>(b.leftCols(last), degreesB, a.col(last), degreesA);
    return result;
  }

  // An upper bound of the difference on a cell and a point of it, both cheap: from the control points of the difference
  // where it is a spline, else from the Bezier points.
  struct Estimate {
    double bound = 0;
    typename BezierPatch<D>::Corner corner;
    double magnitude = 0;
  };
  Estimate estimate(Index number, const DeviationOptions& options) const {
    if (!cellCounts(number, options)) return {};
    if (!second_) return {controlBound(cellIndex(number)), {}, 0};
    const Piece p = piece(number);
    return {p.patch.bound(), countedCorner(p.patch, options), p.magnitude};
  }

  // Fills the norms of the control points, for controlBound.
  void prepare() {
    if (second_) return;
    const Net& net = first_->spline.net();
    norms_.resize(net.rows());
    const Index dimension = net.cols() - (rational_ ? 1 : 0);
    for (Index r = 0; r < net.rows(); ++r)
      norms_[r] = net.row(r).head(dimension).norm() / (rational_ ? net(r, dimension) : 1);
  }

 private:
  static bool sameWeights(const Spline<D>& a, const Spline<D>& b) {
    if (a.isRational() != b.isRational()) return false;
    return !a.isRational() || a.net().col(a.pointDimension()) == b.net().col(b.pointDimension());
  }

  static Spline<D> homogeneous(const Spline<D>& s) {
    if (s.isRational()) return s;
    Net net(s.net().rows(), s.net().cols() + 1);
    net << s.net(), Eigen::VectorXd::Ones(s.net().rows());
    return Spline<D>(s.knots(), std::move(net), true);
  }

  bool cellCounts(Index number, const DeviationOptions& options) const {
    if (options.counts == nullptr) return true;
    const auto cell = cellIndex(number);
    std::array<double, D> from, to;
    for (std::size_t k = 0; k < D; ++k) {
      from[k] = breaks_[k][static_cast<std::size_t>(cell[k])];
      to[k] = breaks_[k][static_cast<std::size_t>(cell[k]) + 1];
    }
    return options.counts(from.data(), to.data(), options.context);
  }

  std::array<Index, D> cellIndex(Index number) const {
    std::array<Index, D> cell;
    for (int k = D - 1; k >= 0; --k) {
      const auto d = static_cast<std::size_t>(k);
      const auto count = static_cast<Index>(breaks_[d].size()) - 1;
      cell[d] = number % count;
      number /= count;
    }
    return cell;
  }

  double controlBound(const std::array<Index, D>& cell) const {
    const Spline<D>& s = first_->spline;
    std::array<Index, 3> first{}, count{1, 1, 1}, size{1, 1, 1};
    for (int k = 0; k < D; ++k) {
      const auto d = static_cast<std::size_t>(k);
      first[d] = first_->cells[d][static_cast<std::size_t>(cell[d])].first;
      count[d] = s.degree(k) + 1;
      size[d] = s.size(k);
    }
    double largest = 0;
    for (Index i = first[0]; i < first[0] + count[0]; ++i) {
      for (Index j = first[1]; j < first[1] + count[1]; ++j) {
        const Index row = (i * size[1] + j) * size[2] + first[2];
        largest = std::max(largest, norms_.segment(row, count[2]).maxCoeff());
      }
    }
    return largest;
  }

  bool rational_ = false;
  std::array<int, D> degrees_{};
  std::array<std::vector<double>, D> breaks_;
  std::optional<Operand<D>> first_, second_;
  Eigen::VectorXd norms_;
};

// What is known of one cell, or of many.
template <int D>
struct Bounds {
  double upper = 0;
  typename BezierPatch<D>::Corner lower;
  double magnitude = 0;
  Index patches = 0;

  void raise(const typename BezierPatch<D>::Corner& corner) {
    if (corner.norm > lower.norm) lower = corner;
  }
};

// Branch and bound on one cell, the part with the largest bound first. Parts that cannot exceed what has been reached
// already (by more than the width asked for, or by more than rounding) are left.
template <int D>
Bounds<D> refineCell(const typename Difference<D>::Piece& piece, double reached, double width, double noise,
                     Index maxPatches, const DeviationOptions& options) {
  struct Part {
    BezierPatch<D> patch;
    double bound;
    std::array<int, D> halvings;
  };
  const auto less = [](const Part& x, const Part& y) { return x.bound < y.bound; };
  Bounds<D> result;
  result.lower.norm = reached;
  result.magnitude = piece.magnitude;
  result.patches = 1;
  result.raise(countedCorner(piece.patch, options));
  std::vector<Part> heap;
  heap.push_back({piece.patch, piece.patch.bound(), {}});
  while (!heap.empty()) {
    std::pop_heap(heap.begin(), heap.end(), less);
    const Part part = std::move(heap.back());
    heap.pop_back();
    const double settled = std::max(result.lower.norm / (1 - width), noise * piece.magnitude);
    const int direction = part.patch.mostBent();
    if (part.bound <= settled || result.patches >= maxPatches || direction < 0 ||
        part.halvings[static_cast<std::size_t>(direction)] >= kMaxHalvings) {
      result.upper = std::max(result.upper, part.bound);
      if (part.bound <= settled) break;
      continue;
    }
    for (auto& half : part.patch.halves(direction)) {
      ++result.patches;
      if (options.counts != nullptr && !options.counts(half.from.data(), half.to.data(), options.context)) continue;
      Part child{std::move(half), 0, part.halvings};
      ++child.halvings[static_cast<std::size_t>(direction)];
      child.bound = child.patch.bound();
      result.raise(countedCorner(child.patch, options));
      heap.push_back(std::move(child));
      std::push_heap(heap.begin(), heap.end(), less);
    }
  }
  return result;
}

// b on the domain of a, or why they cannot be compared.
template <int D>
Spline<D> onDomainOf(const Spline<D>& a, const Spline<D>& b) {
  if (a.pointDimension() != b.pointDimension()) {
    throw InvalidInput(fmt::format("the points have {} and {} coordinates: compare splines of the same space",
                                   a.pointDimension(), b.pointDimension()));
  }
  std::array<KnotVector, D> knots = b.knots();
  for (int k = 0; k < D; ++k) {
    const KnotVector& x = a.knots(k);
    KnotVector& y = knots[static_cast<std::size_t>(k)];
    const double slack = 1e-12 * std::max(x.length(), y.length());
    if (std::abs(x.from() - y.from()) > slack || std::abs(x.to() - y.to()) > slack) {
      throw InvalidInput(
          fmt::format("the domains differ in direction {}, [{}, {}] and [{}, {}]: compare splines on the same domain",
                      directionName(k), x.from(), x.to(), y.from(), y.to()));
    }
    if (x.from() != y.from() || x.to() != y.to()) y = y.rescaled(x.from(), x.to());
  }
  return Spline<D>(std::move(knots), b.net(), b.isRational());
}

}  // namespace

template <int D>
Deviation<D> certifyDeviation(const Spline<D>& a, const Spline<D>& b, const DeviationOptions& options) {
  if (!(options.relativeWidth >= 0 && options.relativeWidth < 1)) {
    throw InvalidInput(fmt::format("the relative width {} of the bounds must lie in [0, 1)", options.relativeWidth));
  }
  Difference<D> difference(a, onDomainOf(a, b));
  difference.prepare();
  const double rounding = roundingAllowance<D>(difference.degrees());
  // A little less than asked for, to leave room for the rounding allowance.
  const double width = 0.9 * options.relativeWidth;

  const auto count = static_cast<std::size_t>(difference.cells());
  std::vector<typename Difference<D>::Estimate> estimates(count);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 64), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i)
      estimates[i] = difference.estimate(static_cast<Index>(i), options);
  });
  Bounds<D> total;
  for (std::size_t k = 0; k < D; ++k) total.lower.place[k] = a.knots()[k].from();
  std::vector<std::size_t> order(count);
  for (std::size_t i = 0; i < count; ++i) {
    order[i] = i;
    total.raise(estimates[i].corner);
    total.magnitude = std::max(total.magnitude, estimates[i].magnitude);
  }
  std::sort(order.begin(), order.end(), [&](std::size_t x, std::size_t y) {
    return estimates[x].bound > estimates[y].bound || (estimates[x].bound == estimates[y].bound && x < y);
  });

  // Batches that grow: the first cells raise the lower bound, the others profit. A batch sees what the batches before
  // it reached and nothing of its own, so that threads change nothing.
  std::size_t done = 0;
  for (std::size_t batch = 32; done < count; batch = std::min(2 * batch, kLargestBatch)) {
    const std::size_t end = std::min(count, done + batch);
    const double reached = total.lower.norm;
    const auto settled = [&](std::size_t i) { return estimates[order[i]].bound * (1 - width) <= reached; };
    if (settled(done) || total.patches >= options.maxPatches) break;
    const Index share = std::max<Index>(1, (options.maxPatches - total.patches) / static_cast<Index>(end - done));
    std::vector<Bounds<D>> found(end - done);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(done, end, 4), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) {
        if (settled(i)) {
          found[i - done].upper = estimates[order[i]].bound;
        } else {
          found[i - done] =
              refineCell<D>(difference.piece(static_cast<Index>(order[i])), reached, width, rounding, share, options);
        }
      }
    });
    for (const Bounds<D>& f : found) {
      total.upper = std::max(total.upper, f.upper);
      total.raise(f.lower);
      total.magnitude = std::max(total.magnitude, f.magnitude);
      total.patches += f.patches;
    }
    done = end;
  }
  if (done < count) total.upper = std::max(total.upper, estimates[order[done]].bound);

  Deviation<D> result;
  result.place = total.lower.place;
  result.lower = std::max(0.0, total.lower.norm - rounding * total.magnitude);
  result.upper = std::max(total.upper, total.lower.norm) * (1 + rounding) + rounding * total.magnitude;
  return result;
}

template Deviation<1> certifyDeviation<1>(const Spline<1>&, const Spline<1>&, const DeviationOptions&);
template Deviation<2> certifyDeviation<2>(const Spline<2>&, const Spline<2>&, const DeviationOptions&);
template Deviation<3> certifyDeviation<3>(const Spline<3>&, const Spline<3>&, const DeviationOptions&);

}  // namespace strak
