#include "strak/fairing/plan_curve.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "strak/base/error.h"
#include "strak/spline/basis.h"
#include "strak/spline/knot_insertion.h"
#include "strak/spline/knot_removal.h"

namespace strak {

namespace {

// Rows k = 0 .. order: derivative k of all basis functions at the end minus at the start of the domain.
Eigen::MatrixXd seamConditions(const KnotVector& knots, int order) {
  const int p = knots.degree();
  Eigen::MatrixXd conditions = Eigen::MatrixXd::Zero(order + 1, knots.size());
  const auto spans = knots.spans();
  conditions.middleCols(spans.back() - p, p + 1) += basisDerivatives(knots, spans.back(), knots.to(), order);
  conditions.middleCols(spans.front() - p, p + 1) -= basisDerivatives(knots, spans.front(), knots.from(), order);
  return conditions;
}

bool hasCrease(const Curve& curve) {
  const auto inner = curve.knots(0).innerKnots();
  return std::any_of(inner.begin(), inner.end(),
                     [&](const auto& knot) { return knot.multiplicity >= curve.degree(0); });
}

struct JoinedCurve {
  Curve curve;
  std::vector<double> breaks, inputBreaks;  // ends and smooth joins; empty if there are none
};

// At knots of multiplicity p the parameters of the pieces are free: those of the pieces behind a smooth join are
// stretched until the speeds agree; then one knot less represents the same curve.
JoinedCurve joinSmoothly(const Curve& curve) {
  constexpr double kSmooth = 2e-4;  // radians
  const KnotVector& knots = curve.knots(0);
  const int p = knots.degree();
  if (curve.isRational() || p < 2) return {curve, {}, {}};
  JoinedCurve result{curve, {knots.from()}, {knots.from()}};
  std::vector<double> mapped = knots.knots();
  double stretch = 1;
  std::size_t done = 0;  // knots before are mapped
  double inputStart = knots.from(), start = knots.from();
  const auto mapUpTo = [&](double end) {
    for (; done < mapped.size() && mapped[done] <= end; ++done) {
      mapped[done] = done < static_cast<std::size_t>(p) ? mapped[done] : start + stretch * (mapped[done] - inputStart);
    }
  };
  for (const auto& knot : knots.innerKnots()) {
    if (knot.multiplicity != p) continue;
    const auto& all = knots.knots();
    const Index first = std::lower_bound(all.begin(), all.end(), knot.value) - all.begin();
    const Index corner = first - 1;
    const double before = knot.value - knots[first - 1], after = knots[first + p] - knot.value;
    const Point in = (curve.net().row(corner) - curve.net().row(corner - 1)) / before;
    const Point out = (curve.net().row(corner + 1) - curve.net().row(corner)) / after;
    const double slow = in.norm(), fast = out.norm();
    if (!(slow > 0) || !(fast > 0) || (in / slow - out / fast).norm() > kSmooth) continue;
    mapUpTo(knot.value);
    start += stretch * (knot.value - inputStart);
    inputStart = knot.value;
    for (std::size_t i = done; i-- > 0 && knots.knots()[i] == knot.value;) mapped[i] = start;
    stretch *= fast / slow;
    result.breaks.push_back(start);
    result.inputBreaks.push_back(knot.value);
  }
  if (result.breaks.size() == 1) return {curve, {}, {}};
  const std::vector<double> joins(result.breaks.begin() + 1, result.breaks.end());
  mapUpTo(std::numeric_limits<double>::infinity());
  // Unclamped ends keep their outer knots in order; the end itself is where the last piece ends.
  result.breaks.push_back(mapped[static_cast<std::size_t>(knots.size())]);
  result.inputBreaks.push_back(knots.to());
  const Curve stretched({KnotVector(p, mapped)}, curve.net());
  result.curve = removeKnots(stretched, 0, joins).spline;
  return result;
}

}  // namespace

int seamContinuity(const Curve& curve) {
  constexpr double kAgree = 1e-8;
  const KnotVector& knots = curve.knots(0);
  const int p = knots.degree();
  const auto spans = knots.spans();
  // Around the first point, or a curve far from the origin would seem closed.
  Net net = curve.net();
  const Index columns = curve.pointDimension();
  const Net euclidean = curve.euclideanNet();
  const Point origin = euclidean.row(0);
  for (Index i = 0; i < net.rows(); ++i) {
    net.row(i).head(columns) -= origin * (curve.isRational() ? net(i, columns) : 1.0);
  }
  const Net end = basisDerivatives(knots, spans.back(), knots.to(), p) * net.middleRows(spans.back() - p, p + 1);
  const Net start = basisDerivatives(knots, spans.front(), knots.from(), p) * net.middleRows(spans.front() - p, p + 1);
  const double size = (euclidean.colwise().maxCoeff() - euclidean.colwise().minCoeff()).norm();
  double unit = size;
  int continuity = -1;
  for (int k = 0; k < p; ++k, unit /= knots.length()) {
    const double scale = std::max({unit, start.row(k).norm(), end.row(k).norm()});
    if (!((end.row(k) - start.row(k)).norm() <= kAgree * scale)) break;
    continuity = k;
  }
  return continuity;
}

CurvePlan planCurve(const Curve& curve, const std::array<Index, 2>& rows, bool refine) {
  const JoinedCurve joined = joinSmoothly(curve);
  const int continuity = seamContinuity(joined.curve);
  const bool smooth = continuity >= std::min(2, curve.degree(0) - 1) && continuity >= 1 && !hasCrease(joined.curve);
  FairingPlanOptions<1> options;
  options.rows = rows;
  options.energyOrder = 2;
  options.refine = refine && !smooth;
  auto plan = planFairing(joined.curve, options);
  CurvePlan result{std::move(plan.spline), std::move(plan.held),      -1,    plan.freePoints, plan.knotsInserted,
                   std::move(plan.notes),  std::move(plan.leftAlone), curve, joined.breaks,   joined.inputBreaks};
  if (smooth) {
    result.seamContinuity = continuity;
    result.held.clear();
    result.leftAlone.clear();
    result.notes = {"closed: the seam moves with the curve and stays as smooth as it was"};
    result.freePoints = unknownsOf(result.spline, {}, continuity).unknowns;
    if (result.freePoints == 0) result.leftAlone = "its seam leaves no control point free";
  }
  return result;
}

Curve CurvePlan::onInput(const Curve& faired) const {
  if (breaks.empty()) return faired;
  // Knots back to the input's parameters, and where pieces join their full multiplicity again.
  const auto back = [&](double u) {
    const auto place = std::lower_bound(breaks.begin(), breaks.end(), u);
    if (place == breaks.end()) return inputBreaks.back();
    const auto i = static_cast<std::size_t>(place - breaks.begin());
    if (*place == u || i == 0) return inputBreaks[i];
    const double part = (u - breaks[i - 1]) / (breaks[i] - breaks[i - 1]);
    const double value = std::lerp(inputBreaks[i - 1], inputBreaks[i], part);
    // A knot of the input comes back to the bit.
    constexpr double kSame = 1e-10;
    const auto& own = input.knots(0).knots();
    const auto near = std::min_element(own.begin(), own.end(),
                                       [&](double a, double b) { return std::abs(a - value) < std::abs(b - value); });
    return std::abs(*near - value) <= kSame * input.knots(0).length() ? *near : value;
  };
  const int p = faired.degree(0);
  std::vector<double> more, inserted;
  for (std::size_t i = 1; i + 1 < breaks.size(); ++i) {
    more.insert(more.end(), static_cast<std::size_t>(std::max(0, p - faired.knots(0).multiplicity(breaks[i]))),
                breaks[i]);
  }
  const KnotVector full = withKnots(faired.knots(0), more);
  for (const auto& knot : full.innerKnots()) {
    const double value = back(knot.value);
    const int missing = knot.multiplicity - input.knots(0).multiplicity(value);
    inserted.insert(inserted.end(), static_cast<std::size_t>(std::max(0, missing)), value);
  }
  Curve result = insertKnots(input, 0, inserted);
  const Net moved = refinementMatrix(faired.knots(0), full) * Net(faired.net() - spline.net());
  for (Index i = 0; i < moved.rows(); ++i) {
    if (!moved.row(i).isZero(0)) result.net().row(i) += moved.row(i);
  }
  return result;
}

PointMap unknownsOf(const Curve& curve, const HeldPoints& held, int continuity) {
  const KnotVector& knots = curve.knots(0);
  const Index n = knots.size();
  if (!held.empty() && static_cast<Index>(held.size()) != n) {
    throw InvalidInput("the list of held points must have one entry a control point or be empty");
  }
  const auto isHeld = [&](Index i) { return !held.empty() && held[static_cast<std::size_t>(i)] != 0; };
  PointMap map;
  map.rows.resize(static_cast<std::size_t>(n));

  // dependent points: -inverse(conditions of them) * conditions of the others
  std::vector<Index> dependents, others;
  Eigen::MatrixXd follow;
  if (continuity >= 0) {
    const Eigen::MatrixXd conditions = seamConditions(knots, continuity);
    const Index last = std::min<Index>(knots.degree() + 1, n);
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(conditions.rightCols(last));
    for (int k = 0; k <= continuity; ++k) dependents.push_back(n - last + qr.colsPermutation().indices()[k]);
    for (Index i = 0; i < n; ++i) {
      const bool isDependent = std::find(dependents.begin(), dependents.end(), i) != dependents.end();
      if (!isDependent && conditions.col(i).cwiseAbs().maxCoeff() > 0) others.push_back(i);
    }
    const auto columns = [&](const std::vector<Index>& list) {
      Eigen::MatrixXd part(conditions.rows(), static_cast<Index>(list.size()));
      for (std::size_t k = 0; k < list.size(); ++k) part.col(static_cast<Index>(k)) = conditions.col(list[k]);
      return part;
    };
    follow = -columns(dependents).colPivHouseholderQr().solve(columns(others));
    const bool anyHeld =
        std::any_of(dependents.begin(), dependents.end(), isHeld) || std::any_of(others.begin(), others.end(), isHeld);
    if (anyHeld) {  // the whole seam stays
      PointMap whole;
      HeldPoints more = held;
      for (const Index i : dependents) more[static_cast<std::size_t>(i)] = 1;
      for (const Index i : others) more[static_cast<std::size_t>(i)] = 1;
      return unknownsOf(curve, more, -1);
    }
  }
  std::vector<Index> number(static_cast<std::size_t>(n), -1);
  for (Index i = 0; i < n; ++i) {
    const bool isDependent = std::find(dependents.begin(), dependents.end(), i) != dependents.end();
    if (isHeld(i) || isDependent) continue;
    number[static_cast<std::size_t>(i)] = map.unknowns;
    map.rows[static_cast<std::size_t>(i)] = {{map.unknowns++, 1.0}};
  }
  // The conditions hold for homogeneous displacements, weight times displacement.
  const auto weight = [&](Index i) { return curve.isRational() ? curve.net()(i, curve.net().cols() - 1) : 1.0; };
  for (std::size_t d = 0; d < dependents.size(); ++d) {
    for (std::size_t o = 0; o < others.size(); ++o) {
      const double factor =
          follow(static_cast<Index>(d), static_cast<Index>(o)) * weight(others[o]) / weight(dependents[d]);
      if (std::abs(factor) > 1e-14) {
        map.rows[static_cast<std::size_t>(dependents[d])].push_back(
            {number[static_cast<std::size_t>(others[o])], factor});
      }
    }
  }
  return map;
}

}  // namespace strak
