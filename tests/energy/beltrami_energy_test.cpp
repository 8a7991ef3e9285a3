#include "strak/energy/beltrami_energy.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <Eigen/LU>

#include "strak/base/error.h"
#include "strak/energy/shape_energy.h"
#include "strak/spline/basis.h"
#include "strak/spline/degree_elevation.h"
#include "strak/spline/knot_insertion.h"
#include "tests/energy/shape_surfaces.h"

namespace strak {
namespace {

using testing::allFree;
using testing::bentSheet;
using testing::someFree;
using testing::withRandomWeights;

// The basis functions of knots without inner ones.
Eigen::RowVectorXd basisRow(const KnotVector& knots, double t) {
  return basisDerivatives(knots, knots.findSpan(t), t, 0).row(0);
}

// The plane (a u + b v, c v, 0) on [0, 1] x [0, 1], with the given degrees and spans.
Surface plane(int p, int q, Index spansU, Index spansV, double a, double b, double c) {
  const KnotVector u = KnotVector::uniformClamped(p, spansU), v = KnotVector::uniformClamped(q, spansV);
  const auto gu = u.greville(), gv = v.greville();
  Net net(u.size() * v.size(), 3);
  for (Index i = 0; i < u.size(); ++i) {
    for (Index j = 0; j < v.size(); ++j) {
      const double x = gu[static_cast<std::size_t>(i)], y = gv[static_cast<std::size_t>(j)];
      net.row(i * v.size() + j) << a * x + b * y, c * y, 0;
    }
  }
  return {{u, v}, net};
}

// z = x^2 y^2 over the rectangle [0, a] x [0, c]: Laplacian 2 x^2 + 2 y^2, its square 4 (x^4 + 2 x^2 y^2 + y^4).
TEST(BeltramiEnergy, OverAPlaneItIsTheSquaredLaplacian) {
  for (const Index spans : {1, 3}) {
    const double a = 2, c = 3;
    const Surface reference = plane(2, 2, spans, 1, a, 0, c);
    // u^2 on the knots, as its blossom; v^2 has the Bezier points 0, 0, 1.
    const auto& k = reference.knots(0);
    Net net = Net::Zero(reference.net().rows(), 3);
    for (Index i = 0; i < k.size(); ++i) net(3 * i + 2, 2) = a * a * c * c * k[i + 1] * k[i + 2];
    const BeltramiEnergy energy(reference, allFree(reference));
    const double exact = 4 * (std::pow(a, 5) * c / 5 + 2 * std::pow(a * c, 3) / 9 + a * std::pow(c, 5) / 5);
    EXPECT_NEAR(energy.value(net), exact, 1e-12 * exact) << spans;
    EXPECT_NEAR(energy.value(reference.net()), 0, 1e-12);
  }
}

// u^2 with x = u + b v, y = c v: u = x - (b / c) y, the Laplacian is 2 + 2 (b / c)^2, the area c.
TEST(BeltramiEnergy, ASkewPlaneIsTheSame) {
  const Surface reference = plane(2, 2, 1, 1, 1, 0.5, 0.25);
  Net net = Net::Zero(9, 3);
  net.bottomRows(3).col(1).setOnes();
  EXPECT_NEAR(BeltramiEnergy(reference, allFree(reference)).value(net), 100 * 0.25, 1e-11);
}

// A quarter of a cylinder of radius r and height h, rational: Delta X = 2 H n, |2 H| = 1 / r.
TEST(BeltramiEnergy, OverItselfItIsTheSquaredMeanCurvature) {
  const double r = 2.5, h = 3, s = std::sqrt(0.5);
  const KnotVector u = KnotVector::uniformClamped(2, 1), v = KnotVector::uniformClamped(1, 1);
  Net net(6, 4);
  net << r, 0, 0, 1, r, 0, h, 1, s * r, s * r, 0, s, s * r, s * r, s * h, s, 0, r, 0, 1, 0, r, h, 1;
  const Surface cylinder{{u, v}, net, true};
  const double area = std::numbers::pi / 2 * r * h;
  EXPECT_NEAR(BeltramiEnergy(cylinder, allFree(cylinder), 12).value(cylinder.euclideanNet()), area / (r * r), 1e-10);
  const Surface fine = insertKnots(elevateDegree(cylinder, 1, 3), 1, {0.2, 0.7});
  EXPECT_NEAR(BeltramiEnergy(fine, allFree(fine), 12).value(fine.euclideanNet()), area / (r * r), 1e-10);
}

// Of a minimal surface nothing is left, of others int 4 H^2 = int k1^2 + k2^2 + 2 int K.
TEST(BeltramiEnergy, EnnepersSurfaceCostsNothing) {
  // (u - u^3 / 3 + u v^2, v - v^3 / 3 + u^2 v, u^2 - v^2) on [0, 1]^2, in Bezier form.
  const KnotVector k = KnotVector::uniformClamped(3, 1);
  const auto blossom = [](Index i, int power) {  // of t^power at i ones and 3 - i zeros
    const double n = static_cast<double>(i);
    return power == 0 ? 1 : power == 1 ? n / 3 : power == 2 ? n * (n - 1) / 6 : n * (n - 1) * (n - 2) / 6;
  };
  Net net(16, 3);
  for (Index i = 0; i < 4; ++i) {
    for (Index j = 0; j < 4; ++j) {
      const auto f = [&](int a, int b) { return blossom(i, a) * blossom(j, b); };
      net.row(4 * i + j) << f(1, 0) - f(3, 0) / 3 + f(1, 2), f(0, 1) - f(0, 3) / 3 + f(2, 1), f(2, 0) - f(0, 2);
    }
  }
  const Surface enneper{{k, k}, net};
  EXPECT_GT(ShapeEnergy(enneper, allFree(enneper), 12).values(net).plate, 1);
  EXPECT_NEAR(BeltramiEnergy(enneper, allFree(enneper), 12).value(net), 0, 1e-12);
}

// All second derivatives: over a plane those of z = x^2 y^2, and over itself int k1^2 + k2^2.
TEST(BeltramiEnergy, TheHessianIsTheThinPlateOfTheInnerGeometry) {
  const double a = 2, c = 3;
  const Surface reference = plane(2, 2, 1, 1, a, 0, c);
  Net net = Net::Zero(9, 3);
  net(8, 2) = a * a * c * c;
  const double exact = 4 * a * std::pow(c, 5) / 5 + 32 * std::pow(a * c, 3) / 9 + 4 * c * std::pow(a, 5) / 5;
  const BeltramiEnergy flat(reference, allFree(reference), 0, InnerBending::hessian);
  EXPECT_NEAR(flat.value(net), exact, 1e-12 * exact);
  EXPECT_NEAR(flat.value(reference.net()), 0, 1e-12);
  for (const unsigned seed : {1U, 2U, 3U}) {
    const Surface sheet = bentSheet(3, 4, 3, 2, 0.05, seed);
    const double plate = ShapeEnergy(sheet, allFree(sheet), 12).values(sheet.net()).plate;
    const BeltramiEnergy own(sheet, allFree(sheet), 12, InnerBending::hessian);
    EXPECT_NEAR(own.value(sheet.net()), plate, 1e-9 * plate);
  }
}

RC_GTEST_PROP(BeltramiEnergy, DependsNeitherOnKnotsNorOnUnitsNorOnThePlace, ()) {
  const auto seed = *rc::gen::arbitrary<unsigned>();
  const int p = *rc::gen::inRange(2, 5), q = *rc::gen::inRange(2, 5);
  const bool rational = *rc::gen::arbitrary<bool>();
  Surface sheet = bentSheet(p, q, 3, 2, 0.03, seed), other = bentSheet(p, q, 3, 2, 0.1, seed + 1);
  if (rational) {
    sheet = withRandomWeights(sheet, seed);
    other = withRandomWeights(other, seed);
  }
  const Net points = other.euclideanNet();
  const auto bending = *rc::gen::element(InnerBending::beltrami, InnerBending::hessian);
  const double value = BeltramiEnergy(sheet, allFree(sheet), 0, bending).value(points);
  RC_ASSERT(value > 0);
  const Surface knots{{sheet.knots(0).rescaled(-3, 17), sheet.knots(1).rescaled(5, 5.01)}, sheet.net(), rational};
  RC_ASSERT(std::abs(BeltramiEnergy(knots, allFree(sheet), 0, bending).value(points) / value - 1) < 1e-9);
  Surface large = sheet;
  large.net().leftCols(3) *= 1000;
  RC_ASSERT(std::abs(BeltramiEnergy(large, allFree(sheet), 0, bending).value(1000 * points) / value - 1) < 1e-9);
  Net far = points;
  far.rowwise() += Eigen::RowVector3d(1e4, -2e4, 3e4);
  RC_ASSERT(std::abs(BeltramiEnergy(sheet, allFree(sheet), 0, bending).value(far) / value - 1) < 1e-6);
}

// u = t^2 makes another net of the same two surfaces: the same energy, unlike that of the parameters.
TEST(BeltramiEnergy, DoesNotSeeTheParametrization) {
  const Surface reference = bentSheet(2, 3, 1, 2, 0.02), surface = bentSheet(2, 3, 1, 2, 0.1, 7);
  // X(t^2 + t) / 2: a quadratic in u is a quartic in t; Bezier points by blossoming are easiest by interpolation.
  const auto bent = [](const Surface& s) {
    const KnotVector quartic = KnotVector::uniformClamped(4, 1);
    Eigen::MatrixXd bernstein(5, 5);
    Net result(5 * s.size(1), 3);
    const Index nv = s.size(1);
    std::vector<double> u;
    for (int i = 0; i < 5; ++i) {
      const double t = i / 4.0;
      bernstein.row(i) = basisRow(quartic, t);
      u.push_back((t + t * t) / 2);
    }
    Eigen::MatrixXd values(5, 3 * nv);
    for (int i = 0; i < 5; ++i) {
      const Eigen::RowVectorXd b = basisRow(s.knots(0), u[static_cast<std::size_t>(i)]);
      for (Index j = 0; j < nv; ++j) {
        Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
        for (Index k = 0; k < 3; ++k) sum += b[k] * s.net().row(k * nv + j);
        values.row(i).segment<3>(3 * j) = sum;
      }
    }
    const Eigen::MatrixXd points = bernstein.partialPivLu().solve(values);
    for (Index i = 0; i < 5; ++i) {
      for (Index j = 0; j < nv; ++j) result.row(i * nv + j) = points.row(i).segment<3>(3 * j);
    }
    return Surface{{quartic, s.knots(1)}, result};
  };
  const double value = BeltramiEnergy(reference, allFree(reference), 14).value(surface.net());
  const Surface other = bent(reference);
  EXPECT_NEAR(BeltramiEnergy(other, allFree(other), 14).value(bent(surface).net()) / value, 1, 1e-9);
}

TEST(BeltramiEnergy, GradientIsThatOfTheValue) {
  for (const bool rational : {false, true}) {
    Surface sheet = bentSheet(3, 2, 3, 4, 0.02);
    if (rational) sheet = withRandomWeights(sheet);
    const std::vector<int> unknownOf = someFree(sheet);
    const int unknowns = 1 + *std::max_element(unknownOf.begin(), unknownOf.end());
    const BeltramiEnergy energy(sheet, unknownOf);
    const Net points = bentSheet(3, 2, 3, 4, 0.1, 5).net();
    const auto moved = [&](const Eigen::VectorXd& e) {
      Net net = points;
      for (std::size_t r = 0; r < unknownOf.size(); ++r) {
        if (unknownOf[r] >= 0) net.row(static_cast<Index>(r)) += e.segment<3>(3 * unknownOf[r]).transpose();
      }
      return energy.value(net);
    };
    const auto pattern =
        std::make_shared<const BlockPattern>(patternOfCliques(unknowns, ShapeEnergy(sheet, unknownOf).cliques()));
    BlockMatrix matrix(pattern);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(3 * unknowns);
    energy.addTo(points, 0.3, matrix, gradient);
    // A quadratic: the expansion is exact.
    const double scale = energy.value(points);
    for (unsigned seed = 1; seed <= 5; ++seed) {
      std::srand(seed);
      const Eigen::VectorXd e = 0.1 * Eigen::VectorXd::Random(3 * unknowns);
      const double change = 0.3 * (moved(e) - scale);
      EXPECT_NEAR(gradient.dot(e) + 0.5 * e.dot(matrix.times(e)), change, 1e-10 * (scale + std::abs(change)));
      EXPECT_GT(e.dot(matrix.times(e)), 0);
    }
  }
}

TEST(BeltramiEnergy, OnlyCellsWithFreePointsCount) {
  const Surface sheet = bentSheet(3, 3, 6, 6);
  std::vector<int> unknownOf(static_cast<std::size_t>(sheet.net().rows()), -1);
  EXPECT_EQ(BeltramiEnergy(sheet, unknownOf).value(sheet.net()), 0);
  unknownOf[static_cast<std::size_t>(sheet.row({0, 0}))] = 0;
  const Eigen::MatrixXd corner = BeltramiEnergy(sheet, unknownOf).matrix();
  EXPECT_GT(corner(0, 0), 0);
  EXPECT_EQ(corner.row(sheet.row({4, 4})).norm(), 0);
  const Eigen::MatrixXd whole = BeltramiEnergy(sheet, allFree(sheet)).matrix();
  EXPECT_EQ((whole - whole.transpose()).norm(), 0);
  EXPECT_LT(whole.rowwise().sum().norm(), 1e-10 * whole.norm()) << "constants cost nothing";
}

// A collapsed edge, a fold, everything on one line: finite, and as exact as ever elsewhere.
TEST(BeltramiEnergy, DegenerateReferencesGiveFiniteEnergies) {
  Surface pole = bentSheet(3, 3, 3, 3), fold = pole, line = pole;
  for (Index j = 0; j < pole.size(1); ++j) pole.net().row(j) = pole.net().row(0);
  fold.net().row(20) = fold.net().row(27);
  fold.net().row(21) = fold.net().row(14);
  line.net().rightCols(2).setZero();
  line.net().col(0) += line.net().rowwise().sum();
  for (Index r = 0; r < line.net().rows(); ++r) line.net()(r, 0) = static_cast<double>(r % 7 + r / 7);
  for (const Surface& reference : {pole, fold, line}) {
    const BeltramiEnergy energy(reference, allFree(reference));
    const double value = energy.value(bentSheet(3, 3, 3, 3, 0.1).net());
    EXPECT_TRUE(std::isfinite(value));
    EXPECT_GT(value, 0);
  }
}

TEST(BeltramiEnergy, RefusesWhatIsNoSurfaceInSpace) {
  const KnotVector k = KnotVector::uniformClamped(2, 1);
  EXPECT_THROW(BeltramiEnergy(Surface{{k, k}, Net::Zero(9, 2)}, std::vector<int>(9, 0)), InvalidInput);
  EXPECT_THROW(BeltramiEnergy(Surface{{k, k}, Net::Zero(9, 3)}, std::vector<int>(9, 0)), InvalidInput);
  const Surface sheet = bentSheet(2, 2, 1, 1);
  EXPECT_THROW(BeltramiEnergy(sheet, {0, 1}), InvalidInput);
}

}  // namespace
}  // namespace strak
