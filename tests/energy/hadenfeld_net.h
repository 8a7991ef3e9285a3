#pragma once
//
// Hadenfeld's first example, re-made: 52 x 52 points of the unit sphere as the control net of a bi-quartic surface with
// equally spaced clamped knots on [0, 1]; the inner 40 x 40 points moved by 0.02 times a uniform point of the unit
// ball.

#include <cmath>
#include <random>

#include "strak/spline/spline.h"

namespace strak::testing {

inline constexpr Index kHadenfeldSize = 52;

inline Surface hadenfeldSurface(bool perturbed) {
  constexpr Index kMargin = 6;
  Net net(kHadenfeldSize * kHadenfeldSize, 3);
  for (Index i = 0; i < kHadenfeldSize; ++i) {
    for (Index j = 0; j < kHadenfeldSize; ++j) {
      const double longitude = -0.6 + 1.2 * static_cast<double>(i) / 51;
      const double latitude = -0.6 + 1.2 * static_cast<double>(j) / 51;
      net.row(i * kHadenfeldSize + j) << std::cos(latitude) * std::cos(longitude),
          std::cos(latitude) * std::sin(longitude), std::sin(latitude);
    }
  }
  std::mt19937_64 random(1995);
  const auto coordinate = [&] { return 2 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1; };
  for (Index j = kMargin; perturbed && j < kHadenfeldSize - kMargin; ++j) {
    for (Index i = kMargin; i < kHadenfeldSize - kMargin; ++i) {
      Eigen::RowVector3d r;
      do {
        for (int c = 0; c < 3; ++c) r[c] = coordinate();
      } while (r.squaredNorm() > 1);
      net.row(i * kHadenfeldSize + j) += 0.02 * r;
    }
  }
  const KnotVector knots = KnotVector::uniformClamped(4, kHadenfeldSize - 4);
  return {{knots, knots}, std::move(net)};
}

}  // namespace strak::testing
