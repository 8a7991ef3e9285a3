#pragma once
//
// The descent that exact fairing of one surface and of a whole part have in common: Gauss-Newton on the logarithms of
// the exact energies of all patches, inside balls on their refined differences, guarded by the figures of every patch.

#include <vector>

#include "strak/base/progress.h"
#include "strak/energy/shape_energy.h"
#include "strak/fairing/faired.h"
#include "strak/metrology/fairness.h"

namespace strak {

struct ShapePatch {
  Surface surface;
  std::vector<int> unknownOf;  // by control points: number of the unknown, -1: held. Patches may share unknowns
};

struct ShapeDescentOptions {
  double tolerance = kUnlimited;
  bool ballsOnPoints = false;
  int maxSteps = 40;
  Progress progress;
};

struct ShapeDescent {
  std::vector<Surface> surfaces;
  std::vector<SurfaceFairness> before, after;
  Index steps = 0;
  StopReason stopReason = StopReason::nothingFree;
  Index activeRows = 0;  // balls that the result touches
  double seconds = 0;    // wall clock
};

// The unknowns are numbered 0, 1, ... without gaps. Throws InvalidInput unless all surfaces lie in space, and if the
// energies leave a motion free (no tolerance and too little held).
ShapeDescent descendShape(const std::vector<ShapePatch>& patches, const ShapeDescentOptions& options);

}  // namespace strak
