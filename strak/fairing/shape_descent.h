#pragma once
//
// The descent that exact fairing of one surface and of a whole part have in common: Gauss-Newton on the logarithms of
// the exact energies of all patches, inside balls on their refined differences, guarded by the figures of every patch.

#include <memory>
#include <optional>
#include <vector>

#include "strak/base/progress.h"
#include "strak/energy/join_energy.h"
#include "strak/energy/shape_energy.h"
#include "strak/fairing/faired.h"
#include "strak/fairing/held_points.h"
#include "strak/metrology/fairness.h"
#include "strak/solve/tied_points.h"

namespace strak {

struct ShapePatch {
  Surface surface;
  std::vector<int> unknownOf;  // by control points: number of the unknown, -1: held. Patches may share unknowns
  // The numbers above are those of points that follow from fewer unknowns, the same ones for all patches; null: they
  // are the unknowns.
  std::shared_ptr<const TiedPoints> tied = nullptr;
};

// A line along which two patches meet; their border points share unknowns, or those of bank A follow bank B's.
struct ShapeJoin {
  std::size_t patchA = 0, patchB = 0;
  JoinBank bankA, bankB;
  bool reversed = false;
  bool withJump = true;  // whether the curvature's jump is to get smaller, or only the angle
  // Patch A meets its own image in a mirror with this unit normal, and there is no patch B.
  std::optional<Eigen::Vector3d> mirror = {};
};

// The surface alone: what is not held is free, and numbered in the order of the net.
ShapePatch patchOf(const Surface& surface, const HeldPoints& held);

struct ShapeDescentOptions {
  double tolerance = kUnlimited;
  bool ballsOnPoints = false;
  int maxSteps = 40;  // and as many again whenever patches are withdrawn
  Progress progress = {};
};

struct ShapeDescent {
  std::vector<Surface> surfaces;
  std::vector<SurfaceFairness> before, after;        // of the patches, over the cells that free points move
  std::vector<JoinFigures> joinsBefore, joinsAfter;  // of the joins as given
  Index steps = 0;
  StopReason stopReason = StopReason::nothingFree;
  Index activeRows = 0;  // balls that the result touches
  double seconds = 0;    // wall clock
};

// Guarded are plate energy, curvature variation and roughness of every patch, and the mean angle and mean curvature
// jump of every join and of every inner knot line that is only C1: none is larger than before (lines that are smooth to
// 1e-5 rad, or to 2 % of their curvature, stay so; the largest angle at one place may rise to 0.1 degrees). Of
// several patches those for which that cannot be had stay where the input has them, and the others go on without them.
// Where a surface is singular and its integrals diverge, the descent's own quadrature must do. The unknowns are
// numbered 0, 1, ... without gaps. Throws InvalidInput unless all surfaces lie in space.
ShapeDescent descendShape(const std::vector<ShapePatch>& patches, const std::vector<ShapeJoin>& joins,
                          const ShapeDescentOptions& options);

}  // namespace strak
