#pragma once
//
// The certified distance, parameter by parameter, of two splines on the same domain.

#include "strak/spline/spline.h"

namespace strak {

template <int D>
struct Deviation {
  double lower = 0;               // |A(place) - B(place)|, really reached (rounding taken off)
  double upper = 0;               // no parameter has a larger distance: proven, rounding included
  std::array<double, D> place{};  // where `lower` was measured
};

struct DeviationOptions {
  double relativeWidth = 1e-4;   // stop once upper - lower <= relativeWidth * upper
  Index maxPatches = 2'000'000;  // or once so many Bezier pieces have been looked at: the bounds stay valid
  // Where not all of the domain counts, as on a trimmed face (TrimRegion::reaches): whether a box of it does, given by
  // D numbers each of its low and high corner; from = to asks for a point. A box with a part that counts must count;
  // called by many threads at once. Null: everything counts. If nothing does, the deviation is 0.
  bool (*counts)(const double* from, const double* to, const void* context) = nullptr;
  const void* context = nullptr;
};

// max over the domain of |A(u) - B(u)|. The splines may have different degrees and knots but must have the same domain
// (to 1e-12 of its length) and dimension; else, and for a width outside [0, 1), InvalidInput says what is wrong. Where
// a spline jumps, limits from both sides count.
//
// Method: the Bezier pieces of the difference on the cells between all knots. A cell whose control points are nearer
// than what has been reached somewhere is done (convex hull property: Hadenfeld (12), (13) made sharp); the others are
// halved, the farthest first. The corners of pieces are points of the difference and raise the lower bound. Same knots
// (and weights): the difference of the nets is used, with rounding relative to the difference; else the rounding is
// relative to the size of a span's points. Rational splines: A/v - B/w = (wA - vB)/(vw) as one rational patch, max
// |P_i|/w_i bounds it. `upper` contains 32 eps (4 + sum of degrees) times those sizes for rounding. Cost: 10^6 pieces
// in about a second. Multi-threaded; the result does not depend on the number of threads.
template <int D>
Deviation<D> certifyDeviation(const Spline<D>& a, const Spline<D>& b, const DeviationOptions& options = {});

}  // namespace strak
