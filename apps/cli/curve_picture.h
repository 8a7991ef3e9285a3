#pragma once
//
// The diagrams of curves that `strak render` draws.

#include <string>
#include <vector>

#include "strak/exchange/model.h"
#include "strak/report/curve_plot.h"

namespace strak::cli {

// Whether `kind` is one of curvature-plot, tolerance-band and k-orthotomic.
bool isCurvePicture(const std::string& kind);

// The diagram of the first curve among `objects`; `reference` the same objects of another file, or empty. Throws
// InvalidInput if there is no curve, or no reference for tolerance-band.
std::string curvePicture(const std::string& kind, const std::vector<Object>& objects,
                         const std::vector<Object>& reference, const CurvePlotOptions& options);

// "X,Y" of --pole. Throws InvalidInput.
Eigen::Vector2d planePoint(const std::string& option, const std::string& text);

}  // namespace strak::cli
