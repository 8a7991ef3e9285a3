#pragma once
//
// The k-orthotomic of a plane curve, an analysis picture: it has a cusp wherever the curve has an inflection.
//
// Source: Hoschek, "Smoothing of curves and surfaces", CAGD 2 (1985), 97-105; Hoschek, Lasser, "Fundamentals of
// Computer Aided Geometric Design" (1993), chapter 13.

#include <Eigen/Core>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

struct Orthotomic {
  Eigen::Vector2d pole;
  double factor = 2;
  std::vector<double> parameters;
  std::vector<Eigen::Vector2d> curve;   // the points x
  std::vector<Eigen::Vector2d> points;  // y = p + k ((x - p) . n) n
  std::vector<double> cusps;            // parameters where the curvature changes its sign
};

// y(u) = p + k ((x(u) - p) . n(u)) n(u), n the unit normal, p the pole: for k = 2 the image of p in the tangent. Its
// derivative is -k curvature |x'| times a vector that vanishes only where the tangent passes through p; so with p on no
// tangent it is regular exactly where the curve has no inflection. Throws InvalidInput unless the curve lies in the
// plane, k is finite and not zero, and there is at least one interval a span.
Orthotomic orthotomic(const Curve& curve, const Eigen::Vector2d& pole, double k = 2, Index samplesPerSpan = 16);

// A pole that few tangents come near: of a grid around the curve's box (as large again on each side) the place whose
// least distance from the tangents at 200 places is largest.
Eigen::Vector2d suggestedPole(const Curve& curve);

}  // namespace strak
