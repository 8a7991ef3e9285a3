#include "strak/fairing/plan_part.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace strak {

namespace {

constexpr int kMostRounds = 12;                          // of inserting knots: each passes them on to a neighbour
constexpr Index kMostGrowth = 2, kAlwaysAllowed = 2048;  // of the points of all faces, by knots of neighbours
constexpr double kSameCorner = 1e-6;                     // of the part's size

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

FacePlan planOne(const PartFace& face, const Surface& surface, std::size_t number, const std::vector<SidePair>& pairs,
                 PlanOptions options, bool refine) {
  options.joined = {};
  for (const SidePair& pair : pairs) {
    if (pair.a == static_cast<Index>(number)) options.joined[static_cast<std::size_t>(pair.sideA)] = true;
    if (pair.b == static_cast<Index>(number)) options.joined[static_cast<std::size_t>(pair.sideB)] = true;
  }
  options.refine = options.refine && refine;
  return planFace(surface, face.border, options);
}

// Points of all faces, joined to sets.
class Sets {
 public:
  explicit Sets(const std::vector<Surface>& surfaces) {
    for (const Surface& surface : surfaces) {
      first_.push_back(count_);
      count_ += surface.net().rows();
    }
    parent_.resize(static_cast<std::size_t>(count_));
    std::iota(parent_.begin(), parent_.end(), Index{0});
  }
  Index number(Index face, Index row) const { return first_[static_cast<std::size_t>(face)] + row; }
  Index root(Index i) {
    while (parent_[static_cast<std::size_t>(i)] != i) {
      auto& up = parent_[static_cast<std::size_t>(i)];
      up = parent_[static_cast<std::size_t>(up)];
      i = up;
    }
    return i;
  }
  void join(Index a, Index b) {
    parent_[static_cast<std::size_t>(std::max(root(a), root(b)))] = std::min(root(a), root(b));
  }
  Index count() const { return count_; }

 private:
  std::vector<Index> first_, parent_;
  Index count_ = 0;
};

// Corners at the same place are one vertex of the part, whatever edges lead there.
void joinCorners(const std::vector<Surface>& surfaces, double limit, Sets& sets) {
  struct Corner {
    Eigen::RowVector3d place;
    Index number;
  };
  std::vector<Corner> corners;
  for (std::size_t f = 0; f < surfaces.size(); ++f) {
    const Surface& s = surfaces[f];
    const Net points = s.euclideanNet();
    for (Index i : {Index{0}, s.size(0) - 1}) {
      for (Index j : {Index{0}, s.size(1) - 1}) {
        corners.push_back({points.row(s.row({i, j})), sets.number(static_cast<Index>(f), s.row({i, j}))});
      }
    }
  }
  std::sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) {
    return a.place[0] < b.place[0] || (a.place[0] == b.place[0] && a.number < b.number);
  });
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (std::size_t j = i + 1; j < corners.size() && corners[j].place[0] - corners[i].place[0] <= limit; ++j) {
      if ((corners[j].place - corners[i].place).norm() <= limit) sets.join(corners[i].number, corners[j].number);
    }
  }
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
  for (std::size_t f = 0; f < faces.size(); ++f) {
    plan.leftAlone[f] = planOne(faces[f], faces[f].surface, f, allPairs, options, true).leftAlone;
    still[f] = !plan.leftAlone[f].empty();
  }
  const auto usable = [&](const Joint& joint) {
    return joint.kind != JointKind::feature && (joint.fit.compatible || joint.fit.differentKnots) &&
           !still[static_cast<std::size_t>(joint.a)] && !still[static_cast<std::size_t>(joint.b)];
  };
  const std::vector<Joint> measured = measureJoints(plan.surfaces, allPairs, jointOptions);
  const auto pairsOf = [&](bool differentKnots) {
    std::vector<SidePair> chosen;
    for (const Joint& joint : measured) {
      if (usable(joint) && (joint.fit.compatible || differentKnots)) {
        chosen.push_back({joint.a, joint.b, joint.sideA, joint.sideB, {}});
      }
    }
    return chosen;
  };
  std::vector<SidePair> pairs = pairsOf(true);
  // Knots that differ along a long row of faces all meet in the end: too many, and those joins are left out.
  if (pointsOf(makeCompatible(plan.surfaces, pairs)) > kMostGrowth * pointsOf(plan.surfaces) + kAlwaysAllowed) {
    pairs = pairsOf(false);
  }

  std::vector<HeldPoints> held(faces.size());
  for (int round = 0; round < kMostRounds; ++round) {
    const std::vector<Surface> before = plan.surfaces;
    const bool refine = round + 1 < kMostRounds;
    for (std::size_t f = 0; f < faces.size(); ++f) {
      FacePlan face = planOne(faces[f], plan.surfaces[f], f, pairs, options, refine);
      plan.surfaces[f] = std::move(face.spline);
      held[f] = std::move(face.held);
      plan.notes[f] = std::move(face.notes);
      plan.leftAlone[f] = std::move(face.leftAlone);
    }
    plan.surfaces = makeCompatible(plan.surfaces, pairs);
    plan.joints = measureJoints(plan.surfaces, pairs, jointOptions);
    const auto bad = std::remove_if(plan.joints.begin(), plan.joints.end(),
                                    [&](const Joint& joint) { return !usable(joint) || !joint.fit.compatible; });
    const bool dropped = bad != plan.joints.end();
    plan.joints.erase(bad, plan.joints.end());
    if (dropped) {
      pairs.clear();
      for (const Joint& joint : plan.joints) pairs.push_back({joint.a, joint.b, joint.sideA, joint.sideB});
    } else if (sameKnots(before, plan.surfaces)) {
      break;
    }
  }

  Sets sets(plan.surfaces);
  for (const Joint& joint : plan.joints) {
    const auto rowsA = borderRow(plan.surfaces[static_cast<std::size_t>(joint.a)], joint.sideA);
    const auto rowsB = borderRow(plan.surfaces[static_cast<std::size_t>(joint.b)], joint.sideB);
    for (std::size_t k = 0; k < rowsA.size(); ++k) {
      sets.join(sets.number(joint.a, rowsA[k]),
                sets.number(joint.b, rowsB[static_cast<std::size_t>(joint.fit.partner[k])]));
    }
  }
  joinCorners(plan.surfaces, std::max(jointOptions.gapLimit, kSameCorner * sizeOf(plan.surfaces)), sets);
  std::vector<bool> fixed(static_cast<std::size_t>(sets.count()), false);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto hold = [&](Index row) {
      fixed[static_cast<std::size_t>(sets.root(sets.number(static_cast<Index>(f), row)))] = true;
    };
    const bool all = !plan.leftAlone[f].empty();
    for (std::size_t r = 0; r < held[f].size(); ++r) {
      if (all || held[f][r] != 0) hold(static_cast<Index>(r));
    }
    // A corner on a side that is not joined stays, whatever is held there otherwise.
    std::array<bool, 4> joined{};
    for (const Joint& joint : plan.joints) {
      if (joint.a == static_cast<Index>(f)) joined[static_cast<std::size_t>(joint.sideA)] = true;
      if (joint.b == static_cast<Index>(f)) joined[static_cast<std::size_t>(joint.sideB)] = true;
    }
    for (int side = 0; side < 4; ++side) {
      if (joined[static_cast<std::size_t>(side)]) continue;
      const auto rows = borderRow(plan.surfaces[f], side);
      hold(rows.front());
      hold(rows.back());
    }
  }
  std::map<Index, int> numbers;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const Index rows = plan.surfaces[f].net().rows();
    auto& unknownOf = plan.unknownOf.emplace_back(static_cast<std::size_t>(rows), -1);
    for (Index r = 0; r < rows; ++r) {
      const Index root = sets.root(sets.number(static_cast<Index>(f), r));
      if (fixed[static_cast<std::size_t>(root)]) continue;
      unknownOf[static_cast<std::size_t>(r)] = numbers.emplace(root, static_cast<int>(numbers.size())).first->second;
    }
  }
  plan.unknowns = static_cast<Index>(numbers.size());
  return plan;
}

}  // namespace strak
