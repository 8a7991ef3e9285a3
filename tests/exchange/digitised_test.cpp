#include "strak/exchange/digitised.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "strak/base/error.h"
#include "strak/base/file.h"
#include "strak/exchange/model.h"
#include "strak/fairing/exact_curve_fairing.h"
#include "strak/fairing/plan_curve.h"
#include "strak/spline/evaluate.h"

namespace strak {
namespace {

// A symmetric profile, from the trailing edge over the top to the nose and back.
std::vector<std::pair<double, double>> profile(int half) {
  std::vector<std::pair<double, double>> points;
  for (int i = -half; i <= half; ++i) {
    const double x = std::pow(static_cast<double>(i) / half, 2);
    const double y =
        0.6 * (0.2969 * std::sqrt(x) - 0.126 * x - 0.3516 * x * x + 0.2843 * x * x * x - 0.1036 * x * x * x * x);
    points.emplace_back(x, i < 0 ? y : -y);
  }
  return points;
}

std::string selig(int half) {
  std::string text = "TEST PROFILE 12\n";
  for (const auto& [x, y] : profile(half)) text += fmt::format(" {:.7f}  {:.7f}\n", x, y);
  return text;
}

Net dataPoints(const std::vector<std::pair<double, double>>& list) {
  Net points(static_cast<Index>(list.size()), 2);
  for (std::size_t i = 0; i < list.size(); ++i) points.row(static_cast<Index>(i)) << list[i].first, list[i].second;
  return points;
}

TEST(InterpolatingCurve, PassesThroughThePointsAndReproducesCubics) {
  Net points(7, 3);
  for (Index i = 0; i < 7; ++i) points.row(i) << std::cos(i), std::sin(1.3 * static_cast<double>(i)), 0.2 * i;
  for (const bool closed : {false, true}) {
    std::vector<double> at;
    const Curve curve = interpolatingCurve(points, closed, &at);
    EXPECT_EQ(curve.degree(0), 3);
    for (Index i = 0; i < 7; ++i) {
      EXPECT_LE((evaluate(curve, {at[static_cast<std::size_t>(i)]}) - points.row(i)).norm(), 1e-13);
    }
    EXPECT_EQ(seamContinuity(curve), closed ? 2 : -1);
  }
  // Not-a-knot ends: a straight line at even speed is reproduced, and so is what a cubic is at four points.
  const Curve line = interpolatingCurve(dataPoints({{0, 0}, {1, 1}, {3, 3}, {4, 4}, {7, 7}}), false);
  EXPECT_LE((line.net().col(0) - line.net().col(1)).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_THROW(interpolatingCurve(points.topRows(3), false), InvalidInput);
  points.row(3) = points.row(2);
  EXPECT_THROW(interpolatingCurve(points, false), InvalidInput);
}

TEST(Digitised, SeligsAndLednicersOrderGiveTheSameCurve) {
  const auto points = profile(20);
  const DigitisedCurve one = parseDigitised(selig(20), "a.dat");
  EXPECT_EQ(one.name, "TEST PROFILE 12");
  EXPECT_FALSE(one.closed);
  EXPECT_EQ(one.curve.net().rows(), 43);
  std::string text = "TEST PROFILE 12\n 21. 21.\n\n";
  for (int i = 20; i >= 0; --i)
    text += fmt::format(" {:.7f}  {:.7f}\n", points[static_cast<std::size_t>(i)].first,
                        points[static_cast<std::size_t>(i)].second);
  text += "\n";
  for (int i = 20; i <= 40; ++i)
    text += fmt::format(" {:.7f}  {:.7f}\n", points[static_cast<std::size_t>(i)].first,
                        points[static_cast<std::size_t>(i)].second);
  const DigitisedCurve other = parseDigitised(text, "b.dat");
  EXPECT_EQ(other.curve, one.curve);
}

TEST(Digitised, TablesNameTheirColumnsAndCloseWhereTheyClose) {
  std::string text = "# s_m; x_m; y_m; psi\n";
  for (int i = 0; i < 50; ++i) {
    const double a = 2 * std::numbers::pi * i / 50;
    text += fmt::format("{}; {:.6f}; {:.6f}; {}\n", i, 5 * std::cos(a), 3 * std::sin(a), a);
  }
  const DigitisedCurve ring = parseDigitised(text, "ring.csv");
  EXPECT_TRUE(ring.closed);
  EXPECT_EQ(ring.curve.pointDimension(), 2);
  EXPECT_EQ(ring.columns, (std::vector<std::size_t>{1, 2}));
  EXPECT_EQ(ring.name, "ring.csv");
  const DigitisedCurve repeated = parseDigitised(text + "50; 5.000000; 0.000000; 0\n", "ring.csv");
  EXPECT_EQ(repeated.curve, ring.curve);
  EXPECT_EQ(parseDigitised("x,y,z\n0,0,1\n1,0,2\n2,1,3\n3,3,4\n", "s.csv").curve.pointDimension(), 3);
}

TEST(Digitised, GoesBackIntoItsFile) {
  const std::string text = selig(10);
  const DigitisedCurve read = parseDigitised(text, "a.dat");
  EXPECT_EQ(formatDigitised(read, read.curve), text);
  Curve moved = read.curve;
  moved.net().col(1).array() += 0.25;
  const DigitisedCurve back = parseDigitised(formatDigitised(read, moved), "a.dat");
  EXPECT_LE((back.curve.net() - moved.net()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_THROW(formatDigitised(read, Curve({read.curve.knots(0).rescaled(0, 99)}, moved.net())), InvalidInput);
}

TEST(Digitised, SaysWhatItCannotRead) {
  const auto message = [](const std::string& text) {
    try {
      parseDigitised(text, "x.dat");
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  EXPECT_NE(message("name\n0 0\n1 0\n").find("at least 4"), std::string::npos);
  EXPECT_NE(message("name\n0 0\n1 0\n2 x\n3 0\n4 1\n").find("line 4"), std::string::npos);
  EXPECT_NE(message("x y z\n0 0 0\n1 0\n2 0 1\n3 0 2\n").find("line 3"), std::string::npos);
  EXPECT_NE(message("DATA binary\n").find("text form"), std::string::npos);
  EXPECT_NE(message("").find("at least 4"), std::string::npos);
}

std::filesystem::path dataFolder() {
  const char* named = std::getenv("STRAK_DATA");
  return named ? named : STRAK_SOURCE_DIR "/../shared/data";
}

struct Real {
  const char* folder;
  const char* ending;
  double tolerance;
};

void PrintTo(const Real& real, std::ostream* out) { *out << real.folder; }

class RealCurves : public testing::TestWithParam<Real> {};

// Fewer curvature extrema inside the tolerance, on every airfoil, track and race line; NACA 0012 stays as it is.
TEST_P(RealCurves, GetFewerCurvatureExtrema) {
  const auto folder = dataFolder() / GetParam().folder;
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "real files are not here: set STRAK_DATA";
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != GetParam().ending) continue;
    ++count;
    const auto model = readModel(entry.path());
    const Object& object = model->objects().front();
    EXPECT_EQ(object.kind, "digitised curve");
    const CurvePlan plan = planCurve(std::get<Curve>(*object.spline), {1, 1});
    ExactCurveFairingOptions options;
    options.tolerance = GetParam().tolerance;
    options.held = plan.held;
    options.seamContinuity = plan.seamContinuity;
    const auto faired = fairCurveExactly(plan.spline, options);
    EXPECT_LE(faired.deviation.upper, options.tolerance);
    if (entry.path().stem() == "naca0012") {
      EXPECT_TRUE(faired.alreadyFair);
      EXPECT_EQ(faired.spline, plan.spline);
    } else {
      EXPECT_LT(faired.after.extrema, faired.before.extrema) << entry.path();
      EXPECT_LT(faired.after.bending, faired.before.bending);
    }
  }
  EXPECT_GT(count, 3);
}

INSTANTIATE_TEST_SUITE_P(Files, RealCurves, testing::Values(Real{"airfoil", ".dat", 5e-4}, Real{"curve", ".csv", 0.2}),
                         [](const auto& test) { return std::string(test.param.folder); });

}  // namespace
}  // namespace strak
