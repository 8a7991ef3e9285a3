#pragma once
//
// The three surfaces of Hadenfeld, "Local Energy Fairing of B-Spline Surfaces", section 8, made again from what the
// paper says about them. The first is its own recipe; of the other two it gives size, kind and error only.

#include "strak/spline/spline.h"

namespace strak::paper {

// A surface and the points that it approximates.
struct Approximation {
  Surface surface;
  Net points;
};

// Example 1: 52 x 52 control points on the unit sphere, degree 4, equidistant knots with 5-fold ends; the inner 40 x 40
// moved by at most 0.02.
Surface perturbedSphere();

// Example 2: a bicubic surface of 10 x 12 segments, uniform knots with 4-fold ends, the least-squares approximation of
// a measured sheet; the largest boundary curve is about 350 long, the points' average distance about 0.726.
Approximation noisySheet();

// Example 3: a panel like a part of a car body, about 150 long. A bicubic least-squares surface of 52 x 13 control
// points and inner knots of multiplicity 3, of which one each is then removed: C1 at the inner knots.
Approximation bodyPanel();

}  // namespace strak::paper
