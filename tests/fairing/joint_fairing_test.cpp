#include "strak/fairing/joint_fairing.h"

#include <gtest/gtest.h>

#include "strak/metrology/deviation.h"
#include "strak/spline/bezier.h"
#include "strak/spline/knot_insertion.h"
#include "tests/energy/shape_surfaces.h"

namespace strak {
namespace {

using testing::bentSheet;

// The sheet cut at u = 0.5: two faces with a common border, each with its own noise away from the outer borders.
std::vector<PartFace> twoFaces(double noise, bool kink) {
  const Surface whole = bentSheet(3, 3, 8, 6);
  const Surface split = insertKnots(whole, 0, {0.5, 0.5, 0.5});
  const KnotVector &u = split.knots(0), &v = split.knots(1);
  const Index rows = (u.size() - 1) / 2 + 1;
  std::vector<double> low(u.knots().begin(), u.knots().begin() + rows + 4);
  low[static_cast<std::size_t>(rows) + 3] = 0.5;
  std::vector<double> high(u.knots().end() - rows - 4, u.knots().end());
  high.front() = 0.5;
  std::vector<Surface> halves{{{KnotVector(3, low), v}, split.net().topRows(rows * v.size())},
                              {{KnotVector(3, high), v}, split.net().bottomRows(rows * v.size())}};
  std::mt19937 engine(4);
  const auto number = [&] { return noise * (2 * static_cast<double>(engine()) / 4294967296.0 - 1); };
  for (Surface& half : halves) {
    for (Index i = 1; i + 1 < half.size(0); ++i) {
      for (Index j = 2; j + 2 < half.size(1); ++j) half.net()(half.row({i, j}), 2) += number();
    }
  }
  if (kink) {
    for (Index j = 2; j + 2 < v.size(); ++j) halves[1].net()(halves[1].row({1, j}), 2) += 0.001;
  }
  return {{halves[0], {}}, {halves[1], {}}};
}

const std::vector<SidePair> kPair{{0, 1, 1, 0}};

PlanOptions heldOutside() {
  PlanOptions options;
  options.rows = PlanOptions::allRows(2);
  options.minFree = 1;
  return options;
}

TEST(PlanPart, BorderPointsAreOneUnknown) {
  const auto faces = twoFaces(0.001, false);
  const PartPlan plan = planPart(faces, kPair, heldOutside());
  ASSERT_EQ(plan.joints.size(), 1U);
  const auto a = borderRow(plan.surfaces[0], 1), b = borderRow(plan.surfaces[1], 0);
  Index free = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const int u = plan.unknownOf[0][static_cast<std::size_t>(a[k])];
    EXPECT_EQ(u, plan.unknownOf[1][static_cast<std::size_t>(b[k])]);
    free += u >= 0;
  }
  EXPECT_EQ(free, static_cast<Index>(a.size()) - 4) << "the two strips at the ends are held";
}

TEST(PlanPart, AFeatureEdgeStays) {
  auto faces = twoFaces(0, false);
  Surface& second = faces[1].surface;
  // Turned down by 45 degrees about the border.
  for (Index i = 1; i < second.size(0); ++i) {
    for (Index j = 0; j < second.size(1); ++j) second.net()(second.row({i, j}), 2) -= 0.2 * static_cast<double>(i);
  }
  const PartPlan plan = planPart(faces, kPair, heldOutside());
  EXPECT_TRUE(plan.joints.empty());
  for (Index row : borderRow(plan.surfaces[0], 1)) EXPECT_EQ(plan.unknownOf[0][static_cast<std::size_t>(row)], -1);
}

TEST(PlanPart, KnotsArePassedOn) {
  auto faces = twoFaces(0.001, false);
  faces[1].surface = insertKnots(faces[1].surface, 1, {0.21, 1.3});
  const PartPlan plan = planPart(faces, kPair, heldOutside());
  ASSERT_EQ(plan.joints.size(), 1U);
  EXPECT_EQ(plan.surfaces[0].size(1), plan.surfaces[1].size(1));
  EXPECT_LT(certifyDeviation(faces[0].surface, plan.surfaces[0]).upper, 1e-12);
}

TEST(JointFairing, TheKinkGoesAndTheBordersMoveAlike) {
  const auto faces = twoFaces(0.002, true);
  const PartPlan plan = planPart(faces, kPair, heldOutside());
  const JointFairing result = fairJointly(plan, {.tolerance = 0.01});
  ASSERT_EQ(result.joinsAfter.size(), 1U);
  EXPECT_LT(result.joinsAfter[0].angle, 0.2 * result.joinsBefore[0].angle);
  EXPECT_LT(result.joinsAfter[0].jump, 0.5 * result.joinsBefore[0].jump);
  for (std::size_t f = 0; f < 2; ++f) {
    EXPECT_LE(result.after[f].plate, result.before[f].plate);
    EXPECT_LE(result.after[f].curvatureVariation, result.before[f].curvatureVariation);
    EXPECT_LT(result.after[f].isophoteRoughness, 0.2 * result.before[f].isophoteRoughness);
    EXPECT_LE(certifyDeviation(faces[f].surface, result.surfaces[f]).upper, 0.01 * (1 + 1e-9));
  }
  const auto a = borderRow(result.surfaces[0], 1), b = borderRow(result.surfaces[1], 0);
  double moved = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_LT((result.surfaces[0].net().row(a[k]) - result.surfaces[1].net().row(b[k])).norm(), 1e-14);
    moved = std::max(moved, (result.surfaces[0].net().row(a[k]) - plan.surfaces[0].net().row(a[k])).norm());
  }
  EXPECT_GT(moved, 1e-5);
}

TEST(JointFairing, NoToleranceNoMove) {
  const PartPlan plan = planPart(twoFaces(0.002, true), kPair, heldOutside());
  const JointFairing result = fairJointly(plan, {.tolerance = 0});
  EXPECT_EQ(result.summary.largestMove, 0);
}

}  // namespace
}  // namespace strak
