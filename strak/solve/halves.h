#pragma once
//
// Points halved across the longest side of the box around them: the step of nested dissection and of windows.

#include <Eigen/Core>
#include <vector>

namespace strak {

// Orders `points` (at least one; numbers of rows of `places`) so that the first points.size() / 2 of them lie on one
// side and returns that number. Equal places are told apart by their numbers, so the result depends on nothing else.
// O(n).
std::ptrdiff_t halveByPlace(std::vector<int>& points, const Eigen::Ref<const Eigen::MatrixX3d>& places);

}  // namespace strak
