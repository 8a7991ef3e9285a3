// strak fit: a fair spline near measured points.

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/fit_energy.h"
#include "apps/cli/fit_knots.h"
#include "apps/cli/fit_normals.h"
#include "apps/cli/fit_points.h"
#include "apps/cli/fit_report.h"
#include "apps/cli/fit_sheet.h"
#include "apps/cli/fit_start.h"
#include "apps/cli/fit_trim.h"
#include "apps/cli/interrupt.h"
#include "apps/cli/json.h"
#include "apps/cli/values.h"
#include "strak/base/error.h"
#include "strak/exchange/file_kind.h"
#include "strak/fitting/adaptive_fit.h"
#include "strak/fitting/minimax_fit.h"
#include "strak/fitting/parameter_correction.h"
#include "strak/fitting/robust_fit.h"
#include "strak/metrology/closest_points.h"

namespace strak::cli {

namespace {

struct FitArguments {
  std::string input, output, kind, columns, degree = "3", size, domain, smoothing = "auto", noise, tolerance,
                                            share = "100", energy, scale = "lengths", conditions, start, hold,
                                            loss = "l2", correct, mostPoints = "40000", memory = "512", threads;
  NormalArguments normals;
  TrimArguments trim;
  bool json = false, quiet = false;
  std::string commandLine;
};

Smoothing smoothingOf(const FitArguments& arguments) {
  if (!arguments.noise.empty()) {
    if (arguments.smoothing != "auto") throw InvalidInput("--noise chooses the smoothing: leave --smoothing out");
    return Smoothing::noise(positiveNumber("--noise", arguments.noise));
  }
  if (arguments.smoothing == "auto") return Smoothing::automatic();
  if (arguments.smoothing == "reml") return Smoothing::likeliest();
  return Smoothing::fixed(positiveNumber("--smoothing", arguments.smoothing, true));
}

template <int D>
void addConditions(const FitArguments& arguments, const FitColumns& columns, FitOptions<D>& options) {
  if (arguments.conditions.empty()) return;
  if (columns.parameters.empty()) {
    throw InvalidInput("--conditions needs parameters: a function, or points with columns t, or u and v");
  }
  const PointFile file = pointFile(arguments.conditions, arguments.columns);
  const FitColumns own = fitColumns(file, arguments.kind);
  if (own.parameters.size() != columns.parameters.size() || own.values.size() != columns.values.size()) {
    throw InvalidInput(fmt::format("'{}' must have the same columns as '{}'", arguments.conditions, arguments.input));
  }
  const Net rows = readPoints(file);
  options.conditionParameters.resize(rows.rows(), D);
  options.conditionValues.resize(rows.rows(), static_cast<Index>(own.values.size()));
  for (Index k = 0; k < D; ++k) {
    options.conditionParameters.col(k) = rows.col(own.parameters[static_cast<std::size_t>(k)]);
  }
  for (Index k = 0; k < options.conditionValues.cols(); ++k) {
    options.conditionValues.col(k) = rows.col(own.values[static_cast<std::size_t>(k)]);
  }
}

// How many rounds of parameter correction: only points that come without parameters are corrected unasked.
int correctionRounds(const FitArguments& arguments, const FitColumns& columns) {
  constexpr int kUnasked = 10;
  if (arguments.correct.empty()) return columns.parameters.empty() ? kUnasked : 0;
  const auto rounds = static_cast<int>(wholeNumber("--correct", arguments.correct, 0, 100000));
  if (rounds > 0 && columns.kind == FitKind::function) {
    throw InvalidInput("--correct is for points in space: those of a function have their parameters");
  }
  return rounds;
}

// The fit after the drawing, unless it folds where the drawn sheet does not: then that one.
// Returns the parameters that go with it.
Net keepSheet(const DrawnCloud& drawn, const FitPoints<2>& points, FitOptions<2> options, Fit<2>& fit,
              FitReport& report) {
  const DrawnSheet& sheet = drawn.sheet;
  SheetCheck check = checkSheet(fit.spline, points);
  std::string folded;
  Net parameters = points.parameters;
  if (check.folded > sheet.check.folded) {
    folded = fmt::format("with less smoothing than {:.3g} the surface folds: the sheet drawn until then is kept",
                         sheet.fit.summary.lambda);
    options.energy = energyNamed<2>(sheet.fit.summary.energyName);
    options.smoothing = Smoothing::fixed(sheet.fit.summary.lambda);
    options.held = sheet.held;
    options.heldNet = sheet.fit.spline.net();
    fit = fitLeastSquares<2>(sheet.fit.spline.knots(), {sheet.parameters, points.values, points.weights}, options);
    check = sheet.check;
    parameters = sheet.parameters;
    report.loss = report.correction = Json();
    report.outside = Json::array();
    report.rounds = 0;
    report.inserted = report.removed = 0;
    report.reached = report.adaptive && fit.summary.insideShare() >= report.share;
  }
  for (auto& warning : sheetWarnings(check, fit.spline)) fit.summary.warnings.push_back(std::move(warning));
  if (!folded.empty()) fit.summary.warnings.push_back(std::move(folded));
  return parameters;
}

template <int D>
FitReport fitAndWrite(const FitArguments& arguments, const PointFile& file, const FitColumns& columns) {
  AdaptiveFitOptions<D> options;
  const auto bending = innerBendingNamed(arguments.energy);
  if (bending && D == 1) throw InvalidInput("the data-dependent energy is for surfaces: curves have other energies");
  // What follows the data starts with a plate.
  if (!arguments.energy.empty()) options.fit.energy = energyNamed<D>(bending ? "thin-plate" : arguments.energy);
  options.fit.scale = parameterScaleNamed(arguments.scale);
  options.fit.smoothing = smoothingOf(arguments);
  options.mostPoints = wholeNumber("--most-points", arguments.mostPoints, 1);
  options.share = positiveNumber("--share", arguments.share) / 100;
  addConditions<D>(arguments, columns, options.fit);
  FitReport report;
  report.adaptive = !arguments.tolerance.empty();
  if (report.adaptive) options.fit.tolerance = positiveNumber("--tolerance", arguments.tolerance);
  report.tolerance = options.fit.tolerance;
  report.share = options.share;
  RobustFitOptions<D> robust;
  const bool isMinimax = arguments.loss == "linf", isRobust = arguments.loss != "l2" && !isMinimax;
  if (isRobust) robust.loss = lossNamed(arguments.loss);
  if ((isRobust || isMinimax) && report.adaptive) {
    throw InvalidInput("--tolerance refines fits of least squares: leave --loss out, or give the --size");
  }
  const int rounds = correctionRounds(arguments, columns);

  FitInput<D> input = fitInput<D>(
      file, columns, static_cast<std::uintmax_t>(wholeNumber("--memory", arguments.memory, 0, 1 << 30)) << 20);
  report.streamed = input.streamed;
  const bool trim = !arguments.trim.gap.empty();
  if (input.streamed && (isRobust || isMinimax || rounds > 0 || trim)) {
    throw InvalidInput(fmt::format("'{}' is too large to be kept in memory, as {} needs: thin the points out",
                                   arguments.input,
                                   trim         ? "--trim"
                                   : rounds > 0 ? "--correct"
                                                : "--loss"));
  }
  const auto given = startSpline<D>(arguments.start, columns);
  if (given && report.adaptive) throw InvalidInput("--start gives the knots: leave --tolerance out");
  if (given) holdBorder<D>(*given, arguments.hold, options.fit);
  if (given && columns.parameters.empty()) parametersOn<D>(*given, input);
  const KnotWishes wishes{arguments.degree, arguments.size, arguments.domain, arguments.mostPoints};
  auto start = given ? given->knots() : startKnots<D>(wishes, input, report.adaptive);
  ProgressBar bar({1.0}, !arguments.json && !arguments.quiet, interrupted);
  options.fit.progress = bar.task(0);
  robust.fit = options.fit;
  bool refining = report.adaptive;
  const auto fitPass = [&](const PointPass<D>& points, const std::array<KnotVector, D>& knots) {
    if (!refining) return fitLeastSquares<D>(knots, input.columns, points, options.fit);
    AdaptiveFit<D> result = fitWithin<D>(knots, input.columns, points, options);
    takeOver<D>(result, report);
    return std::move(result.fit);
  };
  const FitMaker<D> make = [&](const FitPoints<D>& points, const Fit<D>* previous) {
    const auto& knots = previous != nullptr ? previous->spline.knots() : start;
    if (isMinimax) {
      MinimaxFitOptions<D> minimax;
      minimax.fit = options.fit;
      MinimaxFit<D> result = fitMinimax<D>(knots, points, minimax);
      takeOver<D>(result, report);
      return std::move(result.fit);
    }
    if (!isRobust) return fitPass(passOf<D>(points), knots);
    RobustFit<D> result = fitRobustly<D>(knots, points, robust);
    takeOver<D>(result, arguments.loss, report);
    return std::move(result.fit);
  };
  std::optional<DrawnCloud> drawn;
  if constexpr (D == 2) {
    if (columns.parameters.empty() && rounds > 0 && !given) {
      if (!arguments.domain.empty()) {
        throw InvalidInput("--domain is for points with parameters: give them, or leave it out");
      }
      // On a net as fine as without a tolerance: coarse cells would pass for folds.
      drawn = drawOrRefuse({input.parameters, input.values, input.weights}, startKnots<D>(wishes, input, false),
                           options.fit.progress);
      report.drawing = jsonOf(*drawn);
      input.parameters = drawn->sheet.parameters;
      for (std::size_t k = 0; k < D; ++k) {
        const KnotVector& domain = drawn->sheet.fit.spline.knots()[k];
        start[k] = start[k].rescaled(domain.from(), domain.to());
      }
    }
  }
  Fit<D> fit;
  if (input.streamed) {
    fit = fitPass(input.pass, start);
  } else if (rounds == 0) {
    fit = make({input.parameters, input.values, input.weights}, nullptr);
  } else {
    CorrectionOptions correction;
    correction.rounds = rounds;
    correction.progress = options.fit.progress;
    CorrectedFit<D> result = fitWithCorrection<D>({input.parameters, input.values, input.weights}, make, correction);
    report.correction = {{"rounds", result.rounds}, {"settled", result.settled}, {"rms", result.rms}};
    fit = std::move(result.fit);
    input.parameters = std::move(result.parameters);
    if constexpr (D == 2) {
      if (drawn) {
        input.parameters = keepSheet(*drawn, {input.parameters, input.values, input.weights}, options.fit, fit, report);
      }
    }
  }
  if constexpr (D == 2) {
    if (bending) {
      refining = false;
      const EnergyFitMaker again = [&](const FitOptions<2>& own, const Fit<2>& previous) {
        options.fit = robust.fit = own;
        if (input.streamed) return fitPass(input.pass, previous.spline.knots());
        if (rounds > 0) {
          input.parameters = closestPointsFrom<2>(previous.spline, input.values, input.parameters).parameters;
        }
        return make({input.parameters, input.values, input.weights}, &previous);
      };
      report.following = followEnergy(*bending, options.fit, again, fit);
    }
    if (arguments.normals.wanted()) {
      const bool function = columns.kind == FitKind::function;
      report.normals =
          turnNormals(arguments.normals, input, function, options.fit, isRobust || isMinimax ? 0 : rounds, fit);
    }
    if (bending || arguments.normals.wanted()) {
      report.reached = report.adaptive && fit.summary.insideShare() >= report.share;
      report.outside = Json::array();  // of the fit before
    }
  }
  report.summary = fit.summary;
  if (input.repeated > 0) {
    report.summary.warnings.push_back(
        fmt::format("{} points repeat others to the last digit: they count with their number, but as one measurement",
                    input.repeated));
  }
  for (int k = 0; k < D; ++k) {
    report.degree.push_back(fit.spline.degree(k));
    report.size.push_back(fit.spline.size(k));
  }
  const bool function = columns.kind == FitKind::function;
  report.kind = function ? "function" : D == 1 ? "curve" : "surface";
  const auto spline = function ? graphOf<D>(fit.spline) : fit.spline;
  const std::string name = std::filesystem::path(arguments.input).stem().string();
  if constexpr (D == 2) {
    if (!arguments.trim.gap.empty()) {
      report.trimming = writeTrimmedFit(arguments.trim, arguments.output, spline, input.parameters,
                                        lengthsOfUnits(fit.spline), name, report.summary.warnings);
      return report;
    }
  }
  modelOf({spline}, {name})->write(arguments.output);
  return report;
}

// A surface instead of points.
void turn(const FitArguments& a) {
  for (const auto& [option, value] : {std::pair{"--kind", a.kind},
                                      {"--size", a.size},
                                      {"--domain", a.domain},
                                      {"--noise", a.noise},
                                      {"--tolerance", a.tolerance},
                                      {"--conditions", a.conditions},
                                      {"--correct", a.correct},
                                      {"--energy", a.energy},
                                      {"--trim", a.trim.gap},
                                      {"--loss", a.loss == "l2" ? std::string() : a.loss}}) {
    if (!value.empty()) throw InvalidInput(fmt::format("{} is for points: '{}' holds a surface", option, a.input));
  }
  turnSurface(a.normals, {a.input, a.output, a.smoothing, a.commandLine, a.json, a.quiet});
}

void fit(const FitArguments& arguments) {
  const Stopwatch watch;
  requireWritable(arguments.output);
  fileKindOfEnding(arguments.output);
  std::optional<tbb::global_control> threads;
  if (!arguments.threads.empty()) {
    threads.emplace(tbb::global_control::max_allowed_parallelism,
                    static_cast<std::size_t>(wholeNumber("--threads", arguments.threads, 1)));
  }
  catchInterrupt();
  if (arguments.normals.wanted() && holdsSplines(arguments.input)) return turn(arguments);
  const PointFile file = pointFile(arguments.input, arguments.columns);
  const FitColumns columns = fitColumns(file, arguments.kind);
  if (arguments.normals.wanted() && columns.directions == 1) {
    throw InvalidInput("--normals is for surfaces and functions of two variables, not for curves");
  }
  requireTrimmable(arguments.trim, arguments.output, columns.directions);
  const FitReport report =
      columns.directions == 1 ? fitAndWrite<1>(arguments, file, columns) : fitAndWrite<2>(arguments, file, columns);
  for (const auto& warning : report.summary.warnings) {
    if (!arguments.json) fmt::print(stderr, "strak: warning: {}\n", warning);
  }
  if (arguments.json) {
    Json json = jsonHead(arguments.commandLine, {arguments.input});
    json["output"] = arguments.output;
    json["objects"] = Json::array({jsonOf(report)});
    json["seconds"] = watch.seconds();
    printJson(json);
  } else if (!arguments.quiet) {
    print(report, arguments.output, watch.seconds());
  }
}

}  // namespace

void addFit(CLI::App& program, const std::string& commandLine) {
  auto arguments = std::make_shared<FitArguments>();
  arguments->commandLine = commandLine;
  CLI::App* command = program.add_subcommand("fit", "Fit measured points with a fair curve or surface");
  command
      ->add_option(
          "POINTS", arguments->input,
          "Table of numbers (.xyz, .csv, .txt, .dat), heights on a grid (.asc, .dem, .gtx), point cloud (PLY, PCD) or "
          "vertices of a mesh (OBJ, STL, OFF)")
      ->required();
  command->add_option("-o,--output", arguments->output, "File to write; its ending says the format")->required();
  command->add_option(
      "--kind", arguments->kind,
      "function: the last coordinate over the others; surface: a sheet in space (columns u, v, x, y, z, or "
      "x, y, z deep-drawn from their plane); curve: points in their order. Default: by the columns");
  command->add_option("--columns", arguments->columns,
                      "Which columns of the table count, and in which order: numbers from 1, like 1,3; default: all");
  command->add_option("--degree", arguments->degree, "P or P,Q")->capture_default_str();
  command->add_option(
      "--size", arguments->size,
      "Control points, N or NxM; default: one for four points, at most 50 a direction (curves: 200); with "
      "--tolerance where the refinement starts");
  command->add_option("--domain", arguments->domain, "U0,U1,V0,V1; default: the box of the points");
  command
      ->add_option("--smoothing", arguments->smoothing,
                   "auto (cross validation), reml (restricted likelihood), or the weight of the energy")
      ->capture_default_str();
  command->add_option("--noise", arguments->noise,
                      "The standard deviation of a coordinate's error: smooth until the errors have it");
  command->add_option("--tolerance", arguments->tolerance,
                      "Refine the knots until the errors are within this length, then remove those not needed");
  command->add_option("--share", arguments->share, "With --tolerance: percent of the points that must be within")
      ->capture_default_str();
  command->add_option("--most-points", arguments->mostPoints, "At most so many control points")->capture_default_str();
  command
      ->add_option("--loss", arguments->loss,
                   "l2 (least squares); what outliers do not move: huber, tukey, l1 (with a certified gap); linf: the "
                   "largest error is least (with a certified gap)")
      ->capture_default_str();
  command->add_option("--correct", arguments->correct,
                      "Points in space: at most so many rounds of parameter correction; default: 10 if the points come "
                      "without parameters, else 0");
  command->add_option("--energy", arguments->energy,
                      "thin-plate, laplacian, third-order, laplacian-gradient, third-derivatives, q3, or a mixture; "
                      "data-dependent or data-dependent-plate: bending in the geometry of the fit before; "
                      "default: third-derivatives, for lower degrees the highest there is");
  command
      ->add_option("--parameter-scale", arguments->scale,
                   "In which shape of the domain the energy is measured: "
                   "lengths, domain or unit")
      ->capture_default_str();
  addNormalOptions(*command, arguments->normals);
  command->add_option("--conditions", arguments->conditions, "File of points that the result passes through exactly");
  CLI::Option* start = command->add_option(
      "--start", arguments->start, "File with a spline whose knots the fit takes, and whose border it keeps (--hold)");
  for (const char* other : {"--size", "--degree", "--domain"}) start->excludes(other);
  command->add_option("--hold", arguments->hold, "Rows of --start that stay: g0 (default), g1, g2, N, or one an end")
      ->needs(start);
  addTrimOptions(*command, arguments->trim);
  command
      ->add_option("--memory", arguments->memory,
                   "Files of more megabytes are read again whenever their points are needed, block by block")
      ->capture_default_str();
  command->add_option("--threads", arguments->threads, "Use at most so many threads; the result does not depend on it");
  command->add_flag("--json", arguments->json, "Print one JSON object");
  command->add_flag("--quiet", arguments->quiet, "Print nothing but errors and warnings");
  command->footer("Example:\n  strak fit scan.xyz -o scan.step --tolerance 0.05 --share 99");
  command->callback([arguments] { fit(*arguments); });
}

}  // namespace strak::cli
