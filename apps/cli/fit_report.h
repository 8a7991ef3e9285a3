#pragma once
//
// What a fit has to tell, whatever its kind, as text and as JSON.

#include <string>
#include <vector>

#include "apps/cli/json.h"
#include "strak/fitting/adaptive_fit.h"
#include "strak/fitting/minimax_fit.h"
#include "strak/fitting/robust_fit.h"

namespace strak::cli {

struct FitReport {
  std::string kind;
  std::vector<int> degree;
  std::vector<Index> size;
  FitSummary summary;
  std::string scale;  // of the parameters in which the energy is measured
  double tolerance = 0;
  bool adaptive = false, reached = false;
  double share = 1;
  int rounds = 0;
  Index inserted = 0, removed = 0;
  Json outside = Json::array();
  bool streamed = false;
  Json loss, correction, drawing, conditions, following, normals, trimming;  // null where there is none
};

template <int D>
void takeOver(const AdaptiveFit<D>& fit, FitReport& report);
template <int D>
void takeOver(const RobustFit<D>& fit, const std::string& name, FitReport& report);
template <int D>
void takeOver(const MinimaxFit<D>& fit, FitReport& report);

Json jsonOf(const FitReport& report);
void print(const FitReport& report, const std::string& output, double seconds);

}  // namespace strak::cli
