#pragma once
//
// Figures of fairness that do not depend on the parametrization.

#include "strak/spline/spline.h"

namespace strak {

// Integrals over a surface in space (all zero for a plane):
struct SurfaceFairness {
  double area = 0;
  double plate = 0;               // int k1^2 + k2^2 dA, the exact bending energy; no unit
  double curvatureVariation = 0;  // MVS: int (dk1/de1)^2 + (dk2/de2)^2 dA; 1 / length^2
  double isophoteRoughness = 0;   // int |nabla h|^2 dA, h the second fundamental form: all lights; 1 / length^2
  double relativeError = 0;       // estimated error of the worst of the figures
};

struct FairnessOptions {
  double relativeError = 1e-4;    // adaptive integration stops here ...
  Index maxEvaluations = 4'000'000;  // ... or here
  bool (*inside)(double u, double v, const void* context) = nullptr;  // counts only where true (trimmed faces)
  const void* context = nullptr;
};

// Cost: about 50 evaluations with third derivatives a span where the surface is calm. Multi-threaded.
// Throws InvalidInput unless the surface lies in space (3 coordinates).
SurfaceFairness surfaceFairness(const Surface& surface, const FairnessOptions& options = {});

// Integrals along a curve: length, int k^2 ds, int (dk/ds)^2 ds.
struct CurveFairness {
  double length = 0, bending = 0, curvatureVariation = 0;
};
CurveFairness curveFairness(const Curve& curve, const FairnessOptions& options = {});

}  // namespace strak
