#pragma once
//
// Fair closed curves along the borders of a cloud: the trimming curves of a fitted surface.
//
// Between corners a loop is the stiffest cubic spline that the border allows (tube_curve.h): points may be as far from
// it as they stray from smooth lines themselves, so that a ragged border is smoothed and an exact one is kept; or as
// far as a tolerance says. Loops without corners close with continuous curvature.

#include <Eigen/Geometry>

#include "strak/fitting/border_loops.h"
#include "strak/metrology/loop_crossings.h"

namespace strak {

struct BorderCurveOptions {
  // How far border points may be from their curve, but no farther than half the mean width of what the loop surrounds;
  // 0: as far as they stray.
  double tolerance = 0;
  Eigen::AlignedBox2d domain;  // the curves stay inside; empty: anywhere
};

struct FairLoop {
  CurveLoop pieces;  // cubic, clamped; an end of a piece is the beginning of the next to the bit; the cloud to the left
  Index points = 0;  // border points
  Net feet;          // of each, the nearest place on the curves
  Index corners = 0;
  double tolerance = 0;
  double deviation = 0, rms = 0;  // of the border points from the curve
  double length = 0;
  double area = 0;   // as BorderLoop's
  Index pinned = 0;  // border points that the loop runs through straight: no fair curve keeps clear there
};

struct FairPart {
  FairLoop outer;
  std::vector<FairLoop> holes;
};

// The curves of the loops that findBorders has found in `points`. Curves are proven to cross neither themselves nor one
// another. Where smoothing would bring that about the loop is fitted again, along the polygon's edges, too, with a
// half, a quarter and an eighth of the tolerance; where that is not enough the border points around are joined by
// straight lines, more of them from round to round. Cost: tens of small fits a loop and round. Throws InvalidInput for
// a negative tolerance.
std::vector<FairPart> fairBorders(const Eigen::Ref<const Net>& points, const Borders& borders,
                                  const BorderCurveOptions& options = {});

}  // namespace strak
