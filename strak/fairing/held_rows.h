#pragma once
//
// One direction of a net: which rows of points are held at its ends and its creases, and where knots go in so that rows
// between them are free.

#include <cstdint>
#include <vector>

#include "strak/spline/knot_vector.h"

namespace strak {

// How many rows are held at the two ends and at each side of every crease.
struct HeldBorders {
  Index low = 0, high = 0, crease = 0;
};

// Whether the energy of this order sees nothing across an inner knot of this multiplicity.
bool isCrease(const KnotVector& knots, Index multiplicity, int energyOrder);

// One entry a row, non-zero: held. At an end without clamped knots more rows are held, for more of them take part in
// the position there.
std::vector<std::uint8_t> heldRows(const KnotVector& knots, const HeldBorders& borders, int energyOrder);

// The knots to insert so that every stretch between ends and creases has a free row, and all of them together have
// minFree: the middles of the longest spans, again and again.
std::vector<double> knotsForRoom(const KnotVector& knots, const HeldBorders& borders, int energyOrder, Index minFree);

// The middles of the spans between parameters `from` and `to`.
std::vector<double> midSpans(const KnotVector& knots, double from, double to);

}  // namespace strak
