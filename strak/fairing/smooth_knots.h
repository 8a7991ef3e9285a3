#pragma once
//
// Smoothness across inner knots of high multiplicity that are not meant as creases.
//
// Files are often only C0 or C1 inside though nothing is to be seen there: Bezier patches put together, cubic splines
// made of Hermite pieces. An energy cannot see across such a knot line, so both sides would have to be held. Here the
// multiplicity is lowered by one copy after the other, the copy that moves least first, as long as the certified
// deviation holds. Source: the stepwise conversion of Eck and Hadenfeld (A Stepwise Algorithm for Converting B-Splines,
// 1994); the points are fitted together at each step instead of one knot's neighbours alone.

#include <string>
#include <vector>

#include "strak/base/progress.h"
#include "strak/metrology/deviation.h"

namespace strak {

template <int D>
struct SmoothKnotsOptions {
  double tolerance = 0;                           // of the certified deviation from the input
  double creaseAngle = 5 * 0.017453292519943295;  // radians: knot lines with a larger angle somewhere stay
  int continuity = 2;                             // wished: C2; at most degree - 1 is possible
  std::array<Index, 2 * D> rows{};  // derivatives kept at the sides, the value included, as in SimplifyOptions
  bool exactStrips =
      false;  // the image of those rows along the sides stays to rounding: only lines they do not need go
  Progress progress;
};

// Why a line stays that the borders need as they are: without `exactStrips` it might go.
inline constexpr const char* kNeededByBorders = "the held borders need it";

// What became of one knot (for surfaces: of one knot line).
struct SmoothedKnot {
  int direction = 0;
  double knot = 0;
  int multiplicityBefore = 0, multiplicityAfter = 0;
  double angle = 0;  // before, the largest along the line; radians
  std::string kept;  // why it is not as smooth as wished (a clause); empty if it is
};

template <int D>
struct SmoothedKnots {
  Spline<D> spline;                 // the input itself if nothing could be done
  Deviation<D> deviation;           // from the input
  std::vector<SmoothedKnot> lines;  // all knots with too high a multiplicity, direction by direction
  std::vector<std::string> notes;   // the same in a few sentences
};

// Lowers the multiplicity of inner knots to degree - continuity (at least 1). The angle is the one between the tangent
// planes for surfaces in space (innerContinuity), else between the derivatives across the knot along the lines of
// control points. Borders move with the rest, but two splines with the same border and knots keep one. Throws
// InvalidInput for a negative tolerance, angle, rows or continuity. Cost: some fits and certificates for each degree of
// smoothness.
template <int D>
SmoothedKnots<D> smoothKnots(const Spline<D>& spline, const SmoothKnotsOptions<D>& options);

}  // namespace strak
