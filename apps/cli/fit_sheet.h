#pragma once
//
// `strak fit` of sheets in space whose points have no parameters: deep drawing, and what is said of the sheet.

#include "apps/cli/json.h"
#include "strak/fitting/deep_drawing.h"

namespace strak::cli {

// Throws InvalidInput, with a place, if the points lie in layers over the whole sheet.
DrawnCloud drawOrRefuse(const FitPoints<2>& points, const std::array<KnotVector, 2>& sizes, bool robust,
                        const Progress& progress);

Json jsonOf(const DrawnCloud& drawn);

// What is wrong with a sheet that is kept nevertheless.
std::vector<std::string> sheetWarnings(const SheetCheck& check, const Surface& surface);

}  // namespace strak::cli
