#pragma once
//
// strak convert --uniform, --uniform-cubic, --nonuniform: the splines of a file in another form, in their places.

#include <string>
#include <vector>

#include "strak/exchange/model.h"
#include "strak/fairing/conversion.h"
#include "strak/report/before_after.h"

namespace strak::cli {

// What became of one object.
struct ConvertedObject {
  std::string name;
  std::string leftAlone;  // why it stays as it is (a clause); the rest is only set if it does not
  bool unchanged = false;
  double lower = 0, certified = 0;
  std::vector<double> sides;  // certified deviation of every side alone
  std::vector<Index> pointsBefore, points;
  std::vector<std::string> creases;
};

struct ConvertedModel {
  std::vector<ConvertedObject> objects;  // in the model's order
  Audit before, after;
  BeforeAfter joinGap, joinAngle;  // the largest of two faces, if measuredJoins > 0; features have no say in angles
  Index measuredJoins = 0, commonJoins = 0, nearJoins = 0;  // see ConvertedPart
  double joinTolerance = 0;
  std::vector<std::string> looseFaces;
};

// What joins of faces may open by: a length as in lengthOf(), empty for a tenth of the tolerance; and what their angles
// may change by, in degrees, empty for whatever comes.
struct JoinWishes {
  std::string tolerance, angle;
};

// Converts all splines that can be changed, faces with their trims. `options.tolerance` is not looked at but
// `tolerance`, a length as in lengthOf() or empty. Throws InvalidInput for a file without splines; Failure if the
// tolerance is not reached and if the kernel's checker no longer accepts the model: then it is not to be written.
ConvertedModel convertForm(Model& model, ConversionOptions options, const std::string& tolerance,
                           const JoinWishes& joins);

// A table for people.
std::string describe(const ConvertedModel& result, const std::string& unit);

}  // namespace strak::cli
