#pragma once
//
// Which control points stay where they are.

#include <array>
#include <cstdint>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

// One entry a control point, in the order of the net's rows: non-zero means held. An empty list holds none.
using HeldPoints = std::vector<std::uint8_t>;

// Strips of `rows[2 k]` rows at the low and `rows[2 k + 1]` rows at the high end of direction k (Hadenfeld's alpha and
// beta). With clamped knots 1, 2, 3 rows keep position, tangent plane and curvature along that side.
// Throws InvalidInput if a count is negative.
template <int D>
HeldPoints holdStrips(const Spline<D>& spline, const std::array<Index, 2 * D>& rows);

// Points held in either list (empty lists count as none).
HeldPoints holdBoth(const HeldPoints& a, const HeldPoints& b);

}  // namespace strak
