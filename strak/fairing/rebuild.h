#pragma once
//
// The best approximation of a spline on few uniform spans of a chosen degree: the class-A habit of single-span patches
// of degree 5 to 7.
//
// First the corners, then the curves between them, then the surface and the volume between those: each is the best in
// the mean square with its border kept, and then better in its largest deviation by Lawson's reweighting. So what lies
// along a side depends on that side alone: patches that meet along one curve with the same knots still meet. Source:
// Lawson, Contributions to the Theory of Linear Least Maximum Approximation (1961), for points: all coordinates share
// weights.

#include <array>

#include "strak/metrology/deviation.h"

namespace strak {

template <int D>
struct RebuildOptions {
  std::array<int, static_cast<std::size_t>(D)> degree{};   // 1 to 15 in every direction
  std::array<Index, static_cast<std::size_t>(D)> spans{};  // at least 1
  int reweightings = 40;  // at most so many, 0 for the mean square alone; nets above 500 inner points get none
};

template <int D>
struct Rebuilt {
  Spline<D> spline;         // polynomial, clamped, uniform knots on the domain of the input
  Deviation<D> deviation;   // from the input, parameter by parameter
  Deviation<D> meanSquare;  // of the approximation in the mean square, before reweighting
};

// Corners are interpolated. A rational input is approximated by a polynomial spline. The parametrization stays, so
// uneven knots of the input cost deviation. Throws InvalidInput for degrees and spans outside the limits above, and for
// nets above 10^7 points. Cost O(points of both nets degree^2), and for the reweighting some milliseconds to seconds.
template <int D>
Rebuilt<D> rebuild(const Spline<D>& spline, const RebuildOptions<D>& options);

}  // namespace strak
