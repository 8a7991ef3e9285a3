#pragma once
//
// Parameters of noisy points along a curve.
//
// Where the noise is as large as the steps between the points, the length of their polygon is mostly noise, and a curve
// fitted with those parameters winds to follow them. As in deep drawing (strak/fitting/deep_drawing.h) a stiff curve is
// then drawn towards the points: the weight of its energy falls step by step, and after each step the parameters become
// those of the closest points, which the noise along the curve does not touch.
//
// Source: Dietz, in Hoschek and Juettler, section 5, there for surfaces; when to draw, and which parameters are kept,
// is ours.

#include "strak/fitting/least_squares.h"

namespace strak {

struct CurveDrawingOptions {
  int degree = 3;
  Index size = 50;  // control points
  // Huber's weights by the distances of the step before: outliers do not bend the curve.
  bool robust = false;
  Progress progress;
};

struct DrawnCurve {
  Net parameters;           // of the points, one column
  bool drawn = false;       // or they are the given ones: the noise is small, or they are as good
  std::vector<double> rms;  // of every step
};

// `points` come in their order with the lengths of their polygon (chordLengthParameters). Throws InvalidInput as
// fitLeastSquares does. Cost: some 20 fits and the closest points as often.
DrawnCurve drawCurve(const FitPoints<1>& points, const CurveDrawingOptions& options = {});

}  // namespace strak
