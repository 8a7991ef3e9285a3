// strak compare: how far two files' splines are from each other.

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <numbers>
#include <optional>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/json.h"
#include "strak/exchange/model.h"
#include "strak/metrology/continuity.h"
#include "strak/metrology/deviation.h"
#include "strak/metrology/hausdorff.h"
#include "strak/spline/reparametrize.h"

namespace strak::cli {

namespace {

struct CompareArguments {
  std::string first, second;
  bool json = false;
  std::string commandLine;
};

constexpr const char* kNoSplines = "no splines: not compared";

// The worst join across inner knot lines where a surface need not be smooth.
struct Kink {
  double degrees = 0;        // angle of the tangent planes
  double curvatureJump = 0;  // 1 / length
};

// What is known about two objects; empty fields do not apply.
struct Difference {
  bool identical = false;                    // to the bit
  std::optional<double> lower, certified;    // parameter by parameter
  std::optional<double> hausdorff;           // sampled, whatever the parameters
  std::optional<double> controlPoints;       // largest move of a control point
  std::optional<std::array<Kink, 2>> kinks;  // of surfaces with such lines
  std::string note;
};

template <int D>
bool sameDomain(const Spline<D>& a, const Spline<D>& b) {
  for (int k = 0; k < D; ++k) {
    const double small = 1e-12 * a.knots(k).length();
    if (std::abs(a.knots(k).from() - b.knots(k).from()) > small ||
        std::abs(a.knots(k).to() - b.knots(k).to()) > small) {
      return false;
    }
  }
  return true;
}

template <int D>
void certify(const Spline<D>& a, const Spline<D>& b, Difference& difference) {
  const auto deviation = certifyDeviation(a, b);
  difference.lower = deviation.lower;
  difference.certified = deviation.upper;
}

Kink kinkOf(const std::vector<KnotLineContinuity>& lines) {
  Kink kink;
  for (const auto& line : lines) {
    kink.degrees = std::max(kink.degrees, line.continuity.angle.max * 180 / std::numbers::pi);
    kink.curvatureJump = std::max(kink.curvatureJump, line.continuity.curvature.max);
  }
  return kink;
}

void compareKinks(const Surface& a, const Surface& b, Difference& difference) {
  if (a.pointDimension() != 3) return;
  const auto linesA = innerContinuity(a);
  const auto linesB = innerContinuity(b);
  if (!linesA.empty() || !linesB.empty()) difference.kinks = {kinkOf(linesA), kinkOf(linesB)};
}

template <int D>
Difference differenceOf(const Spline<D>& a, const Spline<D>& b) {
  Difference difference;
  difference.identical = a == b;
  if (a.pointDimension() != b.pointDimension()) {
    difference.note = fmt::format("points of {} and {} coordinates", a.pointDimension(), b.pointDimension());
    return difference;
  }
  if (a.sizes() == b.sizes() && a.isRational() == b.isRational()) {
    difference.controlPoints = (a.euclideanNet() - b.euclideanNet()).rowwise().norm().maxCoeff();
  }
  if constexpr (D == 2) compareKinks(a, b, difference);
  if (sameDomain(a, b)) {
    certify(a, b, difference);
  } else {
    Spline<D> mapped = b;
    for (int k = 0; k < D; ++k) mapped = withDomain(mapped, k, a.knots(k).from(), a.knots(k).to());
    certify(a, mapped, difference);
    difference.note = "different domains: certified for parameters in proportion";
    if constexpr (D == 2) difference.hausdorff = hausdorffDistance(a, b).distance;
  }
  return difference;
}

Difference differenceOf(const Object& a, const Object& b) {
  Difference difference;
  if (!a.spline && !b.spline) {
    difference.note = a.kind == b.kind ? kNoSplines : "different kinds: " + a.kind + " and " + b.kind;
    return difference;
  }
  if (!a.spline || !b.spline || a.spline->index() != b.spline->index()) {
    difference.note = "different kinds: " + a.kind + " and " + b.kind;
    return difference;
  }
  return std::visit(
      [&]<int D>(const Spline<D>& spline) { return differenceOf(spline, std::get<Spline<D>>(*b.spline)); }, *a.spline);
}

Json kinksJson(const std::optional<std::array<Kink, 2>>& kinks) {
  if (!kinks) return Json();
  const auto& [a, b] = *kinks;
  return Json{{"angle_degrees", {a.degrees, b.degrees}}, {"curvature_jump", {a.curvatureJump, b.curvatureJump}}};
}

Json objectJson(std::size_t number, const Object& a, const Object& b, const Difference& difference) {
  const auto value = [](const std::optional<double>& figure) { return figure ? Json(*figure) : Json(); };
  return Json{{"number", number},
              {"name", a.name},
              {"other_name", b.name},
              {"kind", a.kind},
              {"identical", difference.identical},
              {"deviation",
               {{"control_points", value(difference.controlPoints)},
                {"lower", value(difference.lower)},
                {"certified", value(difference.certified)}}},
              {"hausdorff", value(difference.hausdorff)},
              {"inner_continuity", kinksJson(difference.kinks)},
              {"note", difference.note.empty() ? Json() : Json(difference.note)}};
}

std::string noteOf(const Difference& difference) {
  if (!difference.kinks) return difference.note;
  const auto& [a, b] = *difference.kinks;
  return fmt::format("{}{}at inner knots angle {} -> {} degrees, curvature jump {} -> {}", difference.note,
                     difference.note.empty() ? "" : "; ", number(a.degrees), number(b.degrees), number(a.curvatureJump),
                     number(b.curvatureJump));
}

std::string auditText(const Audit& audit) {
  if (audit.edges.empty()) return "no edges";
  return fmt::format("{} edges, {}, largest gap {}, largest tolerance {}", audit.edges.size(),
                     audit.valid ? "valid" : fmt::format("not valid ({} faces)", audit.invalidFaces),
                     number(audit.largestGap), number(audit.largestTolerance));
}

void compare(const CompareArguments& arguments) {
  const Stopwatch watch;
  const auto first = readModel(arguments.first);
  const auto second = readModel(arguments.second);
  const auto& a = first->objects();
  const auto& b = second->objects();
  const std::size_t common = std::min(a.size(), b.size());
  Table table({"#", "<object", "<kind", "control points", "certified", "Hausdorff", "<note"});
  Json objects = Json::array();
  std::size_t identical = 0;
  std::size_t withoutSpline = 0;
  double largest = 0;
  for (std::size_t i = 0; i < common; ++i) {
    const Difference difference = differenceOf(a[i], b[i]);
    objects.push_back(objectJson(i + 1, a[i], b[i], difference));
    identical += difference.identical ? 1 : 0;
    largest = std::max(largest, difference.hausdorff.value_or(difference.certified.value_or(0)));
    withoutSpline += difference.note == kNoSplines ? 1 : 0;
    if (difference.identical || difference.note == kNoSplines) continue;
    const auto cell = [](const std::optional<double>& figure) { return figure ? number(*figure) : std::string("-"); };
    table.add({std::to_string(i + 1), a[i].name, a[i].kind, cell(difference.controlPoints), cell(difference.certified),
               cell(difference.hausdorff), noteOf(difference)});
  }
  const Audit before = first->audit();
  const Audit after = second->audit();
  if (arguments.json) {
    Json json = jsonHead(arguments.commandLine, {arguments.first, arguments.second});
    json["object_counts"] = {a.size(), b.size()};
    json["units"] = {first->unit(), second->unit()};
    json["identical"] = identical + withoutSpline == common && a.size() == b.size();
    json["largest_deviation"] = largest;
    json["audits"] = {jsonOf(before), jsonOf(after)};
    json["objects"] = std::move(objects);
    json["seconds"] = watch.seconds();
    printJson(json);
    return;
  }
  if (!table.empty()) fmt::print("{}", table.text());
  const std::string unit = first->unit().empty() ? "" : " " + first->unit();
  fmt::print("{} of {} splines identical to the bit, largest deviation {}{}\n", identical, common - withoutSpline,
             number(largest), unit);
  if (withoutSpline > 0) fmt::print("{} objects of the same kind without splines are not compared\n", withoutSpline);
  if (a.size() != b.size())
    fmt::print("{} objects against {}: the first {} are compared\n", a.size(), b.size(), common);
  if (first->unit() != second->unit()) fmt::print("units: '{}' against '{}'\n", first->unit(), second->unit());
  fmt::print("A: {}\nB: {}\n", auditText(before), auditText(after));
}

}  // namespace

void addCompare(CLI::App& program, const std::string& commandLine) {
  auto arguments = std::make_shared<CompareArguments>();
  arguments->commandLine = commandLine;
  CLI::App* command = program.add_subcommand("compare", "How far two files are from each other, object by object");
  command->add_option("A", arguments->first, "STEP, IGES, BREP, .g2 or JSON file")->required();
  command->add_option("B", arguments->second, "The file to compare with")->required();
  command->add_flag("--json", arguments->json, "Print one JSON object instead of the table");
  command->footer("Example:\n  strak compare hood.step fair.step");
  command->callback([arguments] { compare(*arguments); });
}

}  // namespace strak::cli
