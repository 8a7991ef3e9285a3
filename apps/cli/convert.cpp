// strak convert: another format, a higher degree, Bezier pieces, fewer spans, uniform knots.

#include <fmt/format.h>

#include <memory>
#include <optional>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/json.h"
#include "apps/cli/other_form.h"
#include "apps/cli/rebuild_model.h"
#include "apps/cli/values.h"
#include "strak/base/error.h"
#include "strak/exchange/file_kind.h"
#include "strak/exchange/model.h"
#include "strak/spline/bezier.h"
#include "strak/spline/degree_elevation.h"

namespace strak::cli {

namespace {

struct ConvertArguments {
  std::string input, output, elevate, rebuild, uniform, nonuniform, tolerance, mostPoints, analytic;
  JoinWishes joins;
  bool toBezier = false, uniformCubic = false, json = false;
  std::string commandLine;
};

template <int D>
Spline<D> elevated(Spline<D> spline, int degree, const std::string& name) {
  for (int k = 0; k < D; ++k) {
    const int more = degree - spline.degree(k);
    if (more < 0) {
      throw InvalidInput(
          fmt::format("--elevate {} would lower the degree of '{}' in direction {}, which is {}: give at "
                      "least that",
                      degree, name, directionName(k), spline.degree(k)));
    }
    if (more > 0) spline = elevateDegree(spline, k, more);
  }
  return spline;
}

// A piece as a spline of its own.
template <int D>
Spline<D> splineOf(const BezierPiece<D>& piece, const Spline<D>& whole) {
  std::array<KnotVector, D> knots;
  for (std::size_t k = 0; k < D; ++k) {
    knots[k] = KnotVector::uniformClamped(whole.degree(static_cast<int>(k)), 1, piece.from[k], piece.to[k]);
  }
  return Spline<D>(knots, piece.points, whole.isRational());
}

// The model with other splines: what is no spline has no place in it.
std::unique_ptr<Model> changed(const Model& model, const ConvertArguments& arguments) {
  constexpr Index kHighestDegree = 31;
  const int degree =
      arguments.elevate.empty() ? 0 : static_cast<int>(wholeNumber("--elevate", arguments.elevate, 1, kHighestDegree));
  std::vector<AnySpline> splines;
  std::vector<std::string> names;
  for (const Object& object : model.objects()) {
    if (!object.spline) continue;
    std::visit(
        [&]<int D>(const Spline<D>& original) {
          const Spline<D> spline = degree > 0 ? elevated(original, degree, object.name) : original;
          if (!arguments.toBezier) {
            splines.emplace_back(spline);
            names.push_back(object.name);
            return;
          }
          const auto pieces = bezierPieces(spline);
          for (std::size_t i = 0; i < pieces.size(); ++i) {
            splines.emplace_back(splineOf(pieces[i], spline));
            names.push_back(fmt::format("{} piece {}", object.name, i + 1));
          }
        },
        *object.spline);
  }
  if (splines.empty()) throw InvalidInput(fmt::format("'{}' holds no splines to convert", arguments.input));
  return modelOf(std::move(splines), std::move(names), model.unit());
}

void convertAnalytic(Model& model, const std::string& faces) {
  const std::vector<Index> selected = selectedObjects(faces, model.objects(), "--analytic-to-bspline");
  model.convertAnalytic(selected);
  for (Index index : selected) {
    const Object& object = model.objects()[static_cast<std::size_t>(index)];
    if (!object.spline) throw InvalidInput(fmt::format("'{}' stays as it is: {}", object.name, object.leftAlone));
  }
}

// What --uniform, --uniform-cubic or --nonuniform ask for, if one is there.
std::optional<ConversionOptions> formOf(const ConvertArguments& arguments) {
  const int wishes = (arguments.uniform.empty() ? 0 : 1) + (arguments.uniformCubic ? 1 : 0) +
                     (arguments.nonuniform.empty() ? 0 : 1) + (arguments.rebuild.empty() ? 0 : 1);
  if (wishes > 1) {
    throw InvalidInput("--uniform, --uniform-cubic, --nonuniform and --rebuild make different knots: give one of them");
  }
  constexpr Index kTooHigh = 1000;  // the library names the limit
  ConversionOptions options;
  if (!arguments.mostPoints.empty()) options.mostPoints = wholeNumber("--most-points", arguments.mostPoints, 1);
  if (!arguments.nonuniform.empty()) {
    options.spacing = KnotSpacing::adapted;
    options.degree = static_cast<int>(wholeNumber("--nonuniform", arguments.nonuniform, 1, kTooHigh));
  } else if (!arguments.uniform.empty()) {
    options.degree = static_cast<int>(wholeNumber("--uniform", arguments.uniform, 1, kTooHigh));
  } else if (!arguments.uniformCubic) {
    if (!arguments.mostPoints.empty()) throw InvalidInput("--most-points is for --uniform and --nonuniform");
    return std::nullopt;
  }
  return options;
}

void takeOver(const ConvertedObject& object, Json& entry) {
  entry["left_alone"] = object.leftAlone.empty() ? Json() : Json(object.leftAlone);
  if (!object.leftAlone.empty()) return;
  entry["unchanged"] = object.unchanged;
  entry["deviation"] = {{"lower", object.lower}, {"certified", object.certified}};
  entry["sides"] = object.sides;
  entry["points_before"] = object.pointsBefore;
  entry["creases"] = object.creases;
}

void convert(const ConvertArguments& arguments) {
  const Stopwatch watch;
  requireWritable(arguments.output);
  fileKindOfEnding(arguments.output);
  const auto form = formOf(arguments);
  if (!arguments.tolerance.empty() && arguments.rebuild.empty() && !form) {
    throw InvalidInput("--tolerance is for --rebuild, --uniform and --nonuniform: everything else is exact");
  }
  if (!form && !(arguments.joins.tolerance.empty() && arguments.joins.angle.empty())) {
    throw InvalidInput("--join-tolerance and --join-angle are for --uniform and --nonuniform");
  }
  auto model = readModel(arguments.input);
  const std::string format = model->format();
  if (!arguments.analytic.empty()) convertAnalytic(*model, arguments.analytic);
  if (!arguments.elevate.empty() || arguments.toBezier) model = changed(*model, arguments);
  std::vector<RebuiltObject> rebuilt;
  if (!arguments.rebuild.empty()) {
    RebuiltModel result = rebuildModel(*model, arguments.rebuild, arguments.tolerance);
    model = std::move(result.model);
    rebuilt = std::move(result.objects);
  }
  ConvertedModel converted;
  if (form) converted = convertForm(*model, *form, arguments.tolerance, arguments.joins);
  model->write(arguments.output);
  if (!arguments.json) {
    for (const RebuiltObject& object : rebuilt) {
      fmt::print("{}: certified deviation at most {}\n", object.name, number(object.certified));
    }
    if (form) fmt::print("{}", describe(converted, model->unit()));
    fmt::print("wrote {} ({} objects)\n", arguments.output, model->objects().size());
    return;
  }
  Json json = jsonHead(arguments.commandLine, {arguments.input});
  json["output"] = arguments.output;
  json["from"] = format;
  json["to"] = fileKindName(fileKindOfEnding(arguments.output));
  json["objects"] = Json::array();
  for (std::size_t i = 0; i < model->objects().size(); ++i) {
    const Object& object = model->objects()[i];
    Json entry{{"name", object.name}, {"kind", object.kind}};
    if (!rebuilt.empty()) entry["deviation"] = {{"lower", rebuilt[i].lower}, {"certified", rebuilt[i].certified}};
    if (form) takeOver(converted.objects[i], entry);
    if (object.spline) {
      std::visit(
          [&]<int D>(const Spline<D>& spline) {
            entry["points"] = spline.sizes();
            for (int k = 0; k < D; ++k) entry["degree"].push_back(spline.degree(k));
          },
          *object.spline);
    }
    json["objects"].push_back(std::move(entry));
  }
  if (form && !converted.after.edges.empty()) {
    json["edges"] = {{"gap_before", converted.before.largestGap}, {"gap", converted.after.largestGap}};
  }
  if (form && converted.measuredJoins > 0) {
    json["joins"] = {{"gap_before", converted.joinGap.before},
                     {"gap", converted.joinGap.after},
                     {"angle_before", converted.joinAngle.before},
                     {"angle", converted.joinAngle.after},
                     {"common", converted.commonJoins},
                     {"near", converted.nearJoins},
                     {"loose_faces", converted.looseFaces}};
  }
  json["seconds"] = watch.seconds();
  printJson(json);
}

}  // namespace

void addConvert(CLI::App& program, const std::string& commandLine) {
  auto arguments = std::make_shared<ConvertArguments>();
  arguments->commandLine = commandLine;
  CLI::App* command = program.add_subcommand("convert", "Write a file in another format or form");
  command->add_option("IN", arguments->input, "STEP, IGES, BREP, .g2 or JSON file")->required();
  command->add_option("-o,--output", arguments->output, "File to write; its ending says the format")->required();
  command->add_option("--elevate", arguments->elevate,
                      "Raise all degrees to this one, exactly; only the splines are written");
  command->add_flag("--to-bezier", arguments->toBezier,
                    "Write a Bezier piece for every knot span, exactly; only the splines are written");
  command->add_option("--rebuild", arguments->rebuild,
                      "DEGREE,SPANS: the best approximation of that degree on so many uniform spans (or DU,DV,SU,SV), "
                      "after --elevate and --to-bezier; says the certified deviation; only the splines are written");
  command->add_flag("--uniform-cubic", arguments->uniformCubic, "The same as --uniform 3");
  command->add_option("--uniform", arguments->uniform,
                      "DEGREE: splines of that degree on uniform knots, without weights, faces with their trims; as "
                      "many spans as the tolerance needs; says the certified deviation");
  command->add_option("--nonuniform", arguments->nonuniform,
                      "DEGREE: the same on the knots of the file, with its creases, and spans halved where needed");
  command->add_option("--tolerance", arguments->tolerance,
                      "With --rebuild, --uniform and --nonuniform: write nothing if a deviation may be larger; a "
                      "length, or a part of the size (0.0001size)");
  command->add_option("--join-tolerance", arguments->joins.tolerance,
                      "With --uniform and --nonuniform: what joins of faces may open by, a length like --tolerance; "
                      "default: a tenth of it");
  command->add_option(
      "--join-angle", arguments->joins.angle,
      "With --uniform and --nonuniform: what the angle at a join below 3 degrees may change by, degrees");
  command->add_option("--most-points", arguments->mostPoints,
                      "With --uniform and --nonuniform: at most so many control points a spline; default: 200000");
  command->add_option(
      "--analytic-to-bspline", arguments->analytic,
      "Make these planes, cylinders, cones, ... B-splines, edges as they are: numbers, ranges and names");
  command->add_flag("--json", arguments->json, "Print one JSON object");
  command->footer("Example:\n  strak convert hood.step -o hood.g2 --to-bezier");
  command->callback([arguments] { convert(*arguments); });
}

}  // namespace strak::cli
