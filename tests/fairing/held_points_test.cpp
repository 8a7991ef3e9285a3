#include "strak/fairing/held_points.h"

#include <gtest/gtest.h>

#include "strak/base/error.h"

namespace strak {
namespace {

TEST(HeldPoints, StripsAreCountedFromEverySide) {
  const auto u = KnotVector::uniformClamped(2, 5);  // 7 points
  const auto v = KnotVector::uniformClamped(3, 3);  // 6 points
  const Surface surface({u, v}, Net::Zero(42, 3));
  const auto held = holdStrips<2>(surface, {1, 2, 0, 3});
  for (Index i = 0; i < 7; ++i) {
    for (Index j = 0; j < 6; ++j) {
      EXPECT_EQ(held[static_cast<std::size_t>(i * 6 + j)] != 0, i < 1 || i >= 5 || j >= 3) << i << ", " << j;
    }
  }
}

TEST(HeldPoints, WideStripsHoldEverythingAndNegativeOnesAreRefused) {
  const Curve curve({KnotVector::uniformClamped(3, 2)}, Net::Zero(5, 2));
  for (auto held : holdStrips<1>(curve, {9, 0})) EXPECT_NE(held, 0);
  for (auto held : holdStrips<1>(curve, {0, 0})) EXPECT_EQ(held, 0);
  EXPECT_THROW(holdStrips<1>(curve, {-1, 0}), InvalidInput);
}

TEST(HeldPoints, ListsAreJoined) {
  EXPECT_EQ(holdBoth({1, 0, 0}, {0, 0, 7}), (HeldPoints{1, 0, 1}));
  EXPECT_EQ(holdBoth({}, {0, 1}), (HeldPoints{0, 1}));
  EXPECT_EQ(holdBoth({0, 1}, {}), (HeldPoints{0, 1}));
  EXPECT_THROW(holdBoth({0, 1}, {0}), InvalidInput);
}

}  // namespace
}  // namespace strak
