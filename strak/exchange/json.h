#pragma once
//
// Splines as JSON, for programs that want to read them without a parser of their own:
//
//   {"strak": 1, "unit": "mm", "objects": [
//     {"name": "hood", "kind": "surface", "degrees": [3, 3], "knots": [[0, 0, ...], [...]], "rational": false,
//      "points": [[x, y, z], ...]}]}
//
// "kind" is curve, surface or volume; "points" are the rows of the control net, last direction fastest, homogeneous
// (x w, y w, z w, w) if "rational"; "name", "unit" and "rational" may be missing. Numbers are written with as many
// digits as it takes to read them back to the bit.

#include <string>
#include <string_view>
#include <vector>

#include "strak/exchange/plain_object.h"

namespace strak {

struct JsonContent {
  std::vector<PlainObject> objects;
  std::string unit;  // "" if the file has none
};

// Throws InvalidInput that names the line (for broken JSON) or the object and its part.
JsonContent parseJson(std::string_view text);

// Objects without a spline are skipped: the format holds splines only.
std::string formatJson(const JsonContent& content);

}  // namespace strak
