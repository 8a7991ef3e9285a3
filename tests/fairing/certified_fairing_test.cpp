#include "strak/fairing/certified_fairing.h"

#include <gtest/gtest.h>

#include <random>

#include "strak/base/error.h"
#include "strak/spline/evaluate.h"

namespace strak {
namespace {

// A smooth net with noise, degree and size differing from direction to direction.
template <int D>
Spline<D> noisySpline(std::uint64_t seed) {
  std::mt19937_64 source(seed);
  const auto random = [&] { return 2 * static_cast<double>(source() >> 11) * 0x1p-53 - 1; };
  std::array<KnotVector, D> knots;
  Index rows = 1;
  for (int k = 0; k < D; ++k) {
    knots[static_cast<std::size_t>(k)] = KnotVector::uniformClamped(2 + k, D == 3 ? 6 : 12, 0, 1 + k);
    rows *= knots[static_cast<std::size_t>(k)].size();
  }
  Net net(rows, 3);
  for (Index r = 0; r < rows; ++r) {
    Index rest = r;
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    for (int k = D - 1; k >= 0; --k) {
      const Index n = knots[static_cast<std::size_t>(k)].size();
      place[k] = 5 * static_cast<double>(rest % n) / static_cast<double>(n - 1);
      rest /= n;
    }
    net.row(r) << place.x(), place.y() + 0.1 * place.x() * place.x(), place.z() + 0.1 * place.y() * place.x();
    for (Index c = 0; c < 3; ++c) net(r, c) += 0.05 * random();
  }
  return Spline<D>(knots, net);
}

template <int D>
FairingPlan<D> planFor(const Spline<D>& spline) {
  FairingPlanOptions<D> options;
  options.rows = FairingPlanOptions<D>::allRows(2);
  return planFairing(spline, options);
}

template <int D>
double sampledDistance(const Spline<D>& a, const Spline<D>& b) {
  std::mt19937_64 source(5);
  double largest = 0;
  for (int s = 0; s < 2000; ++s) {
    std::array<double, D> u{};
    for (std::size_t k = 0; k < D; ++k) {
      const KnotVector& knots = a.knots()[k];
      u[k] = knots.from() + knots.length() * static_cast<double>(source() >> 11) * 0x1p-53;
    }
    largest = std::max(largest, (evaluate(a, u) - evaluate(b, u)).norm());
  }
  return largest;
}

template <int D>
void expectCertified(FairingMethod method) {
  const Spline<D> input = noisySpline<D>(11);
  const auto plan = planFor(input);
  CertifiedFairingOptions options;
  options.method = method;
  options.tolerance = 0.03;
  options.maxChangesPerPoint = 50;
  const auto result = fairCertified(input, plan, thinPlate<D>(), options);
  EXPECT_LT(result.summary.energyAfter, result.summary.energyBefore);
  EXPECT_LE(result.deviation.upper, options.tolerance * (1 + 1e-12));
  EXPECT_LE(result.deviation.lower, result.deviation.upper);
  EXPECT_LE(sampledDistance(input, result.spline), result.deviation.upper);
  EXPECT_LE(result.summary.largestMove, options.tolerance * (1 + 1e-12));
  EXPECT_EQ(result.heldMaxMove, 0);
  EXPECT_EQ(result.ballRadius, options.tolerance);
}

TEST(CertifiedFairing, KeepsTheToleranceForCurvesSurfacesAndVolumesWithEveryMethod) {
  for (const auto method : {FairingMethod::optimal, FairingMethod::local, FairingMethod::localLiteral}) {
    expectCertified<1>(method);
    expectCertified<2>(method);
    expectCertified<3>(method);
  }
}

TEST(CertifiedFairing, SurfaceToleranceIsReachedFromBelow) {
  const Surface input = noisySpline<2>(3);
  const auto plan = planFor(input);
  for (const double tolerance : {0.001, 0.005, 0.02}) {
    CertifiedFairingOptions options;
    options.tolerance = tolerance;
    const auto points = fairCertified(input, plan, thinPlate<2>(), options);
    options.toleranceKind = ToleranceKind::surface;
    const auto surface = fairCertified(input, plan, thinPlate<2>(), options);
    EXPECT_LE(surface.deviation.upper, tolerance);
    EXPECT_GE(surface.deviation.upper, 0.999 * tolerance);
    EXPECT_GT(surface.ballRadius, tolerance);
    EXPECT_LT(surface.summary.energyAfter, points.summary.energyAfter);
    EXPECT_GT(surface.summary.steps, points.summary.steps);  // of all solves
  }
}

TEST(CertifiedFairing, ASurfaceToleranceThatDoesNotBindIsNotSearchedFor) {
  const Surface input = noisySpline<2>(3);
  const auto plan = planFor(input);
  CertifiedFairingOptions options;
  options.tolerance = 100;
  options.toleranceKind = ToleranceKind::surface;
  const auto result = fairCertified(input, plan, thinPlate<2>(), options);
  EXPECT_EQ(result.ballRadius, 100);
  EXPECT_EQ(result.summary.activePoints, 0);
  EXPECT_LT(result.deviation.upper, 1);
}

TEST(CertifiedFairing, ACancelledRunKeepsItsPromises) {
  const Surface input = noisySpline<2>(8);
  const auto plan = planFor(input);
  for (const auto kind : {ToleranceKind::points, ToleranceKind::surface}) {
    for (const int allowed : {0, 1, 5, 40}) {
      int reports = 0;
      CertifiedFairingOptions options;
      options.tolerance = 0.01;
      options.toleranceKind = kind;
      options.gap = 1e-12;
      options.progress = Progress([&](double, std::string_view) { return ++reports <= allowed; });
      const auto result = fairCertified(input, plan, thinPlate<2>(), options);
      EXPECT_LE(result.summary.energyAfter, result.summary.energyBefore);
      EXPECT_LE(result.deviation.upper, 0.01 * (1 + 1e-12));
      EXPECT_TRUE(result.summary.stopReason == StopReason::cancelled || reports <= allowed);
    }
  }
}

TEST(CertifiedFairing, TheDeviationIsFromTheInputAlsoWhenKnotsWereInserted) {
  Surface input({KnotVector::uniformClamped(3, 3), KnotVector::uniformClamped(3, 3)}, Net::Zero(36, 3));
  std::mt19937_64 source(4);
  for (Index r = 0; r < 36; ++r) {
    input.net().row(r) << static_cast<double>(r / 6), static_cast<double>(r % 6),
        0.1 * static_cast<double>(source() >> 11) * 0x1p-53;
  }
  const auto plan = planFairing(input);
  ASSERT_GT(plan.knotsInserted, 0);
  CertifiedFairingOptions options;
  options.tolerance = 0.02;
  const auto result = fairCertified(input, plan, thinPlate<2>(), options);
  EXPECT_EQ(result.spline.knots(), plan.spline.knots());
  EXPECT_GT(result.deviation.upper, 0);
  EXPECT_LE(sampledDistance(input, result.spline), result.deviation.upper);
}

TEST(CertifiedFairing, RefusesPlansThatLeaveTheSplineAlone) {
  const Surface input = noisySpline<2>(1);
  auto plan = planFor(input);
  plan.leftAlone = "of a reason";
  EXPECT_THROW(fairCertified(input, plan, thinPlate<2>()), InvalidInput);
}

TEST(CertifiedFairing, NamesAreReadBack) {
  EXPECT_EQ(fairingMethodNamed("optimal"), FairingMethod::optimal);
  EXPECT_EQ(fairingMethodNamed("local"), FairingMethod::local);
  EXPECT_EQ(fairingMethodNamed("local-literal"), FairingMethod::localLiteral);
  EXPECT_THROW(fairingMethodNamed("Local"), InvalidInput);
  for (const auto kind : {ToleranceKind::points, ToleranceKind::surface}) {
    EXPECT_EQ(toleranceKindNamed(toleranceKindName(kind)), kind);
  }
  EXPECT_THROW(toleranceKindNamed(""), InvalidInput);
}

}  // namespace
}  // namespace strak
