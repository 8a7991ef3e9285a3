#include "apps/cli/fair_model.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "apps/cli/console.h"
#include "apps/cli/describe_result.h"
#include "apps/cli/fair_curve.h"
#include "apps/cli/fair_part.h"
#include "apps/cli/model_editor.h"
#include "apps/cli/values.h"
#include "strak/base/error.h"
#include "strak/fairing/data_dependent_fairing.h"
#include "strak/fairing/exact_fairing.h"

namespace strak::cli {

namespace {

// One surface, curve or volume to fair, and all the objects that show it.
struct Job {
  std::vector<Index> objects;  // the first one is reported, the others refer to it
  double weight = 0;           // control points
};

const Object& objectAt(const Model& model, Index index) { return model.objects()[static_cast<std::size_t>(index)]; }

std::vector<Job> jobsOf(const Model& model, const std::vector<Index>& selected) {
  std::vector<Job> jobs;
  std::vector<bool> taken(model.objects().size(), false);
  for (Index index : selected) {
    const Object& object = objectAt(model, index);
    if (taken[static_cast<std::size_t>(index)] || !object.leftAlone.empty() || !object.spline) continue;
    Job job{{index}, 0};
    for (Index other : object.sharedWith) {
      if (other != index) job.objects.push_back(other);
    }
    for (Index member : job.objects) taken[static_cast<std::size_t>(member)] = true;
    job.weight =
        std::visit([](const auto& spline) { return static_cast<double>(spline.net().rows()); }, *object.spline);
    jobs.push_back(std::move(job));
  }
  // The longest first: then the last thread to end has little to do.
  std::stable_sort(jobs.begin(), jobs.end(), [](const Job& a, const Job& b) { return a.weight > b.weight; });
  return jobs;
}

bool sameBorder(const Object& a, const Object& b) { return a.trims == b.trims && a.naturalSide == b.naturalSide; }

// A shared surface is held where any of the faces on it needs it. Each plan may insert knots, so they are made one on
// top of the other until none does.
FacePlan planShared(const Model& model, const Job& job, const Surface& surface, const PlanOptions& options) {
  std::vector<const Object*> borders;
  for (Index index : job.objects) {
    const Object& object = objectAt(model, index);
    const bool known =
        std::any_of(borders.begin(), borders.end(), [&](const Object* other) { return sameBorder(*other, object); });
    if (!known) borders.push_back(&object);
  }
  FacePlan whole = planFace(surface, {borders.front()->trims, borders.front()->naturalSide}, options);
  for (bool changed = borders.size() > 1; changed && whole.leftAlone.empty();) {
    changed = false;
    const Surface onto = whole.spline;
    HeldPoints held;
    for (const Object* object : borders) {
      FacePlan plan = planFace(whole.spline, {object->trims, object->naturalSide}, options);
      plan.knotsInserted += whole.knotsInserted;
      plan.notes.insert(plan.notes.begin(), whole.notes.begin(), whole.notes.end());
      whole = std::move(plan);
      if (!whole.leftAlone.empty()) return whole;
      if (whole.spline.knots() != onto.knots()) {
        changed = true;
        break;
      }
      held = holdBoth(held, whole.held);
    }
    if (!changed) {
      whole.freePoints = std::count(held.begin(), held.end(), 0);
      whole.held = std::move(held);
      if (whole.freePoints == 0) whole.leftAlone = "the faces that share its surface leave no control point free";
    }
  }
  return whole;
}

template <int D>
FairingPlan<D> planOf(const Model& model, const Job& job, const Spline<D>& spline, const QuadraticEnergy<D>& energy,
                      const FairModelOptions& options) {
  FairingPlanOptions<D> planOptions;
  planOptions.rows = rowsAtEnds<D>(options.holdRows);
  planOptions.energyOrder = energy.order();
  planOptions.refine = options.refine;
  if constexpr (D == 2) {
    return planShared(model, job, spline, planOptions);
  } else {
    return planFairing(spline, planOptions);
  }
}

// What a person should be told when the energy and the true bending energy disagree.
void noteHonestly(FairedObject& entry) {
  const double error = entry.fairnessAfter ? std::max(1e-3, entry.fairnessAfter->relativeError) : 1e-3;
  if (entry.plate.after > (1 + error) * entry.plate.before && entry.summary.energyAfter < entry.summary.energyBefore) {
    entry.notes.push_back(
        fmt::format("the energy fell, but the exact plate energy rose from {} to {}: the {} energy also rewards "
                    "sliding points along "
                    "the surface; a smaller tolerance or another energy helps",
                    number(entry.plate.before), number(entry.plate.after), entry.energyName));
  }
}

// The largest move of a held control point: nothing, unless something went wrong.
double heldMove(const FacePlan& plan, const Surface& after) {
  if (after.knots() != plan.spline.knots()) return 0;  // the input itself
  double largest = 0;
  for (std::size_t r = 0; r < plan.held.size(); ++r) {
    const auto row = static_cast<Index>(r);
    if (plan.held[r] != 0) largest = std::max(largest, (after.net().row(row) - plan.spline.net().row(row)).norm());
  }
  return largest;
}

const char* const kNothingGained = "already as fair as the tolerance and the held points allow: left as it was";

const char* const kMeetsItself = "every move that was tried makes it intersect itself: left as it was";

template <class Options>
Options optionsInSpace(const FairModelOptions& options, const Progress& progress) {
  Options result;
  result.tolerance = options.fairing.tolerance;
  result.ballsOnPoints = options.fairing.toleranceKind == ToleranceKind::points;
  result.maxSteps = static_cast<int>(std::min<Index>(options.fairing.maxSteps, result.maxSteps));
  result.progress = progress;
  return result;
}

// By the energy of the shape itself that the options name; tells the entry why if nothing moves.
Faired<2> fairInSpace(const FacePlan& plan, const FairModelOptions& options, const Progress& progress,
                      FairedObject& entry) {
  if (options.energy == kExactEnergy) {
    const auto exact = optionsInSpace<ExactFairingOptions>(options, progress);
    ExactFairing faired = fairExactly(plan.spline, plan.held, exact);
    if (!(faired.summary.largestMove > 0)) {
      entry.notes = {faired.summary.stopReason == StopReason::meetsItself ? kMeetsItself : kNothingGained};
    } else if (faired.tolerance < exact.tolerance) {
      entry.notes.push_back(
          fmt::format("the whole tolerance makes it intersect itself: faired within {}", number(faired.tolerance)));
    }
    return {std::move(faired.spline), faired.summary};
  }
  DataDependentFairing faired =
      fairDataDependently(plan.spline, plan.held, optionsInSpace<DataDependentFairingOptions>(options, progress));
  if (!(faired.summary.largestMove > 0)) {
    entry.notes = {faired.takenBack == 0 ? std::string(kNothingGained)
                                         : "every step made bending, curvature variation or roughness larger: left as "
                                           "it was; --energy exact has steps that do not"};
  } else if (faired.takenBack > 0) {
    entry.notes.push_back(
        fmt::format("the last {} of {} steps made bending, curvature variation or roughness larger than before and "
                    "were taken back{}",
                    faired.takenBack, faired.summary.steps,
                    faired.takenBack == faired.summary.steps ? ", but for a part of the first" : ""));
  }
  return {std::move(faired.spline), faired.summary};
}

void fairSurfaceInSpace(const Model& model, const Job& job, const Surface& spline, const FairModelOptions& options,
                        const Progress& progress, FairedObject& entry) {
  if (spline.pointDimension() != 3) {
    entry.leftAlone = fmt::format("{} energies need a surface in space: choose another --energy", options.energy);
    return;
  }
  PlanOptions planOptions;
  planOptions.rows = rowsAtEnds<2>(options.holdRows);
  planOptions.refine = options.refine;
  planOptions.rational = true;
  const FacePlan plan = planShared(model, job, spline, planOptions);
  entry.notes.insert(entry.notes.end(), plan.notes.begin(), plan.notes.end());
  if (!plan.leftAlone.empty()) {
    entry.leftAlone = plan.leftAlone;
    return;
  }
  Faired<2> faired = fairInSpace(plan, options, progress, entry);
  Deviation<2> deviation;
  if (faired.summary.largestMove > 0) {
    deviation = certifyDeviation(spline, faired.spline);
  } else {
    faired.spline = spline;
  }
  entry.energyName = options.energy;
  entry.heldMaxMove = heldMove(plan, faired.spline);
  describeResult(objectAt(model, job.objects.front()), spline, std::move(faired.spline), faired.summary, deviation,
                 entry);
}

template <int D>
void fairOne(const Model& model, const Job& job, const Spline<D>& spline, const FairModelOptions& options,
             const Progress& progress, FairedObject& entry) {
  constexpr double kSolving = 0.85;    // the rest is for certifying and measuring
  constexpr double kRounding = 1e-12;  // of the energy
  if constexpr (D < 3) {
    const Object& object = objectAt(model, job.objects.front());
    if (fairOtherwise(object, spline, rowsAtEnds<D>(options.holdRows), options, progress, entry)) return;
  }
  if constexpr (D == 2) {
    if (options.energy == kExactEnergy || options.energy == kDataDependentEnergy) {
      fairSurfaceInSpace(model, job, spline, options, progress, entry);
      return;
    }
  }
  if (options.energy == kDataDependentEnergy) {
    entry.leftAlone = "the data-dependent energy is one of surfaces: choose another --energy";
    return;
  }
  const auto energy = energyNamed<D>(options.energy == kExactEnergy ? "thin-plate" : options.energy);
  const auto plan = planOf(model, job, spline, energy, options);
  entry.notes.insert(entry.notes.end(), plan.notes.begin(), plan.notes.end());
  if (!plan.leftAlone.empty()) {
    entry.leftAlone = plan.leftAlone;
    return;
  }
  CertifiedFairingOptions fairing = options.fairing;
  fairing.progress = Progress([&](double fraction, std::string_view message) {
    return progress.report(fraction < 0 ? fraction : kSolving * fraction, message);
  });
  auto faired = fairCertified(spline, plan, energy, fairing);
  if (!(faired.summary.energyAfter < (1 - kRounding) * faired.summary.energyBefore)) {
    faired.spline = spline;
    faired.deviation = {};
    faired.summary.energyAfter = faired.summary.energyBefore;
    faired.summary.largestMove = 0;
    entry.notes = {kNothingGained};
  }
  progress.report(kSolving, entry.name);
  entry.energyName = energy.name;
  entry.heldMaxMove = faired.heldMaxMove;
  describeResult(objectAt(model, job.objects.front()), spline, std::move(faired.spline), faired.summary,
                 faired.deviation, entry);
  noteHonestly(entry);
  progress.report(1, entry.name);
}

// A shared surface must suit all faces on it.
bool onlySidesOf(const Model& model, const Job& job) {
  return std::all_of(job.objects.begin(), job.objects.end(),
                     [&](Index index) { return onlySidesMatter(objectAt(model, index)); });
}

template <int D>
KnotRules<D> knotRules(const Model& model, const Job& job, const FairModelOptions& options, bool bordersMove) {
  return {options.knots, options.fairing.tolerance, rowsAtEnds<D>(options.holdRows),
          mayHaveNeighbours(model) && !bordersMove, onlySidesOf(model, job)};
}

// Smooth knots before the fairing and fewer after it, all within one tolerance.
template <int D>
void fairWithKnots(const Model& model, const Job& job, const Spline<D>& original, const FairModelOptions& options,
                   const Progress& progress, FairedObject& entry, bool bordersMove = false) {
  if (!options.knots.any()) {
    fairOne(model, job, original, options, progress, entry);
    return;
  }
  const KnotRules<D> rules = knotRules<D>(model, job, options, bordersMove);
  const Spline<D> start = withSmoothKnots(original, rules, entry);
  const std::vector<std::string> notes = std::exchange(entry.notes, {});
  FairModelOptions within = options;
  within.fairing.tolerance =
      toleranceForFairing(options.knots, rules.tolerance, entry.smoothed ? entry.smoothed->deviation : 0);
  fairOne(model, job, start, within, progress, entry);
  entry.notes.insert(entry.notes.begin(), notes.begin(), notes.end());
  if (!entry.faired()) return;
  Spline<D> after = withFewerKnots(std::get<Spline<D>>(*entry.after), original, rules, progress, entry);
  const Deviation<D> deviation = certifyDeviation(after, original);
  const FairingSummary summary = entry.summary;
  const Object& object = objectAt(model, job.objects.front());
  describeResult(object, original, std::move(after), summary, deviation, entry);
  if (entry.smoothed && entry.smoothed->smoothed > 0 && rougherThanInput(original, entry)) {
    FairModelOptions unsmoothed = options;
    unsmoothed.knots.smooth = false;
    entry = describe(object);
    fairWithKnots(model, job, original, unsmoothed, progress, entry, bordersMove);
    entry.notes.insert(entry.notes.begin(), "with its inner knots made smooth it would be rougher: they stay");
  }
}

// Faces of which knots can go only if their borders move: together with those that share these, edges re-made. Where
// the model does not take that, because a neighbour cannot follow, say, they are left for their turn alone.
std::vector<Index> fairWithBorders(const Model& model, const FairModelOptions& options, ModelEditor& editor,
                                   std::vector<FairedObject>& entries) {
  std::vector<ModelEditor::Group> groups;
  for (Index index : options.selected) {
    const Object& object = objectAt(model, index);
    if (!object.leftAlone.empty() || !object.spline || object.sharedWith.size() > 1) continue;
    const Surface* surface = std::get_if<Surface>(&*object.spline);
    if (surface == nullptr || options.stopped()) continue;
    try {
      if (needsBorders(*surface, knotRules<2>(model, {{index}}, options, true))) groups.push_back({index});
    } catch (const InvalidInput&) {
      continue;  // its turn alone says why
    }
  }
  if (groups.empty()) return {};
  for (const SharedEdge& edge : model.sharedEdges()) {
    const auto groupOf = [&](Index face) {
      return std::find_if(groups.begin(), groups.end(), [&](const auto& group) {
        return std::find(group.begin(), group.end(), face) != group.end();
      });
    };
    const auto a = groupOf(edge.faceA), b = groupOf(edge.faceB);
    if (a == b || a == groups.end() || b == groups.end()) continue;
    a->insert(a->end(), b->begin(), b->end());
    groups.erase(b);
  }
  std::vector<Index> done;
  for (const ModelEditor::Group& group : groups) {
    bool all = true;
    for (Index index : group) {
      FairedObject& entry = entries[static_cast<std::size_t>(index)];
      try {
        fairWithKnots(model, {{index}}, std::get<Surface>(*objectAt(model, index).spline), options, {}, entry, true);
      } catch (const InvalidInput& error) {
        entry.leftAlone = error.what();
      }
      all = all && entry.faired();
    }
    if (all) editor.accept({group}, true);
    for (Index index : group) {
      FairedObject& entry = entries[static_cast<std::size_t>(index)];
      if (all && entry.faired()) {
        done.push_back(index);
        continue;
      }
      const std::string reason = entry.leftAlone;
      entry = describe(objectAt(model, index));
      if (!reason.empty()) entry.notes.push_back("its borders stay as they are, for with them " + reason);
    }
  }
  std::sort(done.begin(), done.end());
  return done;
}

// The entries of all objects before anything is done: those not chosen say so.
std::vector<FairedObject> entriesOf(const Model& model, const std::vector<Index>& selected) {
  std::vector<FairedObject> entries;
  for (const Object& object : model.objects()) entries.push_back(describe(object));
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (!std::binary_search(selected.begin(), selected.end(), static_cast<Index>(i))) {
      entries[i].leftAlone = "not named by --faces";
    } else if (entries[i].leftAlone.empty() && !entries[i].before) {
      entries[i].leftAlone = "it is not a B-spline";
    }
  }
  return entries;
}

void noteSharing(const Job& job, std::vector<FairedObject>& entries) {
  const auto first = static_cast<std::size_t>(job.objects.front());
  std::string others;
  for (std::size_t k = 1; k < job.objects.size(); ++k) {
    auto& other = entries[static_cast<std::size_t>(job.objects[k])];
    others += fmt::format("{}{}", k == 1 ? "" : ", ", job.objects[k] + 1);
    other.leftAlone = entries[first].faired()
                          ? fmt::format("changed together with object {}, whose surface it shares", first + 1)
                          : entries[first].leftAlone;
  }
  if (!others.empty() && entries[first].faired()) {
    entries[first].notes.push_back("its surface is shared, and changed, with object " + others);
  }
}

}  // namespace

FairModelResult fairModel(Model& model, const FairModelOptions& options) {
  FairModelResult result;
  result.objects = entriesOf(model, options.selected);
  const bool onlyOne = options.selected.size() == 1;
  result.before = result.after = model.audit();
  ModelEditor editor(model, result.before, result.objects);
  std::vector<Index> alone = options.selected;
  if (options.join != JoinWish::keep && options.energy == kExactEnergy) {
    const std::vector<Index> together = fairParts(model, options, editor, result.objects);
    std::erase_if(alone, [&](Index i) { return std::binary_search(together.begin(), together.end(), i); });
  }
  if (options.knots.any() && mayHaveNeighbours(model)) {
    const std::vector<Index> together = fairWithBorders(model, options, editor, result.objects);
    std::erase_if(alone, [&](Index i) { return std::binary_search(together.begin(), together.end(), i); });
  }
  const std::vector<Job> jobs = jobsOf(model, alone);
  {
    std::vector<double> weights(jobs.size());
    std::transform(jobs.begin(), jobs.end(), weights.begin(), [](const Job& job) { return job.weight; });
    ProgressBar bar(weights, options.showProgress, options.stopped);
    tbb::parallel_for(std::size_t{0}, jobs.size(), [&](std::size_t j) {
      auto& entry = result.objects[static_cast<std::size_t>(jobs[j].objects.front())];
      if (!onlyOne && options.stopped()) {
        entry.leftAlone = "the work was interrupted before its turn";
        return;
      }
      // Isolated, or a thread that waits inside would take up another face and count its time too.
      tbb::this_task_arena::isolate([&] {
        try {
          const Progress progress = bar.task(j);
          std::visit([&](const auto& spline) { fairWithKnots(model, jobs[j], spline, options, progress, entry); },
                     *objectAt(model, jobs[j].objects.front()).spline);
        } catch (const InvalidInput& error) {
          if (onlyOne) throw;
          entry.leftAlone = error.what();
        }
      });
    });
  }
  std::vector<ModelEditor::Group> done;
  for (const Job& job : jobs) {
    const Index first = job.objects.front();
    if (result.objects[static_cast<std::size_t>(first)].faired()) done.push_back({first});
  }
  editor.accept(done);
  result.after = editor.audit();
  for (const Job& job : jobs) noteSharing(job, result.objects);
  if (onlyOne) {
    const auto& entry = result.objects[static_cast<std::size_t>(options.selected.front())];
    const std::string reason = fmt::format("'{}' cannot be faired: {}", entry.name, entry.leftAlone);
    if (!entry.faired() && !done.empty()) throw Failure(reason);
    if (!entry.faired()) throw InvalidInput(reason);
  }
  return result;
}

}  // namespace strak::cli
