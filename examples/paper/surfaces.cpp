#include "examples/paper/surfaces.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "strak/spline/basis.h"
#include "strak/spline/knot_removal.h"

namespace strak::paper {

namespace {

// The same numbers on every machine.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : engine_(seed) {}
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double gaussian() {
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    return radius * std::cos(2 * std::numbers::pi * uniform());
  }

 private:
  std::mt19937_64 engine_;
};

// Basis functions (columns) at `count` parameters spread evenly over the domain.
Eigen::MatrixXd collocation(const KnotVector& knots, Index count) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(count, knots.size());
  for (Index i = 0; i < count; ++i) {
    const double u = knots.from() + knots.length() * static_cast<double>(i) / static_cast<double>(count - 1);
    const Index span = knots.findSpan(u);
    matrix.block(i, span - knots.degree(), 1, knots.degree() + 1) = basisDerivatives(knots, span, u, 0);
  }
  return matrix;
}

// Measures `shape` on a grid of rows x columns points with noise along z and fits a surface on `knots`, one direction
// after the other: for a grid that is the whole least-squares solution.
Approximation approximate(const std::array<KnotVector, 2>& knots, Index rows, Index columns,
                          const std::function<Eigen::RowVector3d(double, double)>& shape,
                          const std::function<double(double, double)>& noise) {
  Net points(rows * columns, 3);
  for (Index i = 0; i < rows; ++i) {
    for (Index j = 0; j < columns; ++j) {
      const double s = static_cast<double>(i) / static_cast<double>(rows - 1);
      const double t = static_cast<double>(j) / static_cast<double>(columns - 1);
      points.row(i * columns + j) = shape(s, t) + Eigen::RowVector3d(0, 0, noise(s, t));
    }
  }
  const Eigen::MatrixXd u = collocation(knots[0], rows);
  const Eigen::MatrixXd v = collocation(knots[1], columns);
  const Eigen::LLT<Eigen::MatrixXd> normalU(u.transpose() * u);
  const Eigen::LLT<Eigen::MatrixXd> normalV(v.transpose() * v);
  Net net(knots[0].size() * knots[1].size(), 3);
  for (Index c = 0; c < 3; ++c) {
    const Net column = points.col(c);
    const Net grid = column.reshaped<Eigen::RowMajor>(rows, columns);
    const Eigen::MatrixXd halfDone = normalU.solve(u.transpose() * grid);
    const Net done = normalV.solve(v.transpose() * halfDone.transpose()).transpose();
    net.col(c) = done.reshaped<Eigen::RowMajor>();
  }
  return {Surface(knots, std::move(net)), std::move(points)};
}

KnotVector repeatedKnots(int degree, Index spans, int multiplicity) {
  std::vector<double> knots(static_cast<std::size_t>(degree) + 1, 0);
  for (Index i = 1; i < spans; ++i) {
    knots.insert(knots.end(), static_cast<std::size_t>(multiplicity), static_cast<double>(i));
  }
  knots.insert(knots.end(), static_cast<std::size_t>(degree) + 1, static_cast<double>(spans));
  return {degree, std::move(knots)};
}

std::vector<double> innerValues(const KnotVector& knots) {
  std::vector<double> values;
  for (const auto& knot : knots.innerKnots()) values.push_back(knot.value);
  return values;
}

}  // namespace

Surface perturbedSphere() {
  constexpr Index kSize = 52;
  constexpr Index kMargin = 6;
  Net net(kSize * kSize, 3);
  for (Index i = 0; i < kSize; ++i) {
    for (Index j = 0; j < kSize; ++j) {
      const double longitude = -0.6 + 1.2 * static_cast<double>(i) / static_cast<double>(kSize - 1);
      const double latitude = -0.6 + 1.2 * static_cast<double>(j) / static_cast<double>(kSize - 1);
      net.row(i * kSize + j) << std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
          std::sin(latitude);
    }
  }
  Noise noise(1995);
  for (Index j = kMargin; j < kSize - kMargin; ++j) {
    for (Index i = kMargin; i < kSize - kMargin; ++i) {
      Eigen::RowVector3d r;
      do {
        for (int c = 0; c < 3; ++c) r[c] = 2 * noise.uniform() - 1;
      } while (r.squaredNorm() > 1);
      net.row(i * kSize + j) += 0.02 * r;
    }
  }
  const KnotVector knots = KnotVector::uniformClamped(4, kSize - 4);
  return {{knots, knots}, std::move(net)};
}

Approximation noisySheet() {
  Noise noise(1996);
  const auto shape = [](double s, double t) -> Eigen::RowVector3d {
    const double x = 2 * s - 1;
    const double y = 2 * t - 1;
    return {348 * s, 255 * t, 14 * (1 - x * x) + 7 * (1 - y * y) + 4 * x * y};
  };
  return approximate({KnotVector::uniformClamped(3, 10, 0, 10), KnotVector::uniformClamped(3, 12, 0, 12)}, 81, 97,
                     shape, [&](double, double) { return 0.925 * noise.gaussian(); });
}

Approximation bodyPanel() {
  Noise noise(1997);
  // A flank with a soft crease along it and a slight crown.
  const auto shape = [](double s, double t) -> Eigen::RowVector3d {
    const double crease = std::tanh(4 * (t - 0.55));
    return {149 * s, 38 * t + 3 * std::sin(3 * s),
            6 * std::sin(std::numbers::pi * s) * (1 - 0.4 * t) + 2.5 * crease - 5 * t * t};
  };
  // The edges are cut to a template: there the points are exact.
  const auto error = [&](double s, double t) {
    return 0.3 * std::min(1.0, 20 * std::min({s, 1 - s, t, 1 - t})) * noise.gaussian();
  };
  Approximation panel = approximate({repeatedKnots(3, 17, 3), repeatedKnots(3, 4, 3)}, 120, 32, shape, error);
  for (int k = 0; k < 2; ++k) {
    panel.surface = removeKnots<2>(panel.surface, k, innerValues(panel.surface.knots(k))).spline;
  }
  return panel;
}

}  // namespace strak::paper
