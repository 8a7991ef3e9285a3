#pragma once
//
// Splines as things that can be drawn in space.

#include <string>
#include <vector>

#include "strak/exchange/model.h"

namespace strak {

// What a picture shows of one object: surfaces and curves with three coordinates. A volume gives its six boundary
// faces; points of the plane lie at z = 0; a function of one or two variables gives its graph (Greville abscissae).
// Coordinates beyond the third are not shown.
struct Drawable {
  std::vector<Surface> surfaces;
  std::vector<Curve> curves;
  bool plane = false;  // all of it lies in the plane z = 0
};
Drawable drawable(const AnySpline& spline);

}  // namespace strak
