#pragma once
//
// Fair closed curves along the borders of a cloud: the trimming curves of a fitted surface.
//
// Between corners a loop is the cubic spline of least squares with the energy of bending whose weight makes the product
// of mean squared error and energy least, a corner of the L-curve (Reginska 1996): a ragged border is smoothed, an
// exact one is kept. The tolerance bounds what smoothing may do. Loops without corners close with continuous curvature.

#include <Eigen/Geometry>

#include "strak/fitting/border_loops.h"
#include "strak/metrology/loop_crossings.h"

namespace strak {

struct BorderCurveOptions {
  double tolerance = 0;        // no border point is to be farther from its curve; 0: by the points next to each loop
  Eigen::AlignedBox2d domain;  // the curves stay inside; empty: anywhere
};

struct FairLoop {
  CurveLoop pieces;  // cubic, clamped; an end of a piece is the beginning of the next to the bit; the cloud to the left
  Index points = 0;  // border points
  Index corners = 0;
  double tolerance = 0;
  double deviation = 0, rms = 0;  // of the border points from the curve
  double length = 0;
  double area = 0;         // as BorderLoop's
  bool isPolygon = false;  // no fair curve keeps clear of the others: the polygon of the border points
};

struct FairPart {
  FairLoop outer;
  std::vector<FairLoop> holes;
};

// The curves of the loops that findBorders has found in `points`. Curves are proven to cross neither themselves nor one
// another; where smoothing would bring that about the loop is fitted again with a quarter of the tolerance, and if that
// does not do it becomes the polygon. Cost: some thirty small fits a loop. Throws InvalidInput for a negative
// tolerance.
std::vector<FairPart> fairBorders(const Eigen::Ref<const Net>& points, const Borders& borders,
                                  const BorderCurveOptions& options = {});

}  // namespace strak
