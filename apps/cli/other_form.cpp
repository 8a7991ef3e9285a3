#include "apps/cli/other_form.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <optional>

#include "apps/cli/console.h"
#include "apps/cli/values.h"
#include "strak/base/error.h"
#include "strak/fairing/part_conversion.h"
#include "strak/report/edge_joins.h"

namespace strak::cli {

namespace {

constexpr double kJoinShare = 0.1;  // of the tolerance: what joins may open by, if nothing is said

template <int D>
Converted<D> convertAlone(const Spline<D>& spline, const ConversionOptions& options, const std::string& name) {
  try {
    return convertSpline<D>(spline, options);
  } catch (const InvalidInput& error) {
    throw InvalidInput(fmt::format("'{}' cannot be converted: {}", name, error.what()));
  }
}

// Throws Failure if the tolerance is not reached.
template <int D>
void takeOver(const Spline<D>& had, Converted<D>& made, const ConversionOptions& options, const std::string& unit,
              ConvertedObject& object) {
  object.unchanged = made.unchanged;
  object.lower = made.deviation.lower;
  object.certified = made.deviation.upper;
  object.sides.assign(made.sides.begin(), made.sides.end());
  const auto before = had.sizes(), after = made.spline.sizes();
  object.pointsBefore.assign(before.begin(), before.end());
  object.points.assign(after.begin(), after.end());
  object.creases = std::move(made.creases);
  if (made.reached) return;
  const std::string crease =
      object.creases.empty() ? ""
                             : fmt::format(" (it has a crease of {}, which uniform knots round and --nonuniform keeps)",
                                           object.creases.front());
  throw Failure(fmt::format(
      "'{}' with {} control points is still up to {}{} away, above the tolerance {}{}{}: give a larger tolerance, "
      "another degree, or more than {} control points with --most-points",
      object.name, times(object.points), number(object.certified), unit, number(options.tolerance), unit, crease,
      options.mostPoints));
}

// The faces of a model and where they meet, each surface once however many instances there are.
struct Part {
  std::vector<PartFace> faces;
  std::vector<Index> objects;     // of each face
  std::map<Index, Index> faceOf;  // of each object
  std::vector<PartEdge> edges;
};

void addEdges(const std::vector<SharedEdge>& edges, Part& part) {
  for (const SharedEdge& shared : edges) {
    const auto a = part.faceOf.find(shared.faceA), b = part.faceOf.find(shared.faceB);
    PartEdge edge;
    edge.samePlace = shared.samePlace;
    if (a == part.faceOf.end() && b == part.faceOf.end()) continue;
    if (a == part.faceOf.end()) {
      edge.face = b->second;
      edge.line = shared.lineB;
      edge.side = shared.sideB;
      edge.along = shared.alongB;
    } else {
      edge.face = a->second;
      edge.line = shared.lineA;
      edge.side = shared.sideA;
      edge.along = shared.alongA;
      if (b != part.faceOf.end()) {
        edge.other = b->second;
        edge.otherLine = shared.lineB;
        edge.otherSide = shared.sideB;
        edge.otherAlong = shared.alongB;
      }
    }
    part.edges.push_back(std::move(edge));
  }
}

}  // namespace

ConvertedModel convertForm(Model& model, ConversionOptions options, const std::string& tolerance,
                           const JoinWishes& joins) {
  if (!tolerance.empty()) options.tolerance = lengthOf("--tolerance", tolerance, model.size());
  PartConversionOptions together;
  together.each = options;
  together.joinTolerance = joins.tolerance.empty() ? kJoinShare * options.tolerance
                                                   : lengthOf("--join-tolerance", joins.tolerance, model.size());
  if (!joins.angle.empty()) together.joinAngle = positiveNumber("--join-angle", joins.angle);
  const std::string unit = model.unit().empty() ? "" : " " + model.unit();
  ConvertedModel result;
  std::vector<std::pair<Index, AnySpline>> changes;
  std::vector<std::optional<AnySpline>> had;
  std::map<std::size_t, std::size_t> instanceOf;
  Part part;
  bool any = false;
  for (std::size_t i = 0; i < model.objects().size(); ++i) {
    const Object& object = model.objects()[i];
    had.push_back(object.spline);
    ConvertedObject& entry = result.objects.emplace_back();
    entry.name = object.name;
    entry.leftAlone = object.leftAlone;
    if (!object.leftAlone.empty() || !object.spline) continue;
    any = true;
    const auto at = static_cast<Index>(i);
    const Index first = object.sharedWith.empty()
                            ? at
                            : std::min(at, *std::min_element(object.sharedWith.begin(), object.sharedWith.end()));
    if (first < at) {
      instanceOf[i] = static_cast<std::size_t>(first);
      if (const auto face = part.faceOf.find(first); face != part.faceOf.end()) part.faceOf[at] = face->second;
    } else if (const auto* surface = std::get_if<Surface>(&*object.spline)) {
      part.faceOf[at] = static_cast<Index>(part.faces.size());
      part.faces.push_back({object.name, *surface});
      part.objects.push_back(at);
    } else {
      std::visit(
          [&]<int D>(const Spline<D>& spline) {
            Converted<D> made = convertAlone<D>(spline, options, object.name);
            takeOver<D>(spline, made, options, unit, entry);
            if (!made.unchanged) changes.emplace_back(at, std::move(made.spline));
          },
          *object.spline);
    }
  }
  if (!any) throw InvalidInput("the file holds no splines that could be converted: see strak info");
  const std::vector<SharedEdge> edges = model.sharedEdges();
  addEdges(edges, part);
  ConvertedPart made = convertPart(part.faces, part.edges, together);
  for (std::size_t f = 0; f < part.faces.size(); ++f) {
    const Index object = part.objects[f];
    takeOver<2>(part.faces[f].surface, made.faces[f], options, unit, result.objects[static_cast<std::size_t>(object)]);
    if (!made.faces[f].unchanged) changes.emplace_back(object, std::move(made.faces[f].spline));
  }
  // Instances are changed with the first.
  for (const auto& [instance, first] : instanceOf) {
    std::string name = std::move(result.objects[instance].name);
    result.objects[instance] = result.objects[first];
    result.objects[instance].name = std::move(name);
  }
  result.before = model.audit();
  const std::vector<std::string> refused = model.replaceForms(changes);
  for (std::size_t c = 0; c < changes.size(); ++c) {
    std::vector<Index> group = model.objects()[static_cast<std::size_t>(changes[c].first)].sharedWith;
    group.push_back(changes[c].first);
    for (Index i : group) {
      if (!refused[c].empty()) result.objects[static_cast<std::size_t>(i)].leftAlone = "refused: " + refused[c];
    }
  }
  result.after = model.audit();
  if (result.before.valid && !result.after.valid) {
    throw Failure("the CAD kernel's checker no longer accepts the converted model: give a smaller tolerance");
  }
  result.commonJoins = made.common;
  result.nearJoins = made.near;
  result.looseFaces = std::move(made.loose);
  result.joinTolerance = together.joinTolerance;
  std::vector<const Surface*> was;
  for (const auto& spline : had) was.push_back(spline ? std::get_if<Surface>(&*spline) : nullptr);
  // The edges as they were found: those that are not sewn may lie too far apart now.
  const auto measured = measureJoins(edges, was, surfacesOf(model.objects()));
  result.measuredJoins = static_cast<Index>(measured.size());
  const JoinSummary summary = summaryOf(measured);
  result.joinGap = summary.gap;
  result.joinAngle = summary.angle;
  return result;
}

std::string describe(const ConvertedModel& result, const std::string& unit) {
  Table table({"<object", "points", "now", "certified deviation", "of the sides", "<"});
  std::string remarks;
  for (const ConvertedObject& object : result.objects) {
    if (!object.leftAlone.empty()) {
      table.add({object.name, "", "", "", "", "left alone: " + object.leftAlone});
      continue;
    }
    std::vector<std::string> sides;
    for (double side : object.sides) sides.push_back(number(side));
    table.add({object.name, times(object.pointsBefore), times(object.points), number(object.certified),
               fmt::format("{}", fmt::join(sides, " ")), object.unchanged ? "as it was" : ""});
    if (!object.creases.empty()) {
      remarks += fmt::format("{} has creases, which uniform knots round (--nonuniform keeps them): {}\n", object.name,
                             fmt::join(object.creases, ", "));
    }
  }
  std::string text = table.text() + remarks;
  const std::string ending = unit.empty() ? "" : " " + unit;
  if (result.measuredJoins > 0) {
    text += fmt::format(
        "{} join{}, {} of them one curve on both faces: largest gap {} -> {}{}, largest angle but for features {} -> "
        "{} "
        "degrees\n",
        result.measuredJoins, result.measuredJoins == 1 ? "" : "s", result.commonJoins, number(result.joinGap.before),
        number(result.joinGap.after), ending, number(result.joinAngle.before), number(result.joinAngle.after));
  }
  for (const std::string& face : result.looseFaces) {
    text += fmt::format(
        "{}: to keep its joins within {}{}, and their angles, takes more control points than --most-points allows\n",
        face, number(result.joinTolerance), ending);
  }
  if (!result.after.edges.empty()) {
    text += fmt::format("edges fit their faces within {}{}, before within {}\n", number(result.after.largestGap),
                        ending, number(result.before.largestGap));
  }
  return text;
}

}  // namespace strak::cli
