#include "strak/fairing/joints.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "strak/base/error.h"
#include "strak/metrology/continuity.h"
#include "strak/metrology/curvature.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/knot_insertion.h"
#include "strak/spline/reparametrize.h"

namespace strak {
namespace {

constexpr double kSameKnot = 1e-9;     // of the domain
constexpr double kSameWeight = 1e-12;  // of the weight
constexpr double kGapLimit = 1e-6;     // of the surfaces' size
constexpr double kFlat = 1e-3;         // radians over the length of a joint: bends below this are no curvature
constexpr double kDegrees = 180 / std::numbers::pi;

void requireSide(int side) {
  if (side < 0 || side > 3) {
    throw InvalidInput(fmt::format("a surface has no side {}: give 0 (u low), 1 (u high), 2 (v low) or 3", side));
  }
}

void requirePair(const SidePair& pair, std::size_t surfaces) {
  for (const Index s : {pair.a, pair.b}) {
    if (s < 0 || s >= static_cast<Index>(surfaces)) {
      throw InvalidInput(fmt::format("there is no surface {}: there are {}", s, surfaces));
    }
  }
  requireSide(pair.sideA);
  requireSide(pair.sideB);
}

double sizeOf(const Surface& surface) {
  const Net points = surface.euclideanNet();
  return (points.colwise().maxCoeff() - points.colwise().minCoeff()).stableNorm();
}

// A stretch of the parameter along a border, and which way it runs.
struct Stretch {
  double from, to;
};

Stretch whole(const KnotVector& knots) { return {knots.from(), knots.to()}; }
Stretch partOf(const KnotVector& knots, const std::optional<SidePart>& part) {
  if (!part) return whole(knots);
  // Ends that miss those of the side by rounding are on them.
  const auto near = [&](double at) {
    if (std::abs(at - knots.from()) <= kSameKnot * knots.length()) return knots.from();
    return std::abs(at - knots.to()) <= kSameKnot * knots.length() ? knots.to() : at;
  };
  const double from = near(part->front()), to = near(part->back());
  if (!(knots.from() <= from && from < to && to <= knots.to())) {
    throw InvalidInput(fmt::format("[{}, {}] is no part of a side over [{}, {}]", from, to, knots.from(), knots.to()));
  }
  return {from, to};
}

// Where `u` of one stretch lies on the other, mapped affinely.
double mapped(double u, const Stretch& from, const Stretch& to, bool reversed) {
  const double t = (u - from.from) / (from.to - from.from);
  return reversed ? to.to - t * (to.to - to.from) : to.from + t * (to.to - to.from);
}

// Knots that `other` has inside `theirs`, mapped to `ours`, that own has not, each as often as it is missing. Nearly
// equal ones are the same.
std::vector<double> missingFrom(const KnotVector& own, const Stretch& ours, const KnotVector& other,
                                const Stretch& theirs, bool reversed) {
  std::vector<double> result;
  const auto had = own.innerKnots();
  const double slack = kSameKnot * (ours.to - ours.from), slackThere = kSameKnot * (theirs.to - theirs.from);
  for (const auto& knot : other.innerKnots()) {
    if (knot.value <= theirs.from + slackThere || knot.value >= theirs.to - slackThere) continue;
    const double at = mapped(knot.value, theirs, ours, reversed);
    const auto same =
        std::find_if(had.begin(), had.end(), [&](const auto& k) { return std::abs(k.value - at) <= slack; });
    const int count = knot.multiplicity - (same == had.end() ? 0 : same->multiplicity);
    const double value = same == had.end() ? at : same->value;
    result.insert(result.end(), static_cast<std::size_t>(std::max(0, count)), value);
  }
  return result;
}

// Knots of side A inside the part, and of side B, that the other has not.
std::vector<double> missingOnB(const Surface& a, int sideA, const Surface& b, int sideB, bool reversed,
                               const std::optional<SidePart>& part) {
  const KnotVector &own = knotsAlong(b, sideB), &other = knotsAlong(a, sideA);
  return missingFrom(own, whole(own), other, partOf(other, part), reversed);
}
std::vector<double> missingOnA(const Surface& a, int sideA, const Surface& b, int sideB, bool reversed,
                               const std::optional<SidePart>& part) {
  const KnotVector &own = knotsAlong(a, sideA), &other = knotsAlong(b, sideB);
  return missingFrom(own, partOf(own, part), other, whole(other), reversed);
}

// The border as a curve, its control points those of the net.
Curve borderCurve(const Surface& surface, int side) {
  const auto rows = borderRow(surface, side);
  Net net(static_cast<Index>(rows.size()), surface.net().cols());
  for (std::size_t k = 0; k < rows.size(); ++k) net.row(static_cast<Index>(k)) = surface.net().row(rows[k]);
  return Curve({knotsAlong(surface, side)}, std::move(net), surface.isRational());
}

// Row k: control point k on `target`, in terms of those on `knots`, of the part that the target covers. The knots of
// the part must be among the target's.
Eigen::MatrixXd restriction(const KnotVector& knots, const Stretch& part, const KnotVector& target, bool backwards) {
  // A curve whose control points are the unit vectors shows where each of them goes.
  Curve unit({knots}, Net::Identity(knots.size(), knots.size()));
  if (part.from > knots.from() || part.to < knots.to()) unit = subPatch(unit, 0, part.from, part.to);
  if (backwards) unit = reversed(unit, 0);
  unit = withDomain(unit, 0, target.from(), target.to());
  // Nearly equal knots become equal.
  std::vector<double> values = unit.knots(0).knots();
  const double slack = kSameKnot * target.length();
  for (double& value : values) {
    const auto& others = target.knots();
    const auto next = std::lower_bound(others.begin(), others.end(), value - slack);
    if (next != others.end() && std::abs(*next - value) <= slack) value = *next;
  }
  unit = Curve({KnotVector(knots.degree(), std::move(values))}, unit.net());
  return refine(unit, {target}).net();
}

// The direction in which two borders run together: their ends tell, of closed ones the insides.
bool runsBackwards(const Surface& a, int sideA, const Surface& b, int sideB, const std::optional<SidePart>& part) {
  const Curve one = borderCurve(a, sideA), other = borderCurve(b, sideB);
  const Stretch mine = partOf(one.knots(0), part), theirs = whole(other.knots(0));
  double along = 0, against = 0;
  for (const double t : {0.0, 0.3, 1.0}) {
    const Point p = evaluate<1>(one, {std::lerp(mine.from, mine.to, t)});
    along += (p - evaluate<1>(other, {std::lerp(theirs.from, theirs.to, t)})).norm();
    against += (p - evaluate<1>(other, {std::lerp(theirs.to, theirs.from, t)})).norm();
  }
  return against < along;
}

ParameterCurve edgeOf(const Surface& surface, int side, const std::optional<SidePart>& part = {}) {
  if (!part) return domainEdge(surface, side / 2, side % 2 == 1);
  const ParameterCurve all = domainEdge(surface, side / 2, side % 2 == 1);
  const KnotVector& knots = knotsAlong(surface, side);
  const double from = (part->front() - knots.from()) / knots.length();
  const double to = (part->back() - knots.from()) / knots.length();
  return [all, from, to](double t) { return all(std::lerp(from, to, t)); };
}

// Whether the surface lies to the left of its side, taken with the rising parameter.
bool leftOf(int side) { return side == 1 || side == 2; }

}  // namespace

std::vector<Index> borderRow(const Surface& surface, int side, Index depth) {
  requireSide(side);
  const int k = side / 2;
  if (depth < 0 || depth >= surface.size(k)) {
    throw InvalidInput(fmt::format("side {} has no row {}: the net has {} of them", side, depth, surface.size(k)));
  }
  const Index across = side % 2 == 0 ? depth : surface.size(k) - 1 - depth;
  std::vector<Index> rows(static_cast<std::size_t>(surface.size(1 - k)));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto along = static_cast<Index>(i);
    rows[i] = k == 0 ? surface.row({across, along}) : surface.row({along, across});
  }
  return rows;
}

const KnotVector& knotsAlong(const Surface& surface, int side) {
  requireSide(side);
  return surface.knots(1 - side / 2);
}

BorderFit fitBorders(const Surface& a, int sideA, const Surface& b, int sideB, double gapLimit,
                     const std::optional<SidePart>& part) {
  const KnotVector& knotsA = knotsAlong(a, sideA);
  const KnotVector& knotsB = knotsAlong(b, sideB);
  BorderFit fit;
  if (a.pointDimension() != b.pointDimension()) {
    fit.obstacle = "the surfaces have points of different dimensions";
    return fit;
  }
  fit.reversed = runsBackwards(a, sideA, b, sideB, part);
  if (!a.knots(sideA / 2).isClamped() || !b.knots(sideB / 2).isClamped() || !knotsA.isClamped() ||
      !knotsB.isClamped()) {
    fit.obstacle = "the knots at the border are not clamped";
    return fit;
  }
  if (knotsA.degree() != knotsB.degree()) {
    fit.obstacle = fmt::format("the degrees along the border differ ({} and {})", knotsA.degree(), knotsB.degree());
    return fit;
  }
  const bool missing = !missingOnB(a, sideA, b, sideB, fit.reversed, part).empty() ||
                       (!part && !missingOnA(a, sideA, b, sideB, fit.reversed, part).empty());
  if (missing) {
    fit.differentKnots = true;
    fit.obstacle = "the knots along the border differ";
    return fit;
  }
  const auto n = knotsA.size();
  if (part) {
    fit.fromA = restriction(knotsA, partOf(knotsA, part), knotsB, fit.reversed);
  } else {
    fit.fromA = Eigen::MatrixXd::Zero(n, n);
    for (Index k = 0; k < n; ++k) {
      fit.partner.push_back(fit.reversed ? n - 1 - k : k);
      fit.fromA(fit.partner.back(), k) = 1;
    }
  }
  const Net mine = borderCurve(a, sideA).net(), theirs = borderCurve(b, sideB).net();
  const Index dimension = a.pointDimension();
  const auto weights = [&](const Surface& s, const Net& net) -> Eigen::VectorXd {
    return s.isRational() ? Eigen::VectorXd(net.col(dimension)) : Eigen::VectorXd::Ones(net.rows());
  };
  Net homogeneous(n, dimension + 1);
  homogeneous << mine.leftCols(dimension), weights(a, mine);
  const Net expected = fit.fromA * homogeneous;
  const Eigen::VectorXd had = weights(b, theirs);
  const Net apart = (expected.leftCols(dimension).array().colwise() / expected.col(dimension).array() -
                     theirs.leftCols(dimension).array().colwise() / had.array())
                        .matrix();
  fit.gap = apart.rowwise().norm().maxCoeff();
  if ((expected.col(dimension) - had).cwiseAbs().maxCoeff() > kSameWeight * had.maxCoeff()) {
    fit.obstacle = "the weights along the border differ";
  } else if (fit.gap > gapLimit) {
    fit.obstacle = fmt::format("the control points along the border are up to {:.3g} apart", fit.gap);
  } else {
    fit.compatible = true;
    return fit;
  }
  fit.partner.clear();
  fit.fromA.resize(0, 0);
  return fit;
}

std::vector<Surface> makeCompatible(const std::vector<Surface>& surfaces, const std::vector<SidePair>& pairs,
                                    Index maxPoints) {
  std::vector<Surface> result = surfaces;
  for (const SidePair& pair : pairs) requirePair(pair, surfaces.size());
  const auto add = [&](Index to, int side, const std::vector<double>& missing) {
    if (missing.empty()) return false;
    Surface& surface = result[static_cast<std::size_t>(to)];
    const int direction = 1 - side / 2;
    const Index points = (surface.size(direction) + static_cast<Index>(missing.size())) * surface.size(1 - direction);
    if (points > maxPoints) {
      throw Failure(
          fmt::format("common knots would give surface {} {} control points, more than {}: raise the limit "
                      "or hold its borders",
                      to, points, maxPoints));
    }
    surface = insertKnots(surface, direction, missing);
    return true;
  };
  const auto at = [&](Index i) -> const Surface& { return result[static_cast<std::size_t>(i)]; };
  std::vector<bool> backwards;
  for (const SidePair& pair : pairs) {
    backwards.push_back(runsBackwards(at(pair.a), pair.sideA, at(pair.b), pair.sideB, pair.part));
  }
  // Every pass hands knots one face further. Round a closed ring of uneven T-junctions it might go on for ever; the
  // limit on the points ends that.
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      const auto& [a, b, sideA, sideB, part] = pairs[p];
      if (knotsAlong(at(a), sideA).degree() != knotsAlong(at(b), sideB).degree()) continue;
      changed = add(a, sideA, missingOnA(at(a), sideA, at(b), sideB, backwards[p], part)) || changed;
      changed = add(b, sideB, missingOnB(at(a), sideA, at(b), sideB, backwards[p], part)) || changed;
    }
  }
  return result;
}

const char* jointKindName(JointKind kind) {
  return std::array{"feature", "G0", "G1", "G2"}[static_cast<std::size_t>(kind)];
}

JointKind jointKind(double angleDegrees, double curvatureJump, double largestCurvature, double length,
                    const JointOptions& options) {
  if (angleDegrees > options.featureAngle) return JointKind::feature;
  if (angleDegrees > options.smoothAngle) return JointKind::g0;
  const bool even = curvatureJump <= options.curvatureShare * largestCurvature || curvatureJump * length <= kFlat;
  return even ? JointKind::g2 : JointKind::g1;
}

std::vector<Joint> measureJoints(const std::vector<Surface>& surfaces, const std::vector<SidePair>& pairs,
                                 const JointOptions& options) {
  for (const SidePair& pair : pairs) requirePair(pair, surfaces.size());
  for (const Surface& surface : surfaces) {
    if (surface.pointDimension() != 3) {
      throw InvalidInput("joints need surfaces in space: give control points with three coordinates");
    }
  }
  std::vector<Joint> joints(pairs.size());
  tbb::parallel_for(std::size_t{0}, pairs.size(), [&](std::size_t p) {
    const SidePair& pair = pairs[p];
    const Surface& a = surfaces[static_cast<std::size_t>(pair.a)];
    const Surface& b = surfaces[static_cast<std::size_t>(pair.b)];
    Joint& joint = joints[p];
    joint.a = pair.a;
    joint.b = pair.b;
    joint.sideA = pair.sideA;
    joint.sideB = pair.sideB;
    joint.part = pair.part;
    const double limit = options.gapLimit > 0 ? options.gapLimit : kGapLimit * std::max(sizeOf(a), sizeOf(b));
    joint.fit = fitBorders(a, pair.sideA, b, pair.sideB, limit, pair.part);
    // Along one direction of travel one surface lies to the left and the other to the right.
    joint.sameNormals = leftOf(pair.sideA) != (leftOf(pair.sideB) != joint.fit.reversed);
    const Continuity measured =
        edgeContinuity(a, edgeOf(a, pair.sideA, pair.part), b, edgeOf(b, pair.sideB),
                       {options.samples, joint.sameNormals ? NormalSides::same : NormalSides::opposite});
    joint.gapMax = measured.gap.max;
    joint.angleMax = measured.angle.max * kDegrees;
    joint.curvatureJumpMax = measured.curvature.max;
    joint.kind = jointKind(joint.angleMax, joint.curvatureJumpMax, measured.largestCurvature, measured.length, options);
  });
  return joints;
}

std::vector<std::array<bool, 4>> freeSides(std::size_t surfaces, const std::vector<SidePair>& pairs) {
  std::vector<std::array<bool, 4>> result(surfaces, {true, true, true, true});
  for (const SidePair& pair : pairs) {
    requirePair(pair, surfaces);
    result[static_cast<std::size_t>(pair.a)][static_cast<std::size_t>(pair.sideA)] = false;
    result[static_cast<std::size_t>(pair.b)][static_cast<std::size_t>(pair.sideB)] = false;
  }
  return result;
}

std::optional<SymmetryPlane> symmetryPlane(const Surface& surface, int side, const SymmetryOptions& options) {
  if (surface.pointDimension() != 3) {
    throw InvalidInput("a plane of symmetry needs a surface in space: give control points with three coordinates");
  }
  if (!surface.knots(side / 2).isClamped()) return {};
  const std::vector<Index> rows = borderRow(surface, side);
  const Net net = surface.euclideanNet();
  Eigen::MatrixX3d points(static_cast<Index>(rows.size()), 3);
  for (std::size_t k = 0; k < rows.size(); ++k) points.row(static_cast<Index>(k)) = net.row(rows[k]);
  const Eigen::RowVector3d middle = points.colwise().mean();
  const double size = (points.rowwise() - middle).rowwise().norm().maxCoeff();
  if (!(size > 0)) return {};
  // The plane holds the border and the surface's normals: its own normal is where both have nothing.
  const ParameterCurve edge = edgeOf(surface, side);
  constexpr int kSamples = 33;
  std::vector<Eigen::Vector3d> normals;
  const Eigen::MatrixX3d spread = (points.rowwise() - middle) / size;
  Eigen::Matrix3d moment = spread.transpose() * spread / static_cast<double>(rows.size());
  for (int i = 0; i < kSamples; ++i) {
    const Eigen::Vector2d at = edge(static_cast<double>(i) / (kSamples - 1));
    const Net jet = derivatives<2>(surface, {at[0], at[1]}, 1);
    const auto normal = unitNormal(jet.row(1).transpose(), jet.row(2).transpose());
    if (!normal) continue;
    normals.push_back(*normal);
    moment += *normal * normal->transpose() / kSamples;
  }
  if (normals.empty()) return {};
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moment);
  SymmetryPlane plane{middle.transpose(), options.normal ? *options.normal : solver.eigenvectors().col(0)};
  Index largest = 0;
  plane.normal.cwiseAbs().maxCoeff(&largest);
  if (plane.normal[largest] < 0) plane.normal = -plane.normal;
  const double stray = ((points.rowwise() - middle) * plane.normal).cwiseAbs().maxCoeff();
  if (stray > options.planarity * size) return {};
  const double limit = std::sin(options.angle / kDegrees);
  for (const auto& normal : normals) {
    if (std::abs(normal.dot(plane.normal)) > limit) return {};
  }
  return plane;
}

}  // namespace strak
