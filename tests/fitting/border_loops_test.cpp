#include "strak/fitting/border_loops.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "strak/base/error.h"
#include "tests/fitting/sheet_with_holes.h"

namespace strak {
namespace {

using namespace test;

const auto kEverywhere = [](double, double) { return true; };

std::vector<double> holeAreas(const BorderPart& part) {
  std::vector<double> areas;
  for (const BorderLoop& hole : part.holes) areas.push_back(-hole.area);
  std::sort(areas.rbegin(), areas.rend());
  return areas;
}

TEST(BorderLoops, RandomPointsOfASheetWithARoundAndASquareHole) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Net points = randomPoints(8000, seed, onSheet);
    const Borders borders = findBorders(points);
    ASSERT_EQ(borders.parts.size(), 1U);
    const BorderPart& part = borders.parts[0];
    const std::vector<double> holes = holeAreas(part);
    ASSERT_EQ(holes.size(), 2U) << seed;
    const double spacing = 1 / std::sqrt(8000 / (1 - kRoundArea - kSquareArea));
    EXPECT_NEAR(borders.spacing, 1.1 * spacing, 0.1 * spacing);
    // What is off is a strip along the border, narrower than the spacing.
    EXPECT_NEAR(part.outer.area, 1, 4 * spacing);
    EXPECT_LE(part.outer.area, 1);
    EXPECT_NEAR(holes[0], kRoundArea, 2 * 3.1416 * kRoundRadius * spacing);
    EXPECT_NEAR(holes[1], kSquareArea, 0.9 * spacing);
    EXPECT_GE(part.points + borders.leftOut, 8000);
    EXPECT_LE(borders.leftOut, 4);
    EXPECT_NEAR(part.area, part.outer.area - holes[0] - holes[1], 1e-12);
  }
}

TEST(BorderLoops, AGridsBorderIsExact) {
  const Borders borders = findBorders(gridPoints(80, onSheet));
  ASSERT_EQ(borders.parts.size(), 1U);
  EXPECT_NEAR(borders.parts[0].outer.area, 1, 1e-12);
  EXPECT_EQ(borders.parts[0].outer.points.size(), 320U);
  EXPECT_EQ(borders.leftOut, 0);
  const std::vector<double> holes = holeAreas(borders.parts[0]);
  ASSERT_EQ(holes.size(), 2U);
  // The corners of the square hole are cut off by at most two steps each way.
  EXPECT_LE(holes[1], kSquareArea + 1e-12);
  EXPECT_GE(holes[1], kSquareArea - 4 * 2.0 / 6400);
}

TEST(BorderLoops, LoopsAreSimpleAndShareNoPoint) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    // Thin enough for points that join pieces alone.
    const Net points =
        randomPoints(300, seed, [](double x, double y) { return std::fmod(7 * x * x + 5 * y, 1) < 0.6; });
    BorderOptions options;
    options.gap = 0.11;
    const Borders borders = findBorders(points, options);
    std::set<Index> seen;
    for (const BorderPart& part : borders.parts) {
      EXPECT_GT(part.outer.area, 0);
      std::vector<BorderLoop> loops = part.holes;
      double area = part.outer.area;
      for (const BorderLoop& hole : part.holes) {
        EXPECT_LT(hole.area, 0);
        area += hole.area;
      }
      EXPECT_NEAR(area, part.area, 1e-12);
      loops.push_back(part.outer);
      for (const BorderLoop& loop : loops) {
        for (Index i : loop.points) EXPECT_TRUE(seen.insert(i).second) << seed;
      }
    }
  }
}

TEST(BorderLoops, ACloudWithoutHolesHasNone) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Borders borders = findBorders(randomPoints(3000, seed, kEverywhere));
    ASSERT_EQ(borders.parts.size(), 1U);
    EXPECT_TRUE(borders.parts[0].holes.empty());
  }
}

TEST(BorderLoops, TheDensityMayVary) {
  // A hundred times as dense on the left as on the right.
  const Net points = randomPoints(6000, 1, [](double x, double y) { return onSheet(std::pow(x, 3), y); });
  Net stretched = points;
  stretched.col(0) = points.col(0).array().cube();
  const Borders borders = findBorders(stretched);
  ASSERT_EQ(borders.parts.size(), 1U);
  EXPECT_EQ(borders.parts[0].holes.size(), 2U);
}

TEST(BorderLoops, AHoleAtTheBorderIsABay) {
  const Borders borders = findBorders(gridPoints(60, [](double x, double y) { return std::hypot(x - 0.5, y) >= 0.2; }));
  ASSERT_EQ(borders.parts.size(), 1U);
  EXPECT_TRUE(borders.parts[0].holes.empty());
  EXPECT_NEAR(borders.parts[0].outer.area, 1 - 0.0628, 0.012);
}

TEST(BorderLoops, PartsAndOutliers) {
  Net points = randomPoints(4000, 3, [](double x, double) { return x < 0.5 || x > 0.7; });
  points.conservativeResize(points.rows() + 3, 2);
  points.bottomRows(3) << 2, 2, -3, 0.5, 0.6, 4;
  const Borders borders = findBorders(points);
  ASSERT_EQ(borders.parts.size(), 2U);
  EXPECT_NEAR(borders.parts[0].area, 0.5, 0.02);
  EXPECT_NEAR(borders.parts[1].area, 0.3, 0.02);
  EXPECT_GE(borders.leftOut, 3);
  EXPECT_LE(borders.leftOut, 5);
}

// Six and a half times the spacing; longer edges beside the channel do not widen what counts as a gap.
TEST(BorderLoops, AChannelPartsACloud) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Net points = randomPoints(2000, seed, [](double x, double) { return std::abs(x - 0.5) > 0.08; });
    EXPECT_EQ(findBorders(points).parts.size(), 2U) << seed;
  }
}

// The tips of spikes have edges to one another: needles of triangles between them are not of the cloud.
TEST(BorderLoops, NoBorderRunsFromSpikeToSpike) {
  const auto star = [](double x, double y) {
    const double turn = std::atan2(y - 0.5, x - 0.5) * 12 / 3.14159265358979;
    return std::hypot(x - 0.5, y - 0.5) < 0.25 + 0.2 * std::abs(turn - 2 * std::floor(turn / 2) - 1);
  };
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const Net points = randomPoints(2500, seed, star);
    const Borders borders = findBorders(points);
    ASSERT_EQ(borders.parts.size(), 1U) << seed;
    const std::vector<Index>& loop = borders.parts[0].outer.points;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      EXPECT_LT((points.row(loop[i]) - points.row(loop[(i + 1) % loop.size()])).norm(), 0.1) << seed;
    }
  }
}

// Few points far away, however wide the area among them is.
TEST(BorderLoops, StraysAreNeitherPartsNorJoinedToThem) {
  Net points = randomPoints(1000, 3, onSheet);
  points.conservativeResize(1012, 2);
  for (Index i = 0; i < 12; ++i) points.row(1000 + i) << 5 + 3.0 * static_cast<double>(i % 4), 5.0 * (1 + i / 4);
  const Borders borders = findBorders(points);
  ASSERT_EQ(borders.parts.size(), 1U);
  EXPECT_EQ(borders.leftOut, 12);
  EXPECT_NEAR(borders.parts[0].outer.area, 1, 0.1);
}

TEST(BorderLoops, TheGapDecidesWhatIsAHole) {
  const Net points = gridPoints(80, onSheet);
  BorderOptions options;
  options.gap = 0.15;  // the round hole is 0.3 wide, the other 0.2 by 0.25
  EXPECT_EQ(findBorders(points, options).parts[0].holes.size(), 2U);
  options.gap = 0.25;
  const Borders one = findBorders(points, options);
  EXPECT_EQ(one.gap, 0.25);
  EXPECT_EQ(one.parts[0].holes.size(), 1U);
  options.gap = 0.5;
  EXPECT_TRUE(findBorders(points, options).parts[0].holes.empty());
}

TEST(BorderLoops, NothingDependsOnPlaceAndUnit) {
  const Net points = randomPoints(2000, 4, onSheet);
  const Borders before = findBorders(points);
  Net moved = 1e4 * points;
  moved.col(0).array() += 3e5;
  const Borders after = findBorders(moved);
  ASSERT_EQ(after.parts.size(), before.parts.size());
  EXPECT_EQ(after.parts[0].outer.points.size(), before.parts[0].outer.points.size());
  EXPECT_NEAR(after.parts[0].area, 1e8 * before.parts[0].area, 1);
  EXPECT_NEAR(after.gap, 1e4 * before.gap, 1e-3);
}

TEST(BorderLoops, RefusesWhatHasNoBorder) {
  EXPECT_THROW(findBorders(Net(0, 2)), InvalidInput);
  EXPECT_THROW(findBorders(Net::Zero(2, 2)), InvalidInput);
  Net line(5, 2);
  line << 0, 0, 1, 2, 2, 4, 3, 6, 4, 8;
  EXPECT_THROW(findBorders(line), InvalidInput);
  BorderOptions options;
  options.gap = 1e-3;
  EXPECT_THROW(findBorders(gridPoints(10, kEverywhere), options), InvalidInput);
  options.gap = -1;
  EXPECT_THROW(findBorders(gridPoints(10, kEverywhere), options), InvalidInput);
}

}  // namespace
}  // namespace strak
