#pragma once
//
// What must be settled before a spline is made fair: which control points are held so that borders, trimming curves,
// creases, seams and poles stay exactly where they are, and where knots are inserted first (exactly) so that some
// points are free at all. In real files nine faces out of ten have no free point until then.
//
// Source: document 000 (Hadenfeld), section 5 for the strips; the rest is local support: a point of the surface depends
// on the (p + 1)(q + 1) control points of its span only.

#include <array>
#include <string>
#include <vector>

#include "strak/fairing/trimmed_face.h"

namespace strak {

template <int D>
struct FairingPlanOptions {
  // Rows held at the low and high side of every direction: 1 keeps the position along that side, 2 the tangent planes
  // and 3 the curvatures. Creases and seams keep the larger of their direction's two numbers on each side, poles 3.
  std::array<Index, 2 * D> rows = allRows(3);
  // Sides along which the spline follows a neighbour, or itself at a seam: no row is held for them.
  std::array<bool, 2 * D> joined{};
  int energyOrder = 2;  // highest derivative in the energy: decides which inner knots are creases
  bool refine = true;   // insert knots where too few points are free
  // Whether the energy is one of the shape (curvatures), so that splines with weights may have it, too: their knots are
  // inserted in homogeneous form. Quadratic energies of the derivatives do not know weights.
  bool rational = false;
  Index minFree = 4;      // free rows wanted in every direction; each stretch between creases gets at least one
  double maxGrowth = 16;  // the refined net has at most this many times the points (nets up to 4096 points always may)

  static constexpr std::array<Index, 2 * D> allRows(Index count) {
    std::array<Index, 2 * D> rows{};
    for (Index& r : rows) r = count;
    return rows;
  }
};

template <int D>
struct FairingPlan {
  Spline<D> spline;  // the input, perhaps with more knots: the same shape to rounding
  HeldPoints held;   // one entry a row of spline.net()
  Index freePoints = 0;
  Index knotsInserted = 0;         // over all directions
  std::vector<std::string> notes;  // sentences for the report
  std::string leftAlone;           // why nothing can be done (a clause, lower case); empty if fairing can go ahead
};

using FacePlan = FairingPlan<2>;
using PlanOptions = FairingPlanOptions<2>;

// Plans the fairing of a whole curve, surface or volume. Held are: strips at the sides; as many rows on each side of
// every crease, an inner knot whose multiplicity exceeds degree - energyOrder + 1, across which the energy sees
// nothing; the rows at a seam (first row = last row in space) and at a pole (a row shrunk to one point). Throws
// InvalidInput for negative rows or orders. Straight directions (degree 1, of surfaces, with `rational`) get no knots,
// which would be creases; where fewer than two rows are held at one of their sides and no side is joined the others may
// move. Cost O(points of the refined net).
template <int D>
FairingPlan<D> planFairing(const Spline<D>& spline, const FairingPlanOptions<D>& options = {});

// The same for a face. Strips are held at the sides that edges of the face run along, with more rows where an edge
// strays from its side; held are in addition all control points with influence on a cell of the knot grid that another
// edge touches (its image and all derivatives there stay to the bit), and those without influence on the visible part.
// Where the cells are too coarse for that all spans are halved, repeatedly.
FacePlan planFace(const Surface& surface, const FaceBorder& border, const PlanOptions& options = {});

}  // namespace strak
