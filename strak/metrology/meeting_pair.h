#pragma once
//
// A pair of parameters with one image, by Newton's method.

#include <optional>

#include "strak/metrology/bezier_cells.h"
#include "strak/spline/evaluator.h"

namespace strak {

template <int D>
struct MeetingPair {
  std::array<double, D> a{}, b{};
  double distance = 0;  // of the images: rounding
};

// Solves S(a) = S(b) from a start, with steps of the least length along the surface. Nothing unless the images agree to
// 1e-12 of the size, both places are inside the domain (not on a side that is not closed), and are two: the tangent
// planes (of curves: the tangents) cross there, or the way between them leads far away. Cost: up to 20 steps of two
// evaluations.
template <int D>
std::optional<MeetingPair<D>> findMeetingPair(const BezierCells<D>& cells, const Evaluator<D>& evaluator,
                                              std::array<double, D> a, std::array<double, D> b);

}  // namespace strak
