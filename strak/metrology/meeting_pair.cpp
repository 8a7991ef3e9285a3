#include "strak/metrology/meeting_pair.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace strak {

namespace {

constexpr double kEqual = 1e-12;    // of the size
constexpr double kCrossing = 1e-3;  // sine between tangent planes that cross
constexpr double kApart = 1e-6;     // of the size: the places of a crossing, at least, along the surface
constexpr double kFarApart = 1e-4;  // ... and of sheets that only touch
constexpr double kFromSide = 1e-9;  // of the domain
constexpr int kNewtonSteps = 20;

// The point and its first derivatives, as vectors in space.
template <int D>
struct Place {
  std::array<Eigen::Vector3d, D + 1> x;
  Place(const Evaluator<D>& evaluator, const std::array<double, D>& u) {
    const int dimension = evaluator.pointDimension();
    std::array<double, 3 * (D + 1)> out{};
    evaluator.derivatives(u, 1, out.data());
    for (int i = 0; i <= D; ++i) {
      x[static_cast<std::size_t>(i)].setZero();
      for (int c = 0; c < dimension; ++c)
        x[static_cast<std::size_t>(i)][c] = out[static_cast<std::size_t>(i * dimension + c)];
    }
  }
  // The normal of a surface, the tangent of a curve.
  Eigen::Vector3d direction() const {
    if constexpr (D == 2) return x[1].cross(x[2]);
    return x[1];
  }
};

template <int D>
bool areTwo(const BezierCells<D>& cells, const Evaluator<D>& evaluator, const std::array<double, D>& a,
            const std::array<double, D>& b) {
  const Place<D> first(evaluator, a), second(evaluator, b);
  std::array<double, D> half = a;
  Eigen::Vector3d along = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < D; ++k) {
    const double low = cells.from(k), high = cells.to(k), period = cells.period(k);
    double way = b[k] - a[k];
    if (cells.isClosed(k)) {
      way -= std::round(way / period) * period;
    } else if (std::min({a[k] - low, b[k] - low, high - a[k], high - b[k]}) < kFromSide * period) {
      return false;
    }
    half[k] += way / 2;
    if (half[k] < low) half[k] += period;
    if (half[k] > high) half[k] -= period;
    along += way * first.x[k + 1];
  }
  if ((Place<D>(evaluator, half).x[0] - first.x[0]).norm() > kFarApart * cells.size()) return true;
  const Eigen::Vector3d n = first.direction(), m = second.direction();
  return along.norm() > kApart * cells.size() && n.cross(m).norm() > kCrossing * n.norm() * m.norm();
}

}  // namespace

template <int D>
std::optional<MeetingPair<D>> findMeetingPair(const BezierCells<D>& cells, const Evaluator<D>& evaluator,
                                              std::array<double, D> a, std::array<double, D> b) {
  const double equal = kEqual * cells.size() + 4 * cells.rounding();
  for (int step = 0; step < kNewtonSteps; ++step) {
    const Place<D> first(evaluator, a), second(evaluator, b);
    const Eigen::Vector3d apart = first.x[0] - second.x[0];
    if (apart.norm() <= equal) {
      if (!areTwo<D>(cells, evaluator, a, b)) return {};
      return MeetingPair<D>{a, b, apart.norm()};
    }
    Eigen::Matrix<double, 3, 2 * D> jacobian;
    for (int k = 0; k < D; ++k) {
      jacobian.col(k) = first.x[static_cast<std::size_t>(k) + 1];
      jacobian.col(D + k) = -second.x[static_cast<std::size_t>(k) + 1];
    }
    const Eigen::Matrix<double, 2 * D, 1> lengths = jacobian.colwise().norm().transpose();
    if (!(lengths.minCoeff() > 0)) return {};
    const Eigen::Matrix<double, 3, 2 * D> even = jacobian * lengths.cwiseInverse().asDiagonal();
    const Eigen::Matrix<double, 2 * D, 1> move =
        even.completeOrthogonalDecomposition().solve(-apart).cwiseQuotient(lengths);
    for (std::size_t k = 0; k < D; ++k) {
      a[k] = std::clamp(a[k] + move[static_cast<Index>(k)], cells.from(k), cells.to(k));
      b[k] = std::clamp(b[k] + move[static_cast<Index>(D + k)], cells.from(k), cells.to(k));
    }
  }
  return {};
}

template std::optional<MeetingPair<1>> findMeetingPair<1>(const BezierCells<1>&, const Evaluator<1>&,
                                                          std::array<double, 1>, std::array<double, 1>);
template std::optional<MeetingPair<2>> findMeetingPair<2>(const BezierCells<2>&, const Evaluator<2>&,
                                                          std::array<double, 2>, std::array<double, 2>);

}  // namespace strak
