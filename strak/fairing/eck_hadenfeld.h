#pragma once
//
// Eck and Hadenfeld's local fairing of B-spline curves: one control point at a time moves to where the integral of the
// squared second or third derivative is least, which has a closed form; always the point that gains most.
//
// Source: Eck, Hadenfeld, "Local energy fairing of B-spline curves", Computing Suppl. 10 (1995), 129-147. The ranking
// counts the true gain inside the tolerance (Hoschek and Juettler (5.9)); with the ranking as first printed points on
// their ball stay first for ever.

#include "strak/base/progress.h"
#include "strak/fairing/faired.h"
#include "strak/fairing/held_points.h"

namespace strak {

struct EckHadenfeldOptions {
  int derivative = 2;             // 2 or 3: int |X''|^2 or int |X'''|^2 over the parameter
  double tolerance = kUnlimited;  // of every control point, so of the curve; model units
  HeldPoints held;                // stay to the bit
  Index maxSteps = 100'000;       // point moves
  double gain = 1e-9;             // stop once no point gains more than this part of the energy
  Progress progress;
};

// Throws InvalidInput for rational curves, a degree below the derivative, another derivative than 2 or 3, a negative
// tolerance or gain, or a list of another length. Cost of a step: O(n). Summary: the energy, moves, gain, gap infinite.
Faired<1> fairByEckHadenfeld(const Curve& curve, const EckHadenfeldOptions& options = {});

}  // namespace strak
