#include "strak/solve/tube_minimizer.h"

#include <algorithm>
#include <cmath>

namespace strak {

namespace {

constexpr int kMaxOuter = 40;
constexpr int kMaxNewton = 40;
constexpr double kNewtonAccuracy = 1e-9;  // of the predicted decrease against the first one

double dot(const Points& a, const Points& b) { return a.cwiseProduct(b).sum(); }

Points product(const PointMatrix& h, const Points& x) {
  const Eigen::VectorXd flat = h.product(Eigen::Map<const Eigen::VectorXd>(x.data(), x.size()));
  return Eigen::Map<const Points>(flat.data(), x.rows(), x.cols());
}

}  // namespace

Eigen::RowVectorXd TubeRow::apply(const Points& y) const {
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(y.cols());
  for (std::size_t k = 0; k < points.size(); ++k) sum += coefficients[k] * y.row(points[k]);
  return sum;
}

double largestRow(const std::vector<TubeRow>& rows, const Points& y) {
  double largest = 0;
  for (const TubeRow& row : rows) largest = std::max(largest, row.apply(y).norm());
  return largest;
}

struct TubeMinimizer::State {
  Points y;
  PointMatrix matrix;
  int factorizations = 0;
};

TubeMinimizer::TubeMinimizer(std::vector<TubeRow> rows, double radius, const PointMatrix& pattern)
    : rows_(std::move(rows)), radius_(radius) {
  if (!std::isfinite(radius_)) rows_.clear();
  multipliers_ = Points::Zero(static_cast<Eigen::Index>(rows_.size()), pattern.dimension());
  factor_.analyzePattern(pattern.lower());
}

double TubeMinimizer::lagrangian(const PointMatrix& h, const Points& g, const Points& y0, const Points& y,
                                 Points* gradient) const {
  const Points step = y - y0;
  const Points hStep = product(h, step);
  double value = dot(step, hStep) / 2 + dot(g, step);
  if (gradient != nullptr) *gradient = hStep + g;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const auto i = static_cast<Eigen::Index>(r);
    const Eigen::RowVectorXd z = rows_[r].apply(y) + multipliers_.row(i) / stiffness_[i];
    const double over = z.norm() - radius_;
    if (over <= 0) continue;
    value += stiffness_[i] * over * over / 2;
    if (gradient == nullptr) continue;
    const Eigen::RowVectorXd force = stiffness_[i] * over / (over + radius_) * z;
    for (std::size_t k = 0; k < rows_[r].points.size(); ++k) {
      gradient->row(rows_[r].points[k]) += rows_[r].coefficients[k] * force;
    }
  }
  return value;
}

void TubeMinimizer::addCurvature(const Points& y, PointMatrix& matrix) const {
  const int dimension = matrix.dimension();
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const auto i = static_cast<Eigen::Index>(r);
    const Eigen::VectorXd z = (rows_[r].apply(y) + multipliers_.row(i) / stiffness_[i]).transpose();
    const double length = z.norm();
    if (length <= radius_) continue;
    const Eigen::VectorXd n = z / length;
    const Eigen::MatrixXd normal = n * n.transpose();
    const Eigen::MatrixXd block =
        stiffness_[i] * (normal + (1 - radius_ / length) * (Eigen::MatrixXd::Identity(dimension, dimension) - normal));
    const auto& points = rows_[r].points;
    for (std::size_t a = 0; a < points.size(); ++a) {
      for (std::size_t b = 0; b <= a; ++b) {
        matrix.add(points[a], points[b], rows_[r].coefficients[a] * rows_[r].coefficients[b] * block);
      }
    }
  }
}

bool TubeMinimizer::newton(const PointMatrix& h, const Points& g, const Points& y0, State& state) {
  double firstDecrease = 0;
  Points gradient;
  for (int k = 0; k < kMaxNewton; ++k) {
    const double value = lagrangian(h, g, y0, state.y, &gradient);
    state.matrix = h;
    addCurvature(state.y, state.matrix);
    factor_.factorize(state.matrix.lower());
    ++state.factorizations;
    if (factor_.info() != Eigen::Success) return false;
    const Eigen::VectorXd flat = factor_.solve(Eigen::Map<const Eigen::VectorXd>(gradient.data(), gradient.size()));
    const Points step = -Eigen::Map<const Points>(flat.data(), gradient.rows(), gradient.cols());
    const double slope = dot(gradient, step);
    if (!std::isfinite(slope)) return false;
    firstDecrease = std::max(firstDecrease, -slope);
    if (-slope <= kNewtonAccuracy * firstDecrease) return true;
    constexpr double kArmijo = 1e-4;
    double length = 1;
    while (length > 1e-6 && !(lagrangian(h, g, y0, state.y + length * step, nullptr) <= value + kArmijo * length * slope)) {
      length /= 2;
    }
    if (length <= 1e-6) return true;  // rounding hides what is left to gain
    state.y += length * step;
  }
  return true;
}

TubeMinimizer::Result TubeMinimizer::minimize(const PointMatrix& h, const Points& g, const Points& y0,
                                              double accuracy) {
  // As stiff as the energy itself for a single point: against the soft long waves that use up the tolerance that is
  // nearly a wall, and Newton's method does not mind.
  const Eigen::VectorXd diagonal = h.meanDiagonal();
  stiffness_.resize(static_cast<Eigen::Index>(rows_.size()));
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    double sum = 0;
    for (std::size_t k = 0; k < rows_[r].points.size(); ++k) {
      sum += std::abs(rows_[r].coefficients[k]) * diagonal[rows_[r].points[k]];
    }
    stiffness_[static_cast<Eigen::Index>(r)] = std::max(sum, std::numeric_limits<double>::min());
  }
  State state{y0, h, 0};
  Result result;
  for (int outer = 0; outer < kMaxOuter; ++outer) {
    if (!newton(h, g, y0, state)) {
      result.y = y0;
      result.solved = false;
      result.factorizations = state.factorizations;
      return result;
    }
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const auto i = static_cast<Eigen::Index>(r);
      const Eigen::RowVectorXd z = rows_[r].apply(state.y) + multipliers_.row(i) / stiffness_[i];
      const double over = z.norm() - radius_;
      multipliers_.row(i) = over > 0 ? Eigen::RowVectorXd(stiffness_[i] * over / (over + radius_) * z)
                                     : Eigen::RowVectorXd::Zero(z.size());
    }
    if (rows_.empty()) break;
    result.excess = std::max(0.0, largestRow(rows_, state.y) / radius_ - 1);
    if (result.excess <= accuracy) break;
  }
  // Zero is feasible and the constraints are convex, so shrinking makes any point feasible.
  if (result.excess > 0) state.y /= 1 + result.excess;
  result.y = std::move(state.y);
  result.factorizations = state.factorizations;
  return result;
}

}  // namespace strak
