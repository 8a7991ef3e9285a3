#pragma once
//
// The curvature on a ring, as `strak info --ring` tells it.

#include <string>

#include "apps/cli/json.h"
#include "strak/metrology/ring_curvature.h"

namespace strak::cli {

// "X,Y,R" of --ring.
RingOptions ringNamed(const std::string& text);

// With a refractive index other than 1 the powers in dioptres too, (index - 1) * 1000 * curvature per millimetre.
Json jsonOf(const RingCurvature& ring, double index);
std::string ringText(const RingCurvature& ring, double index);

}  // namespace strak::cli
