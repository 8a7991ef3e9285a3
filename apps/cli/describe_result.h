#pragma once
//
// The figures of a faired object, whatever method it was.

#include "strak/exchange/model.h"
#include "strak/fairing/faired.h"
#include "strak/metrology/deviation.h"
#include "strak/report/fair_report.h"

namespace strak::cli {

// Fills in everything that a person wants to know of `after`, made of `before`: of a trimmed face the visible part
// counts.
template <int D>
void describeResult(const Object& object, const Spline<D>& before, Spline<D> after, const FairingSummary& summary,
                    const Deviation<D>& deviation, FairedObject& entry);

}  // namespace strak::cli
