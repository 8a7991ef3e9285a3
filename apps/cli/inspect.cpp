// strak inspect: how far measured points are from curves and surfaces, and which form these have.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/fit_points.h"
#include "apps/cli/json.h"
#include "apps/cli/values.h"
#include "strak/base/error.h"
#include "strak/base/file.h"
#include "strak/metrology/height_figures.h"
#include "strak/metrology/point_deviation.h"
#include "strak/report/curve_plot.h"
#include "strak/report/drawing.h"

namespace strak::cli {

namespace {

struct InspectArguments {
  std::string points, model, columns, along, tolerance, remove, faces, picture, view, size = "900x700", range;
  bool json = false;
  std::string commandLine;
};

// What is taken away from heights before their figures are taken.
struct Removal {
  bool sphere = false;
  int degree = 0;  // of the polynomial
};

struct Inspection {
  Net points;
  PointDeviation deviation;
  bool heights = false;
  double rms = 0, mean = 0, lowest = 0, highest = 0;
  Index worst = 0, measured = 0, inside = 0;
  std::optional<double> tolerance;
  std::optional<HeightFigures> modelForm, pointForm;  // of where the points are, without what --remove names
};

Removal removalNamed(const std::string& word) {
  if (word == "sphere") return {true, 0};
  if (word == "mean") return {false, 0};
  if (word == "plane") return {false, 1};
  if (word == "quadric") return {false, 2};
  throw InvalidInput(
      fmt::format("--remove cannot be '{}': choose mean, plane (of profiles: a line), quadric (a "
                  "parabola) or sphere (a circle)",
                  word));
}

bool alongHeights(const std::string& word, const std::vector<Object>& objects) {
  if (word == "height") return true;
  if (word == "normal") return false;
  if (!word.empty()) throw InvalidInput(fmt::format("--along cannot be '{}': choose height or normal", word));
  return std::all_of(objects.begin(), objects.end(), [](const Object& object) {
    return std::visit(
        []<int D>(const Spline<D>& spline) {
          if constexpr (D < 3) return isGraph(spline);
          return false;
        },
        *object.spline);
  });
}

// The curves and surfaces of the file. Throws InvalidInput if there are none, or they are of different dimensions.
std::vector<Object> splinesOf(const InspectArguments& arguments, Index& dimension, bool& surfaces) {
  const auto model = readModel(arguments.model);
  std::vector<Object> objects;
  dimension = 0;
  surfaces = false;
  for (Index i : selectedObjects(arguments.faces, model->objects())) {
    const Object& object = model->objects()[static_cast<std::size_t>(i)];
    if (!object.spline || std::holds_alternative<Volume>(*object.spline)) continue;
    const Index own = std::visit([](const auto& spline) { return spline.pointDimension(); }, *object.spline);
    if (dimension != 0 && own != dimension) {
      throw InvalidInput("the objects have different numbers of coordinates: choose some with --faces");
    }
    dimension = own;
    surfaces = surfaces || std::holds_alternative<Surface>(*object.spline);
    objects.push_back(object);
  }
  if (objects.empty()) {
    throw InvalidInput(fmt::format("there is no spline curve or surface in '{}' to measure from", arguments.model));
  }
  return objects;
}

// From the nearest object.
PointDeviation deviationFrom(const std::vector<Object>& objects, const Net& points, bool heights) {
  PointDeviation nearest;
  for (const Object& object : objects) {
    PointDeviation own = std::visit(
        [&]<int D>(const Spline<D>& spline) -> PointDeviation {
          if constexpr (D == 3)
            return {};
          else
            return heights ? heightDeviation(spline, points) : normalDeviation(spline, points);
        },
        *object.spline);
    if (!object.trims.empty()) leaveOutTrimmed(TrimRegion(std::get<Surface>(*object.spline), object.trims), own);
    if (nearest.values.size() == 0) {
      nearest = std::move(own);
      continue;
    }
    for (Index r = 0; r < points.rows(); ++r) {
      if (std::abs(own.values[r]) < std::abs(nearest.values[r]) || std::isnan(nearest.values[r])) {
        nearest.values[r] = own.values[r];
        nearest.feet.row(r) = own.feet.row(r);
      }
    }
  }
  nearest.missed = std::count_if(nearest.values.begin(), nearest.values.end(), [](double v) { return std::isnan(v); });
  return nearest;
}

Net measuredRows(const Net& rows, const Eigen::VectorXd& values) {
  Net kept(rows.rows(), rows.cols());
  Index count = 0;
  for (Index r = 0; r < rows.rows(); ++r) {
    if (!std::isnan(values[r])) kept.row(count++) = rows.row(r);
  }
  kept.conservativeResize(count, Eigen::NoChange);
  return kept;
}

void summarise(const std::string& remove, Inspection& result) {
  const Eigen::VectorXd& values = result.deviation.values;
  double squares = 0, sum = 0;
  for (Index r = 0; r < values.size(); ++r) {
    const double value = values[r];
    if (std::isnan(value)) continue;
    if (result.measured == 0 || std::abs(value) > std::abs(values[result.worst])) result.worst = r;
    result.lowest = result.measured == 0 ? value : std::min(result.lowest, value);
    result.highest = result.measured == 0 ? value : std::max(result.highest, value);
    ++result.measured;
    squares += value * value;
    sum += value;
    if (result.tolerance && std::abs(value) <= *result.tolerance) ++result.inside;
  }
  if (result.measured == 0)
    throw InvalidInput("no point lies over the surface or what its trims leave: are both files in the same unit?");
  result.rms = std::sqrt(squares / static_cast<double>(result.measured));
  result.mean = sum / static_cast<double>(result.measured);
  if (remove.empty()) return;
  const Removal removal = removalNamed(remove);
  const auto figures = [&](const Net& rows) {
    const Net measured = measuredRows(rows, values);
    return removal.sphere ? figuresWithoutSphere(measured) : figuresWithoutPolynomial(measured, removal.degree);
  };
  result.modelForm = figures(result.deviation.feet);
  result.pointForm = figures(result.points);
}

void drawDeviations(const InspectArguments& arguments, const std::vector<Object>& objects, const Inspection& result) {
  const auto cross = std::min(arguments.size.find('x'), arguments.size.size() - 1);
  const auto width = static_cast<int>(wholeNumber("--size (width)", arguments.size.substr(0, cross), 64, 16384));
  const auto height = static_cast<int>(wholeNumber("--size (height)", arguments.size.substr(cross + 1), 64, 16384));
  if (const auto* curve = std::get_if<Curve>(&*objects.front().spline); curve != nullptr && objects.size() == 1) {
    if (!arguments.view.empty() || !arguments.range.empty()) {
      throw InvalidInput("--view and --range are for pictures of surfaces: a curve's is a diagram");
    }
    CurvePlotOptions options;
    options.width = width;
    options.height = height;
    options.tolerance = result.tolerance.value_or(0);
    return writeFile(arguments.picture,
                     deviationPlotSvg(*curve, result.deviation.feet, result.deviation.values, options));
  }
  RenderOptions options;
  options.kind = RenderKind::points;
  options.points = result.deviation.feet;
  options.values = result.deviation.values;
  options.width = width;
  options.height = height;
  if (!arguments.view.empty()) {
    options.view = direction("--view", arguments.view);
  } else if (result.heights) {
    options.view = Eigen::Vector3d::UnitZ();
  }
  std::optional<double> range = result.tolerance;
  if (!arguments.range.empty()) range = positiveNumber("--range", arguments.range);
  if (range) options.range = {-*range, *range};
  writeFile(arguments.picture, renderSvg(objects, options));
}

Json jsonOf(const HeightFigures& figures) {
  Json json{{"peak_to_valley", figures.peakToValley}, {"rms", figures.rms}};
  if (figures.radius > 0) {
    json["radius"] = figures.radius;
    json["centre"] = std::vector<double>(figures.centre.begin(), figures.centre.end());
  }
  return json;
}

std::vector<double> pointOf(const Inspection& result) {
  return {result.points.row(result.worst).begin(), result.points.row(result.worst).end()};
}

void print(const InspectArguments& arguments, const Inspection& result) {
  fmt::print("{} points, {}\n", result.measured,
             result.heights ? "heights over the graph" : "distances from the nearest place");
  if (result.deviation.missed > 0) {
    fmt::print("{} points lie beyond {}\n", result.deviation.missed,
               result.heights ? "the graph's domain or its trims" : "the trims of the faces");
  }
  fmt::print("deviation   rms {}, mean {}, from {} to {}; largest at point {} ({:.6g})\n", number(result.rms),
             number(result.mean), number(result.lowest), number(result.highest), result.worst + 1,
             fmt::join(pointOf(result), ", "));
  if (result.tolerance) {
    fmt::print("tolerance   {:.6g} % of the points within {}\n",
               100 * static_cast<double>(result.inside) / static_cast<double>(result.measured),
               number(*result.tolerance));
  }
  if (result.modelForm) {
    const std::string radius =
        result.modelForm->radius > 0 ? fmt::format(", radius {:.7g}", result.modelForm->radius) : "";
    fmt::print("form        without {}: peak to valley {:.6g}, rms {:.6g}{}; of the points {:.6g}, {:.6g}\n",
               arguments.remove, result.modelForm->peakToValley, result.modelForm->rms, radius,
               result.pointForm->peakToValley, result.pointForm->rms);
  }
  if (!arguments.picture.empty()) fmt::print("wrote {}\n", arguments.picture);
}

void inspect(const InspectArguments& arguments) {
  const Stopwatch watch;
  if (!arguments.picture.empty()) {
    if (!arguments.picture.ends_with(".svg")) {
      throw InvalidInput(fmt::format("cannot draw '{}': let the picture end in .svg", arguments.picture));
    }
    requireWritable(arguments.picture);
  }
  if (!arguments.remove.empty()) removalNamed(arguments.remove);
  Inspection result;
  if (!arguments.tolerance.empty()) result.tolerance = positiveNumber("--tolerance", arguments.tolerance);
  Index dimension = 0;
  bool surfaces = false;
  const auto objects = splinesOf(arguments, dimension, surfaces);
  if (!surfaces && objects.size() > 1 && !arguments.picture.empty()) {
    throw InvalidInput("a picture shows the points at surfaces or at one curve: choose it with --faces");
  }
  result.heights = alongHeights(arguments.along, objects);
  const PointFile file = pointFile(arguments.points, arguments.columns);
  const FitColumns columns = fitColumns(file, surfaces ? "surface" : "curve");
  if (static_cast<Index>(columns.values.size()) != dimension) {
    throw InvalidInput(fmt::format("'{}' has points of {} coordinates, '{}' of {}: choose them with --columns",
                                   arguments.points, columns.values.size(), arguments.model, dimension));
  }
  const Net all = readPoints(file);
  result.points.resize(all.rows(), dimension);
  for (Index c = 0; c < dimension; ++c) result.points.col(c) = all.col(columns.values[static_cast<std::size_t>(c)]);
  result.deviation = deviationFrom(objects, result.points, result.heights);
  summarise(arguments.remove, result);
  if (!arguments.picture.empty()) drawDeviations(arguments, objects, result);
  if (!arguments.json) return print(arguments, result);
  Json json = jsonHead(arguments.commandLine, {arguments.points, arguments.model});
  json["objects"] = Json::array();
  for (const Object& object : objects) json["objects"].push_back({{"name", object.name}, {"kind", object.kind}});
  json["along"] = result.heights ? "height" : "normal";
  json["measured"] = result.measured;
  json["missed"] = result.deviation.missed;
  json["deviation"] = {{"rms", result.rms},
                       {"mean", result.mean},
                       {"lowest", result.lowest},
                       {"highest", result.highest},
                       {"worst", {{"point", result.worst + 1}, {"at", pointOf(result)}}}};
  if (result.tolerance) {
    json["tolerance"] = {{"value", *result.tolerance},
                         {"inside", static_cast<double>(result.inside) / static_cast<double>(result.measured)}};
  }
  if (result.modelForm) {
    json["form"] = {
        {"removed", arguments.remove}, {"model", jsonOf(*result.modelForm)}, {"points", jsonOf(*result.pointForm)}};
  }
  json["picture"] = arguments.picture.empty() ? Json() : Json(arguments.picture);
  json["seconds"] = watch.seconds();
  printJson(json);
}

}  // namespace

void addInspect(CLI::App& program, const std::string& commandLine) {
  auto arguments = std::make_shared<InspectArguments>();
  arguments->commandLine = commandLine;
  CLI::App* command = program.add_subcommand("inspect", "How far measured points are from curves and surfaces");
  command->add_option("POINTS", arguments->points, "File of points, of any kind that strak fit reads")->required();
  command->add_option("MODEL", arguments->model, "STEP, IGES, BREP, .g2 or JSON file")->required();
  command->add_option("--columns", arguments->columns,
                      "Which columns of the table are the coordinates: numbers from 1, like 1,3");
  command->add_option(
      "--along", arguments->along,
      "height: the last coordinate over the others; normal: the shortest way. Default: height where the "
      "objects are graphs, as fits of functions are");
  command->add_option("--tolerance", arguments->tolerance, "Tell the share of the points within this length");
  command->add_option("--remove", arguments->remove,
                      "Peak to valley and RMS of the form too, without its mean, plane (line), quadric (parabola) or "
                      "sphere (circle) of least squares");
  command->add_option("--faces", arguments->faces, "Objects to measure from: numbers, ranges and names");
  command->add_option(
      "--picture", arguments->picture,
      "OUT.svg: the points in the colours of their deviations; of a curve the deviations over its length");
  command->add_option("--range", arguments->range,
                      "The largest deviation of the colours; default: the tolerance, or "
                      "what all but one percent keep");
  command->add_option("--view", arguments->view, "Direction from the model to the eye: X,Y,Z");
  command->add_option("--size", arguments->size, "Pixels: WIDTHxHEIGHT")->capture_default_str();
  command->add_flag("--json", arguments->json, "Print one JSON object");
  command->footer("Example:\n  strak inspect scan.xyz fit.step --tolerance 0.05 --picture deviation.svg");
  command->callback([arguments] { inspect(*arguments); });
}

}  // namespace strak::cli
