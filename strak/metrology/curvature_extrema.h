#pragma once
//
// The curvature extrema of a curve: how many places there are where its curvature changes between rising and falling.
// The number by which shipbuilders and designers judge a line: few extrema, few pieces of a french curve.

#include <vector>

#include "strak/spline/spline.h"

namespace strak {

// A place between two monotone stretches of the curvature, or (in a profile) an end of the curve.
struct CurvatureTurn {
  double parameter = 0;
  double curvature = 0;  // 1 / length; signed for curves that lie in a plane, also in space
};

struct CurvatureExtremaOptions {
  // A swing counts if the two curvatures differ by more than this part of the larger one, but at least by this part of
  // 1 / length of the curve: so rounding, digits of the input and straight parts do not count.
  double threshold = 0.01;
  Index samplesPerSpan = 16;
};

// The curvature as a zigzag of its counted turns.
struct CurvatureProfile {
  std::vector<CurvatureTurn> turns;  // ascending parameters; minima and maxima alternate
  CurvatureTurn begin, end;          // the ends of an open curve
  bool closed = false;               // the first turn follows the last one
  double length = 0;                 // of the curve

  Index extrema() const { return static_cast<Index>(turns.size()); }
};

// The counted extrema of a curve of the plane or of space. A curve whose ends meet with one tangent is closed: its
// curvature is a cyclic function (and the number even). Curvature that jumps at a knot counts with both values.
// Throws InvalidInput for other dimensions, a threshold that is not positive, or fewer than 2 samples.
// Cost: samplesPerSpan evaluations a span.
CurvatureProfile curvatureProfile(const Curve& curve, const CurvatureExtremaOptions& options = {});

// profile.extrema() of the same.
Index countCurvatureExtrema(const Curve& curve, const CurvatureExtremaOptions& options = {});

// The profile without its least significant swings, so that at most `count` extrema are left: again and again the
// neighbours whose asinh(curvature * length) differ least are taken out (in the middle both, at an open end one).
CurvatureProfile mostSignificant(CurvatureProfile profile, Index count);

// Whether the curvature is to rise (+1) or fall (-1) at a parameter between the turns of the profile; 0 if there is no
// swing at all.
int direction(const CurvatureProfile& profile, double parameter);

}  // namespace strak
