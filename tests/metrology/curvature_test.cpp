#include "strak/metrology/curvature.h"

#include <Eigen/Geometry>

#include "strak/base/error.h"
#include "strak/metrology/curvature_comb.h"
#include "strak/metrology/piece.h"
#include "strak/spline/evaluate.h"
#include "tests/metrology/test_surfaces.h"

namespace strak {
namespace {

using Eigen::Vector3d;

TEST(SurfaceCurvature, SphereIsRoundEverywhereAndSingularAtThePole) {
  const Surface ball = testing::sphere(4);
  for (const double u : {0.1, 1.0, 2.7, 3.9}) {
    for (const double v : {0.05, 1.0, 1.6}) {
      const auto c = surfaceCurvature(ball, u, v);
      ASSERT_TRUE(c.regular);
      // The normal points outwards, so the surface bends away from it.
      EXPECT_NEAR((c.normal - c.point.normalized()).norm(), 0, 1e-11);
      EXPECT_NEAR(c.principal[0], -0.25, 1e-11);
      EXPECT_NEAR(c.principal[1], -0.25, 1e-11);
      EXPECT_NEAR(c.gaussian, 1.0 / 16, 1e-11);
      EXPECT_NEAR(c.mean, -0.25, 1e-11);
      EXPECT_NEAR(normalCurvature(ball, u, v, 0.3, -2), -0.25, 1e-11);
    }
  }
  EXPECT_FALSE(surfaceCurvature(ball, 0.5, 0).regular);
  EXPECT_EQ(surfaceCurvature(ball, 0.5, 0).mean, 0);
}

TEST(SurfaceCurvature, TorusHasItsPrincipalDirections) {
  const double big = 3, small = 1;
  const Surface ring = testing::torus(big, small);
  for (const double u : {0.2, 1.5, 3.3}) {
    for (const double v : {0.3, 1.2, 2.6}) {
      const auto c = surfaceCurvature(ring, u, v);
      const double rho = c.point.head<2>().norm(), cosine = (rho - big) / small;
      const double around = -cosine / rho, across = -1 / small;  // outward normal
      EXPECT_NEAR(c.principal[0], std::max(around, across), 1e-10);
      EXPECT_NEAR(c.principal[1], std::min(around, across), 1e-10);
      const Vector3d parallel = Vector3d(-c.point[1], c.point[0], 0).normalized();
      EXPECT_NEAR(std::abs(c.direction[0].dot(parallel)), 1, 1e-9);
      EXPECT_NEAR(c.direction[0].dot(c.direction[1]), 0, 1e-12);
    }
  }
}

// dk/ds along a principal line, and the whole of |nabla h|^2, against differences.
TEST(CurvatureDerivative, AgreesWithDifferencesOnRandomSurfaces) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0.2, 0.8);
  for (int trial = 0; trial < 20; ++trial) {
    const KnotVector knots = KnotVector::uniformClamped(5, 1);
    Surface s = testing::randomSpline<2>(random, {knots, knots}, 3, trial % 2 == 1, 0.08);
    for (Index i = 0; i < 6; ++i) {
      for (Index j = 0; j < 6; ++j) {
        const double w = s.isRational() ? s.net()(i * 6 + j, 3) : 1;
        s.net()(i * 6 + j, 0) += w * 0.2 * static_cast<double>(i);
        s.net()(i * 6 + j, 1) += w * (0.25 * static_cast<double>(j) + 0.05 * static_cast<double>(i));
      }
    }
    const double u = unit(random), v = unit(random);
    const Net d = derivatives<2>(s, {u, v}, 3);
    const auto c = surfaceCurvature(d);
    const Eigen::Vector4d covariant = curvatureRates(d).derivative;
    for (int a = 0; a < 2; ++a) {
      // The parameter direction of e_a.
      Eigen::Matrix<double, 3, 2> tangents;
      tangents << d.row(1).transpose(), d.row(2).transpose();
      const Eigen::Vector2d way = tangents.colPivHouseholderQr().solve(c.direction[a]);
      const double h = 1e-5;
      const auto ahead = surfaceCurvature(s, u + h * way[0], v + h * way[1]);
      const auto behind = surfaceCurvature(s, u - h * way[0], v - h * way[1]);
      const double difference = (ahead.principal[a] - behind.principal[a]) / (2 * h);
      EXPECT_NEAR(std::abs(covariant[a == 0 ? 0 : 3]), std::abs(difference), 1e-5 * (1 + std::abs(difference)));
      // Codazzi: dk2/de1 = C_122, dk1/de2 = C_112.
      const double other = (ahead.principal[1 - a] - behind.principal[1 - a]) / (2 * h);
      EXPECT_NEAR(std::abs(covariant[a == 0 ? 2 : 1]), std::abs(other), 1e-5 * (1 + std::abs(other)));
    }
  }
}

TEST(CurveCurvature, HelixLikeAndPlaneCurves) {
  Net circle = testing::circleNet();
  circle.leftCols(2) *= 2;
  const Curve plane({testing::circleKnots()}, circle, true);
  for (const double u : {0.0, 0.4, 1.0, 3.9, 4.0}) EXPECT_NEAR(curveCurvature(plane, u).curvature, 0.5, 1e-12);

  Net cubic(4, 3);  // (t, t^2, t^3) on [0, 1]
  cubic << 0, 0, 0, 1.0 / 3, 0, 0, 2.0 / 3, 1.0 / 3, 0, 1, 1, 1;
  const Curve twisted({KnotVector::uniformClamped(3, 1)}, cubic);
  const double t = 0.3;
  const Vector3d d1(1, 2 * t, 3 * t * t), d2(0, 2, 6 * t), d3(0, 0, 6);
  const auto c = curveCurvature(twisted, t);
  EXPECT_NEAR(c.curvature, d1.cross(d2).norm() / std::pow(d1.norm(), 3), 1e-12);
  EXPECT_NEAR(c.torsion, d1.cross(d2).dot(d3) / d1.cross(d2).squaredNorm(), 1e-12);

  Net point = Net::Ones(4, 3);
  EXPECT_FALSE(curveCurvature(Curve({KnotVector::uniformClamped(3, 1)}, point), 0.5).regular);
}

TEST(Pieces, AgreeWithTheEvaluationOfTheWholeSpline) {
  std::mt19937_64 random(4);
  for (int trial = 0; trial < 40; ++trial) {
    const Surface s = testing::randomSpline<2>(
        random, {testing::randomKnots(random, trial % 7, 3), testing::randomKnots(random, (trial / 7) % 6, 4)}, 3,
        trial % 3 == 0);
    std::uniform_real_distribution<double> unit(0, 1);
    const double u = unit(random), v = unit(random);
    SurfaceJet jet;
    SurfacePiece(s, s.knots(0).findSpan(u), s.knots(1).findSpan(v)).at(u, v, 3, jet);
    const Net d = derivatives<2>(s, {u, v}, 3);
    for (Index r = 0; r < 10; ++r) {
      EXPECT_NEAR((d.row(r).transpose() - jet[static_cast<std::size_t>(r)]).norm(), 0, 1e-10 * (1 + d.row(r).norm()));
    }
  }
}

TEST(CurvatureComb, ShowsBothSidesOfAJump) {
  Net net = testing::circleNet();
  const Curve circle({testing::circleKnots()}, net, true);
  const CurvatureComb comb = curvatureComb(circle, 4);
  EXPECT_EQ(comb.parameters.size(), 20u);  // four quarters with both ends
  for (std::size_t i = 0; i < comb.points.size(); ++i) {
    EXPECT_NEAR(comb.curvature[i], 1, 1e-12);
    EXPECT_NEAR((comb.normals[i] + comb.points[i]).norm(), 0, 1e-12);  // towards the centre
  }
  EXPECT_NEAR(combScale({comb}, 0.25), 0.25, 1e-12);
  std::mt19937_64 random(5);
  const Curve smooth = testing::randomSpline<1>(random, {KnotVector::uniformClamped(3, 5)}, 3);
  EXPECT_EQ(curvatureComb(smooth, 4).parameters.size(), 21u);
  EXPECT_THROW(curvatureComb(smooth, 0), InvalidInput);
}

TEST(CurvatureComb, OfAnIsolineIsTheNormalCurvature) {
  const Surface ring = testing::torus(3, 1);
  const CurvatureComb comb = curvatureComb(ring, 0, 0.7, 5);
  ASSERT_FALSE(comb.curvature.empty());
  for (std::size_t i = 0; i < comb.curvature.size(); ++i) {
    EXPECT_NEAR(comb.curvature[i], -1, 1e-11);
    EXPECT_NEAR(comb.normals[i].norm(), 1, 1e-12);
  }
  EXPECT_THROW(curvatureComb(ring, 2, 0.5), InvalidInput);
  EXPECT_THROW(curvatureComb(ring, 0, 4.5), InvalidInput);
  const Net straight = (Net(2, 2) << 0, 0, 1, 1).finished();
  EXPECT_EQ(combScale({curvatureComb(Curve({KnotVector::uniformClamped(1, 1)}, straight))}, 1), 0);
}

}  // namespace
}  // namespace strak
