#include "strak/fairing/farin_sapidis.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "strak/base/cpu_time.h"
#include "strak/base/error.h"
#include "strak/spline/basis.h"

namespace strak {

namespace {

void check(const Curve& curve, const CubicFairingOptions& options) {
  const auto inner = curve.knots(0).innerKnots();
  const bool simple = std::all_of(inner.begin(), inner.end(), [](const auto& knot) { return knot.multiplicity == 1; });
  const bool space = curve.pointDimension() == 2 || curve.pointDimension() == 3;
  if (curve.isRational() || curve.degree(0) != 3 || !simple || !space) {
    throw InvalidInput(
        "this method is for cubic polynomial curves of the plane or of space with simple inner knots: fair by the "
        "exact energy, or rebuild the curve first");
  }
  if (!(options.tolerance >= 0)) throw InvalidInput("the tolerance must not be negative");
  if (!options.held.empty() && static_cast<Index>(options.held.size()) != curve.net().rows()) {
    throw InvalidInput("the list of held points must have one entry a control point or be empty");
  }
}

// The net while it is worked on, around its first point.
struct Work {
  const KnotVector& knots;
  const CubicFairingOptions& options;
  Net start, net;

  Work(const Curve& curve, const CubicFairingOptions& o)
      : knots(curve.knots(0)), options(o), start(curve.net().rowwise() - curve.net().row(0)), net(start) {}

  bool free(Index i) const { return options.held.empty() || options.held[static_cast<std::size_t>(i)] == 0; }

  Point inBall(Index i, const Point& target) const {
    const Point away = target - start.row(i);
    const double distance = away.norm();
    return distance <= options.tolerance ? target : Point(start.row(i) + options.tolerance / distance * away);
  }
};

// Greedy descent: the places with the largest value first; `attempt` changes the net at a place and says which control
// points; a step stays if the sum of all values falls.
template <class Value, class Attempt>
Faired<1> descend(const Curve& curve, Work& work, Index places, Index reach, const Value& value,
                  const Attempt& attempt) {
  const double begun = threadSeconds();
  constexpr double kLeast = 1e-9;  // of the sum at the start
  std::vector<double> values(static_cast<std::size_t>(places));
  for (Index k = 0; k < places; ++k) values[static_cast<std::size_t>(k)] = value(k);
  double sum = std::accumulate(values.begin(), values.end(), 0.0);
  Faired<1> result{curve, {}};
  FairingSummary& summary = result.summary;
  summary.energyBefore = sum;
  summary.gap = std::numeric_limits<double>::infinity();
  for (Index i = 0; i < work.net.rows(); ++i) summary.freePoints += work.free(i) ? 1 : 0;
  summary.stopReason =
      summary.freePoints == 0 || work.options.tolerance == 0 ? StopReason::nothingFree : StopReason::steps;
  std::vector<bool> asleep(values.size(), false);  // a step there did not help since its surroundings last changed
  while (summary.stopReason == StopReason::steps && summary.steps < work.options.maxSteps) {
    Index place = -1;
    for (Index k = 0; k < places; ++k) {
      const auto i = static_cast<std::size_t>(k);
      if (!asleep[i] && (place < 0 || values[i] > values[static_cast<std::size_t>(place)])) place = k;
    }
    if (place < 0) {
      summary.stopReason = StopReason::gain;
      break;
    }
    asleep[static_cast<std::size_t>(place)] = true;
    const Index first = std::max<Index>(0, place - reach), last = std::min(places - 1, place + reach);
    const Net before = work.net;
    if (!attempt(place)) continue;
    double change = 0;
    std::vector<double> fresh;
    for (Index k = first; k <= last; ++k) {
      fresh.push_back(value(k));
      change += fresh.back() - values[static_cast<std::size_t>(k)];
    }
    if (!(change < -kLeast * summary.energyBefore)) {
      work.net = before;
      continue;
    }
    for (Index k = first; k <= last; ++k) {
      values[static_cast<std::size_t>(k)] = fresh[static_cast<std::size_t>(k - first)];
      if (k != place) asleep[static_cast<std::size_t>(k)] = false;
    }
    ++summary.steps;
    if (summary.steps % 64 == 0 && !work.options.progress.report(-1, "moving points one by one")) {
      summary.stopReason = StopReason::cancelled;
    }
  }
  summary.energyAfter = std::accumulate(values.begin(), values.end(), 0.0);
  for (Index i = 0; i < work.net.rows(); ++i) {
    const Point move = work.net.row(i) - work.start.row(i);
    if (move.isZero(0)) continue;
    result.spline.net().row(i) += move;
    summary.largestMove = std::max(summary.largestMove, move.norm());
    if (move.norm() >= (1 - 1e-9) * work.options.tolerance) ++summary.activePoints;
  }
  summary.seconds = threadSeconds() - begun;
  return result;
}

}  // namespace

Faired<1> fairByKnotRemoval(const Curve& curve, const CubicFairingOptions& options) {
  check(curve, options);
  Work work(curve, options);
  const KnotVector& u = work.knots;
  const auto spans = u.spans();
  const auto count = static_cast<Index>(spans.size()) - 1;  // inner knots
  // Basis derivatives at the inner knots: X' and X''' of both sides.
  struct AtKnot {
    Index knot;
    Eigen::RowVectorXd tangent, left, right;
  };
  std::vector<AtKnot> places;
  for (Index k = 0; k < count; ++k) {
    const Index before = spans[static_cast<std::size_t>(k)], after = spans[static_cast<std::size_t>(k) + 1];
    const auto l = basisDerivatives(u, before, u[after], 3), r = basisDerivatives(u, after, u[after], 3);
    places.push_back({after, r.row(1), l.row(3), r.row(3)});
  }
  // |jump of dk/ds| = |X' x [X''']| / |X'|^4, because X'' is continuous.
  const auto value = [&](Index k) {
    const AtKnot& at = places[static_cast<std::size_t>(k)];
    Eigen::Vector3d tangent = Eigen::Vector3d::Zero(), jump = Eigen::Vector3d::Zero();
    const Index columns = work.net.cols();
    tangent.head(columns) = (at.tangent * work.net.middleRows(at.knot - 3, 4)).transpose();
    jump.head(columns) =
        (at.right * work.net.middleRows(at.knot - 3, 4) - at.left * work.net.middleRows(at.knot - 4, 4)).transpose();
    const double vv = tangent.squaredNorm();
    return vv > 0 ? tangent.cross(jump).norm() / (vv * vv) : 0;
  };
  const auto attempt = [&](Index k) {
    const Index m = places[static_cast<std::size_t>(k)].knot, r = m - 2;
    if (!work.free(r)) return false;
    // Reinsertion gives d_i = (1 - a_i) e_(i-1) + a_i e_i; from the neighbours on both sides follow e_(m-3), e_(m-2).
    const auto a = [&](Index low, Index high) { return (u[m] - u[low]) / (u[high] - u[low]); };
    const double left = a(m - 3, m + 1), middle = a(m - 2, m + 2), right = a(m - 1, m + 3);
    const Point low = (work.net.row(m - 3) - (1 - left) * work.net.row(m - 4)) / left;
    const Point high = (work.net.row(m - 1) - right * work.net.row(m)) / (1 - right);
    work.net.row(r) = work.inBall(r, (1 - middle) * low + middle * high);
    return true;
  };
  return descend(curve, work, count, 3, value, attempt);
}

Faired<1> fairByDegreeReduction(const Curve& curve, const CubicFairingOptions& options) {
  check(curve, options);
  Work work(curve, options);
  const KnotVector& u = work.knots;
  const auto spans = u.spans();
  std::vector<Eigen::RowVectorXd> third;  // third difference of the Bezier points: h^3 X''' / 6
  for (const Index s : spans) {
    const double h = u[s + 1] - u[s];
    third.emplace_back(basisDerivatives(u, s, u[s], 3).row(3) * (h * h * h / 6));
  }
  const auto difference = [&](Index k) {
    const Index s = spans[static_cast<std::size_t>(k)];
    return Point(third[static_cast<std::size_t>(k)] * work.net.middleRows(s - 3, 4));
  };
  const auto value = [&](Index k) { return difference(k).squaredNorm(); };
  const auto attempt = [&](Index k) {
    const Index s = spans[static_cast<std::size_t>(k)], low = s - 2, high = s - 1;
    if (!work.free(low) && !work.free(high)) return false;
    // The leg d_low d_high carries b1 and b2 at these parts of its length.
    const double whole = u[s + 2] - u[s - 1];
    const double one = (u[s] - u[s - 1]) / whole, two = (u[s + 1] - u[s - 1]) / whole;
    // The parabola with the same ends: b1 moves by a sixth of the third difference, b2 the other way.
    const Point shift = difference(k) / 6;
    const Point b1 = (1 - one) * work.net.row(low) + one * work.net.row(high) - shift;
    const Point b2 = (1 - two) * work.net.row(low) + two * work.net.row(high) + shift;
    const Point leg = (b2 - b1) / (two - one), begin = b1 - one * leg;
    if (work.free(low)) work.net.row(low) = work.inBall(low, begin);
    if (work.free(high)) work.net.row(high) = work.inBall(high, begin + leg);
    return true;
  };
  return descend(curve, work, static_cast<Index>(spans.size()), 4, value, attempt);
}

}  // namespace strak
