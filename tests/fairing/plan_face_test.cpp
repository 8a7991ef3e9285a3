#include "strak/fairing/plan_face.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "strak/base/error.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/knot_insertion.h"

namespace strak {
namespace {

KnotVector uniform(int degree, Index size) { return KnotVector::uniformClamped(degree, size - degree); }

// A wavy patch over its Greville points.
Surface patch(KnotVector u, KnotVector v, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  const auto x = u.greville(), y = v.greville();
  Net net(u.size() * v.size(), 3);
  for (Index i = 0; i < u.size(); ++i) {
    for (Index j = 0; j < v.size(); ++j) {
      net.row(i * v.size() + j) << x[static_cast<std::size_t>(i)], y[static_cast<std::size_t>(j)], noise(random);
    }
  }
  return Surface({std::move(u), std::move(v)}, std::move(net));
}

bool isHeld(const FacePlan& plan, Index i, Index j) {
  return plan.held[static_cast<std::size_t>(plan.spline.row({i, j}))] != 0;
}

std::vector<Eigen::Vector2d> circle(double x, double y, double radius) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i <= 200; ++i) {
    const double angle = 2 * M_PI * i / 200;
    points.emplace_back(x + radius * std::cos(angle), y + radius * std::sin(angle));
  }
  return points;
}

std::vector<Eigen::Vector2d> segment(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i <= 200; ++i) points.emplace_back(a + (b - a) * i / 200.0);
  return points;
}

std::vector<std::vector<Eigen::Vector2d>> unitSquare() {
  return {segment({0, 0}, {1, 0}), segment({1, 0}, {1, 1}), segment({1, 1}, {0, 1}), segment({0, 1}, {0, 0})};
}

// The largest distance of points of the two surfaces at the same parameters of a fine grid.
double largestDifference(const Surface& a, const Surface& b) {
  double largest = 0;
  for (int i = 0; i <= 40; ++i) {
    for (int j = 0; j <= 40; ++j) {
      largest = std::max(largest, (evaluate<2>(a, {i / 40.0, j / 40.0}) - evaluate<2>(b, {i / 40.0, j / 40.0})).norm());
    }
  }
  return largest;
}

Surface moveFree(const FacePlan& plan, double by) {
  Surface moved = plan.spline;
  for (Index r = 0; r < moved.net().rows(); ++r) {
    if (!plan.held[static_cast<std::size_t>(r)]) moved.net().row(r).array() += by;
  }
  return moved;
}

TEST(PlanFace, HoldsTheStripsAskedForAndNothingElse) {
  const Surface surface = patch(uniform(3, 14), uniform(3, 16));
  PlanOptions options;
  options.rows = {1, 2, 3, 4};
  const FacePlan plan = planFairing<2>(surface, options);
  EXPECT_EQ(plan.spline, surface);
  EXPECT_EQ(plan.knotsInserted, 0);
  EXPECT_TRUE(plan.leftAlone.empty());
  EXPECT_EQ(plan.held, holdStrips<2>(surface, {1, 2, 3, 4}));
  EXPECT_EQ(plan.freePoints, (14 - 3) * (16 - 7));
}

TEST(PlanFace, InsertsJustEnoughKnotsInASmallNet) {
  const Surface surface = patch(uniform(5, 6), uniform(3, 12));
  const FacePlan plan = planFairing<2>(surface);
  EXPECT_EQ(plan.spline.size(0), 10);
  EXPECT_EQ(plan.spline.size(1), 12);
  EXPECT_EQ(plan.knotsInserted, 4);
  EXPECT_EQ(plan.freePoints, 4 * 6);
  EXPECT_LT(largestDifference(surface, plan.spline), 1e-14);
}

TEST(PlanFace, LeavesTheNetAloneWhenRefiningIsOff) {
  PlanOptions options;
  options.refine = false;
  const Surface surface = patch(uniform(3, 4), uniform(3, 4));
  const FacePlan plan = planFairing<2>(surface, options);
  EXPECT_EQ(plan.spline, surface);
  EXPECT_EQ(plan.freePoints, 0);
  EXPECT_FALSE(plan.leftAlone.empty());
}

TEST(PlanFace, CreasesAndTheirDerivativesStay) {
  // Degree 3, a triple knot (C0) at 0.5 in u: with 2 rows held position and first derivatives on both sides stay.
  const Surface surface = patch(KnotVector(3, {0, 0, 0, 0, .25, .5, .5, .5, .75, 1, 1, 1, 1}), uniform(3, 9));
  PlanOptions options;
  options.rows = {2, 2, 2, 2};
  const FacePlan plan = planFairing<2>(surface, options);
  ASSERT_TRUE(plan.leftAlone.empty());
  ASSERT_GT(plan.freePoints, 0);
  const Surface moved = moveFree(plan, 0.05);
  EXPECT_GT(largestDifference(surface, moved), 0.01);
  for (double v : {0.0, 0.3, 0.77}) {
    for (double u : {0.5, std::nextafter(0.5, 0.0)}) {
      EXPECT_LT((derivatives<2>(surface, {u, v}, 1) - derivatives<2>(moved, {u, v}, 1)).cwiseAbs().maxCoeff(), 1e-12);
    }
  }
  // Each half has a free row.
  Index low = 0, high = 0;
  for (Index i = 0; i < plan.spline.size(0); ++i) {
    if (isHeld(plan, i, 4)) continue;
    (plan.spline.knots(0).greville()[static_cast<std::size_t>(i)] < 0.5 ? low : high)++;
  }
  EXPECT_GT(low, 0);
  EXPECT_GT(high, 0);
}

TEST(PlanFace, ADoubleKnotOfDegreeThreeIsACreaseForThirdOrderEnergiesOnly) {
  const Surface surface = patch(KnotVector(3, {0, 0, 0, 0, .2, .4, .4, .6, .8, 1, 1, 1, 1}), uniform(3, 12));
  PlanOptions options;
  options.rows = {1, 1, 1, 1};
  EXPECT_EQ(planFairing<2>(surface, options).freePoints, 7 * 10);
  options.energyOrder = 3;
  options.refine = false;
  // Rows s - 3 = 3 and s - 2 = 4 (s = 6) carry the position at the double knot.
  EXPECT_EQ(planFairing<2>(surface, options).freePoints, 5 * 10);
}

TEST(PlanFace, ManyBezierPiecesGetRoomEach) {
  std::vector<double> knots(4, 0.0);
  for (int i = 1; i < 17; ++i) knots.insert(knots.end(), 3, i / 17.0);
  knots.insert(knots.end(), 4, 1.0);
  const Surface surface = patch(KnotVector(3, knots), uniform(3, 18));
  const FacePlan plan = planFairing<2>(surface);
  ASSERT_TRUE(plan.leftAlone.empty());
  EXPECT_EQ(plan.freePoints, 17 * 12);  // one row in each piece
  EXPECT_LT(largestDifference(surface, plan.spline), 1e-13);
}

TEST(PlanFace, SeamRowsAreHeldAlike) {
  Surface surface = patch(uniform(3, 12), uniform(3, 12));
  for (Index j = 0; j < 12; ++j) surface.net().row(surface.row({11, j})) = surface.net().row(surface.row({0, j}));
  PlanOptions options;
  options.rows = {0, 3, 1, 1};
  const FacePlan plan = planFairing<2>(surface, options);
  for (Index i = 0; i < 12; ++i) EXPECT_EQ(isHeld(plan, i, 6), i < 3 || i > 8) << i;
}

TEST(PlanFace, PolesAreHeldWithThreeRows) {
  Surface surface = patch(uniform(3, 12), uniform(3, 12));
  for (Index i = 0; i < 12; ++i) surface.net().row(surface.row({i, 0})) = surface.net().row(0);
  PlanOptions options;
  options.rows = {1, 1, 1, 1};
  const FacePlan plan = planFairing<2>(surface, options);
  for (Index j = 0; j < 12; ++j) EXPECT_EQ(isHeld(plan, 6, j), j < 3 || j == 11) << j;
}

TEST(PlanFace, UnclampedEndsKeepTheirPositionWithMoreRows) {
  std::vector<double> knots;
  for (int i = -3; i <= 15; ++i) knots.push_back(i / 12.0);
  const Surface surface = patch(KnotVector(3, knots), uniform(3, 12));
  PlanOptions options;
  options.rows = {1, 1, 1, 1};
  const FacePlan plan = planFairing<2>(surface, options);
  const Surface moved = moveFree(plan, 0.05);
  EXPECT_GT(largestDifference(surface, moved), 0.01);
  for (double v : {0.1, 0.5}) {
    for (double u : {0.0, 1.0}) {
      EXPECT_LT((evaluate<2>(surface, {u, v}) - evaluate<2>(moved, {u, v})).norm(), 1e-14);
    }
  }
}

TEST(PlanFace, TheSurfaceAroundAHoleStaysToAllDerivatives) {
  const Surface surface = patch(uniform(3, 23), uniform(3, 23));
  FaceBorder border{unitSquare(), {true, true, true, true}};
  border.trims.push_back(circle(0.47, 0.52, 0.13));
  const FacePlan plan = planFace(surface, border);
  ASSERT_TRUE(plan.leftAlone.empty());
  EXPECT_EQ(plan.knotsInserted, 0);
  const Surface moved = moveFree(plan, 0.05);
  EXPECT_GT(largestDifference(surface, moved), 0.01);
  for (const auto& line : border.trims) {
    for (const auto& point : line) {
      EXPECT_LT((derivatives<2>(surface, {point.x(), point.y()}, 2) - derivatives<2>(moved, {point.x(), point.y()}, 2))
                    .cwiseAbs()
                    .maxCoeff(),
                1e-10);
    }
  }
  // Nothing inside the hole is free either.
  EXPECT_EQ(evaluate<2>(surface, {0.47, 0.52}), evaluate<2>(moved, {0.47, 0.52}));
}

TEST(PlanFace, ATriangularFaceOfOnePolynomialPieceIsRefinedUntilThereIsRoom) {
  const Surface surface = patch(uniform(3, 4), uniform(3, 4));
  const std::vector<Eigen::Vector2d> corners{{0.1, 0.1}, {0.9, 0.2}, {0.4, 0.95}};
  FaceBorder border{{segment(corners[0], corners[1]), segment(corners[1], corners[2]), segment(corners[2], corners[0])},
                    {false, false, false, false}};
  const FacePlan plan = planFace(surface, border);
  ASSERT_TRUE(plan.leftAlone.empty()) << plan.leftAlone;
  EXPECT_GE(plan.freePoints, 4);
  EXPECT_LE(plan.spline.net().rows(), 4096);
  const Surface moved = moveFree(plan, 0.05);
  for (const auto& line : border.trims) {
    for (const auto& point : line) {
      EXPECT_LT((evaluate<2>(surface, {point.x(), point.y()}) - evaluate<2>(moved, {point.x(), point.y()})).norm(),
                1e-13);
    }
  }
  // Corners of the domain are cut away: nothing moves there.
  for (double u : {0.0, 1.0}) EXPECT_EQ(evaluate<2>(moved, {u, 1.0}), evaluate<2>(plan.spline, {u, 1.0}));
}

TEST(PlanFace, SidesThatAreEdgesInPartKeepStrips) {
  const Surface surface = patch(uniform(3, 13), uniform(3, 13));
  // The face ends at u = 0.72: two of its sides are edges in part, and the side u high is none.
  FaceBorder border{
      {segment({0, 0}, {.72, 0}), segment({.72, 0}, {.72, 1}), segment({.72, 1}, {0, 1}), segment({0, 1}, {0, 0})},
      {true, false, false, false}};
  const FacePlan plan = planFace(surface, border);
  for (Index i = 0; i < 13; ++i) {
    for (Index j = 0; j < 13; ++j) {
      // Spans of length 0.1: 0.72 lies in span 7 (rows 7..10); those above it are cut away.
      EXPECT_EQ(isHeld(plan, i, j), i < 3 || i >= 7 || j < 3 || j >= 10) << i << ' ' << j;
    }
  }
}

TEST(PlanFace, EdgesThatStrayFromTheirSideGetMoreRows) {
  const Surface surface = patch(uniform(5, 15), uniform(3, 13));
  FaceBorder border{unitSquare(), {true, true, true, true}};
  for (auto& point : border.trims[3]) point.x() = 8e-5;  // of the side u = 0, 8e-4 of its span
  PlanOptions options;
  options.rows = {1, 1, 1, 1};
  const FacePlan plan = planFace(surface, border, options);
  for (Index i = 0; i < 15; ++i) EXPECT_EQ(isHeld(plan, i, 6), i < 4 || i == 14) << i;
  const Surface moved = moveFree(plan, 0.05);
  EXPECT_LT((evaluate<2>(surface, {8e-5, 0.4}) - evaluate<2>(moved, {8e-5, 0.4})).norm(), 1e-9 * 0.05);
}

TEST(PlanFace, SaysWhyNothingCanBeDone) {
  PlanOptions options;
  const Surface flat = patch(uniform(1, 5), uniform(3, 9));
  EXPECT_NE(planFairing<2>(flat).leftAlone.find("degree 1 in direction u"), std::string::npos);
  const Surface point({uniform(3, 5), uniform(3, 5)}, Net::Constant(25, 3, 2.5));
  EXPECT_NE(planFairing<2>(point).leftAlone.find("one point"), std::string::npos);
  const Surface rational({uniform(3, 5), uniform(3, 5)}, Net::Constant(25, 4, 1.0), true);
  EXPECT_NE(planFairing<2>(rational).leftAlone.find("rational"), std::string::npos);
  options.rational = true;
  EXPECT_NE(planFairing<2>(rational, options).leftAlone.find("one point"), std::string::npos);
  options.rows = {200, 200, 3, 3};
  options.maxGrowth = 1;
  EXPECT_NE(planFairing<2>(patch(uniform(3, 70), uniform(3, 70)), options).leftAlone.find("hold fewer rows"),
            std::string::npos);
  options.rows = {-1, 0, 0, 0};
  EXPECT_THROW(planFairing<2>(patch(uniform(3, 9), uniform(3, 9)), options), InvalidInput);
}

TEST(PlanFace, WeightsChangeNothingButTheRefinedNet) {
  const Surface plain = patch(uniform(3, 6), uniform(4, 7));
  Net net(plain.net().rows(), 4);
  for (Index r = 0; r < net.rows(); ++r) {
    const double w = 1 + 0.3 * static_cast<double>(r % 5);
    net.row(r) << w * plain.net().row(r), w;
  }
  const Surface rational(plain.knots(), net, true);
  PlanOptions options;
  options.rational = true;
  const FacePlan plan = planFairing<2>(rational, options);
  const FacePlan same = planFairing<2>(plain, options);
  ASSERT_EQ(plan.leftAlone, "");
  EXPECT_GT(plan.knotsInserted, 0);
  EXPECT_EQ(plan.held, same.held);
  EXPECT_EQ(plan.spline.knots(), same.spline.knots());
  for (double u : {0.01, 0.37, 0.99}) {
    EXPECT_LT((evaluate<2>(plan.spline, {u, 0.4}) - evaluate<2>(rational, {u, 0.4})).norm(), 1e-14);
  }
}

// Poles and seams are found by points, not by points times weights.
TEST(PlanFace, RationalPolesAndSeamsAreFound) {
  const KnotVector u = uniform(2, 9), v = uniform(3, 9);
  Net net(81, 4);
  for (Index i = 0; i < 9; ++i) {
    for (Index j = 0; j < 9; ++j) {
      const double radius = std::sin(0.3 * static_cast<double>(i));
      const double angle = 2 * 3.14159265358979 * static_cast<double>(j % 8) / 8;
      const double w = j % 2 == 0 ? 1 : 0.7;
      net.row(i * 9 + j) << w * radius * std::cos(angle), w * radius * std::sin(angle), w * static_cast<double>(i), w;
    }
  }
  PlanOptions options;
  options.rational = true;
  const FacePlan plan = planFairing<2>(Surface({u, v}, net, true), options);
  std::string notes;
  for (const auto& note : plan.notes) notes += note;
  EXPECT_NE(notes.find("Closed in direction v"), std::string::npos) << notes;
  EXPECT_NE(notes.find("low side of direction u is shrunk to one point"), std::string::npos) << notes;
}

TEST(PlanFace, RuledSurfacesMoveAlongTheirBorders) {
  PlanOptions options;
  options.rational = true;
  EXPECT_NE(planFairing<2>(patch(uniform(1, 2), uniform(3, 12)), options).leftAlone, "") << "both rows are held";
  options.rows = {0, 1, 2, 2};
  const FacePlan ruled = planFairing<2>(patch(uniform(1, 2), uniform(3, 6)), options);
  EXPECT_EQ(ruled.leftAlone, "");
  EXPECT_EQ(ruled.spline.size(0), 2) << "a knot there would be a crease";
  EXPECT_EQ(ruled.spline.size(1), 8);
  EXPECT_EQ(ruled.freePoints, 4) << "of one border, between two rows at its ends";
  // Inner lines of a straight direction are creases: they stay.
  options.rows = {0, 0, 2, 2};
  const FacePlan bent = planFairing<2>(patch(uniform(1, 3), uniform(3, 8)), options);
  EXPECT_EQ(bent.freePoints, 2 * 4);
  for (Index j = 0; j < 8; ++j) EXPECT_TRUE(bent.held[static_cast<std::size_t>(bent.spline.row({1, j}))]);
  options.rows = {1, 1, 2, 2};
  EXPECT_NE(planFairing<2>(patch(uniform(1, 3), uniform(3, 8)), options).leftAlone.find("no room"), std::string::npos);
  options.rational = false;
  options.rows = {0, 0, 2, 2};
  EXPECT_NE(planFairing<2>(patch(uniform(1, 2), uniform(3, 8)), options).leftAlone.find("raise the degree"),
            std::string::npos);
}

TEST(PlanFace, CurvesAndVolumes) {
  const KnotVector knots = uniform(3, 6);
  Net net = Net::Random(6, 2);
  const FairingPlan<1> curve = planFairing<1>(Curve({knots}, net));
  EXPECT_EQ(curve.spline.size(0), 10);
  EXPECT_EQ(curve.freePoints, 4);
  Net block = Net::Random(6 * 8 * 12, 3);
  FairingPlanOptions<3> options;
  options.rows = {1, 1, 2, 2, 3, 3};
  const FairingPlan<3> volume = planFairing<3>(Volume({uniform(3, 6), uniform(3, 8), uniform(2, 12)}, block), options);
  EXPECT_EQ(volume.freePoints, 4 * 4 * 6);
}

TEST(PlanFace, InsertionDoesNotDependOnTheScaleOfTheKnots) {
  const Surface surface = patch(uniform(4, 5), uniform(3, 6));
  const Surface scaled({surface.knots(0).rescaled(-3, 1e-3), surface.knots(1).rescaled(5, 1e4)}, surface.net());
  const FacePlan a = planFairing<2>(surface);
  const FacePlan b = planFairing<2>(scaled);
  ASSERT_EQ(a.spline.sizes(), b.spline.sizes());
  EXPECT_EQ(a.held, b.held);
  EXPECT_LT((a.spline.net() - b.spline.net()).cwiseAbs().maxCoeff(), 1e-10);
}

}  // namespace
}  // namespace strak
