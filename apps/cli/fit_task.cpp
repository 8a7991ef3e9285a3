#include "apps/cli/fit_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <vector>

#include "apps/cli/console.h"
#include "apps/cli/fit_conditions.h"
#include "apps/cli/fit_energy.h"
#include "apps/cli/fit_knots.h"
#include "apps/cli/fit_sheet.h"
#include "apps/cli/fit_start.h"
#include "apps/cli/interrupt.h"
#include "apps/cli/values.h"
#include "strak/base/error.h"
#include "strak/exchange/file_kind.h"
#include "strak/fitting/curve_drawing.h"
#include "strak/fitting/domain_shape.h"
#include "strak/fitting/parameter_correction.h"
#include "strak/fitting/parametrization.h"
#include "strak/fitting/steady_points.h"
#include "strak/fitting/through_points.h"
#include "strak/metrology/closest_points.h"
#include "strak/spline/evaluate.h"

namespace strak::cli {

namespace {

constexpr const char* kChosenScale = "auto";
constexpr double kSettledInNoise = 0.01;  // part of the errors that a round of parameter correction must gain

Smoothing smoothingOf(const FitArguments& arguments) {
  if (!arguments.noise.empty()) {
    if (arguments.smoothing != "auto") throw InvalidInput("--noise chooses the smoothing: leave --smoothing out");
    return Smoothing::noise(positiveNumber("--noise", arguments.noise));
  }
  if (arguments.smoothing == "auto") return Smoothing::automatic();
  if (arguments.smoothing == "reml") return Smoothing::likeliest();
  return Smoothing::fixed(positiveNumber("--smoothing", arguments.smoothing, true));
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

// The options of every fit of this run.
template <int D>
AdaptiveFitOptions<D> optionsOf(const FitArguments& arguments) {
  AdaptiveFitOptions<D> options;
  // What follows the data starts with a plate.
  const bool follows = innerBendingNamed(arguments.energy).has_value();
  if (follows && D == 1) throw InvalidInput("the data-dependent energy is for surfaces: curves have other energies");
  if (!arguments.energy.empty()) options.fit.energy = energyNamed<D>(follows ? "thin-plate" : arguments.energy);
  if (arguments.scale != kChosenScale) options.fit.scale = parameterScaleNamed(arguments.scale);
  options.fit.smoothing = smoothingOf(arguments);
  options.mostPoints = wholeNumber("--most-points", arguments.mostPoints, 1);
  options.share = positiveNumber("--share", arguments.share) / 100;
  if (!arguments.tolerance.empty()) options.fit.tolerance = positiveNumber("--tolerance", arguments.tolerance);
  return options;
}

// What the steps of a fit share; `fit` is the newest and `input` has the parameters that go with it.
template <int D>
struct FitTask {
  const FitArguments& arguments;
  AdaptiveFitOptions<D> options;
  int rounds = 0;  // of parameter correction
  bool refining = false;
  FitInput<D> input{};
  std::array<KnotVector, D> start{};
  Net through{};  // conditions whose parameters are not known yet
  std::optional<DrawnCloud> drawn{};
  std::optional<FitOptions<D>> kept{};  // how the drawn sheet was made again, where any other one folds
  std::vector<Index> steady{};          // with a robust loss, points along a curve that are no outliers
  Fit<D> fit{};
  FitReport report{};

  bool minimax() const { return arguments.loss == "linf"; }
  bool robust() const { return arguments.loss != "l2" && !minimax(); }
  FitPoints<D> points() const { return {input.parameters, input.values, input.weights}; }
};

void requireInMemory(const FitArguments& arguments, int rounds) {
  const char* needing = !arguments.trim.gap.empty() ? "--trim"
                        : rounds > 0                ? "--correct"
                        : arguments.loss != "l2"    ? "--loss"
                                                    : nullptr;
  if (needing == nullptr) return;
  throw InvalidInput(fmt::format("'{}' is too large to be kept in memory, as {} needs: thin the points out",
                                 arguments.input, needing));
}

template <int D>
Fit<D> fitPass(FitTask<D>& task, const PointPass<D>& points, const std::array<KnotVector, D>& knots) {
  if (!task.refining) return fitLeastSquares<D>(knots, task.input.columns, points, task.options.fit);
  AdaptiveFit<D> result = fitWithin<D>(knots, task.input.columns, points, task.options);
  takeOver<D>(result, task.report);
  return std::move(result.fit);
}

// A fit with the wished loss.
template <int D>
Fit<D> fitOnce(FitTask<D>& task, const FitPoints<D>& points, const std::array<KnotVector, D>& knots) {
  if (task.minimax()) {
    MinimaxFitOptions<D> options;
    options.fit = task.options.fit;
    MinimaxFit<D> result = fitMinimax<D>(knots, points, options);
    takeOver<D>(result, task.report);
    return std::move(result.fit);
  }
  if (task.robust()) {
    RobustFitOptions<D> options;
    options.loss = lossNamed(task.arguments.loss);
    options.fit = task.options.fit;
    if (!task.steady.empty()) {
      options.first = Eigen::VectorXd::Zero(points.count());
      options.first(task.steady).setOnes();
    }
    RobustFit<D> result = fitRobustly<D>(knots, points, options);
    takeOver<D>(result, task.arguments.loss, task.report);
    return std::move(result.fit);
  }
  return fitPass<D>(task, passOf<D>(points), knots);
}

// Points without parameters get those on a sheet that is drawn to them.
void drawSheet(FitTask<2>& task, const KnotWishes& wishes) {
  if (!task.arguments.domain.empty()) {
    throw InvalidInput("--domain is for points with parameters: give them, or leave it out");
  }
  // On a net as fine as without a tolerance: coarse cells would pass for folds.
  task.drawn =
      drawOrRefuse(task.points(), startKnots<2>(wishes, task.input, false), task.robust(), task.options.fit.progress);
  task.report.drawing = jsonOf(*task.drawn);
  task.input.parameters = task.drawn->sheet.parameters;
  for (std::size_t k = 0; k < 2; ++k) {
    const KnotVector& domain = task.drawn->sheet.fit.spline.knots()[k];
    task.start[k] = task.start[k].rescaled(domain.from(), domain.to());
  }
}

// Lengths of the polygon along a curve that outliers do not add to.
void setSteadyLengths(FitTask<1>& task) {
  FitInput<1>& input = task.input;
  task.steady = steadyPoints(input.values);
  const Net steady = input.values(task.steady, Eigen::all);
  input.parameters = spreadParameters(task.steady, chordLengthParameters(steady), input.count);
  input.from[0] = input.parameters.minCoeff();
  input.to[0] = input.parameters.maxCoeff();
}

// Points without parameters along a noisy curve get those on a curve that is drawn to them.
void drawCurve(FitTask<1>& task, const KnotWishes& wishes) {
  // On a net as fine as without a tolerance, which starts with few knots.
  const KnotVector fine = startKnots<1>(wishes, task.input, false)[0];
  const CurveDrawingOptions options{fine.degree(), fine.size(), task.robust(), task.options.fit.progress};
  DrawnCurve drawn;
  if (task.steady.empty()) {
    drawn = strak::drawCurve(task.points(), options);
  } else {
    const FitInput<1>& input = task.input;
    const Net parameters = input.parameters(task.steady, Eigen::all), values = input.values(task.steady, Eigen::all);
    Eigen::VectorXd weights;
    if (input.weights.size() > 0) weights = input.weights(task.steady);
    drawn = strak::drawCurve({parameters, values, weights}, options);
    drawn.parameters = spreadParameters(task.steady, drawn.parameters, input.count);
  }
  if (!drawn.drawn) return;
  task.report.drawing = {{"steps", drawn.rms.size()}, {"rms", drawn.rms}};
  task.input.parameters = std::move(drawn.parameters);
  task.start[0] = task.start[0].rescaled(task.input.parameters.minCoeff(), task.input.parameters.maxCoeff());
}

// Fits, with rounds of parameter correction if there are to be any.
template <int D>
void fitCorrected(FitTask<D>& task) {
  CorrectionOptions correction;
  correction.rounds = task.rounds;
  correction.progress = task.options.fit.progress;
  // What small gains are left along a drawn curve make it wind after the noise.
  if (D == 1 && !task.report.drawing.is_null()) correction.settled = kSettledInNoise;
  const FitMaker<D> make = [&](const FitPoints<D>& points, const Fit<D>* previous) {
    return fitOnce<D>(task, points, previous != nullptr ? previous->spline.knots() : task.start);
  };
  CorrectedFit<D> result = fitWithCorrection<D>(task.points(), make, correction);
  task.report.correction = {{"rounds", result.rounds}, {"settled", result.settled}, {"rms", result.rms}};
  task.fit = std::move(result.fit);
  task.input.parameters = std::move(result.parameters);
}

// The fit after the drawing, unless it folds where the drawn sheet does not: then that one.
void keepSheet(FitTask<2>& task) {
  const DrawnSheet& sheet = task.drawn->sheet;
  if (checkSheet(task.fit.spline, task.points(), 0).folded <= sheet.check.folded) return;
  FitOptions<2>& options = task.kept.emplace(task.options.fit);
  options.energy = energyNamed<2>(sheet.fit.summary.energyName);
  options.smoothing = Smoothing::fixed(sheet.fit.summary.lambda);
  options.held = sheet.held;
  options.heldNet = sheet.fit.spline.net();
  task.input.parameters = sheet.parameters;
  task.fit =
      fitLeastSquares<2>(sheet.fit.spline.knots(), {sheet.parameters, task.input.values, sheet.weights}, options);
  FitReport& report = task.report;
  report.loss = report.correction = Json();
  report.outside = Json::array();
  report.rounds = 0;
  report.inserted = report.removed = 0;
  report.reached = report.adaptive && task.fit.summary.insideShare() >= report.share;
}

void warnOfSheet(FitTask<2>& task) {
  std::vector<std::string>& warnings = task.fit.summary.warnings;
  const SheetCheck check =
      task.kept && task.through.rows() == 0 ? task.drawn->sheet.check : checkSheet(task.fit.spline, task.points());
  for (auto& warning : sheetWarnings(check, task.fit.spline)) warnings.push_back(std::move(warning));
  if (!task.kept) return;
  warnings.push_back(fmt::format(
      "with less smoothing than {:.3g} the surface folds: the sheet drawn until then is kept{}",
      task.drawn->sheet.fit.summary.lambda, task.robust() ? ", with an rms in which outliers count less" : ""));
}

// The fit again, through points whose parameters are those of their closest points on it.
template <int D>
void passThrough(FitTask<D>& task) {
  const ConditionalFitMaker<D> make = [&](const Net& parameters, const Fit<D>& previous) {
    task.options.fit.conditionParameters = parameters;
    task.options.fit.conditionValues = task.through;
    if (task.kept) {
      task.kept->conditionParameters = parameters;
      task.kept->conditionValues = task.through;
      return fitLeastSquares<D>(previous.spline.knots(),
                                {task.input.parameters, task.input.values, task.drawn->sheet.weights}, *task.kept);
    }
    if (task.input.streamed) return fitPass<D>(task, task.input.pass, task.start);
    if (task.rounds == 0) return fitOnce<D>(task, task.points(), task.start);
    const Json correction = task.report.correction;
    fitCorrected(task);
    task.report.correction = correction;
    return task.fit;
  };
  const ThroughFit<D> result = fitThrough<D>(task.fit, task.through, make);
  task.fit = result.fit;
  task.report.conditions = {{"count", task.through.rows()},
                            {"largest_before", result.distances.maxCoeff()},
                            {"largest", result.largest},
                            {"rounds", result.rounds}};
}

// Rounds with the energy in the geometry of the fit before.
void followData(FitTask<2>& task, InnerBending bending) {
  task.refining = false;
  const EnergyFitMaker again = [&](const FitOptions<2>& own, const Fit<2>& previous) {
    task.options.fit = own;
    FitInput<2>& input = task.input;
    if (input.streamed) return fitPass<2>(task, input.pass, previous.spline.knots());
    if (task.rounds > 0) {
      input.parameters = closestPointsFrom<2>(previous.spline, input.values, input.parameters).parameters;
    }
    return fitOnce<2>(task, task.points(), previous.spline.knots());
  };
  task.report.following = followEnergy(bending, task.options.fit, again, task.fit);
}

// Where there are no points, heights far beyond theirs are worth a word.
void warnOfGuesses(FitTask<2>& task) {
  constexpr int kLines = 101;
  constexpr double kFar = 1;  // parts of the range of the points' heights
  const Net& values = task.input.values;
  if (values.size() == 0 || !task.arguments.trim.gap.empty()) return;  // of a stream; cut away
  Surface::Grid grid;
  for (std::size_t k = 0; k < 2; ++k) {
    const KnotVector& knots = task.fit.spline.knots()[k];
    for (int i = 0; i < kLines; ++i) grid[k].push_back(std::lerp(knots.from(), knots.to(), i / (kLines - 1.0)));
  }
  const Net heights = derivativesOnGrid<2>(task.fit.spline, grid, 0);
  const double low = values.minCoeff(), high = values.maxCoeff(), far = kFar * (high - low);
  if (!(far > 0) || (heights.minCoeff() >= low - far && heights.maxCoeff() <= high + far)) return;
  task.fit.summary.warnings.push_back(fmt::format(
      "beside the points the surface reaches from {:.4g} to {:.4g}, the points only from {:.4g} to {:.4g}: it "
      "is a guess there; give a smaller --domain, or --trim it",
      heights.minCoeff(), heights.maxCoeff(), low, high));
}

// What is only for surfaces.
void finishSurface(FitTask<2>& task, bool function) {
  const FitArguments& arguments = task.arguments;
  const auto bending = innerBendingNamed(arguments.energy);
  if (bending) followData(task, *bending);
  if (arguments.normals.wanted()) {
    const bool plain = !task.robust() && !task.minimax();
    task.report.normals =
        turnNormals(arguments.normals, task.input, function, task.options.fit, plain ? task.rounds : 0, task.fit);
  }
  if (bending || arguments.normals.wanted()) {
    task.report.reached = task.report.adaptive && task.fit.summary.insideShare() >= task.report.share;
    task.report.outside = Json::array();  // of the fit before
  }
  if (function) warnOfGuesses(task);
}

template <int D>
void write(FitTask<D>& task, const FitColumns& columns) {
  const Spline<D>& spline = task.fit.spline;
  FitReport& report = task.report;
  report.summary = task.fit.summary;
  if (task.input.repeated > 0) {
    report.summary.warnings.push_back(
        fmt::format("{} points repeat others to the last digit: they count with their number, but as one measurement",
                    task.input.repeated));
  }
  for (int k = 0; k < D; ++k) {
    report.degree.push_back(spline.degree(k));
    report.size.push_back(spline.size(k));
  }
  const bool function = columns.kind == FitKind::function;
  report.kind = kindName(columns.kind);
  const auto inSpace = function ? graphOf<D>(spline) : spline;
  const FitArguments& arguments = task.arguments;
  const std::string name = std::filesystem::path(arguments.input).stem().string();
  if constexpr (D == 2) {
    if (!arguments.trim.gap.empty()) {
      report.trimming = writeTrimmedFit(arguments.trim, arguments.output, inSpace, task.input.parameters, function,
                                        name, report.summary.warnings);
      return;
    }
  }
  modelOf({inSpace}, {name})->write(arguments.output);
}

}  // namespace

template <int D>
FitReport fitAndWrite(const FitArguments& arguments, const PointFile& file, const FitColumns& columns) {
  FitTask<D> task{arguments, optionsOf<D>(arguments), correctionRounds(arguments, columns)};
  task.through =
      takeConditions<D>({arguments.conditions, arguments.columns, arguments.input}, columns, task.options.fit);
  task.refining = task.report.adaptive = !arguments.tolerance.empty();
  task.report.tolerance = task.options.fit.tolerance;
  task.report.share = task.options.share;
  if (task.refining && arguments.loss != "l2") {
    throw InvalidInput("--tolerance refines fits of least squares: leave --loss out, or give the --size");
  }
  if (task.robust()) lossNamed(arguments.loss);  // refused before the file is read

  task.input = fitInput<D>(file, columns,
                           static_cast<std::uintmax_t>(wholeNumber("--memory", arguments.memory, 0, 1 << 30)) << 20);
  task.report.streamed = task.input.streamed;
  if (task.input.streamed) requireInMemory(arguments, task.rounds);
  const auto given = startSpline<D>(arguments.start, columns);
  if (given && task.refining) throw InvalidInput("--start gives the knots: leave --tolerance out");
  if (given) holdBorder<D>(*given, arguments.hold, task.options.fit);
  if (given && columns.parameters.empty()) parametersOn<D>(*given, task.input);
  if constexpr (D == 1) {
    if (task.robust() && columns.parameters.empty() && !given) setSteadyLengths(task);
  }
  includeConditions<D>(task.options.fit, task.input);
  const KnotWishes wishes{arguments.degree, arguments.size, arguments.domain, arguments.mostPoints};
  task.start = given ? given->knots() : startKnots<D>(wishes, task.input, task.refining);
  ProgressBar bar({1.0}, !arguments.json && !arguments.quiet, interrupted);
  task.options.fit.progress = bar.task(0);

  if constexpr (D == 2) {
    const bool isWeightGiven = task.options.fit.smoothing.choice == Smoothing::Choice::fixed;
    if (columns.kind == FitKind::function && arguments.scale == kChosenScale && !isWeightGiven) {
      const auto pass = task.input.streamed ? task.input.pass : passOf<2>(task.points());
      task.options.fit.scale = shapeFor(task.start, task.input.columns, pass, task.options.fit);
    }
  }
  task.report.scale = arguments.scale != kChosenScale                  ? arguments.scale
                      : task.options.fit.scale == ParameterScale::unit ? "unit"
                                                                       : "lengths";
  if (columns.parameters.empty() && task.rounds > 0 && !given) {
    if constexpr (D == 1) {
      if (arguments.domain.empty()) drawCurve(task, wishes);
    } else {
      drawSheet(task, wishes);
    }
  }
  if (task.input.streamed) {
    task.fit = fitPass<D>(task, task.input.pass, task.start);
  } else if (task.rounds == 0) {
    task.fit = fitOnce<D>(task, task.points(), task.start);
  } else {
    fitCorrected(task);
  }
  if constexpr (D == 2) {
    if (task.drawn) keepSheet(task);
  }
  if (task.through.rows() > 0) passThrough(task);
  if constexpr (D == 2) {
    if (task.drawn) warnOfSheet(task);
    finishSurface(task, columns.kind == FitKind::function);
  }
  write(task, columns);
  return std::move(task.report);
}

template FitReport fitAndWrite<1>(const FitArguments&, const PointFile&, const FitColumns&);
template FitReport fitAndWrite<2>(const FitArguments&, const PointFile&, const FitColumns&);

}  // namespace strak::cli
