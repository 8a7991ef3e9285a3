#include "apps/cli/other_form.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

#include "apps/cli/console.h"
#include "apps/cli/values.h"
#include "strak/base/error.h"

namespace strak::cli {

namespace {

template <int D>
Spline<D> convertObject(const Spline<D>& spline, const ConversionOptions& options, const std::string& unit,
                        ConvertedObject& object) {
  Converted<D> made = [&] {
    try {
      return convertSpline<D>(spline, options);
    } catch (const InvalidInput& error) {
      throw InvalidInput(fmt::format("'{}' cannot be converted: {}", object.name, error.what()));
    }
  }();
  object.unchanged = made.unchanged;
  object.lower = made.deviation.lower;
  object.certified = made.deviation.upper;
  object.sides.assign(made.sides.begin(), made.sides.end());
  const auto had = spline.sizes(), has = made.spline.sizes();
  object.pointsBefore.assign(had.begin(), had.end());
  object.points.assign(has.begin(), has.end());
  object.creases = std::move(made.creases);
  if (made.reached) return std::move(made.spline);
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

// A spline on its way into the model.
struct Change {
  Index object = 0;
  AnySpline had, made;
  ConversionOptions options;
};

Index spansOf(const Change& change, std::size_t direction) {
  return static_cast<Index>(std::get<Surface>(change.made).knots()[direction].spans().size());
}

// Faces that share whole sides get as many spans along them as the one that needs the most: their common side is then
// approximated alike, and stays common.
void evenOut(const Model& model, const std::string& unit, std::vector<Change>& changes,
             std::vector<ConvertedObject>& objects) {
  constexpr int kMostRounds = 8;
  const auto changeOf = [&](Index face) -> Change* {
    const std::vector<Index>& group = model.objects()[static_cast<std::size_t>(face)].sharedWith;
    const auto at = std::find_if(changes.begin(), changes.end(), [&](const Change& change) {
      return change.object == face || std::find(group.begin(), group.end(), change.object) != group.end();
    });
    return at == changes.end() ? nullptr : &*at;
  };
  const std::vector<SharedEdge> edges = model.sharedEdges();
  std::set<Change*> raised{nullptr};
  for (int round = 0; round < kMostRounds && !raised.empty(); ++round) {
    raised.clear();
    for (const SharedEdge& edge : edges) {
      if (!edge.sideA || !edge.sideB || edge.faceA == edge.faceB) continue;
      Change *const a = changeOf(edge.faceA), *const b = changeOf(edge.faceB);
      if (a == nullptr || b == nullptr) continue;
      // Sides 0 and 1 run along v, 2 and 3 along u.
      const auto alongA = static_cast<std::size_t>(1 - *edge.sideA / 2);
      const auto alongB = static_cast<std::size_t>(1 - *edge.sideB / 2);
      const Index wished = std::max(
          {spansOf(*a, alongA), spansOf(*b, alongB), a->options.leastSpans[alongA], b->options.leastSpans[alongB]});
      for (const auto& [change, along] : {std::pair{a, alongA}, std::pair{b, alongB}}) {
        if (change->options.leastSpans[along] >= wished) continue;
        change->options.leastSpans[along] = wished;
        if (spansOf(*change, along) < wished) raised.insert(change);
      }
    }
    for (Change* change : raised) {
      change->made = convertObject<2>(std::get<Surface>(change->had), change->options, unit,
                                      objects[static_cast<std::size_t>(change->object)]);
    }
  }
}

}  // namespace

ConvertedModel convertForm(Model& model, ConversionOptions options, const std::string& tolerance) {
  if (!tolerance.empty()) options.tolerance = lengthOf("--tolerance", tolerance, model.size());
  const std::string unit = model.unit().empty() ? "" : " " + model.unit();
  ConvertedModel result;
  std::vector<Change> made;
  std::map<std::size_t, std::size_t> instanceOf;
  bool any = false;
  for (std::size_t i = 0; i < model.objects().size(); ++i) {
    const Object& object = model.objects()[i];
    ConvertedObject entry;
    entry.name = object.name;
    entry.leftAlone = object.leftAlone;
    const auto first =
        object.sharedWith.empty()
            ? static_cast<Index>(i)
            : std::min(static_cast<Index>(i), *std::min_element(object.sharedWith.begin(), object.sharedWith.end()));
    if (object.leftAlone.empty() && object.spline && first < static_cast<Index>(i)) {
      instanceOf[i] = static_cast<std::size_t>(first);
    } else if (object.leftAlone.empty() && object.spline) {
      any = true;
      AnySpline next = std::visit(
          [&]<int D>(const Spline<D>& spline) { return AnySpline(convertObject<D>(spline, options, unit, entry)); },
          *object.spline);
      if (!entry.unchanged) made.push_back({static_cast<Index>(i), *object.spline, std::move(next), options});
    }
    result.objects.push_back(std::move(entry));
  }
  if (!any) throw InvalidInput("the file holds no splines that could be converted: see strak info");
  if (options.spacing == KnotSpacing::uniform) evenOut(model, unit, made, result.objects);
  // Instances are changed with the first.
  for (const auto& [instance, first] : instanceOf) {
    std::string name = std::move(result.objects[instance].name);
    result.objects[instance] = result.objects[first];
    result.objects[instance].name = std::move(name);
  }
  std::vector<std::pair<Index, AnySpline>> changes;
  for (Change& change : made) changes.emplace_back(change.object, std::move(change.made));
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
  if (!result.after.edges.empty()) {
    text += fmt::format("edges fit their faces within {}{}, before within {}\n", number(result.after.largestGap),
                        unit.empty() ? "" : " " + unit, number(result.before.largestGap));
  }
  return text;
}

}  // namespace strak::cli
