#pragma once
//
// Fairing as a whole: solve what a plan (plan_face.h) left free, then prove how far the new spline is from the old one.
//
// Source: Hadenfeld, sections 5 and 6; the deviation is certified on the surfaces themselves instead of the bound (13)
// by the control points, which is larger by 8 to 25 % on his examples.

#include "strak/base/progress.h"
#include "strak/energy/parameter_scale.h"
#include "strak/energy/quadratic_energy.h"
#include "strak/fairing/faired.h"
#include "strak/fairing/plan_face.h"
#include "strak/metrology/deviation.h"

namespace strak {

enum class FairingMethod {
  optimal,       // the constrained minimum at once (optimal_fairing.h)
  local,         // one point at a time, ranked by its true gain (local_fairing.h)
  localLiteral,  // the same with the ranking (6) as printed, for study: it hangs at points on their ball
};

enum class ToleranceKind {
  points,   // no control point moves further than the tolerance: (13)
  surface,  // the certified deviation is at most the tolerance; the balls are enlarged until it just reaches it
};

// "optimal", "local", "local-literal" and "points", "surface"; InvalidInput for other words.
FairingMethod fairingMethodNamed(std::string_view name);
ToleranceKind toleranceKindNamed(std::string_view name);
const char* toleranceKindName(ToleranceKind kind);

struct CertifiedFairingOptions {
  FairingMethod method = FairingMethod::optimal;
  double tolerance = kUnlimited;  // model units
  ToleranceKind toleranceKind = ToleranceKind::points;
  double gap = 1e-6;                           // stop once (E - E*) / E is certified to be at most this
  Index maxSteps = kUnlimitedSteps;            // point moves (local) or iterations (optimal) of one solve
  double minGain = 0;                          // local methods: stop once no point gains more
  Index maxChangesPerPoint = kUnlimitedSteps;  // local methods
  Index pointsPerList = 1;                     // local methods
  ParameterScale scale = ParameterScale::lengths;
  Progress progress;
};

template <int D>
struct CertifiedFairing {
  Spline<D> spline;                // on the knots of the plan
  FairingSummary summary;          // energies on the knots of the plan; steps and seconds of all solves together
  Deviation<D> deviation;          // from the input
  double heldMaxMove = 0;          // largest move of a held control point
  double ballRadius = kUnlimited;  // of the control points' balls in the end
};

// Fairs `plan.spline` with respect to `energy` and certifies the deviation of the result from `input`, of which the
// plan was made. With ToleranceKind::surface up to 8 solves find the ball radius at which the certified deviation lies
// between 0.999 tolerance and tolerance; the best of them that keeps the tolerance is returned (the first always does).
// A run stopped by its progress returns the best so far, marked as cancelled.
// Throws InvalidInput as the methods do, and if the plan leaves the spline alone.
template <int D>
CertifiedFairing<D> fairCertified(const Spline<D>& input, const FairingPlan<D>& plan, const QuadraticEnergy<D>& energy,
                                  const CertifiedFairingOptions& options = {});

}  // namespace strak
