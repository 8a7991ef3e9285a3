// strak fair: makes the splines of a file fair within a tolerance.

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/fair_curve.h"
#include "apps/cli/fair_model.h"
#include "apps/cli/interrupt.h"
#include "apps/cli/joins.h"
#include "apps/cli/values.h"
#include "strak/base/error.h"
#include "strak/base/file.h"
#include "strak/exchange/file_kind.h"

namespace strak::cli {

namespace {

// The options as they were typed.
struct FairArguments {
  std::string input, output, report;
  std::string tolerance, toleranceKind, hold = "g2", energy, scale;
  std::string join = "keep", symmetry = "none", method = "optimal", steps, gap, minGain = "0", maxChanges,
              pointsPerList = "1", faces, threads, curvatureExtrema;
  std::string creaseAngle = "5";
  bool simplify = false, simplifyBorders = false, smoothKnots = false;
  bool noRefine = false, convertAnalytic = false, json = false, quiet = false;
  std::string commandLine;
};

void requireReportPath(const FairArguments& arguments) {
  if (arguments.report.empty()) return;
  requireWritable(arguments.report);
  for (const auto& other : {arguments.input, arguments.output}) {
    std::error_code ignored;
    if (arguments.report == other || std::filesystem::equivalent(arguments.report, other, ignored)) {
      throw InvalidInput(fmt::format("--report would overwrite '{}': give the page a name of its own", other));
    }
  }
}

// The energies that act on the surface and not on its parameters.
bool isInSpace(const std::string& energy) { return energy == kExactEnergy || energy == kDataDependentEnergy; }

// The energy that is meant: options that only quadratic energies have imply one.
std::string energyOf(const FairArguments& arguments) {
  const std::string named = arguments.energy == "beltrami" ? kDataDependentEnergy : arguments.energy;
  const char* quadratic = nullptr;
  if (arguments.method != "optimal") quadratic = "--method";
  if (!arguments.scale.empty()) quadratic = "--parameter-scale";
  if (!arguments.gap.empty()) quadratic = "--gap";
  if (isInSpace(named) && quadratic) {
    throw InvalidInput(fmt::format(
        "{} is for energies in the parameters, and --energy {} is none: leave it out, or choose --energy thin-plate",
        quadratic, named));
  }
  if (!named.empty()) {
    if (!isInSpace(named)) energyNamed<2>(named);
    return named;
  }
  return quadratic ? "thin-plate" : kExactEnergy;
}

Index wishedExtrema(const FairArguments& arguments) {
  if (arguments.curvatureExtrema.empty()) return -1;
  if (energyOf(arguments) != kExactEnergy) {
    throw InvalidInput("--curvature-extrema needs --energy exact and the options that go with it");
  }
  return wholeNumber("--curvature-extrema", arguments.curvatureExtrema, 0);
}

JoinWish joinWish(const FairArguments& arguments) {
  if (arguments.join == "keep") return JoinWish::keep;
  if (energyOf(arguments) != kExactEnergy) {
    throw InvalidInput("--join g1 and g2 need --energy exact: leave the other energy out");
  }
  if (arguments.join == "g1") return JoinWish::g1;
  if (arguments.join == "g2") return JoinWish::g2;
  throw InvalidInput(fmt::format("--join cannot be '{}': choose keep, g1 or g2", arguments.join));
}

SymmetryWish symmetryWish(const FairArguments& arguments) {
  const std::array<std::pair<const char*, SymmetryWish>, 5> names{{{"none", SymmetryWish::none},
                                                                   {"any", SymmetryWish::any},
                                                                   {"x", SymmetryWish::x},
                                                                   {"y", SymmetryWish::y},
                                                                   {"z", SymmetryWish::z}}};
  for (const auto& [name, wish] : names) {
    if (arguments.symmetry != name) continue;
    if (wish != SymmetryWish::none && arguments.join == "keep") {
      throw InvalidInput("--symmetry lets borders move, --join keep holds them: add --join g1 or g2");
    }
    return wish;
  }
  throw InvalidInput(fmt::format("--symmetry cannot be '{}': choose none, x, y, z or any", arguments.symmetry));
}

CertifiedFairingOptions fairingOptions(const FairArguments& arguments, double modelSize) {
  CertifiedFairingOptions options;
  if (!isClassicalMethod(arguments.method)) options.method = fairingMethodNamed(arguments.method);
  if (!arguments.tolerance.empty()) options.tolerance = lengthOf("--tolerance", arguments.tolerance, modelSize);
  options.toleranceKind = !arguments.toleranceKind.empty() ? toleranceKindNamed(arguments.toleranceKind)
                          : isInSpace(energyOf(arguments)) ? ToleranceKind::surface
                                                           : ToleranceKind::points;
  if (!arguments.gap.empty()) options.gap = positiveNumber("--gap", arguments.gap);
  options.minGain = positiveNumber("--min-gain", arguments.minGain, true);
  if (!arguments.steps.empty()) options.maxSteps = wholeNumber("--steps", arguments.steps, 1);
  if (!arguments.maxChanges.empty()) options.maxChangesPerPoint = wholeNumber("--max-changes", arguments.maxChanges, 1);
  options.pointsPerList = wholeNumber("--points-per-list", arguments.pointsPerList, 1);
  if (!arguments.scale.empty()) options.scale = parameterScaleNamed(arguments.scale);
  return options;
}

KnotOptions knotOptions(const FairArguments& arguments) {
  constexpr double kRadians = 0.017453292519943295;  // in a degree
  KnotOptions options;
  options.simplify = arguments.simplify || arguments.simplifyBorders;
  options.simplifyBorders = arguments.simplifyBorders;
  options.smooth = arguments.smoothKnots;
  options.creaseAngle = kRadians * positiveNumber("--crease-angle", arguments.creaseAngle, true);
  if (options.any() && arguments.tolerance.empty()) {
    throw InvalidInput(
        fmt::format("{} needs a --tolerance: give a length", options.simplify ? "--simplify" : "--smooth-knots"));
  }
  if (options.any() && arguments.join != "keep") {
    throw InvalidInput(
        fmt::format("{} works on every face for itself, --join {} on several together: choose one, or fair twice",
                    options.simplify ? "--simplify" : "--smooth-knots", arguments.join));
  }
  return options;
}

// "1, 3-5, 9" for object numbers counted from 0, ascending.
std::string ranges(const std::vector<std::size_t>& numbers) {
  std::string text;
  for (std::size_t i = 0; i < numbers.size();) {
    std::size_t last = i;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    text += fmt::format("{}{}", text.empty() ? "" : ", ", numbers[i] + 1);
    if (last > i) text += fmt::format("{}{}", last > i + 1 ? "-" : ", ", numbers[last] + 1);
    i = last + 1;
  }
  return text;
}

std::string leftAloneText(const std::vector<FairedObject>& objects) {
  std::map<std::string, std::vector<std::size_t>> byReason;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (!objects[i].faired()) byReason[objects[i].kind + ": " + objects[i].leftAlone].push_back(i);
  }
  std::string text;
  for (const auto& [reason, numbers] : byReason) text += fmt::format("  {} ({})\n", reason, ranges(numbers));
  return text.empty() ? "" : "left alone:\n" + text;
}

void printTable(const FairReport& report) {
  constexpr std::size_t kMostRows = 40;
  Table table({"#", "<object", "<net", "energy", "after", "change", "plate", "after", "deviation", "gap", "<stopped by",
               "time"});
  std::vector<std::pair<std::string, std::vector<std::size_t>>> notes;  // a text and the objects it is about
  std::size_t rows = 0;
  for (std::size_t i = 0; i < report.objects.size(); ++i) {
    const auto& object = report.objects[i];
    if (!object.faired()) continue;
    if (++rows > kMostRows) continue;
    const auto& summary = object.summary;
    table.add({std::to_string(i + 1), object.name, times(object.points), number(summary.energyBefore),
               number(summary.energyAfter), change(summary.energyBefore, summary.energyAfter),
               number(object.plate.before), number(object.plate.after), number(object.deviationUpper),
               number(summary.gap), stopReasonName(summary.stopReason), duration(summary.seconds)});
    for (const auto& note : object.notes) {
      auto place = std::find_if(notes.begin(), notes.end(), [&](const auto& known) { return known.first == note; });
      if (place == notes.end()) place = notes.insert(notes.end(), {note, {}});
      place->second.push_back(i);
    }
  }
  if (!table.empty()) fmt::print("{}", table.text());
  if (rows > kMostRows) fmt::print("and {} more (--json or --report lists all)\n", rows - kMostRows);
  if (!notes.empty()) fmt::print("notes:\n");
  for (const auto& [note, numbers] : notes) fmt::print("  {}: {}\n", ranges(numbers), note);
  fmt::print("{}", leftAloneText(report.objects));
}

void printSummary(const FairReport& report, const FairArguments& arguments) {
  double before = 0;
  double after = 0;
  double deviation = 0;
  const auto faired = std::count_if(report.objects.begin(), report.objects.end(), [&](const FairedObject& object) {
    if (!object.faired()) return false;
    before += object.summary.energyBefore;
    after += object.summary.energyAfter;
    deviation = std::max(deviation, object.deviationUpper);
    return true;
  });
  const std::string unit = report.unit.empty() ? "" : " " + report.unit;
  if (faired == 0) {
    fmt::print("nothing was faired: the file is written as it was\n");
  } else {
    fmt::print("{} of {} faired: energy {}, certified deviation at most {}{}{}, in {}\n", faired, report.objects.size(),
               change(before, after), number(deviation), unit,
               report.tolerance < kUnlimited ? fmt::format(" (tolerance {}{})", number(report.tolerance), unit) : "",
               duration(report.seconds));
  }
  if (!report.before.edges.empty()) {
    fmt::print("model {} -> {}, largest gap {} -> {}, largest tolerance {} -> {}{}\n",
               report.before.valid ? "valid" : "not valid", report.after.valid ? "valid" : "not valid",
               number(report.before.largestGap), number(report.after.largestGap),
               number(report.before.largestTolerance), number(report.after.largestTolerance), unit);
  }
  fmt::print("{}", joinsText(report.joins, report.unit));
  fmt::print("wrote {}{}\n", arguments.output, arguments.report.empty() ? "" : " and " + arguments.report);
}

void fair(const FairArguments& arguments) {
  const Stopwatch watch;
  const std::string energy = energyOf(arguments);  // a misspelt name is found before the file is read
  const auto rows = holdRows(arguments.hold);
  const JoinWish join = joinWish(arguments);
  const SymmetryWish symmetry = symmetryWish(arguments);
  std::optional<tbb::global_control> threads;
  if (!arguments.threads.empty()) {
    threads.emplace(tbb::global_control::max_allowed_parallelism,
                    static_cast<std::size_t>(wholeNumber("--threads", arguments.threads, 1)));
  }
  const KnotOptions knots = knotOptions(arguments);
  wishedExtrema(arguments);
  fairingOptions(arguments, 1);  // the same for every other option
  requireWritable(arguments.output);
  fileKindOfEnding(arguments.output);
  requireReportPath(arguments);

  const auto model = readModel(arguments.input);
  FairModelOptions options;
  options.selected = selectedObjects(arguments.faces, model->objects());
  if (arguments.convertAnalytic) {
    if (arguments.faces.empty())
      throw InvalidInput("--convert-analytic makes other surfaces of faces: name them with --faces");
    model->convertAnalytic(options.selected);
  }
  options.energy = energy;
  options.holdRows = rows;
  options.join = join;
  options.symmetry = symmetry;
  if (isClassicalMethod(arguments.method)) options.curveMethod = arguments.method;
  options.maxExtrema = wishedExtrema(arguments);
  options.refine = !arguments.noRefine;
  options.fairing = fairingOptions(arguments, model->size());
  options.knots = knots;
  options.showProgress = !arguments.quiet;
  options.stopped = interrupted;
  catchInterrupt();
  FairModelResult result = fairModel(*model, options);

  FairReport report;
  report.version = STRAK_VERSION;
  report.command = arguments.commandLine;
  report.inputName = arguments.input;
  report.outputName = arguments.output;
  report.unit = model->unit();
  report.size = model->size();
  report.tolerance = options.fairing.tolerance;
  report.toleranceKind = toleranceKindName(options.fairing.toleranceKind);
  report.joins = joinsOf(*model, result.objects);
  report.before = std::move(result.before);
  report.after = std::move(result.after);
  report.objects = std::move(result.objects);
  report.seconds = watch.seconds();
  const std::string page = arguments.report.empty() ? "" : fairReportHtml(report);
  model->write(arguments.output);
  if (!arguments.report.empty()) writeFile(arguments.report, page);
  if (interrupted()) printError("interrupted: the best so far is written to '" + arguments.output + "'");
  if (arguments.json) {
    fmt::print("{}\n", fairReportJson(report));
  } else if (!arguments.quiet) {
    printTable(report);
    printSummary(report, arguments);
  }
}

}  // namespace

void addFair(CLI::App& program, const std::string& commandLine) {
  auto arguments = std::make_shared<FairArguments>();
  arguments->commandLine = commandLine;
  CLI::App* command = program.add_subcommand("fair", "Make curves, surfaces and volumes fair within a tolerance");
  command->add_option("IN", arguments->input, "STEP, IGES, BREP, .g2, JSON or digitised curve (.dat, .csv, .txt, .pcd)")
      ->required();
  command->add_option("-o,--output", arguments->output, "File to write (format by its ending); may be IN itself")
      ->required();
  command->add_option("--tolerance", arguments->tolerance,
                      "How far anything may move: a length in the file's unit (0.5), or a part of the model's size "
                      "(0.0001size); without it only the held rows keep the shape");
  command->add_option("--tolerance-kind", arguments->toleranceKind,
                      "surface: the certified deviation of the surface is at most the tolerance; points: no control "
                      "point moves further. Default: surface for --energy exact and data-dependent, points for "
                      "quadratic energies");
  command
      ->add_option("--hold", arguments->hold,
                   "What stays at the borders: g0, g1, g2 (1, 2, 3 rows of control points), a number of rows, or "
                   "UMIN,UMAX,VMIN,VMAX")
      ->capture_default_str();
  command
      ->add_option("--join", arguments->join,
                   "What happens where faces meet smoothly: keep (every face stays as it is along its borders), g1 or "
                   "g2 (they move together, so that angle, or angle and curvature jump, get smaller)")
      ->capture_default_str();
  command
      ->add_option("--symmetry", arguments->symmetry,
                   "With --join g1 or g2: free borders in a plane with this normal (x, y, z, or any) are those of a "
                   "symmetric half; they move in the plane, and the mirrored half goes on smoothly")
      ->capture_default_str();
  command->add_option(
      "--energy", arguments->energy,
      "exact: bending, curvature variation and isophote roughness of the surface itself (default); "
      "data-dependent (or beltrami): bending in the geometry of the step before, for comparison; or a quadratic energy "
      "in the parameters: thin-plate, laplacian, third-order, laplacian-gradient, "
      "third-derivatives, q3, or a mixture like thin-plate+0.01*third-derivatives");
  command->add_option("--parameter-scale", arguments->scale,
                      "In which parameters a quadratic energy is measured: lengths (of the parameter lines, default), "
                      "domain (the knots as they are), unit (each domain [0, 1])");
  command
      ->add_option("--method", arguments->method,
                   "optimal: the best surface within the tolerance; local: one control point at a time; "
                   "local-literal: the same with the ranking as first published; for curves, for comparison: "
                   "eck-hadenfeld, eck-hadenfeld-3, farin-sapidis, farin-degree, kjellander (also for surfaces)")
      ->capture_default_str();
  command->add_option("--gap", arguments->gap,
                      "Quadratic energies: stop once certified to be this near to the least possible (1e-6)");
  command->add_option("--steps", arguments->steps, "At most so many moves (local) or iterations (optimal) an object");
  command->add_option("--min-gain", arguments->minGain, "Local: stop once no point gains more energy than this")
      ->capture_default_str();
  command->add_option("--max-changes", arguments->maxChanges, "Local: move a point at most so often");
  command
      ->add_option("--points-per-list", arguments->pointsPerList, "Local: points moved before the list is sorted again")
      ->capture_default_str();
  command->add_option("--curvature-extrema", arguments->curvatureExtrema,
                      "Curves: no more than so many curvature extrema, if the tolerance allows");
  command->add_option("--faces", arguments->faces, "Objects to fair: numbers, ranges and names, like 1,3-5,hood");
  command->add_flag("--convert-analytic", arguments->convertAnalytic,
                    "Make planes, cylinders and the like among --faces B-splines first, edges as they are");
  command->add_flag("--no-refine", arguments->noRefine, "Never insert knots, even where no control point is free");
  command->add_flag("--simplify", arguments->simplify,
                    "Afterwards remove knots while tolerance, fairness and the held rows' image hold");
  command->add_flag("--simplify-borders", arguments->simplifyBorders,
                    "The same, and approximate the borders on fewer knots, too, where neighbours can follow");
  command->add_flag("--smooth-knots", arguments->smoothKnots,
                    "First make inner knot lines smooth that are only C0 or C1, within half of the tolerance");
  command
      ->add_option("--crease-angle", arguments->creaseAngle,
                   "Degrees: with --smooth-knots, knot lines with a larger angle are creases and stay")
      ->capture_default_str();
  command->add_option("--report", arguments->report,
                      "Write a page to look at (HTML): before, after, deviation, figures");
  command->add_option("--threads", arguments->threads, "Use at most so many threads; the result does not depend on it");
  command->add_flag("--json", arguments->json, "Print one JSON object instead of the table");
  command->add_flag("--quiet", arguments->quiet, "Print nothing but errors");
  command->footer(
      "Example:\n  strak fair hood.step -o fair.step --tolerance 0.5 --report fair.html\n"
      "Ctrl-C ends early: the best so far is written. A second Ctrl-C ends at once and writes nothing.");
  command->callback([arguments] { fair(*arguments); });
}

}  // namespace strak::cli
