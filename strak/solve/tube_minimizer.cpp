#include "strak/solve/tube_minimizer.h"

#include <algorithm>
#include <cmath>

namespace strak {

namespace {

using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 3, 3>;
using Eigen::ArrayXd;

constexpr int kMaxIterations = 60;

double dot(const Points& a, const Points& b) { return a.cwiseProduct(b).sum(); }

Points product(const PointMatrix& h, const Points& x) {
  const Eigen::VectorXd flat = h.product(Eigen::Map<const Eigen::VectorXd>(x.data(), x.size()));
  return Eigen::Map<const Points>(flat.data(), x.rows(), x.cols());
}

Points applyAll(const std::vector<TubeRow>& rows, const Points& y) {
  Points z(static_cast<Eigen::Index>(rows.size()), y.cols());
  for (std::size_t r = 0; r < rows.size(); ++r) z.row(static_cast<Eigen::Index>(r)) = rows[r].apply(y);
  return z;
}

// y += sum of factor_i row_i' z_i.
void addTransposed(const std::vector<TubeRow>& rows, const Points& z, const ArrayXd& factor, Points& y) {
  const Eigen::Index columns = y.cols();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto i = static_cast<Eigen::Index>(r);
    const double* point = z.data() + i * columns;
    for (std::size_t k = 0; k < rows[r].points.size(); ++k) {
      double* target = y.data() + rows[r].points[k] * columns;
      const double scale = factor[i] * rows[r].coefficients[k];
      for (Eigen::Index c = 0; c < columns; ++c) target[c] += scale * point[c];
    }
  }
}

ArrayXd rowDots(const Points& a, const Points& b) { return a.cwiseProduct(b).rowwise().sum().array(); }

// The largest step up to 1 that keeps x + step * dx >= (1 - part) x.
double longestStep(const ArrayXd& x, const ArrayXd& dx, double part) {
  double step = 1;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    if (dx[i] < 0) step = std::min(step, -part * x[i] / dx[i]);
  }
  return step;
}

}  // namespace

TubePoint TubeRow::apply(const Points& y) const {
  // Plain loops: this runs for every row in every iteration.
  double sum[3] = {0, 0, 0};
  const Eigen::Index columns = y.cols();
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double* row = y.data() + points[k] * columns;
    for (Eigen::Index c = 0; c < columns; ++c) sum[c] += coefficients[k] * row[c];
  }
  return Eigen::Map<const TubePoint>(sum, columns);
}

double largestRow(const std::vector<TubeRow>& rows, const Points& y) {
  double largest = 0;
  for (const TubeRow& row : rows) largest = std::max(largest, row.apply(y).norm());
  return largest;
}

TubeMinimizer::TubeMinimizer(std::vector<TubeRow> rows, double radius, const PointMatrix& pattern)
    : rows_(std::move(rows)), radius_(radius) {
  if (!std::isfinite(radius_)) rows_.clear();
  factor_.analyzePattern(pattern.lower());
}

TubeMinimizer::Result TubeMinimizer::minimizeFreely(const PointMatrix& h, const Points& g, const Points& y0) {
  factor_.factorize(h.lower());
  if (factor_.info() != Eigen::Success) return {y0, 0, 1, false};
  const Eigen::VectorXd step = factor_.solve(Eigen::Map<const Eigen::VectorXd>(g.data(), g.size()));
  if (!step.allFinite()) return {y0, 0, 1, false};
  return {y0 - Eigen::Map<const Points>(step.data(), y0.rows(), y0.cols()), 0, 1, true};
}

TubeMinimizer::Result TubeMinimizer::minimize(const PointMatrix& h, const Points& g, const Points& y0,
                                              double accuracy) {
  if (rows_.empty()) return minimizeFreely(h, g, y0);
  const auto m = static_cast<Eigen::Index>(rows_.size());
  const auto count = static_cast<double>(m);
  const int dimension = h.dimension();
  // Rows in parts of the radius: s_i = (1 - |z_i|^2) / 2 >= 0. Start inside.
  constexpr double kInside = 0.97;
  const double unit = 1 / radius_;
  Points y = y0 * std::min(1.0, kInside / std::max(1e-300, largestRow(rows_, y0) * unit));
  Points z = applyAll(rows_, y) * unit;
  ArrayXd s = (1 - rowDots(z, z)) / 2;
  double mu = std::max(0.1 * g.rowwise().norm().sum() * radius_ / count, accuracy / count);
  ArrayXd lambda = mu / s;
  Result result{y0, 0, 0, true};
  double lastGap = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Points away = y - y0;
    const Points hAway = product(h, away);
    Points dual = hAway + g;
    addTransposed(rows_, z, lambda * unit, dual);
    const ArrayXd primal = (1 - rowDots(z, z)) / 2 - s;
    mu = (lambda * s).sum() / count;
    const double fall = std::abs(dot(away, hAway) / 2 + dot(g, away));
    const double unbalanced = dual.rowwise().norm().sum() * radius_;
    lastGap = count * mu + unbalanced;
    if (lastGap <= std::max(0.01 * accuracy, std::min(accuracy, 1e-4 * fall)) && primal.abs().maxCoeff() < 1e-6) break;

    matrix_ = h;
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const auto i = static_cast<Eigen::Index>(r);
      const TubePoint point = z.row(i);
      const Block whole =
          (lambda[i] * unit * unit) * (Block::Identity(dimension, dimension) + point.transpose() * point / s[i]);
      const auto& row = rows_[r];
      for (std::size_t a = 0; a < row.points.size(); ++a) {
        for (std::size_t b = 0; b <= a; ++b) {
          const Block part = row.coefficients[a] * row.coefficients[b] * whole;
          matrix_.add(row.points[a], row.points[b], part);
        }
      }
    }
    factor_.factorize(matrix_.lower());
    ++result.factorizations;
    if (factor_.info() != Eigen::Success) break;

    Points dy;
    ArrayXd ds, dLambda;
    const auto solve = [&](const ArrayXd& complementarity, const ArrayXd& feasibility) {
      Points right = -dual;
      addTransposed(rows_, z, unit * (complementarity + lambda * feasibility) / s, right);
      const Eigen::VectorXd flat = factor_.solve(Eigen::Map<const Eigen::VectorXd>(right.data(), right.size()));
      dy = Eigen::Map<const Points>(flat.data(), y.rows(), y.cols());
      const ArrayXd along = rowDots(z, applyAll(rows_, dy)) * unit;
      ds = feasibility - along;
      dLambda = (-complementarity - lambda * ds) / s;
    };
    solve(lambda * s, primal);
    if (!dy.allFinite()) break;
    const double trial = std::min(longestStep(s, ds, 1), longestStep(lambda, dLambda, 1));
    const double muTrial = ((lambda + trial * dLambda) * (s + trial * ds)).sum() / count;
    const double centring = std::pow(std::clamp(muTrial / mu, 0.0, 1.0), 3);
    const Points bend = applyAll(rows_, dy) * unit;
    const ArrayXd cross = ds * dLambda;
    solve(lambda * s + cross - centring * mu, primal - rowDots(bend, bend) / 2);
    if (!dy.allFinite()) break;
    const double part = std::max(0.9, 1 - mu);
    const double step = std::min(longestStep(s, ds, std::min(part, 0.995)), longestStep(lambda, dLambda, 0.995));
    y += step * dy;
    s += step * ds;
    lambda += step * dLambda;
    z = applyAll(rows_, y) * unit;
    // What the curvature of the constraints leaves of room is taken at once.
    s = s.max((1 - rowDots(z, z)) / 2);
    if (step < 1e-8) break;
  }
  // Zero is feasible and the constraints are convex, so shrinking makes any point feasible.
  y /= std::max(1.0, largestRow(rows_, y) * unit);
  result.solved = result.factorizations > 0 && y.allFinite();
  if (result.solved) result.y = std::move(y);
  result.gap = lastGap;
  return result;
}

}  // namespace strak
