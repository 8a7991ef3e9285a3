#include "strak/fairing/faired.h"

namespace strak {

const char* stopReasonName(StopReason reason) {
  switch (reason) {
    case StopReason::gap:
      return "gap";
    case StopReason::gain:
      return "gain";
    case StopReason::steps:
      return "steps";
    case StopReason::cancelled:
      return "cancelled";
    case StopReason::precision:
      return "precision";
    case StopReason::stalled:
      return "stalled";
    case StopReason::nothingFree:
      return "nothing-free";
    case StopReason::meetsItself:
      return "meets-itself";
  }
  return "unknown";
}

}  // namespace strak
