#include "apps/cli/joins.h"

#include <fmt/format.h>

#include "apps/cli/console.h"

namespace strak::cli {

namespace {

std::string inverse(const std::string& unit) { return unit.empty() ? "" : " 1/" + unit; }

}  // namespace

std::vector<EdgeJoin> joinsOf(const Model& model, const std::vector<FairedObject>& before) {
  std::vector<const Surface*> was;
  std::vector<const Surface*> is = surfacesOf(model.objects());
  for (std::size_t i = 0; i < before.size(); ++i) {
    const auto* surface = before[i].before ? std::get_if<Surface>(&*before[i].before) : nullptr;
    if (surface != nullptr && is[i] != nullptr && *surface == *is[i]) is[i] = surface;
    was.push_back(surface);
  }
  return measureJoins(model.sharedEdges(), was, is);
}

std::vector<EdgeJoin> joinsOf(const Model& model) {
  const std::vector<const Surface*> surfaces = surfacesOf(model.objects());
  return measureJoins(model.sharedEdges(), surfaces, surfaces);
}

std::string joinsText(const std::vector<EdgeJoin>& joins, const std::string& unit) {
  if (joins.empty()) return "";
  const JoinSummary summary = summaryOf(joins);
  const Index features = summary.before[static_cast<std::size_t>(JointKind::feature)];
  return fmt::format(
      "{} join{}{}: largest angle {} -> {} degrees (mean {} -> {}), curvature jump {} -> {}{} (mean {} -> {}), gap {} "
      "-> {}{}\n",
      joins.size(), joins.size() == 1 ? "" : "s", features > 0 ? fmt::format(" ({} features)", features) : "",
      number(summary.angle.before), number(summary.angle.after), number(summary.angleMean.before),
      number(summary.angleMean.after), number(summary.curvature.before), number(summary.curvature.after), inverse(unit),
      number(summary.curvatureMean.before), number(summary.curvatureMean.after), number(summary.gap.before),
      number(summary.gap.after), unit.empty() ? "" : " " + unit);
}

std::string joinCountText(const std::vector<EdgeJoin>& joins, const std::string& unit) {
  if (joins.empty()) return "";
  const JoinSummary summary = summaryOf(joins);
  std::string counts;
  for (const JointKind kind : {JointKind::g2, JointKind::g1, JointKind::g0, JointKind::feature}) {
    const Index count = summary.after[static_cast<std::size_t>(kind)];
    if (count > 0) counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", count, jointKindName(kind));
  }
  return fmt::format("{} join{}: {}; apart from features angle at most {} degrees, curvature jump {}{}, gap {}{}\n",
                     joins.size(), joins.size() == 1 ? "" : "s", counts, number(summary.angle.after),
                     number(summary.curvature.after), inverse(unit), number(summary.gap.after),
                     unit.empty() ? "" : " " + unit);
}

}  // namespace strak::cli
