#pragma once
//
// What every fairing method returns.

#include <limits>
#include <string>

#include "strak/spline/spline.h"

namespace strak {

inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();
inline constexpr Index kUnlimitedSteps = std::numeric_limits<Index>::max();

enum class StopReason {
  gap,          // the certified gap is below the wished one
  gain,         // no single point gains as much as asked for any more
  steps,        // the allowed number of steps is used up
  cancelled,    // the caller asked to stop: the best net so far
  precision,    // no further progress in double precision; the gap says how far it came
  stalled,      // the literal ranking (6) keeps choosing points that cannot move: the paper's hang-up
  nothingFree,  // every point is held, or the tolerance is zero
  meetsItself,  // every move tried makes the spline intersect itself: it is the input
};

// "gap", "gain", "steps", "cancelled", "precision", "stalled", "nothing-free", "meets-itself".
const char* stopReasonName(StopReason reason);

struct FairingSummary {
  double energyBefore = 0;
  double energyAfter = 0;
  double gap = 0;   // certified: (energyAfter - least possible energy) / |energyAfter| is at most this
  Index steps = 0;  // point moves (local) or iterations (optimal)
  StopReason stopReason = StopReason::nothingFree;
  double seconds = 0;      // processor time of this thread, set-up included
  double largestMove = 0;  // largest distance of a control point from its original place
  Index freePoints = 0;
  Index activePoints = 0;  // free points that lie on their ball
};

template <int D>
struct Faired {
  Spline<D> spline;
  FairingSummary summary;
};

}  // namespace strak
