#pragma once
//
// Deep drawing: a surface near an unorganised cloud of points that lies as one sheet, however bent.
//
// A plane is drawn towards the points like a metal sheet towards a mould: the weight of the thin plate's energy falls
// step by step, and after each step the parameters become those of the closest points. The energy keeps the
// parametrization near to isometric and closes holes. Points whose foot lies beyond an edge pull the domain along.
// Source: Dietz, in Hoschek and Juettler, section 5, with (5.10), (5.12) and (5.13) as the errata correct them. That
// the schedule ends by cross validation, gives way before folds, holds what would fold, and that the domain
// grows by tangential steps is ours.

#include "strak/fitting/sheet_check.h"

namespace strak {

struct DeepDrawingOptions {
  std::array<int, 2> degree{3, 3};
  std::array<Index, 2> size{20, 20};  // control points, along the longer and the shorter direction of the cloud
  int steps = 60;                     // at most
  // Huber's weights by the distances of the step before: outliers neither bend the sheet nor enlarge its domain.
  // drawCloud draws plainly, too, and keeps what has the smaller mean distance.
  bool robust = false;
  Progress progress;
};

struct DrawnSheet {
  Fit<2> fit;
  Net parameters;           // of the points, on the fit; the domain is as large as the sheet
  Eigen::VectorXd weights;  // of the points in the fit; none: all alike
  std::vector<double> rms;  // of every step
  double stretch = 1;       // the domain's area, in parts of that of the points' projection
  bool folded = false;      // a lower weight would have made a fold ...
  std::vector<Index> held;  // ... and these control points were held where they were before it, the rest drawn on
  SheetCheck check;         // of the sheet that is returned
};

// Draws a sheet to points with their places in a plane as first parameters (planeParameters). Throws InvalidInput
// unless the points have three coordinates, if the first parameters have no extent, and as fitLeastSquares does. Cost a
// step: a fit, the closest points, and the check for folds; 15 to 30 steps.
DrawnSheet drawSheet(const FitPoints<2>& points, const DeepDrawingOptions& options = {});

// A sheet near points without parameters: drawn from their plane of least squares; if many points then lie in
// layers, it would fold, or is far from the points (a strip that waves higher than it is wide), from the planes of
// their other axes too. One of those is returned if its errors are less than half as large, but none with many layers
// instead of one without.
struct DrawnCloud {
  DrawnSheet sheet;
  int plane = 0;  // as in planeParameters
};
DrawnCloud drawCloud(const Net& points, const Eigen::VectorXd& weights, const DeepDrawingOptions& options = {});

}  // namespace strak
