#include "strak/metrology/loop_crossings.h"

#include <gtest/gtest.h>

#include <cmath>

#include "strak/base/error.h"

namespace strak {
namespace {

Curve line(double x0, double y0, double x1, double y1) {
  Net net(2, 2);
  net << x0, y0, x1, y1;
  return Curve({KnotVector::uniformClamped(1, 1)}, std::move(net));
}

CurveLoop box(double x, double y, double side) {
  return {line(x, y, x + side, y), line(x + side, y, x + side, y + side), line(x + side, y + side, x, y + side),
          line(x, y + side, x, y)};
}

// A closed quadratic curve around (x, y), by the corners of a polygon.
CurveLoop round(double x, double y, double radius) {
  constexpr int kCorners = 12;
  Net net(kCorners + 2, 2);
  for (Index i = 0; i < net.rows(); ++i) {
    const double angle = 2 * 3.14159265358979 * static_cast<double>(i % kCorners) / kCorners;
    net.row(i) << x + radius * std::cos(angle), y + radius * std::sin(angle);
  }
  const Net middle = (net.row(0) + net.row(1)) / 2;
  net.row(0) = net.row(net.rows() - 1) = middle;
  return {Curve({KnotVector::uniformClamped(2, kCorners)}, std::move(net))};
}

// 1 for each loop that is.
std::vector<char> clear(const std::vector<CurveLoop>& loops, double clearance) {
  std::vector<char> result;
  for (const auto& places : placesNotClear(loops, clearance)) result.push_back(places.empty() ? 1 : 0);
  return result;
}

TEST(LoopCrossings, SaysWhere) {
  const auto places = placesNotClear({box(0, 0, 4), box(3, -1, 2)}, 1e-3);
  ASSERT_FALSE(places[0].empty());
  // Sides 0 and 1 of the first are crossed by the second.
  for (const NearPlace& near : places[0]) EXPECT_LE(near.piece, 1U);
  EXPECT_TRUE(placesNotClear({box(0, 0, 4)}, 1e-3)[0].empty());
}

TEST(LoopCrossings, LoopsApartAreClear) {
  const auto result = clear({box(0, 0, 10), round(3, 3, 1), round(6, 6, 2), box(2, 7, 1)}, 1e-3);
  EXPECT_EQ(result, (std::vector<char>{1, 1, 1, 1}));
}

TEST(LoopCrossings, BothLoopsThatCrossAreNot) {
  const auto result = clear({box(0, 0, 10), round(3, 3, 1), round(4.5, 3, 1), round(7, 7, 1)}, 1e-3);
  EXPECT_EQ(result, (std::vector<char>{1, 0, 0, 1}));
}

TEST(LoopCrossings, TouchingCountsToo) {
  EXPECT_EQ(clear({box(0, 0, 1), box(1.0005, 0.25, 0.5)}, 1e-3), (std::vector<char>{0, 0}));
  EXPECT_EQ(clear({box(0, 0, 1), box(1.0005, 0.25, 0.5)}, 1e-4), (std::vector<char>{1, 1}));
}

TEST(LoopCrossings, ALoopThatCrossesItself) {
  const CurveLoop eight{line(0, 0, 1, 1), line(1, 1, 1, 0), line(1, 0, 0, 1), line(0, 1, 0, 0)};
  EXPECT_EQ(clear({eight}, 1e-3), std::vector<char>{0});
  // Within a single piece.
  Net net(6, 2);
  net << 0, 0, 4, 0, 4, 3, 0, -3, 0, 3, 0, 0;
  EXPECT_EQ(clear({{Curve({KnotVector::uniformClamped(3, 3)}, net)}}, 1e-3), std::vector<char>{0});
}

TEST(LoopCrossings, APolygonAlongTheLoopIsNear) {
  Net parabola(3, 2);
  parabola << 2, 0, 1, 2, 0, 0;
  const CurveLoop loop{line(0, 0, 2, 0), Curve({KnotVector::uniformClamped(2, 1)}, parabola)};
  for (double flatness : {0.1, 1e-3, 1e-5}) {
    const auto polygon = flattened(loop, flatness);
    double area = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const auto &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      area += (a[0] * b[1] - a[1] * b[0]) / 2;
    }
    EXPECT_LT(area, 4.0 / 3);
    EXPECT_GT(area, 4.0 / 3 - 3 * flatness);  // the arc is less than 3 long
  }
  EXPECT_EQ(flattened(box(0, 0, 1), 1e-9).size(), 4U);
}

TEST(LoopCrossings, RefusesWhatIsNoPlaneCurve) {
  EXPECT_THROW(clear({box(0, 0, 1)}, 0), InvalidInput);
  EXPECT_THROW(flattened({Curve({KnotVector::uniformClamped(1, 1)}, Net::Zero(2, 3))}, 1), InvalidInput);
}

}  // namespace
}  // namespace strak
