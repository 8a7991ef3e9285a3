#include "strak/fitting/prescribed_normals.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "strak/base/error.h"
#include "strak/spline/evaluate.h"

namespace strak {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Eigen::Vector3d normalAt(const Surface& surface, double u, double v) {
  const Net d = derivatives<2>(surface, {u, v}, 1);
  if (d.cols() == 1) return Eigen::Vector3d(-d(1, 0), -d(2, 0), 1).normalized();
  return Eigen::Vector3d(d.row(1).transpose()).cross(Eigen::Vector3d(d.row(2).transpose())).normalized();
}

// Degrees between lines.
double between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b))) / kDegree;
}

Eigen::Vector3d tilted(const Eigen::Vector3d& normal, double degrees, const Eigen::Vector3d& about) {
  const Eigen::Vector3d axis = (about - about.dot(normal) * normal).normalized();
  return Eigen::AngleAxisd(degrees * kDegree, axis) * normal;
}

// A gently curved bicubic sheet of n x n control points over [0, size]^2, parameters in [0, knots].
Surface sheet(Index n, double size = 1, double knots = 1) {
  const KnotVector line = KnotVector::uniformClamped(3, n - 3, 0, knots);
  const auto greville = line.greville();
  Net net(n * n, 3);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      const double x = greville[static_cast<std::size_t>(i)] / knots, y = greville[static_cast<std::size_t>(j)] / knots;
      net.row(i * n + j) << size * x, size * y, size * (0.2 * std::sin(3 * x) * y + 0.1 * x * y * y);
    }
  }
  return Surface({line, line}, net);
}

struct Sampled {
  Net parameters, values;
};

Sampled sampled(const Surface& surface, int perSide) {
  Surface::Grid grid;
  for (std::size_t d = 0; d < 2; ++d) {
    for (int k = 0; k < perSide; ++k) {
      grid[d].push_back(std::lerp(surface.knots()[d].from(), surface.knots()[d].to(), k / (perSide - 1.0)));
    }
  }
  Sampled result{Net(perSide * perSide, 2), derivativesOnGrid<2>(surface, grid, 0)};
  for (Index r = 0; r < result.parameters.rows(); ++r) {
    result.parameters.row(r) << grid[0][static_cast<std::size_t>(r / perSide)],
        grid[1][static_cast<std::size_t>(r % perSide)];
  }
  return result;
}

Fit<2> fitOf(const Surface& surface, double lambda = 1e-9) {
  const Sampled points = sampled(surface, 40);
  FitOptions<2> options;
  options.smoothing = Smoothing::fixed(lambda);
  return fitLeastSquares<2>(surface.knots(), {points.parameters, points.values}, options);
}

WishedNormals single(double u, double v, const Eigen::Vector3d& normal) {
  WishedNormals wished;
  wished.parameters.resize(1, 2);
  wished.parameters << u, v;
  wished.normals = normal.transpose();
  return wished;
}

Fit<2> functionFit(Index size, int degree, const std::function<double(double, double)>& f, double lambda) {
  const KnotVector line = KnotVector::uniformClamped(degree, size - degree, 0, 1);
  Net parameters(900, 2), values(900, 1);
  for (Index r = 0; r < 900; ++r) {
    parameters.row(r) << (r / 30 + 0.5) / 30, (r % 30 + 0.5) / 30;
    values(r, 0) = f(parameters(r, 0), parameters(r, 1));
  }
  FitOptions<2> options;
  options.smoothing = Smoothing::fixed(lambda);
  return fitLeastSquares<2>({line, line}, {parameters, values}, options);
}

TEST(PrescribedNormals, MeetATiltInsideANet) {
  for (const Fit<2>& fit : {fitOf(sheet(12)), fitOfSurface(sheet(12), 1e-6)}) {
    const Eigen::Vector3d wished = tilted(normalAt(fit.spline, 0.43, 0.61), 5, {1, 0.3, 0});
    const NormalFit turned = prescribeNormals(fit, single(0.43, 0.61, wished));
    EXPECT_EQ(turned.stop, NormalStop::met);
    EXPECT_EQ(turned.rounds, 1);
    EXPECT_NEAR(turned.anglesBefore[0], 5, 1e-9);
    EXPECT_LT(between(normalAt(turned.fit.spline, 0.43, 0.61), wished), 1e-3);
    EXPECT_NEAR(between(normalAt(turned.fit.spline, 0.43, 0.61), wished), turned.largest, 1e-9);
    // No more than 5 degrees over a few knot spans need, and hardly anything far away.
    const Net moves = sampled(turned.fit.spline, 60).values - sampled(fit.spline, 60).values;
    EXPECT_LT(moves.rowwise().norm().maxCoeff(), 0.01);
    EXPECT_LT(moves.row(0).norm(), 2e-3);
  }
}

TEST(PrescribedNormals, MeetTiltsOfAnySizeAndAtAnyPlace) {
  const Fit<2> fit = fitOf(sheet(12));
  for (const double degrees : {0.01, 1.0, 30.0, 70.0}) {
    for (const auto& [u, v] : {std::pair{0.0, 0.0}, {1.0, 0.37}, {1.0 / 3, 2.0 / 9}, {0.98, 0.51}}) {
      const Eigen::Vector3d wished = tilted(normalAt(fit.spline, u, v), degrees, {0.4, 1, 0});
      const NormalFit turned = prescribeNormals(fit, single(u, v, -3 * wished));
      EXPECT_EQ(turned.stop, NormalStop::met) << degrees << ' ' << u << ' ' << v;
      EXPECT_LT(between(normalAt(turned.fit.spline, u, v), wished), 1e-3);
    }
  }
}

// The flat function nearest to zero with a given slope in the middle.
TEST(PrescribedNormals, TurnAFunctionAsByHand) {
  const Fit<2> fit = functionFit(
      2, 1, [](double, double) { return 0.0; }, 0);
  NormalOptions options;
  options.degrees = 1e-9;
  const NormalFit turned = prescribeNormals(fit, single(0.5, 0.5, {-0.3, 0.1, 1}), options);
  for (Index r = 0; r < 4; ++r) {
    const double x = r / 2 - 0.5, y = r % 2 - 0.5;
    EXPECT_NEAR(turned.fit.spline.net()(r, 0), 0.3 * x - 0.1 * y, 1e-11);
  }
  // With the weight w: (1 / 12) (0.3 - a) ... mean of (a x)^2 = a^2 / 12 (1 - 1 / 900), against w |(a - 0.3, b +
  // 0.1)|^2 / (1.1 length) in the metric of the last surface: stationary where both gradients agree.
  options.weight = 0.5;
  const NormalFit soft = prescribeNormals(fit, single(0.5, 0.5, {-0.3, 0, 1}), options);
  EXPECT_EQ(soft.stop, NormalStop::settled);
  const double a = soft.fit.spline.net()(2, 0) - soft.fit.spline.net()(0, 0);
  const double mean = (1 - 1.0 / 900) / 12;
  EXPECT_NEAR(mean * a, 0.5 * (0.3 - a) / (1 + a * a) / 1.09, 1e-6);
}

// Stiff as a plate, a plane is turned about its middle, and its points go along the normal.
TEST(PrescribedNormals, TurnAPlaneAboutItsMiddle) {
  const KnotVector line = KnotVector::uniformClamped(3, 4, 0, 1);
  const auto greville = line.greville();
  Net net(49, 3);
  for (Index r = 0; r < 49; ++r) {
    net.row(r) << greville[static_cast<std::size_t>(r / 7)], greville[static_cast<std::size_t>(r % 7)], 2;
  }
  const Surface plane({line, line}, net);
  const Sampled points = sampled(plane, 41);
  FitOptions<2> options;
  options.energy = thinPlate<2>();
  options.smoothing = Smoothing::fixed(1e4);
  const auto fit = fitLeastSquares<2>(plane.knots(), {points.parameters, points.values}, options);
  const Eigen::Vector3d wished = tilted({0, 0, 1}, 5, {0, 1, 0});
  NormalOptions exact;
  exact.degrees = 1e-6;
  const NormalFit turned = prescribeNormals(fit, single(0.5, 0.5, wished), exact);
  for (Index r = 0; r < 49; ++r) {
    const Eigen::Vector3d from = net.row(r).transpose() - Eigen::Vector3d(0.5, 0.5, 2);
    const Eigen::Vector3d to = Eigen::Vector3d(0.5, 0.5, 2) + from - from.dot(wished) * wished;
    EXPECT_LT((turned.fit.spline.net().row(r).transpose() - to).norm(), 1e-5);
  }
}

TEST(PrescribedNormals, ThatHoldChangeNothing) {
  // A cap of the unit sphere as the graph of a function and as points in space.
  const auto cap = [](double x, double y) { return std::sqrt(4 - x * x - y * y); };
  const Fit<2> function = functionFit(14, 5, cap, 1e-14);
  WishedNormals wished;
  wished.parameters.resize(16, 2);
  wished.normals.resize(16, 3);
  for (Index k = 0; k < 16; ++k) {
    const double x = 0.1 + 0.25 * static_cast<double>(k / 4), y = 0.15 + 0.2 * static_cast<double>(k % 4);
    wished.parameters.row(k) << x, y;
    wished.normals.row(k) << x, y, cap(x, y);
  }
  const NormalFit same = prescribeNormals(function, wished);
  EXPECT_EQ(same.stop, NormalStop::met);
  EXPECT_EQ(same.rounds, 0);
  EXPECT_EQ(same.fit.spline.net(), function.spline.net());
  NormalOptions soft;
  soft.weight = 1;
  const NormalFit nearly = prescribeNormals(function, wished, soft);
  EXPECT_LT((nearly.fit.spline.net() - function.spline.net()).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(PrescribedNormals, OfManyPlacesAreMetTogether) {
  const Fit<2> fit = fitOf(sheet(12));
  WishedNormals wished;
  wished.parameters.resize(36, 2);
  wished.normals.resize(36, 3);
  for (Index k = 0; k < 36; ++k) {
    const double u = 0.05 + 0.18 * static_cast<double>(k / 6), v = 0.03 + 0.19 * static_cast<double>(k % 6);
    wished.parameters.row(k) << u, v;
    wished.normals.row(k) =
        tilted(normalAt(fit.spline, u, v), 2 * std::sin(static_cast<double>(3 * k)), {std::cos(5 * u), 1, v})
            .transpose();
  }
  const NormalFit turned = prescribeNormals(fit, wished);
  EXPECT_EQ(turned.stop, NormalStop::met);
  EXPECT_LT(turned.largest, 1e-3);
  for (Index k = 0; k < 36; ++k) {
    EXPECT_LT(between(normalAt(turned.fit.spline, wished.parameters(k, 0), wished.parameters(k, 1)),
                      wished.normals.row(k).transpose()),
              1e-3);
  }
}

TEST(PrescribedNormals, CountInAngleAsTheirWeightSays) {
  const Fit<2> fit = fitOf(sheet(12));
  const WishedNormals wished = single(0.4, 0.6, tilted(normalAt(fit.spline, 0.4, 0.6), 5, {1, 0, 0}));
  double last = 5;
  NormalOptions options;
  for (const double weight : {1e-6, 1e-4, 1e-2, 1.0, 100.0}) {
    options.weight = weight;
    const NormalFit turned = prescribeNormals(fit, wished, options);
    EXPECT_EQ(turned.stop, NormalStop::settled);
    EXPECT_LT(turned.largest, last);
    last = turned.largest;
  }
  EXPECT_LT(last, 0.01);
  // The same list three times over is the same wish.
  options.weight = 1e-4;
  WishedNormals thrice;
  thrice.parameters = wished.parameters.replicate(3, 1);
  thrice.normals = wished.normals.replicate(3, 1);
  const Net once = prescribeNormals(fit, wished, options).fit.spline.net();
  EXPECT_LT((prescribeNormals(fit, thrice, options).fit.spline.net() - once).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(PrescribedNormals, DoNotDependOnUnitsNorOnTheScaleOfTheKnots) {
  for (const double weight : {0.0, 1e-3}) {
    NormalOptions options;
    options.weight = weight;
    const Fit<2> fit = fitOf(sheet(12));
    const Eigen::Vector3d normal = tilted(normalAt(fit.spline, 0.4, 0.6), 5, {1, 2, 0});
    const Net net = prescribeNormals(fit, single(0.4, 0.6, normal), options).fit.spline.net();
    for (const auto& [size, knots] : {std::pair{1000.0, 1.0}, {1.0, 40.0}, {1e-3, 0.01}}) {
      const Fit<2> other = fitOf(sheet(12, size, knots));
      const NormalFit turned = prescribeNormals(other, single(0.4 * knots, 0.6 * knots, normal), options);
      EXPECT_LT((turned.fit.spline.net() / size - net).cwiseAbs().maxCoeff(), 1e-9) << size << ' ' << knots;
    }
  }
}

TEST(PrescribedNormals, StandAtTheFootOfTheirPlaces) {
  const Fit<2> fit = fitOf(sheet(12));
  WishedNormals wished;
  const Point foot = evaluate<2>(fit.spline, {0.4, 0.7});
  const Eigen::Vector3d normal = normalAt(fit.spline, 0.4, 0.7);
  wished.places = foot + 0.05 * normal.transpose();
  wished.normals = tilted(normal, 5, {1, 1, 0}).transpose();
  const NormalFit turned = prescribeNormals(fit, wished);
  EXPECT_EQ(turned.stop, NormalStop::met);
  const Point now = evaluate<2>(turned.fit.spline, {turned.parameters(0, 0), turned.parameters(0, 1)});
  const Eigen::Vector3d way = (wished.places.row(0) - now).transpose();
  EXPECT_LT(between(way, wished.normals.row(0).transpose()), 2e-3);
  EXPECT_LT(turned.largest, 1e-3);
}

TEST(PrescribedNormals, LeaveWhatIsHeldAndPassThroughWhatIsGiven) {
  const Fit<2> fit = fitOf(sheet(12));
  NormalOptions options;
  for (Index j = 0; j < 24; ++j) options.held.push_back(j);
  options.conditions.resize(1, 2);
  options.conditions << 0.4, 0.6;
  const NormalFit turned =
      prescribeNormals(fit, single(0.4, 0.6, tilted(normalAt(fit.spline, 0.4, 0.6), 5, {1, 0, 0})), options);
  EXPECT_EQ(turned.stop, NormalStop::met);
  EXPECT_EQ(turned.fit.spline.net().topRows(24), fit.spline.net().topRows(24));
  EXPECT_LT((evaluate<2>(turned.fit.spline, {0.4, 0.6}) - evaluate<2>(fit.spline, {0.4, 0.6})).norm(), 1e-12);
  NormalOptions soft = options;
  soft.weight = 0.01;
  const NormalFit partly =
      prescribeNormals(fit, single(0.4, 0.6, tilted(normalAt(fit.spline, 0.4, 0.6), 5, {1, 0, 0})), soft);
  EXPECT_EQ(partly.stop, NormalStop::settled);
  EXPECT_LT((evaluate<2>(partly.fit.spline, {0.4, 0.6}) - evaluate<2>(fit.spline, {0.4, 0.6})).norm(), 1e-12);
  // Nothing can turn where all is held.
  options.held.clear();
  for (Index r = 0; r < 144; ++r) options.held.push_back(r);
  const NormalFit none =
      prescribeNormals(fit, single(0.4, 0.6, tilted(normalAt(fit.spline, 0.4, 0.6), 5, {1, 0, 0})), options);
  EXPECT_EQ(none.stop, NormalStop::contradictory);
  EXPECT_NEAR(none.largest, 5, 1e-9);
}

TEST(PrescribedNormals, ThatContradictOneAnotherDoNotCrumpleTheSurface) {
  const Fit<2> fit = fitOf(sheet(12));
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> unit(0, 1);
  WishedNormals wished;
  wished.parameters.resize(400, 2);
  wished.normals.resize(400, 3);
  for (Index k = 0; k < 400; ++k) {
    wished.parameters.row(k) << unit(random), unit(random);
    wished.normals.row(k) << unit(random) - 0.5, unit(random) - 0.5, 1;
  }
  const NormalFit turned = prescribeNormals(fit, wished);
  EXPECT_EQ(turned.stop, NormalStop::contradictory);
  EXPECT_GT(turned.largest, 5);
  EXPECT_LT(turned.rms, std::sqrt(turned.anglesBefore.squaredNorm() / 400));
  for (Index k = 0; k < 400; ++k) {
    const auto area = [&](const Surface& surface) {
      const Net d = derivatives<2>(surface, {wished.parameters(k, 0), wished.parameters(k, 1)}, 1);
      return Eigen::Vector3d(d.row(1).transpose()).cross(Eigen::Vector3d(d.row(2).transpose())).norm();
    };
    EXPECT_GT(area(turned.fit.spline), 0.4 * area(fit.spline));
  }
}

TEST(PrescribedNormals, SayWhichPointToTheOtherSide) {
  const Fit<2> fit = fitOf(sheet(12));
  WishedNormals wished;
  wished.parameters.resize(3, 2);
  wished.parameters << 0.2, 0.2, 0.5, 0.7, 0.8, 0.4;
  wished.normals.resize(3, 3);
  for (Index k = 0; k < 3; ++k) {
    wished.normals.row(k) =
        (k == 1 ? -1 : 1) *
        tilted(normalAt(fit.spline, wished.parameters(k, 0), wished.parameters(k, 1)), 1, {1, 0, 0}).transpose();
  }
  const NormalFit turned = prescribeNormals(fit, wished);
  EXPECT_EQ(turned.stop, NormalStop::met);
  EXPECT_EQ(turned.opposite, 1);
}

TEST(PrescribedNormals, RefuseWhatIsNoNormal) {
  const Fit<2> fit = fitOf(sheet(8));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(prescribeNormals(fit, {}), InvalidInput);
  EXPECT_THROW(prescribeNormals(fit, single(0.5, 0.5, {0, 0, 0})), InvalidInput);
  EXPECT_THROW(prescribeNormals(fit, single(0.5, 0.5, {0, nan, 1})), InvalidInput);
  EXPECT_THROW(prescribeNormals(fit, single(0.5, 0.5, {0, std::numeric_limits<double>::infinity(), 1})), InvalidInput);
  EXPECT_THROW(prescribeNormals(fit, single(1.1, 0.5, {0, 0, 1})), InvalidInput);
  EXPECT_THROW(prescribeNormals(fit, single(nan, 0.5, {0, 0, 1})), InvalidInput);
  WishedNormals wished = single(0.5, 0.5, {0, 0, 1});
  wished.weights = Eigen::VectorXd::Zero(1);
  EXPECT_THROW(prescribeNormals(fit, wished), InvalidInput);
  wished.weights = Eigen::VectorXd::Constant(1, -1);
  EXPECT_THROW(prescribeNormals(fit, wished), InvalidInput);
  wished.weights = Eigen::VectorXd::Ones(2);
  EXPECT_THROW(prescribeNormals(fit, wished), InvalidInput);
  NormalOptions options;
  options.weight = -1;
  EXPECT_THROW(prescribeNormals(fit, single(0.5, 0.5, {0, 0, 1}), options), InvalidInput);
  options.weight = nan;
  EXPECT_THROW(prescribeNormals(fit, single(0.5, 0.5, {0, 0, 1}), options), InvalidInput);
  options = {};
  options.degrees = 0;
  EXPECT_THROW(prescribeNormals(fit, single(0.5, 0.5, {0, 0, 1}), options), InvalidInput);
  options = {};
  options.held = {64};
  EXPECT_THROW(prescribeNormals(fit, single(0.5, 0.5, {0, 0, 1}), options), InvalidInput);
  // Two at one place.
  WishedNormals two = single(0.5, 0.5, {0, 0, 1});
  two.parameters = two.parameters.replicate(2, 1).eval();
  two.normals.conservativeResize(2, 3);
  two.normals.row(1) << 0, 0.1, 1;
  EXPECT_THROW(prescribeNormals(fit, two), InvalidInput);
  options = {};
  options.weight = 100;
  EXPECT_EQ(prescribeNormals(fit, two, options).stop, NormalStop::contradictory);
  options.weight = 0.01;
  const NormalFit between = prescribeNormals(fit, two, options);
  EXPECT_EQ(between.stop, NormalStop::settled);
  EXPECT_NEAR(between.rms, std::atan(0.1) / kDegree / 2, 0.5);
  // A function is nowhere upright.
  const Fit<2> function = functionFit(
      8, 3, [](double x, double y) { return x * y; }, 1e-9);
  EXPECT_THROW(prescribeNormals(function, single(0.5, 0.5, {1, 0, 0})), InvalidInput);
  wished = single(0.5, 0.5, {0, 0, 1});
  wished.places = Net::Zero(1, 3);
  EXPECT_THROW(prescribeNormals(function, wished), InvalidInput);
  wished.places = Net::Constant(1, 3, nan);
  EXPECT_THROW(prescribeNormals(fit, wished), InvalidInput);
  // A surface that is a line has no tangent plane to turn.
  Net line = Net::Zero(64, 3);
  for (Index r = 0; r < 64; ++r) line(r, 0) = static_cast<double>(r);
  EXPECT_THROW(prescribeNormals(fitOfSurface(Surface(fit.spline.knots(), line), 1e-6), single(0.5, 0.5, {0, 0, 1})),
               InvalidInput);
  EXPECT_THROW(fitOfSurface(sheet(8), nan), InvalidInput);
}

}  // namespace
}  // namespace strak
