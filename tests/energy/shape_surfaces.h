#pragma once
//
// Surfaces that the tests of the exact energies share.

#include <cmath>
#include <numbers>
#include <random>

#include "strak/spline/spline.h"

namespace strak::testing {

// A clamped net of the given degrees on a bent, slightly twisted sheet, each control point moved by up to `noise`.
inline Surface bentSheet(int p, int q, Index spansU, Index spansV, double noise = 0, unsigned seed = 1) {
  const KnotVector u = KnotVector::uniformClamped(p, spansU), v = KnotVector::uniformClamped(q, spansV, 0, 2);
  std::mt19937 engine(seed);
  const auto number = [&] { return 2 * static_cast<double>(engine()) / 4294967296.0 - 1; };
  Net net(u.size() * v.size(), 3);
  const auto gu = u.greville(), gv = v.greville();
  for (Index i = 0; i < u.size(); ++i) {
    for (Index j = 0; j < v.size(); ++j) {
      const double x = gu[static_cast<std::size_t>(i)], y = gv[static_cast<std::size_t>(j)];
      net.row(i * v.size() + j) << x + noise * number(), y + 0.1 * x + noise * number(),
          0.3 * std::sin(2 * x + 0.5 * y) + 0.2 * y * y + noise * number();
    }
  }
  return {{u, v}, net};
}

// The same with random weights between 0.7 and 1.4.
inline Surface withRandomWeights(const Surface& surface, unsigned seed = 1) {
  std::mt19937 engine(seed);
  Net net(surface.net().rows(), 4);
  for (Index r = 0; r < net.rows(); ++r) {
    const double w = 0.7 + 0.7 * static_cast<double>(engine()) / 4294967296.0;
    net.row(r) << w * surface.net().row(r), w;
  }
  return {surface.knots(), net, true};
}

// Every control point its own unknown.
inline std::vector<int> allFree(const Surface& surface) {
  std::vector<int> unknownOf(static_cast<std::size_t>(surface.net().rows()));
  for (std::size_t r = 0; r < unknownOf.size(); ++r) unknownOf[r] = static_cast<int>(r);
  return unknownOf;
}

// Some points free, two of which are one and the same.
inline std::vector<int> someFree(const Surface& surface) {
  std::vector<int> unknownOf(static_cast<std::size_t>(surface.net().rows()), -1);
  int unknowns = 0;
  for (std::size_t r = 7; r < unknownOf.size(); r += 2) unknownOf[r] = unknowns++;
  unknownOf[9] = unknownOf[7];
  return unknownOf;
}

}  // namespace strak::testing
