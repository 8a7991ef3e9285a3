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

// Where knot `u` of `from` lies on `to`, mapped affinely.
double mapped(double u, const KnotVector& from, const KnotVector& to, bool reversed) {
  const double t = (u - from.from()) / from.length();
  return reversed ? to.to() - t * to.length() : to.from() + t * to.length();
}

// Knots of `other`, mapped to `own`, that own has not, each as often as it is missing. Nearly equal ones are the same.
std::vector<double> missingFrom(const KnotVector& own, const KnotVector& other, bool reversed) {
  std::vector<double> result;
  const auto had = own.innerKnots();
  for (const auto& knot : other.innerKnots()) {
    const double at = mapped(knot.value, other, own, reversed);
    const auto same = std::find_if(had.begin(), had.end(),
                                   [&](const auto& k) { return std::abs(k.value - at) <= kSameKnot * own.length(); });
    const int count = knot.multiplicity - (same == had.end() ? 0 : same->multiplicity);
    const double value = same == had.end() ? at : same->value;
    result.insert(result.end(), static_cast<std::size_t>(std::max(0, count)), value);
  }
  return result;
}

// Distance of the borders' control points, either in space or of the curves where the knots differ.
double endDistance(const Surface& a, const std::vector<Index>& rowsA, const Surface& b, const std::vector<Index>& rowsB,
                   bool reversed) {
  const Net pointsA = a.euclideanNet(), pointsB = b.euclideanNet();
  const auto& first = reversed ? rowsB.back() : rowsB.front();
  const auto& last = reversed ? rowsB.front() : rowsB.back();
  return std::max((pointsA.row(rowsA.front()) - pointsB.row(first)).norm(),
                  (pointsA.row(rowsA.back()) - pointsB.row(last)).norm());
}

struct Distances {
  double gap = 0;
  bool sameWeights = true;
};

Distances distances(const Surface& a, const std::vector<Index>& rowsA, const Surface& b,
                    const std::vector<Index>& rowsB, bool reversed) {
  const auto weight = [](const Surface& s, Index row) { return s.isRational() ? s.net()(row, s.net().cols() - 1) : 1; };
  const Net pointsA = a.euclideanNet(), pointsB = b.euclideanNet();
  Distances result;
  for (std::size_t k = 0; k < rowsA.size(); ++k) {
    const Index i = rowsA[k], j = reversed ? rowsB[rowsB.size() - 1 - k] : rowsB[k];
    result.gap = std::max(result.gap, (pointsA.row(i) - pointsB.row(j)).norm());
    const double wa = weight(a, i), wb = weight(b, j);
    result.sameWeights = result.sameWeights && std::abs(wa - wb) <= kSameWeight * std::max(wa, wb);
  }
  return result;
}

// The direction in which two borders run together: their ends tell, of closed ones the control points.
bool runsBackwards(const Surface& a, int sideA, const Surface& b, int sideB) {
  const auto rowsA = borderRow(a, sideA), rowsB = borderRow(b, sideB);
  const double along = endDistance(a, rowsA, b, rowsB, false), against = endDistance(a, rowsA, b, rowsB, true);
  const double size = std::max(sizeOf(a), sizeOf(b));
  if (std::abs(along - against) > kGapLimit * size || rowsA.size() != rowsB.size()) return against < along;
  return distances(a, rowsA, b, rowsB, true).gap < distances(a, rowsA, b, rowsB, false).gap;
}

ParameterCurve edgeOf(const Surface& surface, int side) { return domainEdge(surface, side / 2, side % 2 == 1); }

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

BorderFit fitBorders(const Surface& a, int sideA, const Surface& b, int sideB, double gapLimit) {
  const KnotVector& knotsA = knotsAlong(a, sideA);
  const KnotVector& knotsB = knotsAlong(b, sideB);
  BorderFit fit;
  if (a.pointDimension() != b.pointDimension()) {
    fit.obstacle = "the surfaces have points of different dimensions";
    return fit;
  }
  fit.reversed = runsBackwards(a, sideA, b, sideB);
  const auto clampedAcross = [](const Surface& s, int side) { return s.knots(side / 2).isClamped(); };
  if (!clampedAcross(a, sideA) || !clampedAcross(b, sideB)) {
    fit.obstacle = "the knots across the border are not clamped";
    return fit;
  }
  if (knotsA.degree() != knotsB.degree()) {
    fit.obstacle = fmt::format("the degrees along the border differ ({} and {})", knotsA.degree(), knotsB.degree());
    return fit;
  }
  if (!missingFrom(knotsA, knotsB, fit.reversed).empty() || !missingFrom(knotsB, knotsA, fit.reversed).empty()) {
    fit.differentKnots = true;
    fit.obstacle = "the knots along the border differ";
    return fit;
  }
  const auto rowsA = borderRow(a, sideA), rowsB = borderRow(b, sideB);
  if (rowsA.size() != rowsB.size()) {
    fit.obstacle = "the numbers of control points along the border differ";
    return fit;
  }
  const Distances found = distances(a, rowsA, b, rowsB, fit.reversed);
  fit.gap = found.gap;
  if (!found.sameWeights) {
    fit.obstacle = "the weights along the border differ";
  } else if (fit.gap > gapLimit) {
    fit.obstacle = fmt::format("the control points along the border are up to {:.3g} apart", fit.gap);
  } else {
    fit.compatible = true;
    const auto n = static_cast<Index>(rowsA.size());
    for (Index k = 0; k < n; ++k) fit.partner.push_back(fit.reversed ? n - 1 - k : k);
  }
  return fit;
}

std::vector<Surface> makeCompatible(const std::vector<Surface>& surfaces, const std::vector<SidePair>& pairs,
                                    Index maxPoints) {
  std::vector<Surface> result = surfaces;
  for (const SidePair& pair : pairs) requirePair(pair, surfaces.size());
  const auto complete = [&](Index to, int side, Index from, int otherSide, bool reversed) {
    Surface& surface = result[static_cast<std::size_t>(to)];
    const auto missing =
        missingFrom(knotsAlong(surface, side), knotsAlong(result[static_cast<std::size_t>(from)], otherSide), reversed);
    if (missing.empty()) return false;
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
  // Every pass hands knots one face further; what is inserted is always a knot of the input, so it ends.
  std::vector<bool> backwards;
  for (const SidePair& pair : pairs) {
    backwards.push_back(runsBackwards(result[static_cast<std::size_t>(pair.a)], pair.sideA,
                                      result[static_cast<std::size_t>(pair.b)], pair.sideB));
  }
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      const SidePair& pair = pairs[p];
      const auto& a = result[static_cast<std::size_t>(pair.a)];
      const auto& b = result[static_cast<std::size_t>(pair.b)];
      if (knotsAlong(a, pair.sideA).degree() != knotsAlong(b, pair.sideB).degree()) continue;
      changed = complete(pair.a, pair.sideA, pair.b, pair.sideB, backwards[p]) || changed;
      changed = complete(pair.b, pair.sideB, pair.a, pair.sideA, backwards[p]) || changed;
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
    const double limit = options.gapLimit > 0 ? options.gapLimit : kGapLimit * std::max(sizeOf(a), sizeOf(b));
    joint.fit = fitBorders(a, pair.sideA, b, pair.sideB, limit);
    // Along one direction of travel one surface lies to the left and the other to the right.
    joint.sameNormals = leftOf(pair.sideA) != (leftOf(pair.sideB) != joint.fit.reversed);
    const Continuity measured =
        edgeContinuity(a, edgeOf(a, pair.sideA), b, edgeOf(b, pair.sideB),
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
  SymmetryPlane plane{middle.transpose(), solver.eigenvectors().col(0)};
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
