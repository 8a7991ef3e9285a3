#include "strak/spline/basis.h"

#include <gtest/gtest.h>

#include "strak/base/error.h"
#include "strak/spline/basis_table.h"
#include "tests/spline/random_splines.h"

namespace strak {
namespace {

using strak::testing::Random;

// The k-th derivative of N_{i,p} on `span` straight from the definition, in more digits.
long double byDefinition(const KnotVector& knots, Index span, Index i, int p, long double u, int k) {
  if (p == 0) return k == 0 && i == span ? 1 : 0;
  const auto quotient = [&](long double a, long double b) { return b == 0 ? 0 : a / b; };
  const long double left = static_cast<long double>(knots[i + p]) - knots[i];
  const long double right = static_cast<long double>(knots[i + p + 1]) - knots[i + 1];
  if (k > 0) {
    return p * (quotient(byDefinition(knots, span, i, p - 1, u, k - 1), left) -
                quotient(byDefinition(knots, span, i + 1, p - 1, u, k - 1), right));
  }
  return quotient((u - knots[i]) * byDefinition(knots, span, i, p - 1, u, 0), left) +
         quotient((knots[i + p + 1] - u) * byDefinition(knots, span, i + 1, p - 1, u, 0), right);
}

TEST(Basis, QuadraticUniformValuesAreExact) {
  const KnotVector knots(2, {0, 1, 2, 3, 4, 5});
  const auto values = basisDerivatives(knots, 2, 2.5, 3);
  const double expected[4][3] = {{0.125, 0.75, 0.125}, {-0.5, 0, 0.5}, {1, -2, 1}, {0, 0, 0}};
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 3; ++j) EXPECT_EQ(values(k, j), expected[k][j]);
  }
}

TEST(Basis, CubicBernsteinValuesAreExact) {
  const auto values = basisDerivatives(KnotVector::uniformClamped(3, 1), 3, 0.5, 3);
  const double expected[4][4] = {
      {0.125, 0.375, 0.375, 0.125}, {-0.75, -0.75, 0.75, 0.75}, {3, -3, -3, 3}, {-6, 18, -18, 6}};
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 4; ++j) EXPECT_EQ(values(k, j), expected[k][j]);
  }
}

TEST(Basis, AgreesWithTheDefinition) {
  Random random(21);
  for (int trial = 0; trial < 150; ++trial) {
    const KnotVector knots = testing::randomKnots(random, 7);
    const int p = knots.degree();
    for (int i = 0; i < 5; ++i) {
      const double u = testing::randomParameter(random, knots);
      const Index span = knots.findSpan(u);
      const auto values = basisDerivatives(knots, span, u, 4);
      for (int k = 0; k <= 4; ++k) {
        const double scale = 1 + values.row(k).cwiseAbs().maxCoeff();
        for (int j = 0; j <= p; ++j) {
          ASSERT_NEAR(values(k, j), static_cast<double>(byDefinition(knots, span, span - p + j, p, u, k)),
                      1e-13 * scale)
              << "degree " << p << " derivative " << k;
        }
      }
    }
  }
}

TEST(Basis, IsAPartitionOfUnity) {
  Random random(22);
  for (int trial = 0; trial < 300; ++trial) {
    const KnotVector knots = testing::randomKnots(random, 9);
    const double u = testing::randomParameter(random, knots);
    const auto values = basisDerivatives(knots, knots.findSpan(u), u, 3);
    ASSERT_NEAR(values.row(0).sum(), 1, 1e-14);
    ASSERT_GE(values.row(0).minCoeff(), 0);
    for (int k = 1; k <= 3; ++k) ASSERT_NEAR(values.row(k).sum(), 0, 1e-12 * (1 + values.row(k).cwiseAbs().maxCoeff()));
  }
}

TEST(Basis, WorksForHighDegrees) {
  for (const int p : {20, 31, 32, 40}) {
    const auto knots = KnotVector::uniformClamped(p, 3);
    const auto values = basisDerivatives(knots, knots.findSpan(0.5), 0.5, 1);
    EXPECT_NEAR(values.row(0).sum(), 1, 1e-13);
    EXPECT_NEAR(values.row(1).sum(), 0, 1e-11);
  }
}

TEST(BasisTable, AgreesWithTheRecurrence) {
  Random random(23);
  for (int trial = 0; trial < 300; ++trial) {
    const KnotVector knots = testing::randomKnots(random, 12);
    const BasisTable table(knots);
    const int p = knots.degree();
    const int order = random.integer(0, 3);
    std::vector<double> parameters;
    for (int i = 0; i < 9; ++i) parameters.push_back(testing::randomParameter(random, knots));
    parameters.push_back(knots.from() - 0.01 * knots.length());
    parameters.push_back(knots.to() + 0.01 * knots.length());
    const auto count = static_cast<Index>(parameters.size());
    std::vector<Index> first(parameters.size());
    std::vector<double> weights(parameters.size() * static_cast<std::size_t>((order + 1) * table.width()));
    table.weights(parameters.data(), 1, count, order, first.data(), weights.data());
    for (Index r = 0; r < count; ++r) {
      const double u = parameters[static_cast<std::size_t>(r)];
      ASSERT_EQ(first[static_cast<std::size_t>(r)], knots.findSpan(u) - p);
      const auto expected = basisDerivatives(knots, knots.findSpan(u), u, order);
      for (int k = 0; k <= order; ++k) {
        const double* row = weights.data() + (r * (order + 1) + k) * table.width();
        for (int j = 0; j < table.width(); ++j) {
          const double value = j <= p ? expected(k, j) : 0;
          ASSERT_NEAR(row[j], value, 1e-13 * (1 + expected.row(k).cwiseAbs().maxCoeff()));
        }
      }
    }
  }
}

TEST(BasisTable, FindsSpansAmongCrowdedKnots) {
  // Spans from 1 down to 2^-40: nearly all of them share one bucket of the search table.
  std::vector<double> inner{0, 0, 0};
  for (int i = 40; i >= 1; --i) inner.push_back(std::ldexp(1.0, -i));
  inner.insert(inner.end(), {1, 1, 1});
  const KnotVector knots(2, inner);
  const BasisTable table(knots);
  std::vector<double> weights(static_cast<std::size_t>(table.width()));
  for (const Index span : knots.spans()) {
    for (const double t : {0.0, 0.3, 0.999}) {
      const double u = knots[span] + t * (knots[span + 1] - knots[span]);
      Index first = -1;
      table.weights(&u, 1, 1, 0, &first, weights.data());
      EXPECT_EQ(first, knots.findSpan(u) - 2) << u;
    }
  }
}

TEST(BasisTable, DoesNotFallOverBadParameters) {
  const BasisTable table(KnotVector::uniformClamped(3, 5));
  std::vector<double> weights(static_cast<std::size_t>(table.width()));
  Index first = -1;
  for (const double u : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                         -std::numeric_limits<double>::infinity(), 1e300, -1e300}) {
    table.weights(&u, 1, 1, 0, &first, weights.data());
    EXPECT_GE(first, 0);
    EXPECT_LE(first, 4);
  }
}

TEST(GaussLegendre, IntegratesPolynomialsExactly) {
  for (int count = 1; count <= 12; ++count) {
    const auto rule = gaussLegendre(count);
    for (int degree = 0; degree < 2 * count; ++degree) {
      double sum = 0;
      for (std::size_t i = 0; i < rule.nodes.size(); ++i) sum += rule.weights[i] * std::pow(rule.nodes[i], degree);
      EXPECT_NEAR(sum, degree % 2 == 1 ? 0 : 2.0 / (degree + 1), 1e-15 * 8) << count << " " << degree;
    }
    EXPECT_TRUE(std::is_sorted(rule.nodes.begin(), rule.nodes.end()));
  }
  EXPECT_THROW(gaussLegendre(0), InvalidInput);
}

}  // namespace
}  // namespace strak
