#include "strak/spline/knot_vector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "strak/base/error.h"
#include "tests/spline/random_splines.h"

namespace strak {
namespace {

using strak::testing::Random;

std::string complaint(int degree, std::vector<double> knots, const char* name = "u") {
  try {
    KnotVector(degree, std::move(knots), name);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(KnotVector, SaysWhichKnotDecreases) {
  EXPECT_EQ(complaint(1, {0, 0, 0.4, 0.31, 1, 1}, "v"),
            "knot 3 of direction v is smaller than knot 2 (0.31 < 0.4): sort the knots");
}

TEST(KnotVector, RefusesWhatIsNoKnotVectorAndSaysWhy) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const double huge = std::numeric_limits<double>::max();
  EXPECT_NE(complaint(-1, {0, 1}).find("degree of direction u is -1"), std::string::npos);
  EXPECT_NE(complaint(3, {0, 0, 0, 1, 1, 1}).find("6 knots but degree 3 needs at least 8"), std::string::npos);
  EXPECT_NE(complaint(1, {0, 0, nan, 1, 1}).find("knot 2 of direction u is not a finite number"), std::string::npos);
  EXPECT_NE(complaint(1, {0, 0, 1, inf}).find("knot 3"), std::string::npos);
  EXPECT_NE(complaint(1, {0, 0, 0.5, 0.5, 0.5, 1, 1}).find("more than 2 times"), std::string::npos);
  EXPECT_NE(complaint(2, {0, 0, 0, 0, 1, 1, 1}).find("more than 3 times"), std::string::npos);
  EXPECT_NE(complaint(1, {-1, 0, 0, 1}).find("domain of direction u is empty"), std::string::npos);
  EXPECT_NE(complaint(1, {-huge, -huge, huge, huge}).find("too far"), std::string::npos);
  EXPECT_NE(complaint(0, {}).find("0 knots"), std::string::npos);
  EXPECT_THROW(KnotVector::uniformClamped(3, 0), InvalidInput);
}

TEST(KnotVector, UniformClampedHasTheSpansOfThePaper) {
  const auto knots = KnotVector::uniformClamped(4, 48);
  EXPECT_EQ(knots.size(), 52);
  EXPECT_EQ(knots.multiplicity(0), 5);
  EXPECT_EQ(knots.multiplicity(1), 5);
  EXPECT_EQ(knots[5], 1.0 / 48);
  EXPECT_EQ(knots.spans().size(), 48U);
  EXPECT_TRUE(knots.isClamped());
}

TEST(KnotVector, FindsTheSpanOfEveryParameter) {
  Random random(11);
  for (int trial = 0; trial < 300; ++trial) {
    const KnotVector knots = testing::randomKnots(random, 6);
    for (int i = 0; i < 20; ++i) {
      const double u = i == 0 ? knots.from() - 1 : i == 1 ? knots.to() + 1 : testing::randomParameter(random, knots);
      const Index span = knots.findSpan(u);
      ASSERT_GE(span, knots.degree());
      ASSERT_LT(span, knots.size());
      ASSERT_LT(knots[span], knots[span + 1]);
      if (u >= knots.from() && u < knots.to()) {
        ASSERT_LE(knots[span], u);
        ASSERT_LT(u, knots[span + 1]);
      } else if (u >= knots.to()) {
        ASSERT_EQ(knots[span + 1], knots.to());
      } else {
        ASSERT_EQ(knots[span], knots.from());
      }
    }
  }
}

TEST(KnotVector, CountsInnerKnots) {
  const KnotVector knots(2, {0, 0, 0, 1, 1, 2, 3, 3, 3, 4, 4, 4});
  const auto inner = knots.innerKnots();
  ASSERT_EQ(inner.size(), 3U);
  EXPECT_EQ(inner[0].value, 1);
  EXPECT_EQ(inner[0].multiplicity, 2);
  EXPECT_EQ(inner[1].multiplicity, 1);
  EXPECT_EQ(inner[2].multiplicity, 3);
  EXPECT_EQ(knots.spans(), (std::vector<Index>{2, 4, 5, 8}));
}

TEST(KnotVector, GrevilleAbscissaeAreMeansOfKnots) {
  const KnotVector knots(3, {0, 0, 0, 0, 1, 2, 2, 2, 2});
  EXPECT_EQ(knots.greville(), (std::vector<double>{0, 1.0 / 3, 1, 5.0 / 3, 2}));
  EXPECT_EQ(KnotVector(0, {0, 1, 3}).greville(), (std::vector<double>{0.5, 2}));
}

TEST(KnotVector, RescalesOntoTheExactEnds) {
  Random random(12);
  for (int trial = 0; trial < 100; ++trial) {
    const KnotVector knots = testing::randomKnots(random, 5);
    const double from = random.uniform(-1e6, 1e6);
    const double to = from + random.uniform(1e-3, 1e3);
    const KnotVector scaled = knots.rescaled(from, to);
    EXPECT_EQ(scaled.from(), from);
    EXPECT_EQ(scaled.to(), to);
    EXPECT_EQ(scaled.multiplicity(from), knots.multiplicity(knots.from()));
  }
  EXPECT_THROW(KnotVector().rescaled(1, 1), InvalidInput);
  EXPECT_THROW(KnotVector().rescaled(0, std::numeric_limits<double>::infinity()), InvalidInput);
}

TEST(ActiveKnots, KeepsTheFunctionsAliveInsideAnInterval) {
  const KnotVector knots(2, {-2, -1, 0, 1, 2, 2, 3, 4, 5});
  const auto [all, first] = activeKnots(knots, 0, 3);
  EXPECT_EQ(first, 0);
  EXPECT_EQ(all, knots);
  const auto [part, second] = activeKnots(knots, 1, 2);
  EXPECT_EQ(second, 1);
  EXPECT_EQ(part.knots(), (std::vector<double>{-1, 0, 1, 2, 2, 3}));
  EXPECT_THROW(activeKnots(knots, 0.5, 3), InvalidInput);
  EXPECT_THROW(activeKnots(knots, -1, 3), InvalidInput);
  EXPECT_THROW(activeKnots(knots, 3, 0), InvalidInput);
  EXPECT_THROW(activeKnots(knots, 0, 4), InvalidInput);
}

}  // namespace
}  // namespace strak
