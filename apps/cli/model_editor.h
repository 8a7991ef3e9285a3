#pragma once
//
// Puts changed splines into a model as long as its audit stays as good as it was.

#include <vector>

#include "strak/exchange/model.h"
#include "strak/report/fair_report.h"

namespace strak::cli {

class ModelEditor {
 public:
  // Objects that must change together, or one alone. Their entries hold the new splines.
  using Group = std::vector<Index>;

  // `before` and `entries` (one an object) must outlive the editor.
  ModelEditor(Model& model, const Audit& before, std::vector<FairedObject>& entries)
      : model_(model), before_(before), after_(before), entries_(entries) {}

  // Refuses groups with a spline that newly meets itself. Accepts all others at once if it can, else halves the set
  // until the culprits are alone: few audits for few culprits. The entries of a refused group lose their result and say
  // why. `bordersMove`: edges follow the faces, of a single face, too; always those of several.
  void accept(const std::vector<Group>& groups, bool bordersMove = false);

  const Audit& audit() const { return after_; }

 private:
  FairedObject& entry(Index index) { return entries_[static_cast<std::size_t>(index)]; }
  void put(const Group& group, bool changed, bool bordersMove);
  void refuse(const Group& group, const std::string& reason);

  Model& model_;
  const Audit& before_;
  Audit after_;
  std::vector<FairedObject>& entries_;
};

}  // namespace strak::cli
