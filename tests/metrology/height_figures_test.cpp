#include "strak/metrology/height_figures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "strak/base/error.h"

namespace strak {
namespace {

// A grid of n x n places over [x0, x0 + width] x [0, 2], heights by `height`.
template <class Height>
Net gridOf(Index n, double x0, double width, Height height) {
  Net points(n * n, 3);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      const double x = x0 + width * static_cast<double>(i) / static_cast<double>(n - 1),
                   y = 2.0 * static_cast<double>(j) / static_cast<double>(n - 1);
      points.row(i * n + j) << x, y, height(x, y);
    }
  }
  return points;
}

TEST(HeightFigures, OfFourPointsByHand) {
  Net points(4, 3);
  points << 0, 0, 1, 1, 0, 3, 0, 1, 2, 1, 1, 8;
  const HeightFigures mean = figuresWithoutPolynomial(points, 0);
  EXPECT_DOUBLE_EQ(mean.peakToValley, 7);
  EXPECT_DOUBLE_EQ(mean.rms, std::sqrt((2.5 * 2.5 + 0.5 * 0.5 + 1.5 * 1.5 + 4.5 * 4.5) / 4));
  // The plane leaves the warp: +-(1 - 3 - 2 + 8) / 4.
  const HeightFigures plane = figuresWithoutPolynomial(points, 1);
  EXPECT_NEAR(plane.rms, 1, 1e-14);
  EXPECT_NEAR(plane.peakToValley, 2, 1e-14);
  EXPECT_NEAR(plane.residuals[0], 1, 1e-14);
  EXPECT_NEAR(plane.residuals[1], -1, 1e-14);
}

TEST(HeightFigures, NothingIsLeftOfAPolynomialWhereverItLies) {
  const Net points = gridOf(30, 1e6, 0.5, [](double x, double y) {
    const double s = x - 1e6;
    return 7 + 3 * s - 2 * y + 5 * s * s - s * y + 0.25 * y * y;
  });
  EXPECT_GT(figuresWithoutPolynomial(points, 1).rms, 0.05);
  EXPECT_LT(figuresWithoutPolynomial(points, 2).peakToValley, 1e-13);
  EXPECT_LT(figuresWithoutPolynomial(points, 4).peakToValley, 1e-13);
}

TEST(HeightFigures, OfAProfileAreThoseOfTheWaveThatRodeOnTheParabola) {
  const Index n = 20000;
  Net points(n, 2);
  for (Index i = 0; i < n; ++i) {
    const double x = (static_cast<double>(i) + 0.5) / static_cast<double>(n);
    points.row(i) << x, 40 * x * x - 3 * x + 2 + 1e-3 * std::cos(200 * std::numbers::pi * x);
  }
  const HeightFigures figures = figuresWithoutPolynomial(points, 2);
  EXPECT_NEAR(figures.rms, 1e-3 / std::numbers::sqrt2, 2e-7);
  EXPECT_NEAR(figures.peakToValley, 2e-3, 2e-6);
}

TEST(HeightFigures, PointsOfOnePlaceOrLineAreNoFault) {
  Net line(3, 3);
  line << 0, 0, 1, 1, 1, 2, 2, 2, 3;
  EXPECT_LT(figuresWithoutPolynomial(line, 1).peakToValley, 1e-13);
  const Net one = line.topRows(1);
  EXPECT_EQ(figuresWithoutPolynomial(one, 0).rms, 0);
  EXPECT_LT(figuresWithoutPolynomial(one, 2).rms, 1e-15);
}

TEST(HeightFigures, TheSphereIsFoundFromASmallCapOfIt) {
  const double radius = 7.8;
  const auto cap = [&](double bump) {
    return gridOf(20, -1, 2, [&](double x, double y) {
      return 100 - radius + std::sqrt(radius * radius - x * x - (y - 1) * (y - 1)) + (x > 0.99 && y > 1.99 ? bump : 0);
    });
  };
  const HeightFigures clean = figuresWithoutSphere(cap(0));
  EXPECT_NEAR(clean.radius, radius, 1e-9);
  EXPECT_NEAR(clean.centre[0], 0, 1e-9);
  EXPECT_NEAR(clean.centre[1], 1, 1e-9);
  EXPECT_NEAR(clean.centre[2], 100 - radius, 1e-9);
  EXPECT_LT(clean.peakToValley, 1e-12);
  const HeightFigures dented = figuresWithoutSphere(cap(0.01));
  EXPECT_GT(dented.residuals.maxCoeff(), 0.008);
  EXPECT_NEAR(dented.rms * dented.rms * 400, dented.residuals.squaredNorm(), 1e-12);
}

TEST(HeightFigures, TheCircleOfLeastSquaresIsABestOne) {
  Net points(5, 2);
  points << 1, 0, 0, 1.1, -1, 0, 0, -0.9, 0.8, 0.7;
  const HeightFigures figures = figuresWithoutSphere(points);
  const auto sum = [&](const Point& centre, double radius) {
    return ((points.rowwise() - centre).rowwise().norm().array() - radius).square().sum();
  };
  const double least = sum(figures.centre, figures.radius);
  EXPECT_NEAR(least, figures.residuals.squaredNorm(), 1e-14);
  for (Index k = 0; k < 3; ++k) {
    for (double step : {-1e-3, 1e-3}) {
      Point centre = figures.centre;
      if (k < 2) centre[k] += step;
      EXPECT_GT(sum(centre, figures.radius + (k == 2 ? step : 0)), least);
    }
  }
}

TEST(HeightFigures, RefusesWhatHasNoFigures) {
  const Net none(0, 3), wide = Net::Ones(5, 4), line = Net::Ones(5, 2);
  EXPECT_THROW(figuresWithoutPolynomial(none, 1), InvalidInput);
  EXPECT_THROW(figuresWithoutPolynomial(wide, 1), InvalidInput);
  EXPECT_THROW(figuresWithoutPolynomial(line, -1), InvalidInput);
  EXPECT_THROW(figuresWithoutPolynomial(line, 9), InvalidInput);
  EXPECT_THROW(figuresWithoutSphere(line), InvalidInput);
  const Net plane = gridOf(4, 0, 1, [](double x, double y) { return x + y; });
  EXPECT_THROW(figuresWithoutSphere(plane), InvalidInput);
  Net holed = plane;
  holed(3, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(figuresWithoutPolynomial(holed, 1), InvalidInput);
}

}  // namespace
}  // namespace strak
