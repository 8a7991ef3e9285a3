#pragma once
//
// Fairs the faces of a file that meet smoothly as one part, so that the joins between them get better.

#include "apps/cli/fair_model.h"
#include "apps/cli/model_editor.h"

namespace strak::cli {

// Works on every set of selected faces that smooth joins connect and puts the result into the model. Returns the
// numbers of the faces that are done; all others, and those of a set that could not be changed, are left for themselves
// (their entries say why in a note).
std::vector<Index> fairParts(Model& model, const FairModelOptions& options, ModelEditor& editor,
                             std::vector<FairedObject>& entries);

}  // namespace strak::cli
