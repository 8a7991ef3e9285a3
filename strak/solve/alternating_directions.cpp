#include "strak/solve/alternating_directions.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "strak/solve/free_system.h"

namespace strak {

using Eigen::Index;
using Points = FreeSystem::Points;

BallResult minimizeByAlternatingDirections(const BallProblem& p, const BallOptions& options, Field& e) {
  constexpr double kRelaxation = 1.7;
  constexpr Index kBalanceEvery = 15;
  const BoxLayout& layout = p.energy->layout();
  const FreeSystem system(p);
  const Eigen::VectorXd weight = system.matrix.diagonal();
  ShiftedFactor penalty(system.matrix), certificate(system.matrix);

  Points z = system.toPoints(layout, e);
  Points h = system.times(z) + system.linear;
  double value = z.cwiseProduct(h + system.linear).sum();
  // The multipliers of the start: on the balls, the part of the gradient that pulls outwards.
  double rho = 0.03;
  Points u = Points::Zero(z.rows(), z.cols());
  for (Index r = 0; r < z.rows(); ++r) {
    const double pull = -h.row(r).dot(z.row(r)) / (p.radius * p.radius);
    if (z.row(r).norm() > 0.999 * p.radius && pull > 0) u.row(r) = pull / (rho * weight[r]) * z.row(r);
  }
  BallResult best;
  best.value = value;
  best.bound = std::numeric_limits<double>::infinity();
  best.stop = BallResult::Stop::precision;
  Points bestZ = z;
  double lowerValue = -std::numeric_limits<double>::infinity();
  Eigen::VectorXd lambda(z.rows());
  if (!penalty.factor(rho * weight)) return best;

  Index nextCheck = 20;
  Index idle = 0;
  for (Index i = 1;; ++i) {
    const Points target = z - u;
    const Points x = penalty.solve(-system.linear + rho * (weight.asDiagonal() * target));
    const Points relaxed = kRelaxation * x + (1 - kRelaxation) * z;
    Points next = relaxed + u;
    for (Index r = 0; r < next.rows(); ++r) {
      const double length = next.row(r).norm();
      if (length > p.radius) next.row(r) *= p.radius / length;
    }
    u += relaxed - next;
    const Points change = next - z;
    z = next;
    // Both residuals relative to what they are measured against, so that their balance finds the scale of rho.
    const auto norm = [&](const Points& m) { return std::sqrt(m.rowwise().squaredNorm().dot(weight)); };
    const double primal = norm(x - z) / norm(z);
    const double dual = norm(change) / norm(u);
    const bool last = i >= options.maxIterations;
    if (i >= nextCheck || last) {
      nextCheck = i + std::max<Index>(20, i / 3);
      h = system.times(z) + system.linear;
      value = z.cwiseProduct(h + system.linear).sum();
      for (Index r = 0; r < z.rows(); ++r) lambda[r] = rho * weight[r] * u.row(r).norm() / p.radius;
      lowerValue = std::max(lowerValue, dualValue(system, p.radius, lambda, z, certificate));
      idle = value < best.value - 1e-3 * best.bound || best.value - lowerValue < 0.9 * best.bound ? 0 : idle + 1;
      if (value < best.value) {
        best.value = value;
        bestZ = z;
      }
      best.bound = std::max(best.value - lowerValue, 0.0);
      best.iterations = i;
      const double wished = std::max(options.gap * std::abs(p.scale + best.value), p.noise);
      if (best.bound <= wished) best.stop = BallResult::Stop::gap;
      const bool goOn = options.progress.report(best.bound <= wished ? 1 : wished / best.bound, "solving");
      if (best.stop != BallResult::Stop::gap) {
        best.stop = !goOn  ? BallResult::Stop::cancelled
                    : last ? BallResult::Stop::iterations
                           : BallResult::Stop::precision;
      }
      if (best.bound <= wished || !goOn || last || idle > 8) break;
    }
    if (i % kBalanceEvery == 0 && primal > 0 && dual > 0) {
      const double ratio = primal / dual;
      if (ratio > 3 || ratio < 1.0 / 3) {
        const double factor = std::clamp(std::sqrt(ratio), 0.1, 10.0);
        rho *= factor;
        u /= factor;
        if (!penalty.factor(rho * weight)) break;
      }
    }
  }
  system.toField(layout, bestZ, e);
  return best;
}

}  // namespace strak
