#pragma once
//
// `strak fit --conditions FILE`: points that the result passes through exactly.

#include <string>

#include "apps/cli/fit_points.h"

namespace strak::cli {

struct ConditionArguments {
  std::string file, columns;  // as given; no file: no conditions
  std::string points;         // the file that is fitted
};

// Conditions with parameters go into the options; the places of those without are returned, a row each. Throws
// InvalidInput if the columns are not those of the points.
template <int D>
Net takeConditions(const ConditionArguments& arguments, const FitColumns& columns, FitOptions<D>& options);

// The box of the points' parameters becomes that of the conditions', too.
template <int D>
void includeConditions(const FitOptions<D>& options, FitInput<D>& input);

}  // namespace strak::cli
