#pragma once
//
// Least squares with energy: the B-spline curve or surface on given knots that minimises
//   mean of w_k |z_k - X(u_k)|^2  +  lambda * E(X),
// functions z = f(x, y) as well as points in space with given parameters.
//
// E is measured in a domain of volume 1 that has the shape of the spline's (ParameterScale), so that lambda means the
// same whatever the number of points, the units of the coordinates and of the knots, and however fine the knots are.
// Source: Hoschek and Juettler (2.6), (5.10), (5.11), normalised as the errata ask.

#include <functional>
#include <string>
#include <vector>

#include "strak/base/progress.h"
#include "strak/energy/parameter_scale.h"
#include "strak/energy/quadratic_energy.h"
#include "strak/fitting/normal_equations.h"
#include "strak/fitting/smoothing.h"

namespace strak {

// Hands all points to the visitor, block by block, in the same order whenever it is called: points in memory are one
// block, those of a long file many.
template <int D>
using PointPass = std::function<void(const std::function<void(const FitPoints<D>&)>& visit)>;

// Points in memory, which must stay there as long as the pass.
template <int D>
PointPass<D> passOf(const FitPoints<D>& points) {
  return [points](const std::function<void(const FitPoints<D>&)>& visit) { visit(points); };
}

// The energy for splines of these degrees, if none is asked for: all third derivatives (it has the smaller errors on
// smooth shapes and does not see curvature, only its change), or all second, or first ones where the degree is lower.
template <int D>
QuadraticEnergy<D> fitEnergy(const std::array<KnotVector, D>& knots);

template <int D>
struct FitOptions {
  // No terms: fitEnergy, or the thin plate where the points do not determine the polynomials that it does not see.
  QuadraticEnergy<D> energy;
  // If not empty: K of an energy on the fit's knots, normalised by its maker, in place of the matrix made of `energy`,
  // which then only says the name and which polynomials the points have to determine.
  NetMatrix energyMatrix;
  // In which shape of the domain the energy is measured. For points in space the lengths are those of a stiff first
  // fit; for functions the knots are lengths already.
  ParameterScale scale = ParameterScale::lengths;
  Smoothing smoothing;
  double tolerance = 0;  // errors up to it count as inside

  // Control points that keep the values they have in `heldNet` (a row each control point), to the bit.
  std::vector<Index> held;
  Net heldNet;

  // X(parameters) = values exactly, for each row. The smoothing weight is chosen without them.
  Net conditionParameters, conditionValues;

  Progress progress;
};

struct FitSummary {
  Index points = 0, outsideDomain = 0;
  double lambda = 0;
  double freedom = 0;  // degrees of freedom of the fit, in effect
  double rms = 0;      // root of the weighted mean of the squared errors
  double max = 0;
  Index worstPoint = 0;            // its number, from 0
  std::vector<double> worstPlace;  // its parameters
  Index outsideTolerance = 0;
  std::string energyName;
  double energy = 0;           // in the normalised domain; lambda * energy is the second term
  double crossValidation = 0;  // root of the cross validation's estimate of the mean squared error of a new point
  int factorizations = 0;
  bool stopped = false;  // by the progress callback
  std::vector<std::string> warnings;

  double insideShare() const {
    return points == 0 ? 0 : 1 - static_cast<double>(outsideTolerance) / static_cast<double>(points);
  }
};

// Where the heights of a function fall into two groups in knot cells (a cloud of two sheets, a step): the part of the
// points in cells with enough points that lie in such ones, and the middle of the one with the largest errors.
template <int D>
struct TwoGroups {
  double share = 0;
  std::array<double, D> place{};
};

template <int D>
struct Fit {
  Spline<D> spline;  // as many coordinates as the values have
  FitSummary summary;
  std::vector<typename FitErrors<D>::Cell> cells;  // of the knot cells, the last direction fastest
  // The quadratic problem that the spline solves, a row a control point: that with the data, (mean of w B B^T) + lambda
  // K, and K alone. What comes after the fit (prescribed normals) is measured by them.
  NetMatrix system, energy;
};

// Fits a spline on `knots` to points with `columns` values each. Two passes over the points, the normal equations and
// the errors; a third between them where the errors are so small that the rounding of the first would show. Memory as
// the net. Cost: some tens of nanoseconds a point and pass, and 25 sparse factors (2 ms each for a bicubic 50 x 50 net)
// if the weight is chosen. Throws InvalidInput if no point lies in the domain, a number is not finite, options
// contradict one another, or the points do not determine the net (smoothing weight 0 or an energy that does not see
// what they leave open).
template <int D>
Fit<D> fitLeastSquares(const std::array<KnotVector, D>& knots, Index columns, const PointPass<D>& points,
                       const FitOptions<D>& options = {});

// The same for points in memory.
template <int D>
Fit<D> fitLeastSquares(const std::array<KnotVector, D>& knots, const FitPoints<D>& points,
                       const FitOptions<D>& options = {}) {
  return fitLeastSquares<D>(knots, points.values.cols(), passOf<D>(points), options);
}

// Writes the errors of fit.spline at the points into its summary and cells: counts, rms, largest, places. One pass.
template <int D>
void takeErrors(Fit<D>& fit, const PointPass<D>& points, double tolerance);

template <int D>
TwoGroups<D> twoGroups(const Fit<D>& fit);

// The knots with the domain scaled to volume 1 in the shape that `scale` says; see above.
template <int D>
std::array<KnotVector, D> normalisedKnots(const Spline<D>& spline, ParameterScale scale);

// K of the energy on these knots, whole.
template <int D>
NetMatrix energyMatrixOf(const QuadraticEnergy<D>& energy, const std::array<KnotVector, D>& knots);

// The graph of a function, (2.3): curve (x, f(x)) or surface (x, y, f(x, y)). Throws InvalidInput unless the function
// has one coordinate.
template <int D>
Spline<D> graphOf(const Spline<D>& function);

}  // namespace strak
