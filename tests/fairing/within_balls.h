#pragma once

#include <gtest/gtest.h>

#include "strak/fairing/held_points.h"

namespace strak::testing {

// No control point moved further than the tolerance, and no held one at all.
template <int D>
void expectWithinBalls(const Spline<D>& before, const Spline<D>& after, const HeldPoints& held, double tolerance) {
  for (Index r = 0; r < before.net().rows(); ++r) {
    const double move = (after.net().row(r) - before.net().row(r)).norm();
    EXPECT_LE(move, tolerance) << "point " << r;
    if (held.empty() || held[static_cast<std::size_t>(r)] == 0) continue;
    for (Index c = 0; c < before.net().cols(); ++c) EXPECT_EQ(after.net()(r, c), before.net()(r, c)) << "point " << r;
  }
}

}  // namespace strak::testing
