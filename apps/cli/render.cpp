// strak render: a drawing of the splines in a file.

#include <fmt/format.h>

#include <memory>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/curve_picture.h"
#include "apps/cli/json.h"
#include "apps/cli/values.h"
#include "strak/base/error.h"
#include "strak/base/file.h"
#include "strak/report/drawing.h"

namespace strak::cli {

namespace {

struct RenderArguments {
  std::string input, output, kind = "isophotes", view, light, lines = "24", size = "900x700", faces, reference;
  std::string pole, factor = "2", tolerance = "0";  // of the diagrams of curves
  bool hidden = false, json = false;
  std::string commandLine;
};

enum class PageKind { svg, html };

PageKind pageKindOf(const std::filesystem::path& path) {
  const std::string ending = path.extension().string();
  if (ending == ".svg") return PageKind::svg;
  if (ending == ".html" || ending == ".htm") return PageKind::html;
  throw InvalidInput(fmt::format("cannot tell from '{}' what to draw: let it end in .svg or .html", path.string()));
}

RenderOptions renderOptions(const RenderArguments& arguments) {
  RenderOptions options;
  if (!isCurvePicture(arguments.kind)) options.kind = renderKind(arguments.kind);
  if (!arguments.view.empty()) options.view = direction("--view", arguments.view);
  if (!arguments.light.empty()) options.light = direction("--light", arguments.light);
  options.lines = static_cast<int>(wholeNumber("--lines", arguments.lines, 1, 1000));
  const auto cross = arguments.size.find('x');
  if (cross == std::string::npos) {
    throw InvalidInput(fmt::format("--size is '{}': give WIDTHxHEIGHT in pixels, like 900x700", arguments.size));
  }
  options.width = static_cast<int>(wholeNumber("--size (width)", arguments.size.substr(0, cross), 1, 100'000));
  options.height = static_cast<int>(wholeNumber("--size (height)", arguments.size.substr(cross + 1), 1, 100'000));
  options.hideLines = !arguments.hidden;
  return options;
}

std::vector<Object> objectsOf(const std::string& path, const std::string& faces) {
  const auto model = readModel(path);
  std::vector<Object> objects;
  for (Index i : selectedObjects(faces, model->objects())) {
    objects.push_back(model->objects()[static_cast<std::size_t>(i)]);
  }
  return objects;
}

std::string curveDiagram(const RenderArguments& arguments, PageKind page, const std::vector<Object>& objects,
                         const RenderOptions& options) {
  if (page == PageKind::html) {
    throw InvalidInput(fmt::format("--kind {} is a diagram: let the output end in .svg", arguments.kind));
  }
  CurvePlotOptions plot;
  plot.width = options.width;
  plot.height = options.height;
  if (!arguments.pole.empty()) plot.pole = planePoint("--pole", arguments.pole);
  plot.factor = positiveNumber("--factor", arguments.factor);
  plot.tolerance = positiveNumber("--tolerance", arguments.tolerance, true);
  return curvePicture(arguments.kind, objects, options.reference, plot);
}

void render(const RenderArguments& arguments) {
  const Stopwatch watch;
  const PageKind page = pageKindOf(arguments.output);
  RenderOptions options = renderOptions(arguments);
  if (options.kind == RenderKind::deviation && arguments.reference.empty()) {
    throw InvalidInput("--kind deviation compares with another file: name it with --reference");
  }
  requireWritable(arguments.output);
  const auto objects = objectsOf(arguments.input, arguments.faces);
  if (!arguments.reference.empty()) options.reference = objectsOf(arguments.reference, arguments.faces);
  const std::string title = std::filesystem::path(arguments.input).filename().string();
  const std::string text = isCurvePicture(arguments.kind) ? curveDiagram(arguments, page, objects, options)
                           : page == PageKind::svg        ? renderSvg(objects, options)
                                                          : renderHtml(objects, title, options);
  writeFile(arguments.output, text);
  if (!arguments.json) {
    fmt::print("wrote {} ({})\n", arguments.output, arguments.kind);
    return;
  }
  Json json = jsonHead(arguments.commandLine, {arguments.input});
  json["output"] = arguments.output;
  json["kind"] = arguments.kind;
  json["bytes"] = text.size();
  json["objects"] = Json::array();
  for (const Object& object : objects) {
    json["objects"].push_back({{"name", object.name}, {"kind", object.kind}, {"drawn", object.spline.has_value()}});
  }
  json["seconds"] = watch.seconds();
  printJson(json);
}

}  // namespace

void addRender(CLI::App& program, const std::string& commandLine) {
  auto arguments = std::make_shared<RenderArguments>();
  arguments->commandLine = commandLine;
  CLI::App* command = program.add_subcommand("render", "Draw isophotes, zebra, combs, isolines or curvature");
  command->add_option("IN", arguments->input, "STEP, IGES, BREP, .g2, JSON or digitised curve")->required();
  command->add_option("-o,--output", arguments->output, "OUT.svg (lines, hidden ones removed) or OUT.html (to turn)")
      ->required();
  command
      ->add_option(
          "--kind", arguments->kind,
          "isophotes, zebra, isolines, combs, gaussian, mean or deviation; of the first curve: curvature-plot, "
          "tolerance-band, k-orthotomic")
      ->capture_default_str();
  command->add_option("--reference", arguments->reference,
                      "The file to compare with, for --kind deviation, tolerance-band and curvature-plot");
  command->add_option("--pole", arguments->pole, "X,Y of the k-orthotomic's pole; default: away from the tangents");
  command->add_option("--factor", arguments->factor, "k of the k-orthotomic")->capture_default_str();
  command->add_option("--tolerance", arguments->tolerance, "Half the width of the tolerance band that is drawn");
  command->add_option("--view", arguments->view, "Direction from the model to the eye: X,Y,Z");
  command->add_option("--light", arguments->light, "Direction from the model to the light: X,Y,Z");
  command->add_option("--lines", arguments->lines, "Number of isophotes, stripes, colour steps, combs or isolines")
      ->capture_default_str();
  command->add_option("--size", arguments->size, "Pixels: WIDTHxHEIGHT")->capture_default_str();
  command->add_option("--faces", arguments->faces, "Objects to draw: numbers, ranges and names, like 1,3-5,hood");
  command->add_flag("--hidden", arguments->hidden, "Draw hidden lines too");
  command->add_flag("--json", arguments->json, "Print one JSON object");
  command->footer("Example:\n  strak render hood.step -o hood.svg --kind isophotes --light 0,1,1");
  command->callback([arguments] { render(*arguments); });
}

}  // namespace strak::cli
