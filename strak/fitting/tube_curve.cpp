#include "strak/fitting/tube_curve.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "strak/base/error.h"
#include "strak/energy/gram.h"
#include "strak/metrology/closest_points.h"
#include "strak/spline/basis.h"
#include "strak/spline/periodic.h"

namespace strak {

namespace {

using Eigen::Vector2d;

constexpr int kDegree = 3;
constexpr Index kFirstSpans = 1000;     // at most
constexpr double kStiffest = 100;       // weight of the energy
constexpr double kStiffestCubed = 1e9;  // that weight, in parts of a span's cube: more is beyond rounding
constexpr double kStep = 4;             // of weights
constexpr int kSteps = 24;              // of them, on each set of knots
constexpr double kAim = 0.9;            // of the tolerance
constexpr int kHoldings = 6;            // refits where control points leave the domain
constexpr int kLatest = 6;              // refinements of the knots after which nothing came nearer

// Where spans begin and end: 0 .. 1.
using Breaks = std::vector<double>;

struct Trial {
  Curve curve;
  Eigen::VectorXd errors;
  double excess = std::numeric_limits<double>::infinity();  // sum of the squares of what is beyond the limits
  bool within = false;
};

KnotVector clampedKnots(const Breaks& breaks) {
  std::vector<double> knots(kDegree, breaks.front());
  knots.insert(knots.end(), breaks.begin(), breaks.end());
  knots.insert(knots.end(), kDegree, breaks.back());
  return KnotVector(kDegree, std::move(knots));
}

KnotVector periodicKnots(const Breaks& breaks) {
  const auto spans = static_cast<Index>(breaks.size()) - 1;
  std::vector<double> knots;
  for (Index i = -kDegree; i <= spans + kDegree; ++i) {
    const Index turn = i < 0 ? -1 : i / spans;
    knots.push_back(breaks[static_cast<std::size_t>(i - turn * spans)] + static_cast<double>(turn));
  }
  return KnotVector(kDegree, std::move(knots));
}

// The least squares problem on one set of knots. The control points of a closed curve are those of one turn; of an open
// one the first and the last are given.
class Smoother {
 public:
  Smoother(const Breaks& breaks, const Net& parameters, const Net& points, const Net& ends)
      : points_(points),
        knots_(ends.rows() == 0 ? periodicKnots(breaks) : clampedKnots(breaks)),
        unknowns_(ends.rows() == 0 ? knots_.size() - kDegree : knots_.size()),
        ends_(ends),
        energy_(gramMatrix(knots_, 2, 2)) {
    for (Index i = 0; i < parameters.rows(); ++i) {
      const Index span = knots_.findSpan(parameters(i, 0));
      Row& row = rows_.emplace_back();
      row.first = span - kDegree;
      basisDerivatives(knots_, span, parameters(i, 0), 0, row.values.data());
    }
  }

  // The least of mean of w |error|^2 + stiffness * bending; control points inside the domain.
  Curve curve(const Eigen::VectorXd& weights, double stiffness, const Eigen::AlignedBox2d& domain) const {
    std::vector<Eigen::Triplet<double>> entries;
    Net right = Net::Zero(unknowns_, 2);
    for (Index i = 0; i < energy_.size; ++i) {
      for (Index j = std::max<Index>(i - kDegree, 0); j <= std::min(i + kDegree, energy_.size - 1); ++j) {
        entries.emplace_back(i % unknowns_, j % unknowns_, stiffness * energy_(i, j));
      }
    }
    for (std::size_t p = 0; p < rows_.size(); ++p) {
      const auto point = static_cast<Index>(p);
      const double weight = weights[point] / static_cast<double>(rows_.size());
      for (Index a = 0; a <= kDegree; ++a) {
        const Index i = (rows_[p].first + a) % unknowns_;
        const double own = weight * rows_[p].values[static_cast<std::size_t>(a)];
        right.row(i) += own * points_.row(point);
        for (Index b = 0; b <= kDegree; ++b) {
          entries.emplace_back(i, (rows_[p].first + b) % unknowns_, own * rows_[p].values[static_cast<std::size_t>(b)]);
        }
      }
    }
    SparseMatrix matrix(unknowns_, unknowns_);
    matrix.setFromTriplets(entries.begin(), entries.end());
    Net net = Net::Zero(unknowns_, 2);
    std::vector<char> held(static_cast<std::size_t>(unknowns_), 0);
    if (ends_.rows() > 0) {
      held.front() = held.back() = 1;
      net.row(0) = ends_.row(0);
      net.row(unknowns_ - 1) = ends_.row(1);
    }
    for (Index k = 0; k < 2; ++k) solve(matrix, right.col(k), held, domain, k, net);
    Net all(knots_.size(), 2);
    for (Index i = 0; i < all.rows(); ++i) all.row(i) = net.row(i % unknowns_);
    Curve curve({knots_}, std::move(all));
    return ends_.rows() == 0 ? inside(toClamped<1>(curve, 0), domain) : curve;
  }

 private:
  using SparseMatrix = Eigen::SparseMatrix<double>;
  struct Row {  // of the functions that are not zero at a point
    Index first = 0;
    std::array<double, kDegree + 1> values{};
  };

  // Coordinates that leave the domain stay on its border, and the others follow.
  void solve(const SparseMatrix& matrix, const Eigen::VectorXd& right, std::vector<char> held,
             const Eigen::AlignedBox2d& domain, Index k, Net& net) const {
    for (int round = 0;; ++round) {
      SparseMatrix own = matrix;  // NOLINT(performance-unnecessary-copy-initialization): changed by valueRef
      Eigen::VectorXd rest = right;
      for (Index column = 0; column < unknowns_; ++column) {
        const bool given = held[static_cast<std::size_t>(column)] != 0;
        for (SparseMatrix::InnerIterator entry(own, column); entry; ++entry) {
          if (given && held[static_cast<std::size_t>(entry.row())] == 0)
            rest[entry.row()] -= entry.value() * net(column, k);
          if (given || held[static_cast<std::size_t>(entry.row())] != 0)
            entry.valueRef() = entry.row() == column ? 1 : 0;
        }
        if (given) rest[column] = net(column, k);
      }
      net.col(k) = Eigen::SimplicialLDLT<SparseMatrix>(own).solve(rest);
      bool any = false;
      for (Index i = 0; i < unknowns_ && !domain.isEmpty(); ++i) {
        if (net(i, k) >= domain.min()[k] && net(i, k) <= domain.max()[k]) continue;
        net(i, k) = std::clamp(net(i, k), domain.min()[k], domain.max()[k]);
        any = std::exchange(held[static_cast<std::size_t>(i)], 1) == 0 || any;
      }
      if (!any || round == kHoldings) return;
    }
  }

  // What rounding may leave.
  static Curve inside(Curve curve, const Eigen::AlignedBox2d& domain) {
    Eigen::Ref<Net> net = curve.net();
    for (Index k = 0; k < 2 && !domain.isEmpty(); ++k) {
      net.col(k) = net.col(k).cwiseMax(domain.min()[k]).cwiseMin(domain.max()[k]);
    }
    return curve;
  }

  const Net& points_;
  KnotVector knots_;
  Index unknowns_;
  const Net& ends_;
  BandMatrix energy_;
  std::vector<Row> rows_;
};

class Tube {
 public:
  // Ends: two rows, or none of a closed curve.
  Tube(const Net& parameters, const Net& points, const Net& ends, const TubeLimits& limits,
       const Eigen::AlignedBox2d& domain)
      : parameters_(parameters), points_(points), ends_(ends), limits_(limits), domain_(domain) {}

  Curve curve(Index leastSpans) const {
    const Index spans = std::clamp<Index>(points_.rows() / 2, leastSpans, kFirstSpans);
    Breaks breaks;
    for (Index i = 0; i <= spans; ++i) breaks.push_back(static_cast<double>(i) / static_cast<double>(spans));
    Trial best = fairest(breaks);
    if (best.errors.size() == 0) throw Failure("a trimming curve cannot be computed: its border points are too uneven");
    Eigen::VectorXd errors = best.errors;
    for (int late = 0; !best.within && late < kLatest && refine(errors, breaks);) {
      Trial next = fairest(breaks);
      if (next.errors.size() == 0) break;
      errors = next.errors;
      ++late;
      if (next.within || next.excess < best.excess) {
        best = std::move(next);
        late = 0;
      }
    }
    return std::move(best.curve);
  }

 private:
  // On these knots; the nearest one if none keeps the limits, without errors if rounding leaves none.
  Trial fairest(const Breaks& breaks) const {
    double shortest = 1;
    for (std::size_t i = 1; i < breaks.size(); ++i) shortest = std::min(shortest, breaks[i] - breaks[i - 1]);
    const double stiffest = std::min(kStiffest, kStiffestCubed * std::pow(shortest, 3));
    const Smoother smoother(breaks, parameters_, points_, ends_);
    Eigen::VectorXd weights = Eigen::VectorXd::Ones(points_.rows());
    Trial best;
    for (int step = 0; step < kSteps; ++step) {
      Curve curve = smoother.curve(weights, stiffest, domain_);
      if (!curve.net().allFinite()) break;  // weights too different for rounding
      Eigen::VectorXd errors = closestPointsFrom<1>(curve, points_, parameters_).distances;
      const auto count = static_cast<double>(errors.size());
      const double noise = std::max(std::sqrt(errors.squaredNorm() / count) - limits_.noise, 0.0);
      const double excess = (errors.array() - limits_.tolerance).max(0).square().sum() + count * noise * noise;
      const bool noisy = noise > 0, within = excess == 0;
      for (Index i = 0; i < weights.size(); ++i) {
        if (noisy || errors[i] > kAim * limits_.tolerance) weights[i] *= kStep;
      }
      if (within || excess < best.excess) best = {std::move(curve), std::move(errors), excess, within};
      if (within) break;
    }
    return best;
  }

  // Halves the spans of points that are too far away between their points; one alone gets a knot, where the curve can
  // touch the domain's border, and then a neighbour. If none of them can be halved all with several points are.
  bool refine(const Eigen::VectorXd& errors, Breaks& breaks) const {
    const Breaks old = breaks;
    for (const bool all : {false, true}) {
      Index first = 0;
      for (std::size_t s = 0; s + 1 < old.size(); ++s) {
        Index end = first;
        double squares = 0, largest = 0;
        for (; end < points_.rows() && (parameters_(end, 0) < old[s + 1] || s + 2 == old.size()); ++end) {
          squares += errors[end] * errors[end];
          largest = std::max(largest, errors[end]);
        }
        const auto count = static_cast<double>(end - first);
        const bool bad = largest > limits_.tolerance || squares > count * limits_.noise * limits_.noise;
        const Index middle = (first + end) / 2;
        double place = (old[s] + old[s + 1]) / 2;
        if (end - first > 1) {
          place = (parameters_(middle - 1, 0) + parameters_(middle, 0)) / 2;
        } else if (end > first && parameters_(first, 0) > old[s]) {
          place = parameters_(first, 0);
        }
        if (end - first > (bad ? 0 : 1) && (bad || all) && place > old[s] && place < old[s + 1]) {
          breaks.push_back(place);
        }
        first = end;
      }
      if (breaks.size() > old.size()) break;
    }
    std::sort(breaks.begin(), breaks.end());
    return breaks.size() > old.size();
  }

  const Net& parameters_;
  const Net& points_;
  const Net& ends_;
  TubeLimits limits_;
  Eigen::AlignedBox2d domain_;
};

Curve lineBetween(const Vector2d& from, const Vector2d& to) {
  Net net(kDegree + 1, 2);
  for (Index i = 0; i <= kDegree; ++i) {
    net.row(i) = (from + (to - from) * (static_cast<double>(i) / kDegree)).transpose();
  }
  net.row(kDegree) = to.transpose();
  return Curve({KnotVector::uniformClamped(kDegree, 1)}, std::move(net));
}

}  // namespace

Curve tubeBetween(const Vector2d& from, const Net& between, const Vector2d& to, const TubeLimits& limits,
                  const Eigen::AlignedBox2d& domain) {
  const Index count = between.rows();
  if (count == 0) return lineBetween(from, to);
  Net parameters(count, 1);
  double gone = 0;
  Vector2d last = from;
  for (Index i = 0; i < count; ++i) {
    gone += (between.row(i).transpose() - last).norm();
    last = between.row(i).transpose();
    parameters(i, 0) = gone;
  }
  parameters /= gone + (to - last).norm();
  Net ends(2, 2);
  ends << from.transpose(), to.transpose();
  return Tube(parameters, between, ends, limits, domain).curve(1);
}

Curve tubeAround(const Net& points, const TubeLimits& limits, const Eigen::AlignedBox2d& domain) {
  const Index count = points.rows();
  Net parameters(count, 1);
  double gone = 0;
  for (Index i = 0; i < count; ++i) {
    parameters(i, 0) = gone;
    gone += (points.row((i + 1) % count) - points.row(i)).norm();
  }
  parameters /= gone;
  return Tube(parameters, points, Net(0, 2), limits, domain).curve(kDegree + 1);
}

}  // namespace strak
