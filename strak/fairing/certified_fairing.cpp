#include "strak/fairing/certified_fairing.h"

#include <fmt/format.h>

#include <algorithm>

#include "strak/base/error.h"
#include "strak/fairing/local_fairing.h"
#include "strak/fairing/optimal_fairing.h"

namespace strak {

namespace {

constexpr int kMaxSolves = 8;
constexpr double kReached = 0.999;  // the part of the tolerance that is near enough to it

template <int D>
Faired<D> solve(const FairingPlan<D>& plan, const QuadraticEnergy<D>& energy, const CertifiedFairingOptions& options,
                double radius, const Progress& progress) {
  if (options.method == FairingMethod::optimal) {
    OptimalFairingOptions optimal;
    optimal.tolerance = radius;
    optimal.held = plan.held;
    optimal.gap = options.gap;
    optimal.scale = options.scale;
    optimal.maxIterations = options.maxSteps;
    optimal.progress = progress;
    return fairOptimally(plan.spline, energy, optimal);
  }
  LocalFairingOptions local;
  local.tolerance = radius;
  local.held = plan.held;
  local.gap = options.gap;
  local.minGain = options.minGain;
  local.maxSteps = options.maxSteps;
  local.maxChangesPerPoint = options.maxChangesPerPoint;
  local.pointsPerList = options.pointsPerList;
  local.ranking = options.method == FairingMethod::local ? RankingNumber::gain : RankingNumber::literal;
  local.scale = options.scale;
  local.progress = progress;
  return fairLocally(plan.spline, energy, local);
}

// The largest move of a control point that is held.
template <int D>
double heldMove(const FairingPlan<D>& plan, const Spline<D>& spline) {
  double largest = 0;
  for (std::size_t r = 0; r < plan.held.size(); ++r) {
    const auto row = static_cast<Index>(r);
    if (plan.held[r] != 0) largest = std::max(largest, (spline.net().row(row) - plan.spline.net().row(row)).norm());
  }
  return largest;
}

// Where the deviation, a growing function of the ball radius, is expected to meet the tolerance.
class RadiusSearch {
 public:
  explicit RadiusSearch(double tolerance) : tolerance_(tolerance), next_(tolerance) {}

  double next() const { return next_; }

  // Takes the deviation that next() led to.
  void add(double deviation) {
    if (deviation <= tolerance_) {
      low_ = next_;
      lowDeviation_ = deviation;
    } else {
      high_ = next_;
      highDeviation_ = deviation;
    }
    const double aim = (1 + kReached) / 2 * tolerance_;
    if (high_ == kUnlimited) {
      next_ = low_ * std::min(4.0, aim / lowDeviation_);
    } else {
      const double width = high_ - low_;
      const double secant = low_ + width * (aim - lowDeviation_) / (highDeviation_ - lowDeviation_);
      next_ = std::clamp(secant, low_ + 0.1 * width, high_ - 0.1 * width);
    }
  }

 private:
  double tolerance_, next_;
  double low_ = 0, lowDeviation_ = 0, highDeviation_ = 0;
  double high_ = kUnlimited;
};

}  // namespace

FairingMethod fairingMethodNamed(std::string_view name) {
  if (name == "optimal") return FairingMethod::optimal;
  if (name == "local") return FairingMethod::local;
  if (name == "local-literal") return FairingMethod::localLiteral;
  throw InvalidInput(fmt::format("there is no fairing method '{}': choose optimal, local or local-literal", name));
}

ToleranceKind toleranceKindNamed(std::string_view name) {
  if (name == "points") return ToleranceKind::points;
  if (name == "surface") return ToleranceKind::surface;
  throw InvalidInput(fmt::format("there is no tolerance kind '{}': choose points or surface", name));
}

const char* toleranceKindName(ToleranceKind kind) { return kind == ToleranceKind::points ? "points" : "surface"; }

template <int D>
CertifiedFairing<D> fairCertified(const Spline<D>& input, const FairingPlan<D>& plan, const QuadraticEnergy<D>& energy,
                                  const CertifiedFairingOptions& options) {
  if (!plan.leftAlone.empty()) throw InvalidInput(fmt::format("this spline cannot be faired: {}", plan.leftAlone));
  const bool search = options.toleranceKind == ToleranceKind::surface && options.tolerance < kUnlimited;
  const int solves = search ? kMaxSolves : 1;
  RadiusSearch radius(options.tolerance);
  CertifiedFairing<D> best;
  Index steps = 0;
  double seconds = 0;
  for (int k = 0; k < solves; ++k) {
    const Progress part([&options, k, solves](double fraction, std::string_view message) {
      return options.progress.report(fraction < 0 ? fraction : (k + fraction) / solves, message);
    });
    const double ball = search ? radius.next() : options.tolerance;
    Faired<D> faired = solve(plan, energy, options, ball, part);
    steps += faired.summary.steps;
    seconds += faired.summary.seconds;
    const auto deviation = certifyDeviation(input, faired.spline);
    const bool better = deviation.upper <= options.tolerance && faired.summary.energyAfter < best.summary.energyAfter;
    if (k == 0 || better) {
      best = {std::move(faired.spline), faired.summary, deviation, 0, ball};
    } else if (faired.summary.stopReason == StopReason::cancelled) {
      best.summary.stopReason = StopReason::cancelled;
    }
    if (best.summary.stopReason == StopReason::cancelled || best.summary.activePoints == 0) break;
    if (deviation.upper <= options.tolerance && deviation.upper >= kReached * options.tolerance) break;
    radius.add(deviation.upper);
  }
  best.summary.steps = steps;
  best.summary.seconds = seconds;
  best.heldMaxMove = heldMove(plan, best.spline);
  return best;
}

#define STRAK_INSTANTIATE(D)                                                                                     \
  template CertifiedFairing<D> fairCertified(const Spline<D>&, const FairingPlan<D>&, const QuadraticEnergy<D>&, \
                                             const CertifiedFairingOptions&);
STRAK_INSTANTIATE(1)
STRAK_INSTANTIATE(2)
STRAK_INSTANTIATE(3)
#undef STRAK_INSTANTIATE

}  // namespace strak
