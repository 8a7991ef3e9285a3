#include "apps/cli/fair_part.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>

#include "apps/cli/console.h"
#include "apps/cli/describe_result.h"
#include "strak/base/error.h"
#include "strak/fairing/joint_fairing.h"
#include "strak/report/edge_joins.h"

namespace strak::cli {

namespace {

const Object& objectAt(const Model& model, Index index) { return model.objects()[static_cast<std::size_t>(index)]; }

using Mirrors = std::array<std::optional<SymmetryPlane>, 4>;

// Faces that can be joined, and the sides at which they meet or lie in planes of symmetry.
struct Part {
  std::vector<Index> faces;      // objects
  std::vector<Mirrors> mirrors;  // by numbers of `faces`
  std::vector<SidePair> pairs;   // the same
};

bool joinable(const Model& model, const FairModelOptions& options, Index index) {
  const Object& object = objectAt(model, index);
  if (!std::binary_search(options.selected.begin(), options.selected.end(), index)) return false;
  if (!object.leftAlone.empty() || !object.spline || object.sharedWith.size() > 1) return false;
  const Surface* surface = std::get_if<Surface>(&*object.spline);
  return surface && surface->pointDimension() == 3;
}

// The planes of symmetry that hold sides where no other face is.
std::vector<Mirrors> mirrorsOf(const Model& model, const FairModelOptions& options,
                               const std::vector<SharedEdge>& edges) {
  std::vector<Mirrors> mirrors(model.objects().size());
  if (options.symmetry == SymmetryWish::none) return mirrors;
  SymmetryOptions wish;
  if (options.symmetry != SymmetryWish::any) {
    wish.normal = Eigen::Vector3d::Unit(static_cast<Index>(options.symmetry) - static_cast<Index>(SymmetryWish::x));
  }
  for (Index face = 0; face < static_cast<Index>(mirrors.size()); ++face) {
    if (!joinable(model, options, face)) continue;
    for (int side = 0; side < 4; ++side) {
      const auto there = [&](Index f, const std::optional<int>& along) {
        return f == face && (!along || along == side);
      };
      const bool isShared = std::any_of(edges.begin(), edges.end(), [&](const SharedEdge& edge) {
        return there(edge.faceA, edge.alongA) || there(edge.faceB, edge.alongB);
      });
      const Object& object = objectAt(model, face);
      if (isShared || !object.naturalSide[static_cast<std::size_t>(side)]) continue;
      mirrors[static_cast<std::size_t>(face)][static_cast<std::size_t>(side)] =
          symmetryPlane(std::get<Surface>(*object.spline), side, wish);
    }
  }
  return mirrors;
}

std::vector<Part> partsOf(const Model& model, const FairModelOptions& options) {
  const std::vector<SharedEdge> edges = model.sharedEdges();
  const std::vector<Mirrors> mirrors = mirrorsOf(model, options, edges);
  std::vector<SidePair> pairs = joinableSides(edges);
  std::erase_if(pairs, [&](const SidePair& pair) {
    return !joinable(model, options, pair.a) || !joinable(model, options, pair.b);
  });
  const auto count = model.objects().size();
  std::vector<Index> set(count), place(count, -1);
  std::iota(set.begin(), set.end(), Index{0});
  const auto root = [&](Index i) {
    while (set[static_cast<std::size_t>(i)] != i) i = set[static_cast<std::size_t>(i)];
    return static_cast<std::size_t>(i);
  };
  std::vector<bool> taken(count, false);
  for (const SidePair& pair : pairs) {
    const std::size_t a = root(pair.a), b = root(pair.b);
    set[std::max(a, b)] = static_cast<Index>(std::min(a, b));
    taken[static_cast<std::size_t>(pair.a)] = taken[static_cast<std::size_t>(pair.b)] = true;
  }
  std::vector<Part> parts;
  std::vector<std::size_t> partOf(count, 0);  // by roots, which come first
  for (std::size_t f = 0; f < count; ++f) {
    const bool mirrored =
        std::any_of(mirrors[f].begin(), mirrors[f].end(), [](const auto& m) { return m.has_value(); });
    if (!taken[f] && !mirrored) continue;
    const std::size_t r = root(static_cast<Index>(f));
    if (r == f) {
      partOf[r] = parts.size();
      parts.emplace_back();
    }
    Part& part = parts[partOf[r]];
    place[f] = static_cast<Index>(part.faces.size());
    part.faces.push_back(static_cast<Index>(f));
    part.mirrors.push_back(mirrors[f]);
  }
  for (SidePair pair : pairs) {
    Part& part = parts[partOf[root(pair.a)]];
    pair.a = place[static_cast<std::size_t>(pair.a)];
    pair.b = place[static_cast<std::size_t>(pair.b)];
    part.pairs.push_back(pair);
  }
  return parts;
}

std::array<Index, 4> rowsOf(const std::vector<Index>& rows) {
  std::array<Index, 4> result{};
  for (std::size_t k = 0; k < 4; ++k) result[k] = rows.size() == 1 ? rows.front() : rows.at(k);
  return result;
}

// How a face was faired with others, with itself across a seam, and with its image in a mirror.
std::string howFaired(const PartPlan& plan, const JointFairing& faired, Index face) {
  std::vector<std::string> how;
  if (plan.surfaces.size() > 1) {
    how.push_back(fmt::format("with {} neighbour{}", plan.surfaces.size() - 1, plan.surfaces.size() == 2 ? "" : "s"));
  }
  const bool closed =
      std::any_of(plan.joints.begin(), plan.joints.end(), [&](const Joint& j) { return j.a == face && j.b == face; });
  if (closed) how.emplace_back("across its seam");
  for (std::size_t m = 0; m < plan.mirrors.size(); ++m) {
    if (plan.mirrors[m].face != face) continue;
    const auto degrees = [&](const std::vector<JoinFigures>& joins) {
      return std::asin(std::min(1.0, joins[plan.joints.size() + m].angle)) * 180 / std::numbers::pi;
    };
    const int side = plan.mirrors[m].side;
    how.push_back(fmt::format("with its mirror image across {} {} (angle {:.2g} -> {:.2g} degrees)",
                              side < 2 ? "u" : "v", side % 2 == 0 ? "low" : "high", degrees(faired.joinsBefore),
                              degrees(faired.joinsAfter)));
  }
  return how.empty() ? "" : fmt::format("faired as one {}", fmt::join(how, ", "));
}

std::vector<PartFace> partFaces(const Model& model, const Part& part) {
  std::vector<PartFace> faces;
  for (std::size_t f = 0; f < part.faces.size(); ++f) {
    const Object& object = objectAt(model, part.faces[f]);
    faces.push_back({std::get<Surface>(*object.spline), {object.trims, object.naturalSide}, part.mirrors[f]});
  }
  return faces;
}

PartPlan planOf(const Model& model, const Part& part, const FairModelOptions& options) {
  PlanOptions planOptions;
  planOptions.rows = rowsOf(options.holdRows);
  planOptions.refine = options.refine;
  planOptions.rational = true;
  JointOptions jointOptions;
  jointOptions.gapLimit = std::max(1e-6 * model.size(), 0.5 * std::min(options.fairing.tolerance, 1e-3 * model.size()));
  return planPart(partFaces(model, part), part.pairs, planOptions, jointOptions);
}

// Those that nothing couples are parts of their own, smaller systems, and one that cannot be faired stops no other.
std::vector<Part> independentParts(const Part& part, const PartPlan& plan) {
  std::vector<Part> result;
  for (const std::vector<Index>& faces : facesThatMoveTogether(plan)) {
    Part& own = result.emplace_back();
    std::map<Index, Index> place;
    for (Index face : faces) {
      place.emplace(face, static_cast<Index>(own.faces.size()));
      own.faces.push_back(part.faces[static_cast<std::size_t>(face)]);
      own.mirrors.push_back(part.mirrors[static_cast<std::size_t>(face)]);
    }
    for (const Joint& joint : plan.joints) {
      if (place.count(joint.a) == 0) continue;
      own.pairs.push_back({place.at(joint.a), place.at(joint.b), joint.sideA, joint.sideB, joint.part});
    }
  }
  return result;
}

// Faces one part; returns the faces whose entries have a result.
ModelEditor::Group fairPart(const Model& model, const Part& part, const FairModelOptions& options,
                            const Progress& progress, std::vector<FairedObject>& entries) {
  const PartPlan plan = planOf(model, part, options);
  if ((plan.joints.empty() && plan.mirrors.empty()) || plan.unknowns == 0) return {};
  JointFairingOptions joint;
  joint.tolerance = options.fairing.tolerance;
  joint.ballsOnPoints = options.fairing.toleranceKind == ToleranceKind::points;
  joint.aim = options.join == JoinWish::g1 ? JoinAim::g1 : JoinAim::g2;
  joint.maxSteps = static_cast<int>(std::min<Index>(options.fairing.maxSteps, joint.maxSteps));
  joint.progress = progress;
  JointFairing faired = fairJointly(plan, joint);
  if (!(faired.summary.largestMove > 0)) {
    for (Index face : part.faces) {
      entries[static_cast<std::size_t>(face)].notes.push_back(
          "together with its neighbours nothing could be gained: faired on its own");
    }
    return {};
  }
  ModelEditor::Group group;
  for (std::size_t f = 0; f < part.faces.size(); ++f) {
    FairedObject& entry = entries[static_cast<std::size_t>(part.faces[f])];
    const Object& object = objectAt(model, part.faces[f]);
    const Net moved = faired.surfaces[f].euclideanNet() - plan.surfaces[f].euclideanNet();
    FairingSummary summary = faired.summary;
    summary.energyBefore = faired.before[f].isophoteRoughness;
    summary.energyAfter = faired.after[f].isophoteRoughness;
    summary.largestMove = moved.rowwise().norm().maxCoeff();
    summary.freePoints =
        std::count_if(plan.unknownOf[f].begin(), plan.unknownOf[f].end(), [](int u) { return u >= 0; });
    summary.seconds = faired.summary.seconds / static_cast<double>(part.faces.size());
    const auto& before = std::get<Surface>(*object.spline);
    const auto deviation = certifyDeviation(before, faired.surfaces[f]);
    entry.energyName = kExactEnergy;
    entry.notes = plan.notes[f];
    const std::string how = howFaired(plan, faired, static_cast<Index>(f));
    if (!how.empty()) entry.notes.push_back(how);
    describeResult(object, before, std::move(faired.surfaces[f]), summary, deviation, entry);
    group.push_back(part.faces[f]);
  }
  return group;
}

}  // namespace

std::vector<Index> fairParts(Model& model, const FairModelOptions& options, ModelEditor& editor,
                             std::vector<FairedObject>& entries) {
  std::vector<Part> parts;
  for (const Part& part : partsOf(model, options)) {
    std::vector<Part> own = independentParts(part, planOf(model, part, options));
    std::move(own.begin(), own.end(), std::back_inserter(parts));
  }
  std::vector<double> weights;
  for (const Part& part : parts) weights.push_back(static_cast<double>(part.faces.size()));
  ProgressBar bar(weights, options.showProgress, options.stopped);
  std::vector<Index> done;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const ModelEditor::Group group = fairPart(model, parts[p], options, bar.task(p), entries);
    if (group.empty()) continue;
    editor.accept({group}, true);
    for (Index index : group) {
      FairedObject& entry = entries[static_cast<std::size_t>(index)];
      if (entry.faired()) {
        done.push_back(index);
      } else {
        // On its own it may still get better.
        entry.notes = {"not together with its neighbours: " + entry.leftAlone};
        entry.leftAlone.clear();
      }
    }
  }
  std::sort(done.begin(), done.end());
  return done;
}

}  // namespace strak::cli
