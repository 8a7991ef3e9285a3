#include "apps/cli/fair_model.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "apps/cli/console.h"
#include "strak/base/error.h"
#include "strak/fairing/exact_fairing.h"
#include "strak/metrology/trim_region.h"

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

template <int D>
std::array<Index, 2 * D> rowsFor(const std::vector<Index>& rows) {
  if (rows.size() == 1) return FairingPlanOptions<D>::allRows(rows.front());
  std::array<Index, 2 * D> result{};
  if (rows.size() != result.size()) {
    throw InvalidInput(fmt::format("--hold gives {} numbers, but a {} has {} ends: give one number, or one an end",
                                   rows.size(),
                                   D == 1   ? "curve"
                                   : D == 2 ? "surface"
                                            : "volume",
                                   result.size()));
  }
  std::copy(rows.begin(), rows.end(), result.begin());
  return result;
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
  planOptions.rows = rowsFor<D>(options.holdRows);
  planOptions.energyOrder = energy.order();
  planOptions.refine = options.refine;
  if constexpr (D == 2) {
    return planShared(model, job, spline, planOptions);
  } else {
    return planFairing(spline, planOptions);
  }
}

// Looser on big nets: the figure must not cost more than the fairing. Of a trimmed face only the visible part counts.
FairnessOptions fairnessOptions(Index points, const TrimRegion* visible) {
  constexpr Index kBigNet = 10'000;
  FairnessOptions options;
  options.relativeError = points <= kBigNet ? 1e-3 : 1e-2;
  if (visible != nullptr) {
    options.context = visible;
    options.inside = [](double u, double v, const void* region) {
      return static_cast<const TrimRegion*>(region)->inside({u, v});
    };
  }
  return options;
}

void measure(const Object&, const Curve& before, const Curve& after, FairedObject& entry) {
  if (before.pointDimension() != 2 && before.pointDimension() != 3) return;
  entry.plate = {curveFairness(before).bending, curveFairness(after).bending};
}

void measure(const Object& object, const Surface& before, const Surface& after, FairedObject& entry) {
  if (before.pointDimension() != 3) return;
  const bool whole = std::all_of(object.naturalSide.begin(), object.naturalSide.end(), [](bool side) { return side; });
  std::optional<TrimRegion> visible;
  if (!whole) visible.emplace(before, object.trims);
  const TrimRegion* region = visible && !visible->isWholeDomain() ? &*visible : nullptr;
  entry.fairnessBefore = surfaceFairness(before, fairnessOptions(before.net().rows(), region));
  entry.fairnessAfter = surfaceFairness(after, fairnessOptions(after.net().rows(), region));
  entry.plate = {entry.fairnessBefore->plate, entry.fairnessAfter->plate};
}

void measure(const Object&, const Volume&, const Volume&, FairedObject&) {}

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

// Everything that a person wants to know of a faired object, whatever method it was.
template <int D>
void describeResult(const Model& model, const Job& job, const Spline<D>& before, Spline<D> after,
                    const FairingSummary& summary, const Deviation<D>& deviation, FairedObject& entry) {
  entry.summary = summary;
  entry.deviationLower = deviation.lower;
  entry.deviationUpper = deviation.upper;
  entry.controlPointMove = summary.largestMove;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  entry.plate = {kNone, kNone};
  measure(objectAt(model, job.objects.front()), before, after, entry);
  for (int k = 0; k < D; ++k) entry.points[static_cast<std::size_t>(k)] = after.size(k);
  entry.after = std::move(after);
}

const char* const kNothingGained = "already as fair as the tolerance and the held points allow: left as it was";

void fairSurfaceExactly(const Model& model, const Job& job, const Surface& spline, const FairModelOptions& options,
                        const Progress& progress, FairedObject& entry) {
  if (spline.pointDimension() != 3) {
    entry.leftAlone = "exact energies need a surface in space: choose another --energy";
    return;
  }
  PlanOptions planOptions;
  planOptions.rows = rowsFor<2>(options.holdRows);
  planOptions.refine = options.refine;
  const FacePlan plan = planShared(model, job, spline, planOptions);
  entry.notes.insert(entry.notes.end(), plan.notes.begin(), plan.notes.end());
  if (!plan.leftAlone.empty()) {
    entry.leftAlone = plan.leftAlone;
    return;
  }
  ExactFairingOptions exact;
  exact.tolerance = options.fairing.tolerance;
  exact.ballsOnPoints = options.fairing.toleranceKind == ToleranceKind::points;
  exact.maxSteps = static_cast<int>(std::min<Index>(options.fairing.maxSteps, exact.maxSteps));
  exact.progress = progress;
  ExactFairing faired = fairExactly(plan.spline, plan.held, exact);
  Deviation<2> deviation;
  if (faired.summary.largestMove > 0) {
    deviation = certifyDeviation(spline, faired.spline);
  } else {
    faired.spline = spline;
    entry.notes = {kNothingGained};
  }
  entry.energyName = kExactEnergy;
  describeResult(model, job, spline, std::move(faired.spline), faired.summary, deviation, entry);
}

template <int D>
void fairOne(const Model& model, const Job& job, const Spline<D>& spline, const FairModelOptions& options,
             const Progress& progress, FairedObject& entry) {
  constexpr double kSolving = 0.85;    // the rest is for certifying and measuring
  constexpr double kRounding = 1e-12;  // of the energy
  if constexpr (D == 2) {
    if (options.energy == kExactEnergy) {
      fairSurfaceExactly(model, job, spline, options, progress, entry);
      return;
    }
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
  describeResult(model, job, spline, std::move(faired.spline), faired.summary, faired.deviation, entry);
  noteHonestly(entry);
  progress.report(1, entry.name);
}

// How the model got worse by a change: empty if it did not.
std::string worsening(const Audit& before, const Audit& after, double size) {
  const double rounding = 1e-11 * size;
  if ((before.valid && !after.valid) || after.invalidFaces > before.invalidFaces) {
    return "the CAD kernel's checker no longer accepts the model with the change";
  }
  if (after.largestTolerance > before.largestTolerance + rounding) {
    return fmt::format("an edge's tolerance would rise from {} to {}", number(before.largestTolerance),
                       number(after.largestTolerance));
  }
  for (std::size_t e = 0; e < std::min(before.edges.size(), after.edges.size()); ++e) {
    if (after.edges[e].gap > before.edges[e].gap + rounding) {
      return fmt::format("the gap at {} would grow from {} to {}", after.edges[e].name, number(before.edges[e].gap),
                         number(after.edges[e].gap));
    }
  }
  return "";
}

// Puts changed splines into the model as long as its audit stays as good as it was.
class Editor {
 public:
  Editor(Model& model, const Audit& before, std::vector<FairedObject>& entries)
      : model_(model), before_(before), after_(before), entries_(entries) {}

  // Accepts all of the jobs at once if it can, else halves the set until the culprits are alone: few audits for few
  // culprits.
  void accept(const std::vector<Job>& jobs) {
    if (jobs.empty()) return;
    for (const Job& job : jobs) model_.replace(job.objects.front(), *entryOf(job).after);
    Audit audit = model_.audit();
    const std::string reason = worsening(before_, audit, model_.size());
    if (reason.empty()) {
      after_ = std::move(audit);
      return;
    }
    for (const Job& job : jobs) model_.replace(job.objects.front(), *entryOf(job).before);
    if (jobs.size() == 1) {
      entryOf(jobs.front()).after.reset();
      entryOf(jobs.front()).leftAlone = "refused: " + reason;
      return;
    }
    const auto middle = jobs.begin() + static_cast<std::ptrdiff_t>(jobs.size() / 2);
    accept({jobs.begin(), middle});
    accept({middle, jobs.end()});
  }

  const Audit& audit() const { return after_; }

 private:
  FairedObject& entryOf(const Job& job) { return entries_[static_cast<std::size_t>(job.objects.front())]; }

  Model& model_;
  const Audit& before_;
  Audit after_;
  std::vector<FairedObject>& entries_;
};

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
  const std::vector<Job> jobs = jobsOf(model, options.selected);
  result.before = result.after = model.audit();
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
          std::visit([&](const auto& spline) { fairOne(model, jobs[j], spline, options, progress, entry); },
                     *objectAt(model, jobs[j].objects.front()).spline);
        } catch (const InvalidInput& error) {
          if (onlyOne) throw;
          entry.leftAlone = error.what();
        }
      });
    });
  }
  std::vector<Job> done;
  std::copy_if(jobs.begin(), jobs.end(), std::back_inserter(done),
               [&](const Job& job) { return result.objects[static_cast<std::size_t>(job.objects.front())].faired(); });
  Editor editor(model, result.before, result.objects);
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
