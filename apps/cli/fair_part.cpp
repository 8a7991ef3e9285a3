#include "apps/cli/fair_part.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "apps/cli/console.h"
#include "apps/cli/describe_result.h"
#include "strak/base/error.h"
#include "strak/fairing/joint_fairing.h"

namespace strak::cli {

namespace {

const Object& objectAt(const Model& model, Index index) { return model.objects()[static_cast<std::size_t>(index)]; }

// Faces that can be joined, and the sides at which they meet.
struct Part {
  std::vector<Index> faces;     // objects
  std::vector<SidePair> pairs;  // by numbers of `faces`
};

bool joinable(const Model& model, const FairModelOptions& options, Index index) {
  const Object& object = objectAt(model, index);
  if (!std::binary_search(options.selected.begin(), options.selected.end(), index)) return false;
  if (!object.leftAlone.empty() || !object.spline || object.sharedWith.size() > 1) return false;
  const Surface* surface = std::get_if<Surface>(&*object.spline);
  return surface && surface->pointDimension() == 3;
}

std::vector<Part> partsOf(const Model& model, const FairModelOptions& options) {
  const auto count = model.objects().size();
  std::vector<Index> set(count), place(count, -1);
  std::iota(set.begin(), set.end(), Index{0});
  const auto root = [&](Index i) {
    while (set[static_cast<std::size_t>(i)] != i) i = set[static_cast<std::size_t>(i)];
    return i;
  };
  std::vector<SharedEdge> edges;
  for (SharedEdge& edge : model.sharedEdges()) {
    if (!edge.sideA || !edge.sideB || !edge.notJoinable.empty()) continue;
    if (!joinable(model, options, edge.faceA) || !joinable(model, options, edge.faceB)) continue;
    const Index a = root(edge.faceA), b = root(edge.faceB);
    set[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    edges.push_back(std::move(edge));
  }
  std::vector<Part> parts;
  std::vector<std::size_t> partOf(count, 0);
  const auto add = [&](Index face) {
    const auto f = static_cast<std::size_t>(face), r = static_cast<std::size_t>(root(face));
    if (place[f] >= 0) return;
    if (place[r] < 0 && r != f) {
      partOf[r] = parts.size();
      parts.emplace_back();
      place[r] = 0;
      parts.back().faces.push_back(static_cast<Index>(r));
    } else if (r == f) {
      partOf[r] = parts.size();
      parts.emplace_back();
    }
    Part& part = parts[partOf[r]];
    place[f] = static_cast<Index>(part.faces.size());
    part.faces.push_back(face);
  };
  for (const SharedEdge& edge : edges) {
    add(edge.faceA);
    add(edge.faceB);
    parts[partOf[static_cast<std::size_t>(root(edge.faceA))]].pairs.push_back(
        {place[static_cast<std::size_t>(edge.faceA)], place[static_cast<std::size_t>(edge.faceB)], *edge.sideA,
         *edge.sideB});
  }
  return parts;
}

std::array<Index, 4> rowsOf(const std::vector<Index>& rows) {
  std::array<Index, 4> result{};
  for (std::size_t k = 0; k < 4; ++k) result[k] = rows.size() == 1 ? rows.front() : rows.at(k);
  return result;
}

// Faces one part; returns the faces whose entries have a result.
ModelEditor::Group fairPart(const Model& model, const Part& part, const FairModelOptions& options,
                            const Progress& progress, std::vector<FairedObject>& entries) {
  std::vector<PartFace> faces;
  for (Index index : part.faces) {
    const Object& object = objectAt(model, index);
    faces.push_back({std::get<Surface>(*object.spline), {object.trims, object.naturalSide}});
  }
  PlanOptions planOptions;
  planOptions.rows = rowsOf(options.holdRows);
  planOptions.refine = options.refine;
  planOptions.rational = true;
  JointOptions jointOptions;
  jointOptions.gapLimit = std::max(1e-6 * model.size(), 0.5 * std::min(options.fairing.tolerance, 1e-3 * model.size()));
  const PartPlan plan = planPart(faces, part.pairs, planOptions, jointOptions);
  if (plan.joints.empty() || plan.unknowns == 0) return {};
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
    const auto deviation = certifyDeviation(faces[f].surface, faired.surfaces[f]);
    entry.energyName = kExactEnergy;
    entry.notes = plan.notes[f];
    entry.notes.push_back(
        fmt::format("faired as one with {} neighbour{}", part.faces.size() - 1, part.faces.size() == 2 ? "" : "s"));
    describeResult(object, faces[f].surface, std::move(faired.surfaces[f]), summary, deviation, entry);
    group.push_back(part.faces[f]);
  }
  return group;
}

}  // namespace

std::vector<Index> fairParts(Model& model, const FairModelOptions& options, ModelEditor& editor,
                             std::vector<FairedObject>& entries) {
  const std::vector<Part> parts = partsOf(model, options);
  std::vector<double> weights;
  for (const Part& part : parts) weights.push_back(static_cast<double>(part.faces.size()));
  ProgressBar bar(weights, options.showProgress, options.stopped);
  std::vector<Index> done;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const ModelEditor::Group group = fairPart(model, parts[p], options, bar.task(p), entries);
    if (group.empty()) continue;
    editor.accept({group});
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
