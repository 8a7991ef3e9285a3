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
  double relativeError = 0;       // estimated error of the worst of the figures; near 1 where they are infinite
};

struct FairnessOptions {
  double relativeError = 1e-3;       // adaptive integration stops here (infinity: one pass, no refinement) ...
  Index maxEvaluations = 4'000'000;  // ... or here; one pass with 13 evaluations a span is always made
  bool (*inside)(double u, double v, const void* context) = nullptr;  // counts only where true (trimmed faces)
  const void* context = nullptr;
};

// Jumps of the curvature across knot lines of low continuity are not part of the integrals. Where the surface is
// singular (collapsed edges, cusps) the density counts as zero at the point itself. Method: two Gauss rules per knot
// span, compared; the cells that differ most are quartered until the sum of all differences is small, or until a figure
// has grown in proportion to its cells for eight rounds and so has no finite value. With `inside` the
// cells that it cuts count as independent errors. The result does not depend on the number of threads. Cost: 52
// evaluations with third derivatives a span where the surface is calm. Multi-threaded. Throws InvalidInput unless the
// surface lies in space (3 coordinates).
SurfaceFairness surfaceFairness(const Surface& surface, const FairnessOptions& options = {});

// Integrals along a curve of the plane or of space: length, int k^2 ds, int (dk/ds)^2 ds.
struct CurveFairness {
  double length = 0, bending = 0, curvatureVariation = 0;
};
// Throws InvalidInput for other dimensions. `inside` is not used.
CurveFairness curveFairness(const Curve& curve, const FairnessOptions& options = {});

}  // namespace strak
