#pragma once
//
// The part of the fairing report that is about curves: curvature before and after, and the way in the tolerance band.

#include <string>

#include "strak/report/fair_report.h"

namespace strak {

// HTML; empty if no curve was faired. The 12 curves with the most curvature extrema before.
std::string curveDiagrams(const FairReport& report);

}  // namespace strak
