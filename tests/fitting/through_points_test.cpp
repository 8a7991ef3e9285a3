#include "strak/fitting/through_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "strak/base/error.h"
#include "strak/metrology/closest_point.h"
#include "strak/spline/evaluate.h"

namespace strak {
namespace {

// A bent sheet with a little noise.
struct Sheet {
  std::mt19937_64 random{11};
  Net parameters{2000, 2}, values{2000, 3};
  std::array<KnotVector, 2> knots{KnotVector::uniformClamped(3, 8), KnotVector::uniformClamped(3, 6)};

  Sheet() {
    std::uniform_real_distribution<double> unit(0, 1);
    std::normal_distribution<double> noise(0, 1e-3);
    for (Index r = 0; r < parameters.rows(); ++r) {
      parameters.row(r) << unit(random), unit(random);
      values.row(r) = place(parameters(r, 0), parameters(r, 1), 0) +
                      Point(Eigen::RowVector3d(noise(random), noise(random), noise(random)));
    }
  }

  static Point place(double u, double v, double above) {
    const double radius = 1 + above;
    return Eigen::RowVector3d(radius * std::sin(2 * u), 2 * v, radius * std::cos(2 * u));
  }

  Fit<2> fit(const Net& conditions, const Net& at) const {
    FitOptions<2> options;
    options.conditionParameters = at;
    options.conditionValues = conditions;
    return fitLeastSquares<2>(knots, {parameters, values}, options);
  }
};

Net rows(const std::vector<Point>& points) {
  Net net(static_cast<Index>(points.size()), points.front().size());
  for (std::size_t r = 0; r < points.size(); ++r) net.row(static_cast<Index>(r)) = points[r];
  return net;
}

TEST(ThroughPoints, AreMetExactly) {
  const Sheet sheet;
  const Net points = rows({Sheet::place(0.3, 0.2, 0.004), Sheet::place(0.71, 0.55, -0.003), Sheet::place(0, 1, 0.002)});
  const Fit<2> plain = sheet.fit({}, {});
  const auto result = fitThrough<2>(plain, points, [&](const Net& at, const Fit<2>&) { return sheet.fit(points, at); });
  EXPECT_LT(result.largest, 1e-12);
  for (Index r = 0; r < points.rows(); ++r) {
    EXPECT_NEAR(result.distances[r], closestPoint<2>(plain.spline, points.row(r)).distance, 1e-12);
    EXPECT_GT(result.distances[r], 1e-3);
    EXPECT_LT(closestPoint<2>(result.fit.spline, points.row(r)).distance, 1e-12);
    const Surface::Parameter at{result.parameters(r, 0), result.parameters(r, 1)};
    EXPECT_LT((evaluate<2>(result.fit.spline, at) - points.row(r)).norm(), 1e-12);
  }
  EXPECT_LT(result.fit.summary.rms, 1.2 * plain.summary.rms);
}

TEST(ThroughPoints, RefusesWhatBelongsToAnotherShape) {
  const Sheet sheet;
  const Fit<2> plain = sheet.fit({}, {});
  const auto make = [&](const Net&, const Fit<2>& previous) { return previous; };
  try {
    fitThrough<2>(plain, rows({Sheet::place(0.3, 0.2, 0), Sheet::place(0.5, 0.5, -0.5)}), make);
    FAIL() << "it is half the radius away";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("condition 2 lies 0.5"), std::string::npos) << error.what();
  }
  // A maker that does not listen.
  EXPECT_THROW(fitThrough<2>(plain, rows({Sheet::place(0.3, 0.2, 0.01)}), make), Failure);
  EXPECT_THROW(fitThrough<2>(plain, Net::Zero(1, 2), make), InvalidInput);
}

}  // namespace
}  // namespace strak
