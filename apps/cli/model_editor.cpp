#include "apps/cli/model_editor.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/cli/console.h"
#include "strak/base/error.h"

namespace strak::cli {

namespace {

// How the model got worse by a change: empty if it did not.
std::string worsening(const Audit& before, const Audit& after, double size) {
  const double rounding = 1e-11 * size;
  if ((before.valid && !after.valid) || after.invalidFaces > before.invalidFaces) {
    return "the CAD kernel's checker no longer accepts the model with the change";
  }
  if (after.largestTolerance > before.largestTolerance + rounding) {
    return fmt::format("an edge's tolerance would rise from {} to {}", number(before.largestTolerance),
                       number(after.largestTolerance));
  }
  for (std::size_t e = 0; e < std::min(before.edges.size(), after.edges.size()); ++e) {
    if (after.edges[e].gap > before.edges[e].gap + rounding) {
      return fmt::format("the gap at {} would grow from {} to {}", after.edges[e].name, number(before.edges[e].gap),
                         number(after.edges[e].gap));
    }
  }
  return "";
}

}  // namespace

void ModelEditor::put(const Group& group, bool changed, bool bordersMove) {
  std::vector<std::pair<Index, AnySpline>> splines;
  for (Index index : group) splines.emplace_back(index, changed ? *entry(index).after : *entry(index).before);
  if (splines.size() == 1 && !bordersMove) {
    model_.replace(splines.front().first, splines.front().second);
  } else {
    model_.replaceTogether(splines);
  }
}

void ModelEditor::refuse(const Group& group, const std::string& reason) {
  for (Index index : group) {
    entry(index).after.reset();
    entry(index).leftAlone = "refused: " + reason;
  }
}

void ModelEditor::accept(const std::vector<Group>& groups, bool bordersMove) {
  if (groups.empty()) return;
  std::vector<Group> changed;
  for (const Group& group : groups) {
    const auto meets = [&](Index index) { return entry(index).newMeeting; };
    if (std::any_of(group.begin(), group.end(), meets)) {
      refuse(group, group.size() == 1 ? "the move makes it intersect itself: use a smaller tolerance"
                                      : "the move makes one of the faces intersect itself: use a smaller tolerance");
      continue;
    }
    try {
      put(group, true, bordersMove);
      changed.push_back(group);
    } catch (const InvalidInput& error) {
      refuse(group, error.what());
    }
  }
  Audit audit = model_.audit();
  const std::string reason = worsening(before_, audit, model_.size());
  if (reason.empty()) {
    after_ = std::move(audit);
    return;
  }
  for (const Group& group : changed) put(group, false, bordersMove);
  if (changed.size() == 1) {
    refuse(changed.front(), reason);
    return;
  }
  const auto middle = changed.begin() + static_cast<std::ptrdiff_t>(changed.size() / 2);
  accept({changed.begin(), middle}, bordersMove);
  accept({middle, changed.end()}, bordersMove);
}

}  // namespace strak::cli
