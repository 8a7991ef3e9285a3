#pragma once
//
// Fits that pass exactly through some points in space whose parameters are not known.
//
// Their parameters become those of their closest points on a fit made without them; with these the fit is made anew,
// under exact conditions. Parameters of the others may be corrected in between. Source: the conditions of Hoschek and
// Juettler (5.11) together with their parameter correction (5.12).

#include <functional>

#include "strak/fitting/least_squares.h"

namespace strak {

struct ThroughOptions {
  double within = 1e-9;    // of the fit's size: how near is exact
  double farthest = 0.05;  // of it: a point farther from the fit made without it belongs to another shape
  int rounds = 10;
};

// Makes a fit anew that has the values of the points at these parameters, a row a point.
template <int D>
using ConditionalFitMaker = std::function<Fit<D>(const Net& parameters, const Fit<D>& previous)>;

template <int D>
struct ThroughFit {
  Fit<D> fit;
  Net parameters;             // of the points, on it
  Eigen::VectorXd distances;  // of the points from the fit made without them
  double largest = 0;         // from the result
  int rounds = 0;
};

// `fit` is made without the points; `points` has as many columns as it has coordinates. Throws InvalidInput for a
// function, and if a point lies too far away, with its number and distance; Failure if the rounds are used up before
// all are met (a maker that does not keep its conditions); as `make` does. Cost a round: that of `make`.
template <int D>
ThroughFit<D> fitThrough(const Fit<D>& fit, const Net& points, const ConditionalFitMaker<D>& make,
                         const ThroughOptions& options = {});

}  // namespace strak
