#pragma once
//
// `strak fit` with the energy that follows the data.

#include <string>

#include "apps/cli/json.h"
#include "strak/fitting/data_dependent_fit.h"

namespace strak::cli {

// Goes on from the thin plate's fit; `options` become those of the last round. Returns what there is to tell.
Json followEnergy(InnerBending bending, FitOptions<2>& options, const EnergyFitMaker& make, Fit<2>& fit);

std::string describeFollowing(const Json& following);

}  // namespace strak::cli
