#pragma once
//
// Curvature of lenses, mirrors and corneas on a ring around their axis: what a keratometer sees.

#include <array>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

struct RingOptions {
  std::array<double, 2> centre{0, 0};  // x, y of the axis, which is parallel to z
  double radius = 1.5;                 // of the ring, seen along the axis
  Index meridians = 256;               // half meridians, evenly spread, an even number
};

// The axial (sagittal) curvature at the angle phi, from x towards y, is sin(slope along the meridian) / radius: one
// over the way along the normal back to the axis. Positive on a dome, negative in a bowl.
struct RingCurvature {
  std::vector<double> axial;  // at the angles 2 pi k / meridians
  double mean = 0;
  // The regular astigmatism: mean - part * cos(2 (phi - flatAngle)) fits best. flat and steep are its curvatures with
  // the smaller and the larger size, at right angles to each other.
  double flat = 0, steep = 0, flatAngle = 0, steepAngle = 0;  // angles in [0, pi)
  double irregular = 0;                                       // RMS of what mean and astigmatism leave
  // Of whole meridians, the mean of both halves, those with the least and the largest size: what topographers call
  // simulated keratometry. Not at right angles where the surface is irregular.
  double flattest = 0, steepest = 0, flattestAngle = 0, steepestAngle = 0;
};

// Throws InvalidInput if the surface does not lie in space, the options are out of range, or the ring leaves the
// surface or meets it where it is steep (no normal with a part along z). Cost: a closest point and a normal each.
RingCurvature ringCurvature(const Surface& surface, const RingOptions& options = {});

}  // namespace strak
