#pragma once
//
// The borders of a cloud in its parameter plane: one outer loop for each part of it, and the loops around its holes.
//
// The cloud is the union of its Delaunay triangles with small circumscribed circles, an alpha shape (Edelsbrunner,
// Kirkpatrick and Seidel 1983); what is small is measured by the points around, so that the density may vary.

#include <vector>

#include "strak/spline/spline.h"

namespace strak {

struct BorderOptions {
  // Holes that a circle of this diameter fits into are holes, and so are bays of the border; 0: chosen by the spacing
  // of the points around.
  double gap = 0;
  double smallestPart = 0.02;  // parts with less of the points or the area of the one with most points are outliers
};

struct BorderLoop {
  std::vector<Index> points;  // numbers of the points along it; the cloud lies to the left
  double area = 0;            // inside the polygon, > 0: an outer border, < 0: a hole
  double spacing = 0;         // of the points next to it: how ragged it must be expected to be
};

struct BorderPart {
  BorderLoop outer;
  std::vector<BorderLoop> holes;
  double area = 0;   // of the part, holes left out
  Index points = 0;  // in it and on its border
};

struct Borders {
  std::vector<BorderPart> parts;  // the largest first
  double spacing = 0;             // the median distance of neighbours
  double gap = 0;                 // what counts as a hole where the points have that spacing
  Index leftOut = 0;              // points in no part: outliers
};

// The loops of the rows of `points` (two columns, in one unit of length). Loops are simple polygons without common
// points; where one point is all that joins two pieces they are cut there. Cost: a Delaunay triangulation (about two
// microseconds a point). Throws InvalidInput as delaunay does, for a negative gap, and if no three points make a
// triangle or the gap leaves none.
Borders findBorders(const Eigen::Ref<const Net>& points, const BorderOptions& options = {});

}  // namespace strak
