#pragma once
//
// The distance of two surfaces as sets of points, whatever their parameters.

#include <functional>

#include "strak/base/progress.h"
#include "strak/spline/spline.h"

namespace strak {

// One side: from each point of a surface to the nearest point of the other.
struct DirectedDistance {
  double max = 0;
  double rms = 0;                 // over the samples, a grid cell each
  std::array<double, 2> place{};  // parameters of the farthest point found
  Point point, nearest;           // that point, and the nearest one on the other surface
  Index samples = 0;
};

struct HausdorffDistance {
  DirectedDistance fromA, fromB;
  double distance = 0;   // the larger maximum
  bool complete = true;  // false if it was cancelled: then it is the distance of the samples seen
};

struct HausdorffOptions {
  // Samples per knot span and direction, with the spans' ends; raised until a direction has minSamples, lowered until
  // it has maxSamples (but two a span stay).
  Index samplesPerSpan = 4, minSamples = 32, maxSamples = 400;
  // Only samples where it is true (trimmed faces); empty: everywhere. Called from many threads.
  std::function<bool(double u, double v)> insideA{}, insideB{};
  Progress progress{};
};

// The two-sided Hausdorff distance by dense samples: a lower bound, sharpened around the worst sample of either side by
// ever finer grids. The surfaces may have any knots, degrees and domains.
// Cost: some 10 to 20 microseconds a sample. Multi-threaded; the result does not depend on the number of threads.
// Throws InvalidInput if the dimensions differ or the options are not positive.
HausdorffDistance hausdorffDistance(const Surface& a, const Surface& b, const HausdorffOptions& options = {});

}  // namespace strak
