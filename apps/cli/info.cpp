// strak info: what is inside a file, and what of it can be faired.

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/joins.h"
#include "apps/cli/json.h"
#include "apps/cli/ring.h"
#include "apps/cli/values.h"
#include "strak/base/error.h"
#include "strak/exchange/model.h"
#include "strak/fairing/plan_face.h"
#include "strak/metrology/fairness.h"
#include "strak/metrology/self_intersection.h"

namespace strak::cli {

namespace {

struct InfoArguments {
  std::string input;
  std::string ring, index;
  bool fairness = false, meetings = false, json = false;
  std::string commandLine;
};

// What there is to say about one object.
struct Facts {
  std::vector<int> degree;
  std::vector<Index> points;
  std::vector<std::array<double, 2>> domain;
  std::optional<int> continuity;  // the lowest at an inner knot; none if there is no inner knot
  bool rational = false;
  Index dimension = 0;
  Index freePoints = 0, knotsInserted = 0;
  std::string leftAlone;
  std::optional<SurfaceFairness> surface;
  std::optional<CurveFairness> curve;
  std::optional<SelfMeeting> meeting;
  std::optional<RingCurvature> ring;
  std::string noRing;  // why there is none
};

template <int D>
FairingPlan<D> planOf(const Object& object, const Spline<D>& spline) {
  if constexpr (D == 2) {
    return planFace(spline, {object.trims, object.naturalSide});
  } else {
    return planFairing(spline);
  }
}

template <int D>
Facts factsOf(const Object& object, const Spline<D>& spline, const InfoArguments& arguments) {
  Facts facts;
  facts.rational = spline.isRational();
  facts.dimension = spline.pointDimension();
  facts.leftAlone = object.leftAlone;
  for (int k = 0; k < D; ++k) {
    const KnotVector& knots = spline.knots(k);
    facts.degree.push_back(knots.degree());
    facts.points.push_back(knots.size());
    facts.domain.push_back({knots.from(), knots.to()});
    for (const auto& knot : knots.innerKnots()) {
      const int continuity = knots.degree() - knot.multiplicity;
      facts.continuity = std::min(facts.continuity.value_or(continuity), continuity);
    }
  }
  if (facts.leftAlone.empty()) {
    const auto plan = planOf(object, spline);
    facts.leftAlone = plan.leftAlone;
    facts.freePoints = plan.freePoints;
    facts.knotsInserted = plan.knotsInserted;
  }
  if constexpr (D < 3) {
    const bool known = facts.dimension == 3 || (D == 1 && facts.dimension == 2);
    if (arguments.meetings && known) facts.meeting = findSelfIntersection(spline).answer;
  }
  if constexpr (D == 2) {
    if (!arguments.ring.empty()) {
      try {
        facts.ring = ringCurvature(spline, ringNamed(arguments.ring));
      } catch (const InvalidInput& problem) {
        facts.noRing = problem.what();
      }
    }
  }
  if (arguments.fairness) {
    if constexpr (D == 2) {
      if (facts.dimension == 3) facts.surface = surfaceFairness(spline);
    } else if constexpr (D == 1) {
      if (facts.dimension == 2 || facts.dimension == 3) facts.curve = curveFairness(spline);
    }
  }
  return facts;
}

Facts factsOf(const Object& object, const InfoArguments& arguments) {
  if (object.spline) {
    return std::visit([&](const auto& spline) { return factsOf(object, spline, arguments); }, *object.spline);
  }
  Facts facts;
  facts.leftAlone = object.leftAlone.empty() ? "it is not a B-spline" : object.leftAlone;
  return facts;
}

Json objectJson(std::size_t number, const Object& object, const Facts& facts, double refractiveIndex) {
  Json json{{"number", number}, {"name", object.name}, {"kind", object.kind}};
  if (object.spline) {
    json["degree"] = facts.degree;
    json["points"] = facts.points;
    json["dimension"] = facts.dimension;
    json["rational"] = facts.rational;
    json["continuity"] = facts.continuity ? Json(*facts.continuity) : Json();
    json["domain"] = facts.domain;
  }
  json["left_alone"] = facts.leftAlone.empty() ? Json() : Json(facts.leftAlone);
  json["free_points"] = facts.freePoints;
  json["knots_to_insert"] = facts.knotsInserted;
  Json shared = Json::array();
  for (Index other : object.sharedWith) shared.push_back(other + 1);
  json["shared_with"] = shared;
  if (facts.meeting) json["self_intersection"] = selfMeetingName(*facts.meeting);
  if (facts.ring) json["ring"] = jsonOf(*facts.ring, refractiveIndex);
  if (facts.surface) {
    json["fairness"] = {{"area", facts.surface->area},
                        {"plate", facts.surface->plate},
                        {"curvature_variation", facts.surface->curvatureVariation},
                        {"isophote_roughness", facts.surface->isophoteRoughness},
                        {"relative_error", facts.surface->relativeError}};
  }
  if (facts.curve) {
    json["fairness"] = {{"length", facts.curve->length},
                        {"bending", facts.curve->bending},
                        {"curvature_variation", facts.curve->curvatureVariation}};
  }
  return json;
}

std::string fairableText(const Facts& facts) {
  if (!facts.leftAlone.empty()) return "no: " + facts.leftAlone;
  if (facts.knotsInserted == 0) return fmt::format("yes, {} points free", facts.freePoints);
  return fmt::format("yes, {} points free after inserting {} knots", facts.freePoints, facts.knotsInserted);
}

Json joinsJson(const std::vector<EdgeJoin>& joins) {
  Json list = Json::array();
  for (const EdgeJoin& join : joins) {
    list.push_back({{"edge", join.name},
                    {"faces", {join.faceA + 1, join.faceB + 1}},
                    {"gap", join.gap.after},
                    {"angle", join.angle.after},
                    {"curvature", join.curvature.after},
                    {"kind", jointKindName(join.kindAfter)}});
  }
  return list;
}

void printHead(const InfoArguments& arguments, const Model& model, const Audit& audit,
               const std::vector<EdgeJoin>& joins) {
  std::map<std::string, int> kinds;
  for (const Object& object : model.objects()) ++kinds[object.kind];
  std::string counts;
  for (const auto& [kind, count] : kinds) counts += fmt::format("{}{} x {}", counts.empty() ? "" : ", ", count, kind);
  const std::string unit = model.unit().empty() ? "" : " " + model.unit();
  fmt::print("{}: {}, size {}{}\n{} objects: {}\n", arguments.input, model.format(), number(model.size()), unit,
             model.objects().size(), counts);
  if (!audit.edges.empty()) {
    fmt::print("{} edges, {}, largest gap {}{}, largest tolerance {}{}\n", audit.edges.size(),
               audit.valid ? "valid" : fmt::format("not valid ({} faces)", audit.invalidFaces),
               number(audit.largestGap), unit, number(audit.largestTolerance), unit);
  }
  fmt::print("{}", joinCountText(joins, model.unit()));
}

void printTable(const Model& model, const std::vector<Facts>& facts, const InfoArguments& arguments) {
  std::vector<std::string> headings{"#", "<object", "<kind", "<degree", "<net", "<inner", "<can be faired"};
  if (arguments.fairness) headings.insert(headings.end() - 1, {"plate", "variation", "isophotes"});
  if (arguments.meetings) headings.insert(headings.end() - 1, "<meets itself");
  Table table(headings);
  for (std::size_t i = 0; i < facts.size(); ++i) {
    const Object& object = model.objects()[i];
    const Facts& f = facts[i];
    std::vector<std::string> row{std::to_string(i + 1), object.name,
                                 object.kind,           times(f.degree),
                                 times(f.points),       f.continuity ? fmt::format("C{}", *f.continuity) : "",
                                 fairableText(f)};
    if (arguments.fairness) {
      const auto figures =
          f.surface ? std::vector{number(f.surface->plate), number(f.surface->curvatureVariation),
                                  number(f.surface->isophoteRoughness)}
          : f.curve ? std::vector{number(f.curve->bending), number(f.curve->curvatureVariation), std::string()}
                    : std::vector<std::string>(3);
      row.insert(row.end() - 1, figures.begin(), figures.end());
    }
    if (arguments.meetings) row.insert(row.end() - 1, f.meeting ? selfMeetingName(*f.meeting) : "");
    table.add(row);
  }
  fmt::print("{}", table.text());
}

// Faces that the ring does not meet are passed over, unless that are all of them.
void requireRing(const std::vector<Facts>& facts) {
  std::string why = "there is no surface for --ring in the file";
  for (const Facts& f : facts) {
    if (f.ring) return;
    if (!f.noRing.empty()) why = f.noRing;
  }
  throw InvalidInput(why);
}

void info(const InfoArguments& arguments) {
  const Stopwatch watch;
  const double refractiveIndex = arguments.index.empty() ? 1 : positiveNumber("--index", arguments.index);
  const auto model = readModel(arguments.input);
  const Audit audit = model->audit();
  const std::vector<EdgeJoin> joins = joinsOf(*model);
  std::vector<Facts> facts;
  for (const Object& object : model->objects()) facts.push_back(factsOf(object, arguments));
  if (!arguments.ring.empty()) requireRing(facts);
  if (!arguments.json) {
    printHead(arguments, *model, audit, joins);
    printTable(*model, facts, arguments);
    for (std::size_t i = 0; i < facts.size(); ++i) {
      if (facts[i].ring) fmt::print("{}: {}", model->objects()[i].name, ringText(*facts[i].ring, refractiveIndex));
    }
    return;
  }
  Json json = jsonHead(arguments.commandLine, {arguments.input});
  json["format"] = model->format();
  json["unit"] = model->unit();
  json["size"] = model->size();
  json["audit"] = jsonOf(audit);
  json["joins"] = joinsJson(joins);
  json["objects"] = Json::array();
  for (std::size_t i = 0; i < facts.size(); ++i)
    json["objects"].push_back(objectJson(i + 1, model->objects()[i], facts[i], refractiveIndex));
  json["seconds"] = watch.seconds();
  printJson(json);
}

}  // namespace

void addInfo(CLI::App& program, const std::string& commandLine) {
  auto arguments = std::make_shared<InfoArguments>();
  arguments->commandLine = commandLine;
  CLI::App* command = program.add_subcommand("info", "What is inside a file, and what of it can be faired");
  command->add_option("FILE", arguments->input, "STEP, IGES, BREP, .g2 or JSON file")->required();
  command->add_flag("--fairness", arguments->fairness,
                    "Figures of fairness too: exact bending energy, curvature variation, isophote roughness");
  command->add_flag("--self-intersections", arguments->meetings,
                    "Whether objects intersect themselves: free (proven), intersects (shown) or undecided");
  command->add_option("--ring", arguments->ring,
                      "X,Y,R: axial curvature of surfaces on the ring of radius R around the axis along z through X,Y");
  command->add_option("--index", arguments->index,
                      "With --ring, lengths in millimetres: the refractive index for powers in dioptres (1.3375 of "
                      "corneas: simulated keratometry)");
  command->add_flag("--json", arguments->json, "Print one JSON object instead of the table");
  command->footer("Example:\n  strak info hood.step --fairness");
  command->callback([arguments] { info(*arguments); });
}

}  // namespace strak::cli
