#include "strak/energy/quadratic_energy.h"

#include <gtest/gtest.h>

#include "strak/base/error.h"
#include "strak/energy/energy_operator.h"
#include "strak/energy/gram.h"
#include "tests/spline/random_splines.h"

namespace strak {
namespace {

using testing::Random;

TEST(Gram, OfMassSumsToTheDomainAndOfMixedDerivativesIsTheTransposed) {
  Random random(11);
  for (int i = 0; i < 60; ++i) {
    const KnotVector knots = testing::randomKnots(random, 7);
    EXPECT_NEAR(gramMatrix(knots, 0, 0).dense().sum(), knots.length(), 1e-13 * knots.length());
    for (int a = 0; a <= 3; ++a) {
      for (int b = 0; b <= 3; ++b) {
        const Eigen::MatrixXd gram = gramMatrix(knots, a, b).dense();
        EXPECT_LE((gram - gramMatrix(knots, b, a).dense().transpose()).cwiseAbs().maxCoeff(),
                  1e-14 * gram.cwiseAbs().maxCoeff());
        if (a > knots.degree() || b > knots.degree()) {
          EXPECT_EQ(gram.cwiseAbs().maxCoeff(), 0);
        }
      }
    }
  }
}

TEST(Gram, OfUniformLinearSplinesIsTheKnownOne) {
  const Eigen::MatrixXd mass = gramMatrix(KnotVector::uniformClamped(1, 3, 0, 3), 0, 0).dense();
  const Eigen::MatrixXd stiffness = gramMatrix(KnotVector::uniformClamped(1, 3, 0, 3), 1, 1).dense();
  EXPECT_NEAR(mass(1, 1), 2.0 / 3, 1e-15);
  EXPECT_NEAR(mass(0, 0), 1.0 / 3, 1e-15);
  EXPECT_NEAR(mass(1, 2), 1.0 / 6, 1e-15);
  EXPECT_EQ(mass(0, 2), 0);
  EXPECT_NEAR(stiffness(1, 1), 2, 1e-15);
  EXPECT_NEAR(stiffness(1, 2), -1, 1e-15);
}

TEST(QuadraticEnergy, KnowsItsOrder) {
  EXPECT_EQ(thinPlate<2>().order(), 2);
  EXPECT_EQ(laplacian<3>().order(), 2);
  EXPECT_EQ(thirdOrder<1>().order(), 3);
  EXPECT_EQ(laplacianGradient<2>().order(), 3);
  EXPECT_EQ(energyNamed<2>("thin-plate + q3").order(), 3);
}

TEST(QuadraticEnergy, CountsMixedDerivativesAsOftenAsTheyOccur) {
  double mixed = 0;
  for (const auto& term : thinPlate<2>().terms) {
    if (term.a == std::array{1, 1}) mixed += term.coefficient;
  }
  EXPECT_EQ(mixed, 2);
  double all = 0;
  for (const auto& term : thirdDerivatives<3>().terms) all += term.coefficient;
  EXPECT_EQ(all, 27);
}

TEST(EnergyNamed, MakesMixturesThatAddUp) {
  Random random(5);
  const auto surface = testing::randomSpline<2>(
      random, {testing::randomKnots(random, testing::KnotKind::nonUniform, 4, 3), KnotVector::uniformClamped(3, 4)}, 3,
      false);
  const auto value = [&](const char* name) {
    return EnergyOperator<2>(energyNamed<2>(name), surface.knots()).value(surface.net());
  };
  const double plate = value("thin-plate");
  const double third = value("third-derivatives");
  const double mixed = value("q3");
  EXPECT_NEAR(value("thin-plate + 0.01 * third-derivatives"), plate + 0.01 * third, 1e-12 * (plate + third));
  EXPECT_NEAR(value("1e+2*thin-plate+2.5E-1*q3"), 100 * plate + 0.25 * mixed, 1e-12 * (100 * plate + mixed));
  EXPECT_NEAR(value(" q3+q3 +\tq3"), 3 * mixed, 1e-12 * mixed);
  EXPECT_EQ(energyNamed<2>("laplacian + q3").name, "laplacian + q3");
}

TEST(EnergyNamed, RefusesWhatItDoesNotKnow) {
  for (const char* name : {"", "+", "thin plate x", "Thin-Plate", "thin-plate+", "+thin-plate", "0*thin-plate",
                           "-1*thin-plate", "nan*thin-plate", "inf*thin-plate", "1e999*thin-plate", "two*thin-plate",
                           "*thin-plate", "2*", "2*3*thin-plate", "2thin-plate"}) {
    EXPECT_THROW(energyNamed<2>(name), InvalidInput) << name;
  }
  EXPECT_THROW(energyNamed<1>("q3"), InvalidInput);
  try {
    energyNamed<2>("bending");
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("thin-plate"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace strak
