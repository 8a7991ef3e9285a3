#include "apps/cli/fit_normals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "apps/cli/console.h"
#include "apps/cli/model_editor.h"
#include "apps/cli/values.h"
#include "strak/base/error.h"
#include "strak/base/file.h"
#include "strak/exchange/file_kind.h"
#include "strak/exchange/g2.h"
#include "strak/fairing/held_points.h"
#include "strak/fitting/parameter_correction.h"
#include "strak/fitting/prescribed_normals.h"
#include "strak/metrology/closest_points.h"
#include "strak/metrology/deviation.h"
#include "strak/metrology/self_intersection.h"

namespace strak::cli {

namespace {

// The column of the first of these names that there is, or -1.
Index columnOf(const PointFile& file, const std::vector<std::string>& names) {
  for (const auto& name : names) {
    if (const Index column = file.columnNamed(name); column >= 0) return column;
  }
  return -1;
}

// u v nx ny nz, or x y z nx ny nz, by the names of the columns or by their number.
WishedNormals readNormals(const std::string& path, bool function) {
  const PointFile file(path);
  std::vector<Index> parameters{columnOf(file, {"u"}), columnOf(file, {"v"})};
  std::vector<Index> place{columnOf(file, {"x"}), columnOf(file, {"y"}), columnOf(file, {"z"})};
  std::vector<Index> normal{columnOf(file, {"nx", "normal_x"}), columnOf(file, {"ny", "normal_y"}),
                            columnOf(file, {"nz", "normal_z"})};
  const auto missing = [](const std::vector<Index>& columns) {
    return std::find(columns.begin(), columns.end(), -1) != columns.end();
  };
  if (file.names().empty()) {
    if (file.columns() == 5) {
      parameters = {0, 1};
      normal = {2, 3, 4};
    } else if (file.columns() == 6) {
      place = {0, 1, 2};
      normal = {3, 4, 5};
    }
  }
  // Over a plane the place says where.
  if (function && missing(parameters)) parameters = {place[0], place[1]};
  if (missing(normal) || (missing(parameters) && missing(place))) {
    throw InvalidInput(fmt::format(
        "'{}' has {} columns, but normals need five (u v nx ny nz), six (x y z nx ny nz), or a header with these names",
        path, file.columns()));
  }
  const Net rows = readPoints(file);
  WishedNormals wished;
  const auto chosen = [&](const std::vector<Index>& columns) {
    Net result(rows.rows(), static_cast<Index>(columns.size()));
    for (std::size_t k = 0; k < columns.size(); ++k) result.col(static_cast<Index>(k)) = rows.col(columns[k]);
    return result;
  };
  wished.normals = chosen(normal);
  if (missing(parameters)) {
    wished.places = chosen(place);
  } else {
    wished.parameters = chosen(parameters);
  }
  if (const Index weight = columnOf(file, {"weight", "w"}); weight >= 0) wished.weights = rows.col(weight);
  return wished;
}

NormalOptions optionsOf(const NormalArguments& arguments) {
  NormalOptions options;
  if (!arguments.weight.empty()) options.weight = positiveNumber("--normals-weight", arguments.weight);
  options.degrees = positiveNumber("--normals-angle", arguments.angle);
  return options;
}

Json jsonOf(const NormalFit& turned, const NormalOptions& options) {
  const Index count = turned.angles.size();
  const double rmsBefore = std::sqrt(turned.anglesBefore.squaredNorm() / static_cast<double>(count));
  Json json{{"count", count},
            {"stop", normalStopName(turned.stop)},
            {"rounds", turned.rounds},
            {"weight", turned.weight},
            {"angle",
             {{"wished", options.weight > 0 ? Json() : Json(options.degrees)},
              {"largest_before", turned.anglesBefore.maxCoeff()},
              {"rms_before", rmsBefore},
              {"largest", turned.largest},
              {"rms", turned.rms}}},
            {"worst",
             {{"normal", turned.worst + 1},
              {"at", {turned.parameters(turned.worst, 0), turned.parameters(turned.worst, 1)}}}},
            {"larger_than_wished", (turned.angles.array() > options.degrees).count()},
            {"opposite", turned.opposite}};
  return json;
}

std::vector<std::string> warningsOf(const NormalFit& turned, const NormalOptions& options) {
  std::vector<std::string> warnings;
  if (turned.stop == NormalStop::contradictory || turned.stop == NormalStop::rounds) {
    warnings.push_back(fmt::format(
        "{} of {} normals are left with more than {:g} degrees, the worst, number {}, with {:.4g}: {}; use more "
        "control points, fewer normals, or a --normals-weight",
        (turned.angles.array() > options.degrees).count(), turned.angles.size(), options.degrees, turned.worst + 1,
        turned.largest,
        turned.stop == NormalStop::rounds ? "the rounds are used up"
                                          : "the control points cannot turn the surface so everywhere"));
  }
  if (turned.opposite > 0) {
    warnings.push_back(
        fmt::format("{} of {} normals point to the other side of the surface than the rest: taken as "
                    "turned round",
                    turned.opposite, turned.angles.size()));
  }
  return warnings;
}

}  // namespace

void addNormalOptions(CLI::App& command, NormalArguments& arguments) {
  command.add_option("--normals", arguments.file,
                     "File of normals that the result shall have: rows u v nx ny nz, or x y z nx ny nz (there, or at "
                     "the closest point). Instead of points a file with one surface may be given: it stays as it is, "
                     "but for its normals");
  command.add_option("--normals-weight", arguments.weight,
                     "Of the mean squared sine of the angles left, times the area, against the mean squared error; "
                     "default: as large as --normals-angle needs");
  command.add_option("--normals-angle", arguments.angle, "The largest angle that may be left, in degrees")
      ->capture_default_str();
  command.add_option("--normals-hold", arguments.hold,
                     "Of a surface that is given: rows of control points at its borders that stay, as --hold of fair");
}

Json turnNormals(const NormalArguments& arguments, const FitInput<2>& input, bool function, FitOptions<2> options,
                 int correctionRounds, Fit<2>& fit) {
  if (!arguments.hold.empty()) throw InvalidInput("--normals-hold is for a surface that is given, not for points");
  const WishedNormals wished = readNormals(arguments.file, function);
  NormalOptions own = optionsOf(arguments);
  own.held = options.held;
  own.conditions = options.conditionParameters;
  own.progress = options.progress;
  const double rmsBefore = fit.summary.rms, maxBefore = fit.summary.max;
  std::vector<NormalFit> rounds;  // of the correction; the last of them may be one that is not taken
  std::size_t taken = 0;
  const auto turn = [&](const Fit<2>& plain, const PointPass<2>& points) {
    rounds.push_back(prescribeNormals(plain, wished, own));
    takeErrors<2>(rounds.back().fit, points, options.tolerance);
    return rounds.back().fit;
  };
  if (input.streamed) {
    fit = turn(fit, input.pass);
  } else if (function || correctionRounds == 0) {
    fit = turn(fit, passOf<2>({input.parameters, input.values, input.weights}));
  } else {
    options.smoothing = Smoothing::fixed(fit.summary.lambda);
    const Fit<2> first = fit;
    const FitMaker<2> make = [&](const FitPoints<2>& points, const Fit<2>* previous) {
      return turn(previous == nullptr ? first : fitLeastSquares<2>(first.spline.knots(), points, options),
                  passOf<2>(points));
    };
    const Net parameters = closestPointsFrom<2>(fit.spline, input.values, input.parameters).parameters;
    CorrectionOptions correction;
    correction.rounds = correctionRounds;
    correction.progress = options.progress;
    CorrectedFit<2> corrected = fitWithCorrection<2>({parameters, input.values, input.weights}, make, correction);
    const auto warnings = fit.summary.warnings;
    fit = std::move(corrected.fit);
    fit.summary.warnings = warnings;
    taken = static_cast<std::size_t>(corrected.rounds);
  }
  for (auto& warning : warningsOf(rounds[taken], own)) fit.summary.warnings.push_back(std::move(warning));
  Json json = jsonOf(rounds[taken], own);
  json["errors_before"] = {{"rms", rmsBefore}, {"max", maxBefore}};
  return json;
}

std::string describeNormals(const Json& normals) {
  const Json& angle = normals["angle"];
  return fmt::format("normals     {}: {}, largest angle {} degrees ({} before), rms {}\n", normals["count"].dump(),
                     normals["stop"].get<std::string>(), number(angle["largest"].get<double>()),
                     number(angle["largest_before"].get<double>()), number(angle["rms"].get<double>()));
}

bool holdsSplines(const std::string& path) {
  try {
    const FileKind kind = fileKindOfEnding(path);
    return kind == FileKind::g2 ? !beginsWithG2Cloud(readFile(path)) : kind != FileKind::points;
  } catch (const InvalidInput&) {
    return false;
  }
}

void turnSurface(const NormalArguments& arguments, const SurfaceTask& task) {
  const Stopwatch watch;
  const std::string& input = task.input;
  const auto model = readModel(input);
  if (model->objects().size() != 1 || !model->objects()[0].spline ||
      !std::holds_alternative<Surface>(*model->objects()[0].spline)) {
    throw InvalidInput(fmt::format("'{}' must hold one B-spline surface and nothing else for --normals", input));
  }
  const Object& object = model->objects()[0];
  if (!object.leftAlone.empty())
    throw InvalidInput(fmt::format("'{}' stays as it is: {}", object.name, object.leftAlone));
  const Surface surface = std::get<Surface>(*object.spline);  // replacing changes that of the model
  const WishedNormals wished = readNormals(arguments.file, false);
  NormalOptions options = optionsOf(arguments);
  if (!arguments.hold.empty()) {
    const std::vector<Index> rows = holdRows(arguments.hold);
    if (rows.size() != 1 && rows.size() != 4) {
      throw InvalidInput(
          fmt::format("--normals-hold is '{}': give one number, or one for each of four sides", arguments.hold));
    }
    std::array<Index, 4> sides;
    for (std::size_t k = 0; k < 4; ++k) sides[k] = rows[rows.size() == 1 ? 0 : k];
    const HeldPoints held = holdStrips<2>(surface, sides);
    for (std::size_t r = 0; r < held.size(); ++r) {
      if (held[r] != 0) options.held.push_back(static_cast<Index>(r));
    }
  }
  const double lambda =
      task.smoothing == "auto" ? naturalSmoothing(surface) : positiveNumber("--smoothing", task.smoothing, true);
  const NormalFit turned = prescribeNormals(fitOfSurface(surface, lambda), wished, options);
  const Surface& after = turned.fit.spline;

  const Audit audit = model->audit();
  std::vector<FairedObject> entries{describe(object)};
  entries[0].after = after;
  entries[0].newMeeting = meetingAfterMove(surface, after).isNew;
  ModelEditor(*model, audit, entries).accept({{0}}, options.held.empty());
  if (!entries[0].faired()) {
    throw Failure(fmt::format("'{}' cannot be turned so: {}", object.name, entries[0].leftAlone));
  }
  model->write(task.output);
  const auto deviation = certifyDeviation<2>(surface, after);
  const auto warnings = warningsOf(turned, options);
  const Json normals = jsonOf(turned, options);
  if (task.json) {
    Json json = jsonHead(task.commandLine, {input});
    json["output"] = task.output;
    json["objects"] = Json::array({{{"name", object.name},
                                    {"kind", "surface"},
                                    {"degree", {after.degree(0), after.degree(1)}},
                                    {"points", {after.size(0), after.size(1)}},
                                    {"smoothing", {{"lambda", lambda}}},
                                    {"normals", normals},
                                    {"deviation", {{"lower", deviation.lower}, {"certified", deviation.upper}}},
                                    {"warnings", warnings}}});
    json["seconds"] = watch.seconds();
    printJson(json);
    return;
  }
  for (const auto& warning : warnings) fmt::print(stderr, "strak: warning: {}\n", warning);
  if (task.quiet) return;
  fmt::print("{} of degree {}x{} with {}x{} control points\n{}deviation   certified at most {}\nwrote {} in {}\n",
             object.name, after.degree(0), after.degree(1), after.size(0), after.size(1), describeNormals(normals),
             number(deviation.upper), task.output, duration(watch.seconds()));
}

}  // namespace strak::cli
