// strak fit: a fair spline near measured points.

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <memory>
#include <optional>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/fit_task.h"
#include "apps/cli/interrupt.h"
#include "apps/cli/json.h"
#include "apps/cli/values.h"
#include "strak/base/error.h"
#include "strak/exchange/file_kind.h"

namespace strak::cli {

namespace {

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
      ->add_option("POINTS", arguments->input,
                   "Table of numbers (.xyz, .csv, .txt, .dat), heights on a grid (.asc, .dem, .gtx), point cloud (PLY, "
                   "PCD, LAS, .g2) or "
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
  command->add_option("--domain", arguments->domain, "U0,U1,V0,V1; default: the box of the points and conditions");
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
      ->add_option(
          "--parameter-scale", arguments->scale,
          "In which shape of the domain the energy is measured: lengths, domain or unit; auto: lengths, but unit "
          "for functions over an elongated domain if cross validation expects smaller errors with it")
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
