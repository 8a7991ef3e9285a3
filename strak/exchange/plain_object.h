#pragma once
//
// An object of a file that holds nothing but splines (.g2 and our JSON).

#include <optional>
#include <string>

#include "strak/exchange/model.h"

namespace strak {

struct PlainObject {
  std::string name;                 // empty if the file has none
  std::optional<AnySpline> spline;  // empty for other kinds
  std::string kind;                 // of another kind: what it is, for people
  std::string text;                 // of another kind: its text in the file, written back as it was
};

}  // namespace strak
