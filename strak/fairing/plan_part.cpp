#include "strak/fairing/plan_part.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "strak/base/error.h"
#include "strak/fairing/part_points.h"
#include "strak/spline/periodic.h"

namespace strak {

namespace {

constexpr int kMostRounds = 12;                          // of inserting knots: each passes them on to a neighbour
constexpr Index kMostGrowth = 2, kAlwaysAllowed = 2048;  // of the points of all faces, by knots of neighbours
constexpr Index kMostLaterGrowth = 4;                    // the same, between two rounds
constexpr double kSameCorner = 1e-6;                     // of the part's size
constexpr double kPerpendicular = 1e-9;                  // of a face's size
constexpr double kSameEnd = 1e-6;                        // of a side: parts that leave less uncovered cover it

std::vector<Surface> surfacesOf(const std::vector<PartFace>& faces) {
  std::vector<Surface> surfaces;
  for (const PartFace& face : faces) surfaces.push_back(face.surface);
  return surfaces;
}

bool sameKnots(const std::vector<Surface>& a, const std::vector<Surface>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Surface& x, const Surface& y) { return x.knots() == y.knots(); });
}

Index pointsOf(const std::vector<Surface>& surfaces) {
  return std::accumulate(surfaces.begin(), surfaces.end(), Index{0},
                         [](Index sum, const Surface& surface) { return sum + surface.net().rows(); });
}

// How a side of a face is used: which parts of it are joined, and whether it moves in a plane.
struct SideUse {
  bool mirror = false;
  std::vector<SidePart> parts;
  bool moves() const { return mirror || !parts.empty(); }
};
using SideUses = std::array<SideUse, 4>;

SideUses usesOf(const Surface& surface, std::size_t number, const std::vector<SidePair>& pairs,
                const std::vector<MirrorSide>& mirrors) {
  SideUses uses;
  const auto whole = [&](int side) -> SidePart {
    return {knotsAlong(surface, side).from(), knotsAlong(surface, side).to()};
  };
  for (const SidePair& pair : pairs) {
    auto& a = uses[static_cast<std::size_t>(pair.sideA)];
    auto& b = uses[static_cast<std::size_t>(pair.sideB)];
    if (pair.a == static_cast<Index>(number)) a.parts.push_back(pair.part.value_or(whole(pair.sideA)));
    if (pair.b == static_cast<Index>(number)) b.parts.push_back(whole(pair.sideB));
  }
  for (const MirrorSide& mirror : mirrors) {
    if (mirror.face == static_cast<Index>(number)) uses[static_cast<std::size_t>(mirror.side)].mirror = true;
  }
  return uses;
}

// The stretches of a side that no part covers.
std::vector<SidePart> uncovered(const KnotVector& knots, std::vector<SidePart> parts) {
  std::sort(parts.begin(), parts.end());
  const double slack = kSameEnd * knots.length();
  std::vector<SidePart> result;
  double reached = knots.from();
  for (const auto& [from, to] : parts) {
    if (from > reached + slack) result.push_back({reached, from});
    reached = std::max(reached, to);
  }
  if (reached < knots.to() - slack) result.push_back({reached, knots.to()});
  return result;
}

FacePlan planOne(const PartFace& face, const Surface& surface, const SideUses& uses, PlanOptions options, bool refine) {
  for (std::size_t side = 0; side < 4; ++side) options.joined[side] = uses[side].moves();
  options.refine = options.refine && refine;
  return planFace(surface, face.border, options);
}

// Calls hold(row) for the points in `depth` rows behind what no part covers.
template <class Hold>
void holdUncovered(const Surface& surface, int side, const SideUse& use, Index depth, const Hold& hold) {
  if (use.mirror || use.parts.empty()) return;
  const KnotVector& knots = knotsAlong(surface, side);
  for (const auto& [from, to] : uncovered(knots, use.parts)) {
    for (Index row = 0; row < std::min(depth, surface.size(side / 2)); ++row) {
      const auto points = borderRow(surface, side, row);
      for (Index k = 0; k < knots.size(); ++k) {
        if (knots[k] < to && knots[k + knots.degree() + 1] > from) hold(points[static_cast<std::size_t>(k)]);
      }
    }
  }
}

std::optional<std::vector<Surface>> compatible(const std::vector<Surface>& surfaces, const std::vector<SidePair>& pairs,
                                               Index maxPoints) {
  try {
    auto result = makeCompatible(surfaces, pairs, maxPoints);
    if (pointsOf(result) <= maxPoints) return result;
  } catch (const Failure&) {
    // Round a ring of uneven T-junctions knots beget knots.
  }
  return {};
}

std::vector<MirrorSide> mirrorsOf(const std::vector<PartFace>& faces) {
  std::vector<MirrorSide> mirrors;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (int side = 0; side < 4; ++side) {
      const auto& plane = faces[f].mirror[static_cast<std::size_t>(side)];
      if (plane) mirrors.push_back({static_cast<Index>(f), side, *plane});
    }
  }
  return mirrors;
}

// Whether the first two rows of a side differ along the normal only.
bool isPerpendicular(const Surface& surface, int side, const Eigen::Vector3d& normal) {
  const Net points = surface.euclideanNet();
  const auto border = borderRow(surface, side), behind = borderRow(surface, side, 1);
  const double slack = kPerpendicular * (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm();
  for (std::size_t k = 0; k < border.size(); ++k) {
    const Eigen::Vector3d step = (points.row(behind[k]) - points.row(border[k])).transpose();
    if ((step - step.dot(normal) * normal).norm() > slack) return false;
  }
  return true;
}

// A closed face stays as smooth across its seam, in parameters, as it is.
void keepSeam(PartPlan& plan, const Joint& joint, PartPoints& points) {
  const int direction = joint.sideA / 2;
  if (joint.a != joint.b || joint.sideB / 2 != direction || joint.part || joint.fit.reversed) return;
  const auto face = static_cast<std::size_t>(joint.a);
  const int order = seamSmoothness(plan.surfaces[face], direction);
  if (order < 1) return;
  points.smoothSeam(joint.a, direction, order);
  plan.notes[face].push_back(fmt::format("Closed in direction {}: the seam is free and stays smooth of order {}.",
                                         directionName(direction), order));
}

double sizeOf(const std::vector<Surface>& surfaces) {
  Eigen::RowVector3d low = surfaces.front().euclideanNet().row(0), high = low;
  for (const Surface& surface : surfaces) {
    const Net points = surface.euclideanNet();
    low = low.cwiseMin(points.colwise().minCoeff());
    high = high.cwiseMax(points.colwise().maxCoeff());
  }
  return (high - low).norm();
}

}  // namespace

PartPlan planPart(const std::vector<PartFace>& faces, const std::vector<SidePair>& allPairs, const PlanOptions& options,
                  const JointOptions& jointOptions) {
  PartPlan plan;
  plan.surfaces = surfacesOf(faces);
  plan.notes.resize(faces.size());
  plan.leftAlone.resize(faces.size());
  if (faces.empty()) return plan;

  std::vector<bool> still(faces.size(), false);  // nothing of the face moves
  plan.mirrors = mirrorsOf(faces);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const SideUses uses = usesOf(faces[f].surface, f, allPairs, plan.mirrors);
    plan.leftAlone[f] = planOne(faces[f], faces[f].surface, uses, options, true).leftAlone;
    still[f] = !plan.leftAlone[f].empty();
  }
  std::erase_if(plan.mirrors, [&](const MirrorSide& m) { return bool{still[static_cast<std::size_t>(m.face)]}; });
  const auto usable = [&](const Joint& joint) {
    return joint.kind != JointKind::feature && (joint.fit.compatible || joint.fit.differentKnots) &&
           !still[static_cast<std::size_t>(joint.a)] && !still[static_cast<std::size_t>(joint.b)];
  };
  const std::vector<Joint> measured = measureJoints(plan.surfaces, allPairs, jointOptions);
  const auto pairsOf = [&](bool differentKnots) {
    std::vector<SidePair> chosen;
    for (const Joint& joint : measured) {
      if (usable(joint) && (joint.fit.compatible || differentKnots)) {
        chosen.push_back({joint.a, joint.b, joint.sideA, joint.sideB, joint.part});
      }
    }
    return chosen;
  };
  std::vector<SidePair> pairs = pairsOf(true);
  // Knots that differ along a long row of faces all meet in the end: too many, and those joins are left out.
  if (!compatible(plan.surfaces, pairs, kMostGrowth * pointsOf(plan.surfaces) + kAlwaysAllowed)) pairs = pairsOf(false);

  std::vector<HeldPoints> held(faces.size());
  for (int round = 0; round < kMostRounds; ++round) {
    const std::vector<Surface> before = plan.surfaces;
    const bool refine = round + 1 < kMostRounds;
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const SideUses uses = usesOf(plan.surfaces[f], f, pairs, plan.mirrors);
      FacePlan face = planOne(faces[f], plan.surfaces[f], uses, options, refine);
      plan.surfaces[f] = std::move(face.spline);
      held[f] = std::move(face.held);
      plan.notes[f] = std::move(face.notes);
      plan.leftAlone[f] = std::move(face.leftAlone);
    }
    auto together = compatible(plan.surfaces, pairs, kMostLaterGrowth * pointsOf(plan.surfaces) + kAlwaysAllowed);
    if (!together) {
      // Those least likely to be the cause are kept; without any pair nothing grows.
      if (std::erase_if(pairs, [](const SidePair& pair) { return pair.part.has_value(); }) == 0) pairs.clear();
      plan.surfaces = before;
      --round;
      continue;
    }
    plan.surfaces = *std::move(together);
    plan.joints = measureJoints(plan.surfaces, pairs, jointOptions);
    const auto dropped = std::erase_if(plan.joints, [&](const Joint& j) { return !usable(j) || !j.fit.compatible; });
    if (dropped > 0) {
      pairs.clear();
      for (const Joint& joint : plan.joints) pairs.push_back({joint.a, joint.b, joint.sideA, joint.sideB, joint.part});
    } else if (sameKnots(before, plan.surfaces)) {
      break;
    }
  }

  PartPoints points(plan.surfaces, std::max(jointOptions.gapLimit, kSameCorner * sizeOf(plan.surfaces)));
  for (const Joint& joint : plan.joints) points.join(joint);
  for (const Joint& joint : plan.joints) keepSeam(plan, joint, points);
  for (const MirrorSide& mirror : plan.mirrors) {
    points.confine(mirror.face, mirror.side, mirror.plane.normal);
    if (isPerpendicular(plan.surfaces[static_cast<std::size_t>(mirror.face)], mirror.side, mirror.plane.normal)) {
      points.keepPerpendicular(mirror.face, mirror.side, mirror.plane.normal);
    }
  }
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto face = static_cast<Index>(f);
    const auto hold = [&](Index row) { points.hold(face, row); };
    const bool all = !plan.leftAlone[f].empty();
    for (std::size_t r = 0; r < held[f].size(); ++r) {
      if (all || held[f][r] != 0) hold(static_cast<Index>(r));
    }
    const SideUses uses = usesOf(plan.surfaces[f], f, pairs, plan.mirrors);
    for (int side = 0; side < 4; ++side) {
      const SideUse& use = uses[static_cast<std::size_t>(side)];
      holdUncovered(plan.surfaces[f], side, use, std::max<Index>(1, options.rows[static_cast<std::size_t>(side)]),
                    hold);
      if (use.moves()) continue;
      // A corner on a side that is not joined stays, whatever is held there otherwise.
      const auto rows = borderRow(plan.surfaces[f], side);
      hold(rows.front());
      hold(rows.back());
    }
  }
  PartPoints::Result solved = points.solve();
  plan.unknownOf = std::move(solved.pointOf);
  plan.tied = std::move(solved.tied);
  plan.unknowns = solved.unknowns;
  return plan;
}

std::vector<std::vector<Index>> facesThatMoveTogether(const PartPlan& plan) {
  std::vector<std::size_t> set(plan.surfaces.size());
  std::iota(set.begin(), set.end(), std::size_t{0});
  const auto root = [&](std::size_t f) {
    while (set[f] != f) f = set[f];
    return f;
  };
  std::vector<std::size_t> owner(static_cast<std::size_t>(plan.unknowns), plan.surfaces.size());
  for (std::size_t f = 0; f < plan.surfaces.size(); ++f) {
    const auto use = [&](int unknown) {
      std::size_t& first = owner[static_cast<std::size_t>(unknown)];
      if (first == plan.surfaces.size()) first = f;
      const std::size_t a = root(first), b = root(f);
      set[std::max(a, b)] = std::min(a, b);
    };
    for (const int point : plan.unknownOf[f]) {
      if (point < 0) continue;
      if (!plan.tied) {
        use(point);
        continue;
      }
      for (const TiedPoints::Term& term : plan.tied->terms(point)) use(term.unknown);
    }
  }
  std::vector<bool> used(plan.surfaces.size(), false);
  for (const Joint& joint : plan.joints) {
    used[static_cast<std::size_t>(joint.a)] = used[static_cast<std::size_t>(joint.b)] = true;
  }
  for (const MirrorSide& mirror : plan.mirrors) used[static_cast<std::size_t>(mirror.face)] = true;
  std::map<std::size_t, std::vector<Index>> groups;
  for (std::size_t f = 0; f < used.size(); ++f) {
    if (used[f]) groups[root(f)].push_back(static_cast<Index>(f));
  }
  std::vector<std::vector<Index>> result;
  for (auto& [first, faces] : groups) result.push_back(std::move(faces));
  return result;
}

}  // namespace strak
