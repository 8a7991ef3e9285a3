#include "strak/fitting/tube_curve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "strak/fitting/least_squares.h"
#include "strak/metrology/closest_points.h"
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
constexpr int kLatest = 6;              // halvings of knots after which nothing came nearer

// Where spans begin and end: 0 .. 1.
using Breaks = std::vector<double>;

struct Trial {
  Curve curve;
  Eigen::VectorXd errors;
  double excess = std::numeric_limits<double>::infinity();  // sum of the squares of what is beyond the tolerance
  bool within = false;
};

// `fit(breaks, weights, lambda)` makes a curve of the points with these parameters.
template <typename Fitter>
class Tube {
 public:
  Tube(const Net& parameters, const Net& points, const TubeLimits& limits, const Fitter& fit)
      : parameters_(parameters), points_(points), limits_(limits), fit_(fit) {}

  Curve curve(Index leastSpans) const {
    const Index spans = std::clamp<Index>(points_.rows() / 2, leastSpans, kFirstSpans);
    Breaks breaks;
    for (Index i = 0; i <= spans; ++i) breaks.push_back(static_cast<double>(i) / static_cast<double>(spans));
    Trial best = fairest(breaks);
    Eigen::VectorXd errors = best.errors;
    for (int late = 0; !best.within && late < kLatest && refine(errors, breaks);) {
      Trial next = fairest(breaks);
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
  // On these knots; the nearest one if none keeps the limits.
  Trial fairest(const Breaks& breaks) const {
    double shortest = 1;
    for (std::size_t i = 1; i < breaks.size(); ++i) shortest = std::min(shortest, breaks[i] - breaks[i - 1]);
    const double stiffest = std::min(kStiffest, kStiffestCubed * std::pow(shortest, 3));
    Eigen::VectorXd weights = Eigen::VectorXd::Ones(points_.rows());
    Trial best;
    for (int step = 0; step < kSteps; ++step) {
      Curve curve = fit_(breaks, weights, stiffest / weights.mean());
      Eigen::VectorXd errors = closestPointsFrom<1>(curve, points_, parameters_).distances;
      const bool noisy = std::sqrt(errors.squaredNorm() / static_cast<double>(errors.size())) > limits_.noise;
      const double excess = (errors.array() - limits_.tolerance).max(0).square().sum();
      const bool within = !noisy && excess == 0;
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
  TubeLimits limits_;
  const Fitter& fit_;
};

KnotVector clampedKnots(const Breaks& breaks) {
  std::vector<double> knots(kDegree, breaks.front());
  knots.insert(knots.end(), breaks.begin(), breaks.end());
  knots.insert(knots.end(), kDegree, breaks.back());
  return KnotVector(kDegree, std::move(knots));
}

FitOptions<1> bending(double lambda) {
  FitOptions<1> options;
  options.energy = thinPlate<1>();
  options.scale = ParameterScale::unit;
  options.smoothing = Smoothing::fixed(lambda);
  return options;
}

// The curve of least squares whose control points lie in the domain: coordinates that leave it stay on its border, and
// the others follow.
Curve fitInside(const KnotVector& knots, const FitPoints<1>& points, FitOptions<1> options,
                const Eigen::AlignedBox2d& domain) {
  Curve curve = fitLeastSquares<1>({knots}, points, options).spline;
  Net net = curve.net();
  for (Index k = 0; k < 2 && !domain.isEmpty(); ++k) {
    const auto leaves = [&](Index i) { return net(i, k) < domain.min()[k] || net(i, k) > domain.max()[k]; };
    const Net values = points.values.col(k);
    FitOptions<1> own = options;
    own.heldNet = options.held.empty() ? Net::Zero(net.rows(), 1) : Net(options.heldNet.col(k));
    for (int round = 0;; ++round) {
      bool any = false;
      for (Index i = 0; i < net.rows(); ++i) {
        if (!leaves(i)) continue;
        any = true;
        net(i, k) = own.heldNet(i, 0) = std::clamp(net(i, k), domain.min()[k], domain.max()[k]);
        own.held.push_back(i);
      }
      if (!any || round == kHoldings) break;
      net.col(k) = fitLeastSquares<1>({knots}, {points.parameters, values, points.weights}, own).spline.net();
    }
  }
  curve.net() = net;
  return curve;
}

Curve lineBetween(const Vector2d& from, const Vector2d& to) {
  Net net(kDegree + 1, 2);
  for (Index i = 0; i <= kDegree; ++i) {
    net.row(i) = (from + (to - from) * (static_cast<double>(i) / kDegree)).transpose();
  }
  net.row(kDegree) = to.transpose();
  return Curve({KnotVector::uniformClamped(kDegree, 1)}, std::move(net));
}

// The middle one of three turns on these breaks.
Curve closed(const Curve& turns, const Breaks& breaks) {
  const auto spans = static_cast<Index>(breaks.size()) - 1;
  const auto knotAt = [&](Index i) {
    const Index turn = i < 0 ? -1 : i / spans;
    return breaks[static_cast<std::size_t>(i - turn * spans)] + static_cast<double>(turn);
  };
  // Functions spans .. 2 spans + 2 are those alive in the middle turn; the last three repeat the first three.
  std::vector<double> knots;
  for (Index i = -kDegree; i <= spans + kDegree; ++i) knots.push_back(knotAt(i));
  Net net = turns.net().middleRows(spans, spans + kDegree);
  for (Index i = 0; i < kDegree; ++i) {
    net.row(i) = (net.row(i) + net.row(spans + i)).eval() / 2;
    net.row(spans + i) = net.row(i);
  }
  return toClamped<1>(Curve({KnotVector(kDegree, std::move(knots))}, std::move(net)), 0);
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
  const auto fit = [&](const Breaks& breaks, const Eigen::VectorXd& weights, double lambda) {
    const KnotVector knots = clampedKnots(breaks);
    FitOptions<1> options = bending(lambda);
    options.held = {0, knots.size() - 1};
    options.heldNet = Net::Zero(knots.size(), 2);
    options.heldNet.row(0) = from.transpose();
    options.heldNet.row(knots.size() - 1) = to.transpose();
    return fitInside(knots, {parameters, between, weights}, options, domain);
  };
  return Tube(parameters, between, limits, fit).curve(1);
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
  Net allParameters(3 * count, 1), allPoints(3 * count, 2);
  for (Index turn = 0; turn < 3; ++turn) {
    allParameters.middleRows(turn * count, count) = parameters.array() + static_cast<double>(turn);
    allPoints.middleRows(turn * count, count) = points;
  }
  const auto fit = [&](const Breaks& breaks, const Eigen::VectorXd& weights, double lambda) {
    Breaks turns = breaks;
    for (int turn = 1; turn < 3; ++turn) {
      for (std::size_t i = 1; i < breaks.size(); ++i) turns.push_back(breaks[i] + turn);
    }
    const Eigen::VectorXd allWeights = weights.replicate(3, 1);
    Curve curve =
        closed(fitInside(clampedKnots(turns), {allParameters, allPoints, allWeights}, bending(lambda), domain), breaks);
    for (Index k = 0; k < 2 && !domain.isEmpty(); ++k) {  // which rounding may leave
      Eigen::Ref<Net> net = curve.net();
      net.col(k) = net.col(k).cwiseMax(domain.min()[k]).cwiseMin(domain.max()[k]);
    }
    return curve;
  };
  return Tube(parameters, points, limits, fit).curve(kDegree + 1);
}

}  // namespace strak
