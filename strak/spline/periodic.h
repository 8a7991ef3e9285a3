#pragma once
//
// Closed splines without a seam: between clamped end knots and knots that go on periodically.
//
// In periodic form the last control points repeat the first ones. Whatever is done to the net, alike to both, the
// spline is as smooth across its seam as at an inner knot. Only blossoms are taken, so the shape stays, and all control
// points but `smoothness` of them at each end keep their bits.
//
// Source: Piegl, Tiller, "The NURBS Book" (1997), section 12.2, unclamped ends; control points as blossoms: Ramshaw,
// "Blossoms are polar forms" (1989).

#include <optional>

#include "strak/spline/spline.h"

namespace strak {

// How smooth the spline is across its seam in `direction`, in parameters: the largest s <= degree - 1 such that
// toPeriodic takes it with smoothness s; -1 if it is not clamped there or not closed. Homogeneous points count: the
// weights must close, too. Cost O(degree^3 + degree times the points of a row).
template <int D>
int seamSmoothness(const Spline<D>& spline, int direction, double relativeTolerance = 1e-9);

// The spline with knots that go on periodically in `direction`, with multiplicity degree - smoothness at the seam, and
// as many control points as before. Points i and n - 1 - smoothness + i, i = 0 .. smoothness, are equal to the bit: one
// of the two as it was, or the mean of both continuations, which may differ by relativeTolerance of the size of the
// net (the extent of its points in space). Nothing if it is not clamped in that direction, less smooth than asked for,
// or has fewer than 2 (smoothness + 1) points there. Throws InvalidInput for a smoothness outside [0, degree - 1].
template <int D>
std::optional<Spline<D>> toPeriodic(const Spline<D>& spline, int direction, int smoothness,
                                    double relativeTolerance = 1e-9);

// The way back: (degree + 1)-fold knots at both ends of `direction` by knot insertion; as many control points, and all
// but those next to the ends keep their bits. One clamped already is returned as it is. The first and the last row of a
// periodic form become equal to the bit.
template <int D>
Spline<D> toClamped(const Spline<D>& spline, int direction);

}  // namespace strak
