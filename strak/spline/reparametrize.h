#pragma once
//
// The same geometry with other parameters: domain mapped, direction reversed, directions exchanged, part of the domain.
// Nothing here moves a point.

#include "strak/spline/spline.h"

namespace strak {

// `direction` mapped affinely to the domain [from, to]: X_new(from + t (to - from)) = X_old(a + t (b - a)).
// The net stays to the bit. Throws InvalidInput unless from < to.
template <int D>
Spline<D> withDomain(const Spline<D>& spline, int direction, double from, double to);

// Runs through `direction` backwards on the same domain [a, b]: X_new(u) = X_old(a + b - u). Control points keep their
// bits, knots may change in the last one.
template <int D>
Spline<D> reversed(const Spline<D>& spline, int direction);

// Direction k of the result is direction order[k] of the input. Throws InvalidInput unless `order` is a permutation.
template <int D>
Spline<D> permuted(const Spline<D>& spline, const typename Spline<D>::Directions& order);

// u and v exchanged.
Surface transposed(const Surface& surface);

// The part over [from, to] of `direction`, with clamped knots there. Throws InvalidInput unless from < to and both lie
// in the domain. Where the input is discontinuous at an end, the side inside [from, to] is taken.
template <int D>
Spline<D> subPatch(const Spline<D>& spline, int direction, double from, double to);

// The same in all directions at once.
template <int D>
Spline<D> subPatch(const Spline<D>& spline, const typename Spline<D>::Parameter& from,
                   const typename Spline<D>::Parameter& to);

// The same spline with (degree + 1)-fold end knots in all directions; a clamped one comes back to the bit.
template <int D>
Spline<D> clamped(const Spline<D>& spline);

}  // namespace strak
