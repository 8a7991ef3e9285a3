#include "strak/fitting/curve_drawing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "strak/fitting/parametrization.h"
#include "strak/spline/evaluate.h"
#include "tests/spline/random_splines.h"

namespace strak {
namespace {

using testing::Random;

double normal(Random& random) {
  const double radius = std::sqrt(-2 * std::log(1 - random.uniform()));
  return radius * std::cos(2 * std::numbers::pi * random.uniform());
}

// `count` points in order on a half ellipse, with noise of this deviation; two or three columns.
Net ellipse(Index count, double noise, int columns, std::uint64_t seed) {
  Random random(seed);
  std::vector<double> places;
  for (Index r = 0; r < count; ++r) places.push_back(std::numbers::pi * random.uniform(0, 1));
  std::sort(places.begin(), places.end());
  Net points(count, columns);
  for (Index r = 0; r < count; ++r) {
    const double t = places[static_cast<std::size_t>(r)];
    points.row(r).head<2>() << -100 * std::cos(t), 40 * std::sin(t);
    if (columns == 3) points(r, 2) = 10 * std::cos(t);
    for (Index c = 0; c < columns; ++c) points(r, c) += noise * normal(random);
  }
  return points;
}

Fit<1> fitWith(const Net& parameters, const Net& points) {
  const KnotVector knots = KnotVector::uniformClamped(3, 47, parameters.minCoeff(), parameters.maxCoeff());
  return fitLeastSquares<1>({knots}, {parameters, points});
}

// How far the tangent turns along the curve, to and fro.
double turning(const Curve& curve) {
  constexpr Index kPlaces = 1000;
  const KnotVector& knots = curve.knots()[0];
  double sum = 0;
  Eigen::RowVectorXd before;
  Eigen::RowVectorXd last = evaluate<1>(curve, {knots.from()});
  for (Index i = 1; i <= kPlaces; ++i) {
    const Eigen::RowVectorXd point =
        evaluate<1>(curve, {knots.from() + knots.length() * static_cast<double>(i) / kPlaces});
    const Eigen::RowVectorXd way = (point - last).normalized();
    if (i > 1) sum += std::acos(std::clamp(way.dot(before), -1.0, 1.0));
    before = way;
    last = point;
  }
  return sum;
}

TEST(CurveDrawing, FindsTheParametersThatTheNoiseHides) {
  for (const int columns : {2, 3}) {
    double before = 0, after = 0;
    for (const std::uint64_t seed : {7U, 8U, 9U, 10U}) {
      const Net points = ellipse(2000, 0.5, columns, seed);
      const Net lengths = chordLengthParameters(points);
      const DrawnCurve drawn = drawCurve({lengths, points});
      ASSERT_TRUE(drawn.drawn);
      EXPECT_LT(drawn.rms.back(), drawn.rms.front());
      // The polygon is five times as long as the ellipse.
      EXPECT_GT(lengths(1999, 0), 1000);
      EXPECT_NEAR(drawn.parameters.maxCoeff() - drawn.parameters.minCoeff(), 230, 12);
      const Fit<1> plain = fitWith(lengths, points), good = fitWith(drawn.parameters, points);
      EXPECT_LT(good.summary.freedom, 0.7 * plain.summary.freedom);
      before += turning(plain.spline) / 4;
      after += turning(good.spline) / 4;
    }
    // Half a turn by itself.
    EXPECT_GT(before, 1.3 * std::numbers::pi);
    EXPECT_LT(after, 1.1 * std::numbers::pi);
  }
}

TEST(CurveDrawing, KeepsTheLengthsWhereTheNoiseIsSmall) {
  for (const double noise : {0.0, 0.01}) {
    const Net points = ellipse(100, noise, 2, 3);
    const Net lengths = chordLengthParameters(points);
    const DrawnCurve drawn = drawCurve({lengths, points});
    EXPECT_FALSE(drawn.drawn);
    EXPECT_EQ(drawn.parameters, lengths);
  }
}

TEST(CurveDrawing, DoesNotDependOnTheUnit) {
  const Net points = ellipse(500, 1, 2, 11);
  const Net small = 1e-3 * points;
  const DrawnCurve one = drawCurve({chordLengthParameters(points), points});
  const DrawnCurve other = drawCurve({chordLengthParameters(small), small});
  ASSERT_TRUE(one.drawn && other.drawn);
  EXPECT_LT((1e3 * other.parameters - one.parameters).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(CurveDrawing, LeavesFewPointsAlone) {
  const Net points = ellipse(10, 5, 2, 2);
  EXPECT_FALSE(drawCurve({chordLengthParameters(points), points}).drawn);
}

}  // namespace
}  // namespace strak
