#include "strak/fairing/joint_fairing.h"

#include <gtest/gtest.h>

#include <numbers>

#include "strak/metrology/deviation.h"
#include "strak/spline/bezier.h"
#include "strak/spline/knot_insertion.h"
#include "strak/spline/periodic.h"
#include "strak/spline/reparametrize.h"
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

// Noise on the control points that are not in the given numbers of rows at the sides.
void addNoise(Surface& surface, double noise, const std::array<Index, 4>& rows, std::mt19937& engine) {
  for (Index i = rows[0]; i < surface.size(0) - rows[1]; ++i) {
    for (Index j = rows[2]; j < surface.size(1) - rows[3]; ++j) {
      const Index row = surface.row({i, j});
      const double w = surface.isRational() ? surface.net()(row, 3) : 1;
      surface.net()(row, 2) += noise * w * (2 * static_cast<double>(engine()) / 4294967296.0 - 1);
    }
  }
}

// A sheet cut along u = 0.5, its right half once more at v = 0.7: the long side 1 of the first face meets the short
// sides 0 of the others. Every face has noise of its own behind the borders, and all of them the same on these.
std::vector<PartFace> threeFaces(bool rational, bool turned) {
  std::mt19937 engine(11);
  Surface sheet = bentSheet(3, 3, 8, 10);
  if (rational) {
    // Weights as smooth as the sheet.
    Net net(sheet.net().rows(), 4);
    for (Index r = 0; r < net.rows(); ++r) {
      const double w = 1 + 0.1 * sheet.net()(r, 0) + 0.05 * sheet.net()(r, 1);
      net.row(r) << w * sheet.net().row(r), w;
    }
    sheet = Surface(sheet.knots(), net, true);
  }
  addNoise(sheet, 0.001, {2, 2, 2, 2}, engine);
  const Surface right = subPatch(sheet, 0, 0.5, 1);
  std::vector<Surface> patches{subPatch(sheet, 0, 0, 0.5), subPatch(right, 1, 0, 0.7),
                               withDomain(subPatch(right, 1, 0.7, 2), 1, -3, 5)};
  addNoise(patches[0], 0.001, {2, 1, 2, 2}, engine);
  addNoise(patches[1], 0.001, {1, 2, 2, 1}, engine);
  addNoise(patches[2], 0.001, {1, 2, 1, 2}, engine);
  if (turned) patches[1] = reversed(patches[1], 1);
  return {{patches[0], {}}, {patches[1], {}}, {patches[2], {}}};
}

std::vector<SidePair> threePairs(bool turned) {
  return {{0, 1, 1, 0, SidePart{0, 0.7}}, {0, 2, 1, 0, SidePart{0.7, 2}}, {1, 2, turned ? 2 : 3, 2}};
}

double gapOf(const std::vector<Surface>& surfaces, const std::vector<SidePair>& pairs) {
  double gap = 0;
  for (const Joint& joint : measureJoints(surfaces, pairs)) gap = std::max(gap, joint.gapMax);
  return gap;
}

TEST(JointFairing, AShortSideFollowsTheLongOneItLiesOn) {
  for (const bool rational : {false, true}) {
    const auto faces = threeFaces(rational, rational);
    const auto pairs = threePairs(rational);
    PlanOptions planOptions = heldOutside();
    planOptions.rational = true;
    const PartPlan plan = planPart(faces, pairs, planOptions);
    ASSERT_EQ(plan.joints.size(), 3U);
    ASSERT_TRUE(plan.tied);
    EXPECT_LT(gapOf(plan.surfaces, pairs), 1e-14);
    const JointFairing result = fairJointly(plan, {.tolerance = 0.005});
    EXPECT_LT(gapOf(result.surfaces, pairs), 1e-14);
    double moved = 0;
    for (Index row : borderRow(result.surfaces[1], 0)) {
      moved = std::max(moved, (result.surfaces[1].euclideanNet() - plan.surfaces[1].euclideanNet()).row(row).norm());
    }
    EXPECT_GT(moved, 1e-5);
    for (std::size_t j = 0; j < 3; ++j) {
      EXPECT_LT(result.joinsAfter[j].meanAngle, 0.3 * result.joinsBefore[j].meanAngle) << j;
      EXPECT_LT(result.joinsAfter[j].meanJump, 0.5 * result.joinsBefore[j].meanJump) << j;
    }
    for (std::size_t f = 0; f < 3; ++f) {
      EXPECT_LE(result.after[f].plate, result.before[f].plate);
      EXPECT_LE(result.after[f].curvatureVariation, result.before[f].curvatureVariation);
      EXPECT_LT(result.after[f].isophoteRoughness, 0.5 * result.before[f].isophoteRoughness);
      EXPECT_LE(certifyDeviation(faces[f].surface, result.surfaces[f]).upper, 0.005 * (1 + 1e-9));
    }
  }
}

TEST(PlanPart, WhatNoPartCoversIsHeld) {
  const auto faces = threeFaces(false, false);
  PlanOptions options = heldOutside();
  options.refine = false;
  const PartPlan plan = planPart(faces, {threePairs(false)[0]}, options);
  ASSERT_EQ(plan.joints.size(), 1U);
  const Surface& first = plan.surfaces[0];
  const KnotVector& v = first.knots(1);
  for (Index depth = 0; depth < 2; ++depth) {
    const auto rows = borderRow(first, 1, depth);
    Index free = 0;
    for (Index j = 0; j < v.size(); ++j) {
      const int u = plan.unknownOf[0][static_cast<std::size_t>(rows[static_cast<std::size_t>(j)])];
      if (v[j + 4] > 0.7) {
        EXPECT_EQ(u, -1) << "it moves the border beyond the part";
      }
      free += u >= 0;
    }
    EXPECT_GT(free + depth, 0);
  }
  EXPECT_LT(gapOf(fairJointly(plan, {.tolerance = 0.005}).surfaces, {threePairs(false)[0]}), 1e-14);
}

TEST(PlanPart, TellsWhichFacesMoveTogether) {
  std::vector<PartFace> faces = twoFaces(0.001, false);
  for (const PartFace& face : twoFaces(0.001, false)) {
    faces.push_back(face);
    faces.back().surface.net().col(0).array() += 5;
  }
  faces.push_back({bentSheet(3, 3, 8, 6), {}});
  faces.back().surface.net().col(0).array() += 10;
  const PartPlan plan = planPart(faces, {{0, 1, 1, 0}, {2, 3, 1, 0}}, heldOutside());
  EXPECT_EQ(facesThatMoveTogether(plan), (std::vector<std::vector<Index>>{{0, 1}, {2, 3}}));
  const PartPlan three = planPart(threeFaces(false, false), threePairs(false), heldOutside());
  EXPECT_EQ(facesThatMoveTogether(three), (std::vector<std::vector<Index>>{{0, 1, 2}}));
}

// Four faces round a fifth one, each with a corner on the side of the next: whatever is followed leads back to the
// start.
TEST(PlanPart, ARingOfPartsHoldsTogether) {
  const Surface sheet = bentSheet(3, 3, 3, 3, 0.0005, 3);
  const Surface whole = withDomain(withDomain(sheet, 0, 0, 3), 1, 0, 3);
  const auto piece = [&](double u0, double u1, double v0, double v1) {
    return subPatch(subPatch(whole, 0, u0, u1), 1, v0, v1);
  };
  std::vector<PartFace> faces;
  for (const Surface& patch :
       {piece(0, 2, 0, 1), piece(2, 3, 0, 2), piece(1, 3, 2, 3), piece(0, 1, 1, 3), piece(1, 2, 1, 2)}) {
    faces.push_back({patch, {}});
  }
  const std::vector<SidePair> pairs{{1, 0, 0, 1, SidePart{0, 1}}, {2, 1, 2, 3, SidePart{2, 3}},
                                    {3, 2, 1, 0, SidePart{2, 3}}, {0, 3, 3, 2, SidePart{0, 1}},
                                    {0, 4, 3, 2, SidePart{1, 2}}, {1, 4, 0, 1, SidePart{1, 2}},
                                    {2, 4, 2, 3, SidePart{1, 2}}, {3, 4, 1, 0, SidePart{1, 2}}};
  PlanOptions options = heldOutside();
  options.rows = PlanOptions::allRows(1);
  const PartPlan plan = planPart(faces, pairs, options);
  ASSERT_EQ(plan.joints.size(), pairs.size());
  ASSERT_TRUE(plan.tied);
  // Any move of the unknowns leaves the borders together.
  std::vector<Surface> moved = plan.surfaces;
  const Eigen::VectorXd y = Eigen::VectorXd::Random(3 * plan.unknowns);
  double inside = 0;
  for (std::size_t f = 0; f < moved.size(); ++f) {
    for (std::size_t r = 0; r < plan.unknownOf[f].size(); ++r) {
      if (plan.unknownOf[f][r] < 0) continue;
      const Eigen::Vector3d step = plan.tied->at(plan.unknownOf[f][r], y);
      moved[f].net().row(static_cast<Index>(r)) += step.transpose();
      if (f == 4) inside = std::max(inside, step.norm());
    }
  }
  EXPECT_LT(gapOf(moved, pairs), 1e-8);
  EXPECT_GT(inside, 0.01);
  EXPECT_GT(gapOf({moved[0], plan.surfaces[1]}, {pairs[0]}), 1e-3);
}

// Half of a dish, even in x to start with, with noise: the border at x = 0 in the plane.
TEST(JointFairing, ABorderMovesInItsPlaneOfSymmetry) {
  Surface half = bentSheet(3, 3, 6, 6);
  std::mt19937 engine(5);
  const auto number = [&] { return 2 * static_cast<double>(engine()) / 4294967296.0 - 1; };
  const auto g = half.knots(0).greville(), h = half.knots(1).greville();
  for (Index i = 0; i < half.size(0); ++i) {
    for (Index j = 0; j < half.size(1); ++j) {
      const double x = i == 1 ? 0 : g[static_cast<std::size_t>(i)], y = h[static_cast<std::size_t>(j)];
      half.net().row(half.row({i, j})) << g[static_cast<std::size_t>(i)], y, 0.3 * std::cos(1.5 * x) + 0.1 * y * y;
      const bool inside = i + 2 < half.size(0) && j > 1 && j + 2 < half.size(1);
      if (inside) half.net()(half.row({i, j}), 2) += 0.001 * number();
    }
  }
  const auto plane = symmetryPlane(half, 0, {.planarity = 1e-6, .angle = 3, .normal = Eigen::Vector3d::UnitX()});
  ASSERT_TRUE(plane);
  PartFace face{half, {}};
  face.mirror[0] = plane;
  const PartPlan plan = planPart({face}, {}, heldOutside());
  ASSERT_EQ(plan.mirrors.size(), 1U);
  const JointFairing result = fairJointly(plan, {.tolerance = 0.005});
  double moved = 0;
  for (Index row : borderRow(result.surfaces[0], 0)) {
    EXPECT_EQ(result.surfaces[0].net()(row, 0), plan.surfaces[0].net()(row, 0));
    moved = std::max(moved, (result.surfaces[0].net() - plan.surfaces[0].net()).row(row).norm());
  }
  EXPECT_GT(moved, 1e-4);
  ASSERT_EQ(result.joinsAfter.size(), 1U);
  EXPECT_GT(result.joinsBefore[0].meanAngle, 1e-3);
  EXPECT_LT(result.joinsAfter[0].meanAngle, 0.1 * result.joinsBefore[0].meanAngle);
  EXPECT_LT(result.after[0].isophoteRoughness, 0.25 * result.before[0].isophoteRoughness);
  EXPECT_LE(result.after[0].plate, result.before[0].plate);
  EXPECT_LE(certifyDeviation(half, result.surfaces[0]).upper, 0.005 * (1 + 1e-9));
}

// The same, perpendicular to the plane to begin with: so it is at the end.
TEST(JointFairing, WhatIsPerpendicularToItsPlaneOfSymmetryStaysSo) {
  Surface half = bentSheet(3, 3, 6, 6);
  std::mt19937 engine(5);
  for (Index j = 0; j < half.size(1); ++j) half.net()(half.row({0, j}), 0) = 0;
  addNoise(half, 0.001, {0, 2, 2, 2}, engine);
  for (Index j = 0; j < half.size(1); ++j) {
    half.net().row(half.row({1, j})) = half.net().row(half.row({0, j})) + 0.05 * Eigen::RowVector3d::UnitX();
  }
  PartFace face{half, {}};
  face.mirror[0] = symmetryPlane(half, 0);
  ASSERT_TRUE(face.mirror[0]);
  const PartPlan plan = planPart({face}, {}, heldOutside());
  const JointFairing result = fairJointly(plan, {.tolerance = 0.005});
  EXPECT_LT(result.joinsAfter[0].angle, 1e-14);
  EXPECT_LT(result.after[0].isophoteRoughness, 0.5 * result.before[0].isophoteRoughness);
  double moved = 0, across = 0;
  for (Index j = 0; j < half.size(1); ++j) {
    const Eigen::RowVector3d border = (result.surfaces[0].net() - plan.surfaces[0].net()).row(half.row({0, j}));
    const Eigen::RowVector3d behind = (result.surfaces[0].net() - plan.surfaces[0].net()).row(half.row({1, j}));
    EXPECT_LT((behind - border).tail(2).norm(), 1e-15);
    moved = std::max(moved, border.norm());
    across = std::max(across, std::abs(behind[0]));
  }
  EXPECT_GT(moved, 1e-5);
  EXPECT_GT(across, 1e-6);
}

// A quarter in two faces: a join runs into one plane of symmetry, and the corner where both planes meet stays in both.
TEST(JointFairing, PlanesOfSymmetryMeetJoinsAndOneAnother) {
  Surface quarter = bentSheet(3, 3, 6, 8);
  std::mt19937 engine(9);
  const auto g = quarter.knots(0).greville(), h = quarter.knots(1).greville();
  for (Index i = 0; i < quarter.size(0); ++i) {
    for (Index j = 0; j < quarter.size(1); ++j) {
      const double x = i == 1 ? 0 : g[static_cast<std::size_t>(i)], y = j == 1 ? 0 : h[static_cast<std::size_t>(j)];
      quarter.net().row(quarter.row({i, j})) << g[static_cast<std::size_t>(i)], h[static_cast<std::size_t>(j)],
          0.3 * std::cos(1.5 * x) * std::cos(0.7 * y);
    }
  }
  std::vector<PartFace> faces{{subPatch(quarter, 1, 0, 1), {}}, {subPatch(quarter, 1, 1, 2), {}}};
  addNoise(faces[0].surface, 0.001, {2, 2, 2, 1}, engine);
  addNoise(faces[1].surface, 0.001, {2, 2, 1, 2}, engine);
  for (PartFace& face : faces) face.mirror[0] = symmetryPlane(face.surface, 0);
  faces[0].mirror[2] = symmetryPlane(faces[0].surface, 2);
  ASSERT_TRUE(faces[0].mirror[0] && faces[1].mirror[0] && faces[0].mirror[2]);
  const PartPlan plan = planPart(faces, {{0, 1, 3, 2}}, heldOutside());
  ASSERT_EQ(plan.mirrors.size(), 3U);
  const JointFairing result = fairJointly(plan, {.tolerance = 0.005});
  EXPECT_GT(result.summary.largestMove, 1e-3);
  EXPECT_LT(gapOf(result.surfaces, {{0, 1, 3, 2}}), 1e-14);
  for (std::size_t f = 0; f < 2; ++f) {
    for (Index row : borderRow(result.surfaces[f], 0)) EXPECT_NEAR(result.surfaces[f].net()(row, 0), 0, 1e-15);
    EXPECT_LT(result.after[f].isophoteRoughness, 0.5 * result.before[f].isophoteRoughness);
  }
  for (Index row : borderRow(result.surfaces[0], 2)) EXPECT_NEAR(result.surfaces[0].net()(row, 1), 0, 1e-15);
  const Index corner = result.surfaces[0].row({0, 0});
  EXPECT_NE(result.surfaces[0].net()(corner, 2), plan.surfaces[0].net()(corner, 2));
  EXPECT_LT(result.joinsAfter[0].meanAngle, 0.2 * result.joinsBefore[0].meanAngle);
  for (std::size_t m : {1U, 2U, 3U}) EXPECT_LE(result.joinsAfter[m].meanAngle, 1e-5) << "by its energy at the corner";
}

TEST(JointFairing, ATorusMovesAcrossBothSeams) {
  const Index n = 9, m = 8;
  std::mt19937 engine(5);
  Net net((n + 3) * (m + 3), 3);
  for (Index i = 0; i < n + 3; ++i) {
    for (Index j = 0; j < m + 3; ++j) {
      const double s = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
      const double t = 2 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(m);
      const double r = 1 + 0.01 * (2 * static_cast<double>(engine()) / 4294967296.0 - 1);
      net.row(i * (m + 3) + j) << (3 + r * std::cos(t)) * std::cos(s), (3 + r * std::cos(t)) * std::sin(s),
          r * std::sin(t);
      if (i >= n || j >= m) net.row(i * (m + 3) + j) = net.row(i % n * (m + 3) + j % m);
    }
  }
  const auto knots = [](Index count) {
    std::vector<double> values;
    for (Index i = 0; i < count; ++i) values.push_back(static_cast<double>(i));
    return KnotVector(3, values);
  };
  const Surface torus = toClamped(toClamped(Surface({knots(n + 7), knots(m + 7)}, net), 0), 1);
  const PartPlan plan = planPart({{torus, {}}}, {{0, 0, 0, 1}, {0, 0, 2, 3}}, heldOutside());
  EXPECT_EQ(plan.unknowns, n * m) << "as many as a period has points";
  const JointFairing result = fairJointly(plan, {.tolerance = 0.03});
  EXPECT_EQ(seamSmoothness(result.surfaces[0], 0, 1e-12), 2);
  EXPECT_EQ(seamSmoothness(result.surfaces[0], 1, 1e-12), 2);
  EXPECT_LT(result.after[0].isophoteRoughness, 0.9 * result.before[0].isophoteRoughness);
}

// A tube whose two sides in u meet, smooth to second order, with noise between its ends.
Surface tubeWith(double noise) {
  const Index n = 16, m = 7;
  const KnotVector v = KnotVector::uniformClamped(3, m - 3);
  std::mt19937 engine(5);
  const auto number = [&] { return 2 * static_cast<double>(engine()) / 4294967296.0 - 1; };
  Net net((n + 3) * m, 3);
  for (Index i = 0; i < n + 3; ++i) {
    const double t = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
    for (Index j = 0; j < m; ++j) {
      const bool inside = j > 1 && j + 2 < m;
      const double r = 1 + (inside ? noise * number() : 0);
      net.row(i * m + j) << r * std::cos(t), r * std::sin(t), static_cast<double>(j);
      if (i >= n) net.row(i * m + j) = net.row((i - n) * m + j);
    }
  }
  std::vector<double> knots;
  for (Index i = 0; i < n + 7; ++i) knots.push_back(static_cast<double>(i));
  return toClamped(Surface({KnotVector(3, knots), v}, net), 0);
}

TEST(JointFairing, AClosedFaceMovesAcrossItsSeam) {
  const Surface tube = tubeWith(0.005);
  const PartPlan plan = planPart({{tube, {}}}, {{0, 0, 0, 1}}, heldOutside());
  ASSERT_EQ(plan.joints.size(), 1U);
  const JointFairing result = fairJointly(plan, {.tolerance = 0.02});
  const auto low = borderRow(result.surfaces[0], 0), high = borderRow(result.surfaces[0], 1);
  double moved = 0;
  for (std::size_t k = 0; k < low.size(); ++k) {
    EXPECT_LT((result.surfaces[0].net().row(low[k]) - result.surfaces[0].net().row(high[k])).norm(), 1e-14);
    moved = std::max(moved, (result.surfaces[0].net().row(low[k]) - plan.surfaces[0].net().row(low[k])).norm());
  }
  EXPECT_GT(moved, 1e-4);
  EXPECT_EQ(seamSmoothness(result.surfaces[0], 0, 1e-12), 2);
  EXPECT_LT(result.joinsAfter[0].angle, 1e-12);
  const SurfaceFairness clean = surfaceFairness(tubeWith(0));
  EXPECT_GT(result.before[0].isophoteRoughness, 1.5 * clean.isophoteRoughness);
  EXPECT_LT(result.after[0].isophoteRoughness, 1.05 * clean.isophoteRoughness);
}

TEST(JointFairing, ForTangentPlanesAloneTheCurvatureDoesNotGetWorse) {
  const auto faces = threeFaces(false, false);
  const PartPlan plan = planPart(faces, threePairs(false), heldOutside());
  const JointFairing result = fairJointly(plan, {.tolerance = 0.005, .aim = JoinAim::g1});
  EXPECT_GT(result.summary.largestMove, 1e-3);
  for (std::size_t j = 0; j < 3; ++j) {
    EXPECT_LT(result.joinsAfter[j].meanAngle, 0.3 * result.joinsBefore[j].meanAngle) << j;
    EXPECT_LE(result.joinsAfter[j].meanJump, result.joinsBefore[j].meanJump) << j;
  }
}

// Three strips of a sheet side by side; the middle one is a piece of a plane, which any move makes rougher.
TEST(JointFairing, AFaceThatTheOthersMakeWorseKeepsStillAlone) {
  std::mt19937 engine(3);
  std::vector<PartFace> faces;
  std::vector<SidePair> pairs;
  for (int strip = 0; strip < 3; ++strip) {
    Surface sheet = withDomain(bentSheet(3, 3, 8, 8), 0, strip, strip + 1);
    sheet.net().col(0).array() += strip;
    sheet.net().col(1).array() += 0.1 * strip;
    sheet.net().col(2).setZero();
    if (strip != 1) addNoise(sheet, 0.002, {strip == 0 ? 2 : 1, strip == 0 ? 1 : 2, 2, 2}, engine);
    faces.push_back({sheet, {}});
    if (strip > 0) pairs.push_back({strip - 1, strip, 1, 0});
  }
  const PartPlan plan = planPart(faces, pairs, heldOutside());
  ASSERT_EQ(plan.joints.size(), 2U);
  const JointFairing result = fairJointly(plan, {.tolerance = 0.01});
  EXPECT_EQ(result.surfaces[1].net(), plan.surfaces[1].net());
  for (const std::size_t f : {std::size_t{0}, std::size_t{2}}) {
    EXPECT_LT(result.after[f].isophoteRoughness, 0.5 * result.before[f].isophoteRoughness);
  }
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_LE(result.joinsAfter[j].meanAngle, std::max(1e-5, result.joinsBefore[j].meanAngle));
  }
}

TEST(JointFairing, NoToleranceNoMove) {
  const PartPlan plan = planPart(twoFaces(0.002, true), kPair, heldOutside());
  const JointFairing result = fairJointly(plan, {.tolerance = 0});
  EXPECT_EQ(result.summary.largestMove, 0);
}

}  // namespace
}  // namespace strak
