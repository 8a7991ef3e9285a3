#pragma once
//
// Whether a curve or a surface meets itself: proven free, shown to meet itself, or not decided.

#include "strak/spline/spline.h"

namespace strak {

enum class SelfMeeting {
  free,        // proven: two parameters have two images (at a closed side: apart from the side itself)
  intersects,  // shown: a pair of parameters with one image
  undecided,   // neither, within the work allowed: cusps, poles, sheets that nearly touch
};

// "free", "intersects", "undecided".
const char* selfMeetingName(SelfMeeting answer);

template <int D>
struct SelfIntersection {
  SelfMeeting answer = SelfMeeting::free;
  std::array<double, D> a{}, b{};  // intersects: the pair; undecided: where a piece and its partner lie
  double distance = 0;             // intersects: |S(a) - S(b)|, rounding
  Index undecided = 0;             // pairs of pieces that could be neither separated nor shown to meet
  bool onlyAtPoles = false;        // all of those lie at a side that is shrunk to one point
};

template <int D>
struct SelfIntersectionOptions {
  Index maxPairs = 400'000;  // pairs of pieces looked at; what is left then is undecided
  int maxHalvings = 6;       // of a knot cell, a direction
  // A spline on the same knots: pairs of knot cells whose control points are the same in both are not looked at. Null:
  // all are.
  const Spline<D>* unchangedFrom = nullptr;
};

// Method: the domain is halved, down to parts of knot cells, and pairs of pieces are taken apart by boxes and along
// their normals around their Bezier points. A piece, or the rectangle around two neighbours, is free if for some
// vectors a, b and everywhere in it
//   (S_u du + S_v dv) . (a du + b dv) > 0   for all (du, dv) != 0:
// integrated along the segment between two parameters that says (S(x) - S(y)) . (a du + b dv) > 0. No condition on the
// border is needed, as it is with cones of normals (Volino and Thalmann 1994), because rectangles are convex. It is
// checked with boxes around the control points of S_u and S_v (rational: of w S_u and w S_v) and holds on every regular
// piece that is small enough, also across creases below a right angle or so and across closed sides. What is left is
// looked at with triangles and Newton's method for S(x) = S(y): a pair shown is equal to 1e-12 of the size, away from
// the sides, and either the tangent planes cross there or the parameters lie far apart.
// A side that meets its opposite one to 1e-9 of the size counts as closed. Invariant under the knots' scale. Rounding
// is allowed for. Throws InvalidInput unless the points have 2 (curves) or 3 coordinates. Cost: O(cells) where the
// surface is a graph over a plane, O(cells log cells) else, and what sheets that nearly touch need: about 1 us a pair.
// Multi-threaded; the result does not depend on the number of threads.
template <int D>
SelfIntersection<D> findSelfIntersection(const Spline<D>& spline, const SelfIntersectionOptions<D>& options = {});

template <int D>
struct MovedMeeting {
  SelfIntersection<D> found;  // of what the move changed: free means that it made no new meeting
  bool isNew = false;         // it is shown to meet itself, and before the move it was not
};

// Whether moving `before` to `after` made it meet itself. On the same knots only cells that have moved are looked at.
template <int D>
MovedMeeting<D> meetingAfterMove(const Spline<D>& before, const Spline<D>& after);

}  // namespace strak
