#pragma once
//
// strak convert --rebuild: every spline of a file on few uniform spans of a chosen degree.

#include <memory>
#include <string>
#include <vector>

#include "strak/exchange/model.h"

namespace strak::cli {

// The certified deviation of one rebuilt object.
struct RebuiltObject {
  std::string name;
  double lower = 0, certified = 0;
};

struct RebuiltModel {
  std::unique_ptr<Model> model;        // the splines alone
  std::vector<RebuiltObject> objects;  // in the model's order
};

// `wish` is "DEGREE,SPANS", or all degrees and then all spans: "DU,DV,SU,SV" for surfaces. `tolerance` is a length as
// in lengthOf(), empty for none. Throws InvalidInput for another text and a file without splines; Failure if a
// certified deviation exceeds the tolerance.
RebuiltModel rebuildModel(const Model& model, const std::string& wish, const std::string& tolerance);

}  // namespace strak::cli
