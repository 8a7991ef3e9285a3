#pragma once
//
// Franke's function with noise, by the generator that other programs were measured with.

#include <cmath>
#include <numbers>
#include <random>

#include "strak/spline/evaluate.h"

namespace strak::test {

inline double franke(double x, double y) {
  const auto square = [](double a) { return a * a; };
  return 0.75 * std::exp(-(square(9 * x - 2) + square(9 * y - 2)) / 4) +
         0.75 * std::exp(-square(9 * x + 1) / 49 - (9 * y + 1) / 10) +
         0.5 * std::exp(-(square(9 * x - 7) + square(9 * y - 3)) / 4) -
         0.2 * std::exp(-square(9 * x - 4) - square(9 * y - 7));
}

// Rows x, y, franke(x, y) + 0.01 times a normally distributed number.
inline Net frankePoints(Index count, double noise = 0.01) {
  std::mt19937_64 random(42);
  const auto draw = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  Net points(count, 3);
  for (Index i = 0; i < count; ++i) {
    const double u = draw(), v = draw(), a = draw(), b = draw();
    const double gaussian = std::sqrt(-2 * std::log(1 - a)) * std::cos(2 * std::numbers::pi * b);
    points.row(i) << u, v, franke(u, v) + noise * gaussian;
  }
  return points;
}

// Root of the mean square of the error against the function without noise, on the grid (k / 199, l / 199).
inline double frankeError(const Surface& fit) {
  Surface::Grid grid;
  for (int k = 0; k < 200; ++k) {
    grid[0].push_back(k / 199.0);
    grid[1].push_back(k / 199.0);
  }
  const Net values = derivativesOnGrid<2>(fit, grid, 0);
  double sum = 0;
  for (Index r = 0; r < values.rows(); ++r) {
    const double e =
        values(r, 0) - franke(grid[0][static_cast<std::size_t>(r / 200)], grid[1][static_cast<std::size_t>(r % 200)]);
    sum += e * e;
  }
  return std::sqrt(sum / 40000);
}

}  // namespace strak::test
