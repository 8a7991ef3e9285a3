#include "strak/fairing/plan_curve.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "strak/base/error.h"
#include "strak/spline/basis.h"

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
  const int continuity = seamContinuity(curve);
  const bool smooth = continuity >= std::min(2, curve.degree(0) - 1) && continuity >= 1 && !hasCrease(curve);
  FairingPlanOptions<1> options;
  options.rows = rows;
  options.energyOrder = 2;
  options.refine = refine && !smooth;
  auto plan = planFairing(curve, options);
  CurvePlan result{std::move(plan.spline), std::move(plan.held),  -1, plan.freePoints, plan.knotsInserted,
                   std::move(plan.notes),  std::move(plan.leftAlone)};
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
    const bool anyHeld = std::any_of(dependents.begin(), dependents.end(), isHeld) ||
                         std::any_of(others.begin(), others.end(), isHeld);
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
      const double factor = follow(static_cast<Index>(d), static_cast<Index>(o)) * weight(others[o]) / weight(dependents[d]);
      if (std::abs(factor) > 1e-14) {
        map.rows[static_cast<std::size_t>(dependents[d])].push_back({number[static_cast<std::size_t>(others[o])], factor});
      }
    }
  }
  return map;
}

}  // namespace strak
