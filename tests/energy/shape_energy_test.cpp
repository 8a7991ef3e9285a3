#include "strak/energy/shape_energy.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "strak/base/error.h"
#include "strak/energy/join_energy.h"
#include "strak/energy/shape_residuals.h"
#include "strak/spline/knot_insertion.h"
#include "strak/spline/reparametrize.h"
#include "tests/energy/shape_surfaces.h"

namespace strak {
namespace {

using testing::allFree;
using testing::bentSheet;
using testing::someFree;
using testing::withRandomWeights;

ShapeDerivatives randomDerivatives(unsigned seed) {
  std::mt19937 engine(seed);
  ShapeDerivatives x;
  for (int i = 0; i < 27; ++i) x.data()[i] = 2 * static_cast<double>(engine()) / 4294967296.0 - 1;
  return x;
}

TEST(ShapeResiduals, DerivativesAreThoseOfTheValues) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const ShapeDerivatives x = randomDerivatives(seed);
    ShapeResiduals r;
    ASSERT_TRUE(shapeResiduals(x, r));
    for (int d = 0; d < kShapeDerivatives; ++d) {
      for (int c = 0; c < 3; ++c) {
        const double h = 1e-6;
        ShapeDerivatives up = x, down = x;
        up(d, c) += h;
        down(d, c) -= h;
        std::array<double, kShapeResiduals> a, b;
        shapeResiduals(up, a);
        shapeResiduals(down, b);
        for (int k = 0; k < kShapeResiduals; ++k) {
          const double slope = (a[k] - b[k]) / (2 * h), scale = 1 + std::abs(slope);
          EXPECT_NEAR(r.derivative(3 * k + c, d) / scale, slope / scale, 2e-5) << seed << " " << k << " " << d << c;
        }
      }
    }
  }
}

// A sphere's curvature is constant: |nabla h| = 0; a cylinder's too.
TEST(ShapeResiduals, KnownSurfaces) {
  for (const double u : {0.1, 0.7, 1.2}) {
    const double r = 2, cu = std::cos(u), su = std::sin(u), cv = std::cos(0.4), sv = std::sin(0.4);
    ShapeDerivatives x;
    x << -r * su * cv, -r * su * sv, r * cu, -r * cu * sv, r * cu * cv, 0,                                 // u, v
        -r * cu * cv, -r * cu * sv, -r * su, r * su * sv, -r * su * cv, 0, -r * cu * cv, -r * cu * sv, 0,  // uu uv vv
        r * su * cv, r * su * sv, -r * cu, r * cu * sv, -r * cu * cv, 0, r * su * cv, r * su * sv, 0,  // uuu uuv uvv
        r * cu * sv, -r * cu * cv, 0;                                                                  // vvv
    std::array<double, kShapeResiduals> q;
    ASSERT_TRUE(shapeResiduals(x, q));
    const double area = r * r * cu;
    EXPECT_NEAR(q[4] * q[4] + q[5] * q[5] + q[6] * q[6], 2 / (r * r) * area, 1e-12);
    EXPECT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 0, 1e-20);
  }
}

TEST(ShapeResiduals, NoNormalNoResidual) {
  ShapeDerivatives x = randomDerivatives(3);
  x.row(1) = 2 * x.row(0);
  ShapeResiduals r;
  EXPECT_FALSE(shapeResiduals(x, r));
  EXPECT_TRUE(r.derivative.isZero(0));
}

// The roughness is the sum over the frame, so it must not change with the parametrization: u -> 3 u + v^2 / 4 ...
TEST(ShapeEnergy, DoesNotSeeTheParameters) {
  const Surface sheet = bentSheet(3, 4, 4, 3, 0.01);
  const ShapeEnergies energies = ShapeEnergy(sheet, allFree(sheet), 12).values(sheet.net());
  const Surface scaled{{sheet.knots(0).rescaled(-3, 17), sheet.knots(1).rescaled(5, 5.01)}, sheet.net()};
  const ShapeEnergies same = ShapeEnergy(scaled, allFree(sheet), 12).values(sheet.net());
  EXPECT_NEAR(same.plate / energies.plate, 1, 1e-12);
  EXPECT_NEAR(same.roughness / energies.roughness, 1, 1e-12);
  const ShapeEnergies larger = ShapeEnergy(sheet, allFree(sheet), 12).values(1000 * sheet.net());
  EXPECT_NEAR(larger.plate / energies.plate, 1, 1e-12);
  EXPECT_NEAR(1e6 * larger.roughness / energies.roughness, 1, 1e-12);
}

// F as a function of the unknowns, metric included.
double value(const ShapeEnergy& energy, const Net& points, const ShapeEnergy::Weights& w) {
  const ShapeEnergies e = energy.values(points);
  return w.roughness * e.roughness + w.plate * e.plate + (w.metric > 0 ? w.metric * energy.metric(points) : 0);
}

TEST(ShapeEnergy, GradientIsThatOfTheValue) {
  for (const bool rational : {false, true}) {
    Surface sheet = bentSheet(3, 2, 3, 4, 0.02);
    if (rational) sheet = withRandomWeights(sheet);
    const std::vector<int> unknownOf = someFree(sheet);
    const int unknowns = 1 + *std::max_element(unknownOf.begin(), unknownOf.end());
    ShapeEnergy energy(sheet, unknownOf, 5);
    const Net points = sheet.euclideanNet();
    energy.setMetric(points);
    const ShapeEnergy::Weights weights{0.3, 2, 0.1};
    const auto pattern = std::make_shared<const BlockPattern>(patternOfCliques(unknowns, energy.cliques()));
    BlockMatrix matrix(pattern);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(3 * unknowns);
    const ShapeEnergies e = energy.addStep(points, weights, matrix, gradient);
    EXPECT_NEAR(e.roughness, energy.values(points).roughness, 1e-10 * e.roughness);
    for (int k = 0; k < 3 * unknowns; k += 5) {
      const auto moved = [&](double h) {
        Net net = points;
        for (std::size_t r = 0; r < unknownOf.size(); ++r) {
          if (unknownOf[r] == k / 3) net(static_cast<Index>(r), k % 3) += h;
        }
        return value(energy, net, weights);
      };
      const double slope = (moved(1e-6) - moved(-1e-6)) / 2e-6;
      EXPECT_NEAR(gradient[k], slope, 1e-5 * (1 + gradient.cwiseAbs().maxCoeff())) << k << rational;
    }
    // The matrix is symmetric and positive semidefinite.
    Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(3 * unknowns, -1, 1), y = x.cwiseAbs2();
    EXPECT_NEAR(y.dot(matrix.times(x)), x.dot(matrix.times(y)), 1e-9 * std::abs(y.dot(matrix.times(x))));
    EXPECT_GT(x.dot(matrix.times(x)), 0);
  }
}

TEST(ShapeEnergy, EqualWeightsAreNoWeights) {
  const Surface sheet = bentSheet(3, 3, 3, 3, 0.02);
  Net net(sheet.net().rows(), 4);
  net << 2 * sheet.net(), Eigen::VectorXd::Constant(sheet.net().rows(), 2);
  const Surface rational{sheet.knots(), net, true};
  const ShapeEnergies a = ShapeEnergy(sheet, allFree(sheet)).values(sheet.net());
  const ShapeEnergies b = ShapeEnergy(rational, allFree(sheet)).values(rational.euclideanNet());
  EXPECT_NEAR(a.roughness, b.roughness, 1e-10 * a.roughness);
  EXPECT_NEAR(a.plate, b.plate, 1e-12 * a.plate);
}

TEST(ShapeEnergy, OnlyCellsWithFreePointsCount) {
  const Surface sheet = bentSheet(3, 3, 6, 6);
  std::vector<int> unknownOf(static_cast<std::size_t>(sheet.net().rows()), -1);
  unknownOf[static_cast<std::size_t>(sheet.row({0, 0}))] = 0;
  const ShapeEnergy energy(sheet, unknownOf);
  EXPECT_EQ(energy.activeCells(), 1);
  EXPECT_TRUE(energy.isActive(0.01, 0.01));
  EXPECT_FALSE(energy.isActive(0.5, 0.01));
  EXPECT_FALSE(energy.isWhole());
}

TEST(ShapeEnergy, RefusesWhatIsNotInSpace) {
  const KnotVector k = KnotVector::uniformClamped(2, 1);
  EXPECT_THROW(ShapeEnergy(Surface{{k, k}, Net::Zero(9, 2)}, std::vector<int>(9, 0)), InvalidInput);
  const Surface sheet = bentSheet(2, 2, 1, 1);
  EXPECT_THROW(ShapeEnergy(sheet, {0, 1}), InvalidInput);
}

// The two halves of a smooth surface meet smoothly.
TEST(JoinEnergy, HalvesOfASmoothSurfaceJoinWithoutRoughness) {
  const Surface whole = bentSheet(4, 3, 4, 3);
  const Surface split = insertKnots(whole, 0, {0.5, 0.5, 0.5});
  const std::vector<int> unknownOf = allFree(split);
  const JoinEnergy line(split, unknownOf, {0, 0.5, false}, split, unknownOf, {0, 0.5, true}, false);
  const JoinFigures figures = line.figures(split.net(), split.net());
  EXPECT_LT(figures.ofAngle + figures.ofJump, 1e-15);
  EXPECT_LT(figures.angle, 1e-12);
  EXPECT_LT(figures.jump, 1e-10);
  EXPECT_GT(figures.curvature, 0.1);
}

TEST(JoinEnergy, MeasuresAKinkAndAJump) {
  // A plane and a plane that rises by 0.1 rad: a roof along v.
  const KnotVector k = KnotVector::uniformClamped(2, 1);
  Net low(9, 3), high(9, 3);
  for (Index i = 0; i < 3; ++i) {
    for (Index j = 0; j < 3; ++j) {
      const double x = 0.5 * static_cast<double>(i), y = 0.5 * static_cast<double>(j);
      low.row(3 * i + j) << x - 1, y, 0;
      high.row(3 * i + j) << x * std::cos(0.1), y, x * std::sin(0.1);
    }
  }
  const Surface a{{k, k}, low}, b{{k, k}, high};
  const std::vector<int> free = allFree(a);
  JoinFigures roof = JoinEnergy(a, free, bankOfSide(a, 1), b, free, bankOfSide(b, 0), false).figures(low, high);
  EXPECT_NEAR(roof.angle, std::sin(0.1), 1e-12);
  EXPECT_NEAR(roof.jump, 0, 1e-12);
  EXPECT_GT(roof.ofAngle, 0);
  // A parabola y = x^2 / 2 that goes on from the plane: curvature 1.
  for (Index i = 0; i < 3; ++i) {
    for (Index j = 0; j < 3; ++j) {
      const double x = 0.5 * static_cast<double>(i), z = i == 2 ? 0.5 : 0;
      high.row(3 * i + j) << x, 0.5 * static_cast<double>(j), z;
    }
  }
  const Surface c{{k, k}, high};
  const JoinFigures bend = JoinEnergy(a, free, bankOfSide(a, 1), c, free, bankOfSide(c, 0), false).figures(low, high);
  EXPECT_NEAR(bend.angle, 0, 1e-14);
  EXPECT_NEAR(bend.jump, 1, 1e-12);
  EXPECT_NEAR(bend.ofJump, 1, 1e-12) << "jump^2 / width times length";
}

TEST(JoinEnergy, GradientIsThatOfTheValue) {
  for (const bool rational : {false, true}) {
    Surface a = bentSheet(3, 3, 3, 2, 0.03, 1), b = bentSheet(3, 3, 3, 2, 0.03, 2);
    if (rational) {
      a = withRandomWeights(a, 3);
      b = withRandomWeights(b, 4);
    }
    std::vector<int> unknownA = allFree(a), unknownB = allFree(b);
    for (int& u : unknownB) u += static_cast<int>(unknownA.size());
    unknownA[3] = -1;
    const auto unknowns = static_cast<int>(unknownA.size() + unknownB.size());
    const JoinEnergy join(a, unknownA, bankOfSide(a, 3), b, unknownB, bankOfSide(b, 2), true);
    const auto pattern = std::make_shared<const BlockPattern>(patternOfCliques(unknowns, join.cliques()));
    BlockMatrix matrix(pattern);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(3 * unknowns);
    const Net pa = a.euclideanNet(), pb = b.euclideanNet();
    join.addStep(pa, pb, 0.5, 0.3, matrix, gradient);
    EXPECT_GT(gradient.norm(), 0);
    for (int k = 0; k < 3 * unknowns; k += 2) {
      if (k / 3 == 3) continue;
      const auto moved = [&](double h) {
        Net ma = pa, mb = pb;
        if (k / 3 < static_cast<int>(unknownA.size())) {
          ma(k / 3, k % 3) += h;
        } else {
          mb(k / 3 - static_cast<Index>(unknownA.size()), k % 3) += h;
        }
        const JoinFigures f = join.figures(ma, mb);
        return 0.5 * f.ofAngle + 0.3 * f.ofJump;
      };
      const double slope = (moved(1e-6) - moved(-1e-6)) / 2e-6;
      EXPECT_NEAR(gradient[k], slope, 1e-6 * gradient.cwiseAbs().maxCoeff() + 1e-9) << k << rational;
    }
  }
}

// A line of two faces of which one is longer, and the join of a face with its mirror image.
TEST(JoinEnergy, PartsAndMirrors) {
  const Surface sheet = bentSheet(3, 3, 4, 4);
  const Surface a = subPatch(sheet, 0, 0, 0.5), b = subPatch(subPatch(sheet, 0, 0.5, 1), 1, 0.7, 1.6);
  JoinBank side = bankOfSide(a, 1);
  side.part = {0.7, 1.6};
  const JoinEnergy part(b, allFree(b), bankOfSide(b, 0), a, allFree(a), side, false);
  const JoinFigures smooth = part.figures(b.net(), a.net());
  EXPECT_LT(smooth.angle, 1e-13);
  EXPECT_LT(smooth.jump, 1e-11);
  side.part = {0.7, 1.5};
  const JoinEnergy wrong(b, allFree(b), bankOfSide(b, 0), a, allFree(a), side, false);
  EXPECT_GT(wrong.figures(b.net(), a.net()).angle, 1e-3);

  // A plane turned by 0.1 about the border: the mirror image is twice as far away.
  Surface plane = bentSheet(3, 3, 1, 1);
  const auto g = plane.knots(0).greville(), h = plane.knots(1).greville();
  for (Index i = 0; i < 4; ++i) {
    for (Index j = 0; j < 4; ++j) {
      const double x = g[static_cast<std::size_t>(i)];
      plane.net().row(plane.row({i, j})) << std::cos(0.1) * x, h[static_cast<std::size_t>(j)], std::sin(0.1) * x;
    }
  }
  const JoinEnergy turned(plane, allFree(plane), bankOfSide(plane, 0), Eigen::Vector3d::UnitX());
  EXPECT_NEAR(turned.figures(plane.net(), plane.net()).meanAngle, 2 * std::sin(0.1), 1e-12);

  const Surface bent = bentSheet(3, 3, 3, 2, 0.03, 1);
  const auto free = allFree(bent);
  const JoinEnergy mirror(bent, free, bankOfSide(bent, 2), Eigen::Vector3d(0, 0.6, 0.8));
  const auto unknowns = static_cast<int>(free.size());
  BlockMatrix matrix(std::make_shared<const BlockPattern>(patternOfCliques(unknowns, mirror.cliques())));
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(3 * unknowns);
  mirror.addStep(bent.net(), bent.net(), 0.5, 0.3, matrix, gradient);
  EXPECT_GT(gradient.norm(), 0);
  for (int k = 0; k < 3 * unknowns; ++k) {
    const auto moved = [&](double by) {
      Net net = bent.net();
      net(k / 3, k % 3) += by;
      const JoinFigures f = mirror.figures(net, net);
      return 0.5 * f.ofAngle + 0.3 * f.ofJump;
    };
    const double slope = (moved(1e-6) - moved(-1e-6)) / 2e-6;
    EXPECT_NEAR(gradient[k], slope, 1e-6 * gradient.cwiseAbs().maxCoeff() + 1e-9) << k;
  }
}

TEST(JoinEnergy, ABankMustBeAKnotLine) {
  const Surface a = bentSheet(2, 2, 2, 2);
  const auto free = allFree(a);
  EXPECT_THROW(JoinEnergy(a, free, {0, 0.3, true}, a, free, {0, 0.3, false}, false), InvalidInput);
}

}  // namespace
}  // namespace strak
