#include "strak/metrology/trim_region.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "strak/metrology/deviation.h"
#include "strak/spline/evaluate.h"

namespace strak {
namespace {

using Polyline = std::vector<Eigen::Vector2d>;

KnotVector knots() { return KnotVector::uniformClamped(3, 8, -1, 3); }

Surface wavy(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-0.2, 0.2);
  Net net(121, 3);
  for (Index r = 0; r < 121; ++r)
    net.row(r) << static_cast<double>(r / 11), static_cast<double>(r % 11), number(random);
  return Surface({knots(), knots()}, std::move(net));
}

Polyline circle(double radius) {
  Polyline line;
  for (int i = 0; i <= 400; ++i) {
    const double angle = 2 * std::numbers::pi * i / 400;
    line.emplace_back(1 + radius * std::cos(angle), 1 + radius * std::sin(angle));
  }
  line.back() = line.front();
  return line;
}

const Polyline kOutline{{-1, -1}, {3, -1}, {3, 3}, {-1, 3}, {-1, -1}};

TEST(TrimRegionCover, BoxesInsideOutsideAndCut) {
  const TrimRegion disc(wavy(1), {circle(1)});
  const auto cover = [&](double u0, double u1, double v0, double v1) {
    return disc.cover({Eigen::Vector2d(u0, v0), Eigen::Vector2d(u1, v1)});
  };
  EXPECT_EQ(cover(0.5, 1.5, 0.5, 1.5), Cover::inside);
  EXPECT_EQ(cover(-1, -0.1, -1, 3), Cover::outside);
  EXPECT_EQ(cover(1.5, 3, 0, 2), Cover::cut);
  EXPECT_EQ(cover(-1, 3, -1, 3), Cover::cut);              // the whole curve lies inside
  EXPECT_EQ(cover(1.71, 1.8, 1.72, 1.8), Cover::outside);  // its box overlaps the circle's, the circle passes by
  EXPECT_EQ(cover(2, 2, 1, 1), Cover::cut);                // a point on the curve
  EXPECT_EQ(cover(1.9, 1.9, 1, 1), Cover::inside);
  EXPECT_EQ(cover(2.1, 2.1, 1, 1), Cover::outside);
}

TEST(TrimRegionCover, TheDomainsOwnBorderCutsNothing) {
  const TrimRegion whole(wavy(1), {kOutline});
  const TrimRegion holed(wavy(1), {kOutline, circle(0.2)});
  EXPECT_EQ(whole.cover({Eigen::Vector2d(-1, -1), Eigen::Vector2d(0, 3)}), Cover::inside);
  EXPECT_EQ(holed.cover({Eigen::Vector2d(-1, -1), Eigen::Vector2d(0, 3)}), Cover::inside);
  EXPECT_EQ(holed.cover({Eigen::Vector2d(0.95, 0.95), Eigen::Vector2d(1.05, 1.05)}), Cover::outside);
  EXPECT_EQ(holed.cover({Eigen::Vector2d(3.5, 3.5), Eigen::Vector2d(4, 4)}), Cover::outside);
}

// Against points: no cell that shows something is called outside, none that hides something inside.
TEST(TrimRegionCover, CellsAgreeWithPoints) {
  const Surface surface = wavy(1);
  const TrimRegion region(surface, {kOutline, circle(1.3), circle(0.45)});
  const auto cells = coverOfCells(surface, region);
  ASSERT_EQ(cells.size(), 64U);
  std::array<int, 3> count{};
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t j = 0; j < 8; ++j) {
      int seen = 0;
      for (int a = 0; a < 20; ++a) {
        for (int b = 0; b < 20; ++b) {
          seen += region.inside({-1 + 0.5 * (static_cast<double>(i) + (a + 0.5) / 20),
                                 -1 + 0.5 * (static_cast<double>(j) + (b + 0.5) / 20)});
        }
      }
      const Cover cover = cells[i * 8 + j];
      ++count[static_cast<std::size_t>(cover)];
      if (seen > 0 && seen < 400) {
        EXPECT_EQ(cover, Cover::cut);
      } else if (cover != Cover::cut) {
        EXPECT_EQ(cover, seen > 0 ? Cover::inside : Cover::outside);
      }
    }
  }
  EXPECT_GT(count[0], 0);
  EXPECT_GT(count[1], 0);
  EXPECT_LT(count[2], 40);
}

// The deviation on a disc, against many points of it.
TEST(TrimRegionDeviation, OnlyTheVisiblePartCounts) {
  for (unsigned seed : {1U, 2U, 3U}) {
    const Surface a = wavy(seed);
    Surface b = wavy(seed + 10);
    b.net().row(0) += Point::Constant(3, 50);  // far off in a corner that is cut away
    Surface finer = b;
    if (seed == 3) {
      // Other knots: the difference is made piece by piece.
      std::array<KnotVector, 2> other{KnotVector::uniformClamped(3, 8, -1, 3),
                                      KnotVector(3, {-1, -1, -1, -1, -0.4, 0, 0.5, 1, 1.4, 2, 2.6, 3, 3, 3, 3})};
      finer = Surface(other, b.net());
    }
    const TrimRegion region(a, {circle(1)});
    DeviationOptions options;
    options.relativeWidth = 1e-3;
    options.counts = TrimRegion::reaches;
    options.context = &region;
    const auto whole = certifyDeviation<2>(a, finer);
    const auto part = certifyDeviation<2>(a, finer, options);
    EXPECT_GT(whole.lower, 80);
    double sampled = 0;
    for (int i = 0; i <= 200; ++i) {
      for (int j = 0; j <= 200; ++j) {
        const double u = -1 + 0.02 * i, v = -1 + 0.02 * j;
        if (region.inside({u, v}))
          sampled = std::max(sampled, (evaluate<2>(a, {u, v}) - evaluate<2>(finer, {u, v})).norm());
      }
    }
    EXPECT_GE(part.upper, sampled);
    EXPECT_LE(part.lower, 1.02 * sampled);
    EXPECT_GE(part.lower, 0.98 * sampled);
    EXPECT_LE(part.upper, 1.001 * part.lower);
    EXPECT_LT((Eigen::Vector2d(part.place[0], part.place[1]) - Eigen::Vector2d(1, 1)).norm(), 1 + 2e-3);
  }
}

TEST(TrimRegionDeviation, NothingCountsNothingDiffers) {
  DeviationOptions options;
  options.counts = [](const double*, const double*, const void*) { return false; };
  EXPECT_EQ(certifyDeviation<2>(wavy(1), wavy(2), options).upper, 0);
  options.counts = [](const double*, const double*, const void*) { return true; };
  const auto all = certifyDeviation<2>(wavy(1), wavy(2), options), plain = certifyDeviation<2>(wavy(1), wavy(2));
  EXPECT_NEAR(all.upper, plain.upper, 2e-4 * plain.upper);
}

}  // namespace
}  // namespace strak
