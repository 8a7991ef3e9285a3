#pragma once
//
// Prescribed normals: a fit, or any surface, whose normals at given places are as wished, for a flow of reflection
// lines or joints that are nearly G1, and which is else as near to the points and as fair as before.
//
// With the lengths of the tangents X_u, X_v taken from the surface of the round before, the functional
//   Q5 = sum of (n . x_r)^2 + (n . x_s)^2 ,   x_r | x_s = (X_u / |X_u| +- X_v / |X_v|) / |the same|
// is quadratic in the control points and is there the sum of sin^2 of the angles between the wished tangent planes and
// the surface's. To the objective of the fit (least_squares.h) is added
//   weight * area * (mean of w Q5) ,
// so that an angle (in radians) left everywhere costs as much as errors of sqrt(weight) * angle * the surface's size:
// a weight means the same whatever the number of points and of normals, the units and the knots' scale.
// That the wished planes hold at all, n . X_u = n . X_v = 0, is linear in the control points whatever those lengths
// are: a weight as large as an angle needs is found by multipliers.
// Source: Dietz, in Hoschek and Juettler (5.14), (5.15); the errata on what Q5 does not see: it is zero, too, where the
// tangents vanish, and blind to the side of a normal. The scale and the multipliers are ours.

#include "strak/fitting/least_squares.h"

namespace strak {

// A row a normal.
struct WishedNormals {
  Net parameters;           // u, v
  Net normals;              // of any length above 0; which of both sides they point to does not matter
  Eigen::VectorXd weights;  // >= 0; empty: all 1
  // Not empty: places in space whose closest points on the surface shall have the normals. `parameters` may then be
  // empty, and are found anew while the surface moves. Not for functions.
  Net places;
};

struct NormalOptions {
  double weight = 0;      // of Q5; 0: as large as `degrees` needs
  double degrees = 1e-3;  // the largest angle that may be left, where the weight is free
  int rounds = 30;
  std::vector<Index> held;  // control points that stay, to the bit
  Net conditions;           // parameters of points that stay, a row each
  Progress progress;
};

enum class NormalStop {
  met,            // no angle is larger than wished
  settled,        // the weight is given: nothing moves any more
  contradictory,  // the net cannot turn into all wished planes: with the largest weight that does not crumple it
  rounds,
  cancelled
};
// "met", "settled", ...
const char* normalStopName(NormalStop stop);

struct NormalFit {
  Fit<2> fit;                            // with the new spline; its errors are those of the old one until takeErrors
  Net parameters;                        // of the normals
  Eigen::VectorXd anglesBefore, angles;  // degrees, 0 to 90
  double largest = 0, rms = 0;           // of those left; normals of weight 0 do not count in rms
  Index worst = 0;                       // the normal with the largest, from 0
  Index opposite = 0;                    // normals that point to the other side than most
  double weight = 0;                     // of Q5, the largest that was used
  double energyBefore = 0;
  int rounds = 0;
  NormalStop stop = NormalStop::met;
};

// Turns fit.spline: a function of two parameters or a surface in space. Cost a round: one sparse factor of the net's
// coordinates and some ten solutions, whatever the number of normals. Throws InvalidInput if normals are zero, not
// finite or outside the domain, if two at one place contradict one another (the weight being free), if those of a
// function are horizontal, or where the surface has no tangent plane.
NormalFit prescribeNormals(const Fit<2>& fit, const WishedNormals& wished, const NormalOptions& options = {});

// A given surface as its own fit: what moves it costs the mean square of the change and `smoothing` times the energy
// fitEnergy of the change, so that it stays as it is away from the normals. Throws InvalidInput for rational surfaces.
Fit<2> fitOfSurface(const Surface& surface, double smoothing);

// The smoothing with which a normal moves about as much of the surface as its control points can tell apart: the mean
// knot span, in parts of the root of the domain's area, to the power of twice the energy's order.
double naturalSmoothing(const Surface& surface);

}  // namespace strak
