#pragma once
//
// The knots that `strak fit` starts on.

#include <array>
#include <string>

#include "apps/cli/fit_points.h"

namespace strak::cli {

// The options' texts; empty where there are none.
struct KnotWishes {
  std::string degree, size, domain, mostPoints;
};

// Uniform knots over the domain that is asked for or the points' box, with as many control points as asked for, or one
// for four points; few where a tolerance decides. Throws InvalidInput if the points have no extent, or the size is too
// small for the degree or too large.
template <int D>
std::array<KnotVector, D> startKnots(const KnotWishes& wishes, const FitInput<D>& input, bool adaptive);

}  // namespace strak::cli
