#include "strak/fitting/loss.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "strak/base/error.h"

namespace strak {

namespace {

constexpr double kHuber = 1.345;
constexpr double kTukey = kOutlier;

// The median of |error| for normal noise of deviation 1 in one direction: errors of corrected parameters have one, and
// those of functions. For more it makes the scale larger, which is the safe side.
constexpr double kMedianOfNormal = 0.6744897501960817;

}  // namespace

Loss lossNamed(std::string_view name) {
  if (name == "huber") return Loss::huber;
  if (name == "tukey") return Loss::tukey;
  if (name == "l1") return Loss::absolute;
  throw InvalidInput(fmt::format("there is no loss '{}': choose l2, l1, linf, huber or tukey", name));
}

double lossOf(Loss loss, double r, double s) {
  switch (loss) {
    case Loss::huber:
      return r <= kHuber * s ? r * r : kHuber * s * (2 * r - kHuber * s);
    case Loss::tukey: {
      const double far = kTukey * s, inside = 1 - std::min(r / far, 1.0) * std::min(r / far, 1.0);
      return far * far / 3 * (1 - inside * inside * inside);
    }
    case Loss::absolute:
      return 2 * s * r;
  }
  return 0;
}

double lossWeight(Loss loss, double r, double s, double least) {
  switch (loss) {
    case Loss::huber:
      return r <= kHuber * s ? 1 : kHuber * s / r;
    case Loss::tukey: {
      const double inside = 1 - std::min(r / (kTukey * s), 1.0) * std::min(r / (kTukey * s), 1.0);
      return inside * inside;
    }
    case Loss::absolute:
      return s / std::hypot(r, least);
  }
  return 1;
}

double robustScale(Eigen::VectorXd errors) {
  double* const middle = errors.data() + errors.size() / 2;
  std::nth_element(errors.data(), middle, errors.data() + errors.size());
  return *middle / kMedianOfNormal;
}

}  // namespace strak
