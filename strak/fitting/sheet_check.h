#pragma once
//
// Whether a fitted surface is one sheet over its domain, and the points one sheet over the surface.

#include "strak/fitting/least_squares.h"

namespace strak {

// A larger doubt is no accident of steps and noise: the cloud is not one sheet.
inline constexpr double kNotOneSheet = 0.25;
// Points that lie farther from the surface, in the middle of all and in parts of its size, are no sheet but a heap.
inline constexpr double kThick = 0.015;

struct SheetCheck {
  // Knot cells, those that hang over the border of the cloud apart, in which the surface folds: its normal turns by
  // more than 90 degrees within half a cell, or its parameter lines touch.
  Index folded = 0, cells = 0;
  std::array<double, 2> foldedAt{};
  std::vector<std::array<Index, 2>> foldedCells;  // counted in knot spans of each direction
  // The part of the points in cells where their distances, with sign, fall into two groups: two layers of points. 0 if
  // the distances are below 3e-4 of the size: mesh vertices often have such patterns.
  double layered = 0;
  std::array<double, 2> layeredAt{};
  double thickness = 0;  // the median of the distances in parts of the surface's size
  // Parts of the cloud with a twentieth of the points at least and an empty strip of the domain between them, which is
  // wider than some three steps between points; the middle of the second largest.
  Index parts = 1;
  std::array<double, 2> partAt{};
  // Of `looked` points spread over all: how many lie at most half as far from another place of the surface, more than a
  // knot span away in the domain.
  Index astray = 0, looked = 0;
  Point astrayPoint;

  // The share of the points that do not lie as on one sheet.
  double doubt() const { return layered + astrayShare(); }
  double astrayShare() const { return looked > 0 ? static_cast<double>(astray) / static_cast<double>(looked) : 0; }
};

// Checks a surface in space against the points with their places on it. `mostLooked` bounds the search for nearer
// places, the costly part (some 10 microseconds a point); 0 leaves it out. Throws InvalidInput if the shapes do not
// match.
SheetCheck checkSheet(const Surface& surface, const FitPoints<2>& points, Index mostLooked = 2000);

}  // namespace strak
