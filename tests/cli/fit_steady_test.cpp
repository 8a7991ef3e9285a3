// strak fit of points without parameters, some of which are outliers.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "strak/metrology/closest_points.h"
#include "strak/spline/evaluator.h"
#include "tests/cli/program.h"

namespace strak {
namespace {

class SteadyFit : public test::Program {
 protected:
  double next() { return 2 * static_cast<double>(random_() >> 11) * 0x1p-53 - 1; }

 private:
  std::mt19937_64 random_{7};
};

TEST_F(SteadyFit, CurvesAreNotMovedByOutliers) {
  // 200 points of a helix with noise, five of them far away: the way there and back is longer than the helix.
  constexpr double kNoise = 0.01;
  std::string text;
  for (int i = 0; i < 200; ++i) {
    const double t = i / 40.0, far = i % 40 == 17 ? 3 : 0;
    text += fmt::format("{} {} {}\n", std::cos(t) + kNoise * next() + far, std::sin(t) + kNoise * next() - far / 2,
                        t / 5 + kNoise * next());
  }
  const std::string input = write("helix.xyz", text);
  for (const char* loss : {"l1", "huber", "tukey"}) {
    const auto result = json({"fit", input, "-o", path("out.g2"), "--kind", "curve", "--loss", loss});
    EXPECT_EQ(result["objects"][0]["loss"]["outliers"], 5) << loss;
    const auto model = readModel(file("out.g2"));
    const Curve& curve = std::get<Curve>(*model->objects()[0].spline);
    const KnotVector& knots = curve.knots()[0];
    const Net places = Eigen::VectorXd::LinSpaced(2000, knots.from(), knots.to());
    const Net points = Evaluator<1>(curve).derivativesAt(places, 0);
    double worst = 0;
    for (Index r = 0; r < points.rows(); ++r) {
      double nearest = 1;
      for (double t = 5 * points(r, 2) - 0.3; t < 5 * points(r, 2) + 0.3; t += 0.01) {
        nearest = std::min(nearest, (points.row(r) - Eigen::RowVector3d(std::cos(t), std::sin(t), t / 5)).norm());
      }
      worst = std::max(worst, nearest);
    }
    EXPECT_LT(worst, 2 * kNoise) << loss;
  }
}

TEST_F(SteadyFit, SheetsAreNotMovedByOutliers) {
  constexpr double kNoise = 0.005;
  std::string text;
  Net clean(1500, 3);
  for (Index i = 0; i < clean.rows(); ++i) {
    const double x = next(), y = next(), z = x * x - y * y;
    clean.row(i) << x, y, z;
    text += fmt::format("{} {} {}\n", x, y, z + kNoise * next());
  }
  for (int i = 0; i < 15; ++i) text += fmt::format("{} {} {}\n", 1.2 * next(), 1.2 * next(), 1.5 * next());
  const std::string input = write("saddle.xyz", text);
  for (const char* loss : {"l1", "huber", "tukey"}) {
    json({"fit", input, "-o", path("out.g2"), "--kind", "surface", "--loss", loss, "--size", "10"});
    const Surface surface = test::readSurface(file("out.g2"));
    // An outlier just beyond the border may bend a corner.
    EXPECT_LT(closestPoints<2>(surface, clean).distances.norm(), kNoise * std::sqrt(1500.0)) << loss;
  }
}

}  // namespace
}  // namespace strak
