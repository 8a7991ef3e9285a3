#pragma once
//
// Fairing that is not the quadratic optimum: curves by their exact energy, and the classical methods.

#include "apps/cli/fair_model.h"

namespace strak::cli {

// Whether `name` is a --method of this file: eck-hadenfeld, eck-hadenfeld-3, farin-sapidis, farin-degree, kjellander.
bool isClassicalMethod(const std::string& name);

// Fairs `spline` if the options ask for a classical method or, for curves, for the exact energy, and fills in the
// entry; false if they ask for something else. `rows`: held at the ends. Throws InvalidInput if the method is not for
// such a spline.
bool fairOtherwise(const Object& object, const Curve& spline, const std::array<Index, 2>& rows,
                   const FairModelOptions& options, const Progress& progress, FairedObject& entry);
bool fairOtherwise(const Object& object, const Surface& spline, const std::array<Index, 4>& rows,
                   const FairModelOptions& options, const Progress& progress, FairedObject& entry);

// Bending, curvature variation and curvature extrema before and after; nothing for other dimensions.
void measureCurve(const Curve& before, const Curve& after, FairedObject& entry);

}  // namespace strak::cli
