#include "strak/fairing/joints.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "strak/base/error.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/knot_insertion.h"
#include "strak/spline/reparametrize.h"

namespace strak {
namespace {

constexpr double kPi = std::numbers::pi;

// A bicubic net over [x0, x1] x [0, 1] with z = f(x, y) at the Greville places: a quadratic f comes out exactly but
// for a constant.
Surface graph(double x0, double x1, Index spansU, Index spansV, const std::function<double(double, double)>& f) {
  const KnotVector u = KnotVector::uniformClamped(3, spansU), v = KnotVector::uniformClamped(3, spansV);
  const auto s = u.greville(), t = v.greville();
  Net net(u.size() * v.size(), 3);
  for (Index i = 0; i < u.size(); ++i) {
    for (Index j = 0; j < v.size(); ++j) {
      const double x = x0 + (x1 - x0) * s[static_cast<std::size_t>(i)], y = t[static_cast<std::size_t>(j)];
      net.row(i * v.size() + j) << x, y, f(x, y);
    }
  }
  return Surface({u, v}, std::move(net));
}

Surface flat(double x0, double x1, double slope = 0) {
  return graph(x0, x1, 2, 3, [&](double x, double) { return slope * x; });
}

TEST(BorderRow, CountsInwardsAndWithTheRisingParameter) {
  const Surface surface = graph(0, 1, 2, 3, [](double x, double y) { return x * y; });
  EXPECT_EQ(borderRow(surface, 0), (std::vector<Index>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(borderRow(surface, 1, 1), (std::vector<Index>{18, 19, 20, 21, 22, 23}));
  EXPECT_EQ(borderRow(surface, 2), (std::vector<Index>{0, 6, 12, 18, 24}));
  EXPECT_EQ(borderRow(surface, 3, 2), (std::vector<Index>{3, 9, 15, 21, 27}));
  EXPECT_EQ(knotsAlong(surface, 0), surface.knots(1));
  EXPECT_THROW(borderRow(surface, 4), InvalidInput);
  EXPECT_THROW(borderRow(surface, 0, 5), InvalidInput);
}

TEST(FitBorders, FindsPartnersInEitherDirection) {
  const auto f = [](double x, double y) { return std::sin(3 * x + y); };
  const Surface a = graph(0, 1, 2, 3, f), b = graph(1, 2, 4, 3, f);
  for (const bool turned : {false, true}) {
    const Surface other = withDomain(turned ? reversed(b, 1) : b, 1, 5, 11);
    const BorderFit fit = fitBorders(a, 1, other, 0, 1e-12);
    ASSERT_TRUE(fit.compatible) << fit.obstacle;
    EXPECT_EQ(fit.reversed, turned);
    EXPECT_EQ(fit.gap, 0);
    const auto rowsA = borderRow(a, 1), rowsB = borderRow(other, 0);
    ASSERT_EQ(fit.partner.size(), rowsA.size());
    for (std::size_t k = 0; k < rowsA.size(); ++k) {
      EXPECT_EQ(a.net().row(rowsA[k]), other.net().row(rowsB[static_cast<std::size_t>(fit.partner[k])]));
    }
  }
  const BorderFit transposedFit = fitBorders(a, 1, transposed(b), 2, 1e-12);
  EXPECT_TRUE(transposedFit.compatible);
}

TEST(FitBorders, SaysWhatIsInTheWay) {
  const Surface a = flat(0, 1);
  Surface b = flat(1, 2);
  b.net()(2, 2) += 0.01;
  const BorderFit apart = fitBorders(a, 1, b, 0, 1e-6);
  EXPECT_FALSE(apart.compatible);
  EXPECT_NEAR(apart.gap, 0.01, 1e-15);
  EXPECT_NE(apart.obstacle.find("0.01 apart"), std::string::npos);
  EXPECT_TRUE(fitBorders(a, 1, b, 0, 0.02).compatible);
  const BorderFit knots = fitBorders(a, 1, insertKnots(flat(1, 2), 1, {0.4}), 0, 1e-6);
  EXPECT_TRUE(knots.differentKnots);
  EXPECT_FALSE(knots.compatible);
  Net homogeneous(a.net().rows(), 4);
  homogeneous << a.net(), Eigen::VectorXd::Ones(a.net().rows());
  homogeneous.row(0) *= 2;  // a corner
  const BorderFit weights = fitBorders(Surface(a.knots(), homogeneous, true), 0, flat(-1, 0), 1, 1e-6);
  EXPECT_EQ(weights.obstacle, "the weights along the border differ");
}

TEST(MakeCompatible, HandsKnotsOnThroughAllFaces) {
  const auto f = [](double x, double y) { return x * x - y; };
  std::vector<Surface> row{graph(0, 1, 2, 1, f), reversed(graph(1, 2, 3, 1, f), 1), graph(2, 3, 1, 1, f)};
  row[0] = insertKnots(row[0], 1, {0.25});
  row[2] = withDomain(insertKnots(row[2], 1, {0.5, 0.5}), 1, -1, 1);
  const std::vector<SidePair> pairs{{0, 1, 1, 0}, {1, 2, 1, 0}};
  const auto joined = makeCompatible(row, pairs);
  EXPECT_EQ(joined[0].knots(1).knots(), (std::vector<double>{0, 0, 0, 0, 0.25, 0.5, 0.5, 1, 1, 1, 1}));
  EXPECT_EQ(joined[1].knots(1).knots(), (std::vector<double>{0, 0, 0, 0, 0.5, 0.5, 0.75, 1, 1, 1, 1}));
  EXPECT_EQ(joined[2].knots(1).knots(), (std::vector<double>{-1, -1, -1, -1, -0.5, 0, 0, 1, 1, 1, 1}));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(joined[i].knots(0), row[i].knots(0));
    const double v = i == 2 ? -0.3 : 0.35;
    EXPECT_LT((evaluate<2>(joined[i], {0.6, v}) - evaluate<2>(row[i], {0.6, v})).norm(), 1e-14);
  }
  for (const SidePair& pair : pairs) {
    EXPECT_TRUE(fitBorders(joined[static_cast<std::size_t>(pair.a)], pair.sideA,
                           joined[static_cast<std::size_t>(pair.b)], pair.sideB, 1e-12)
                    .compatible);
  }
  EXPECT_EQ(makeCompatible(joined, pairs), joined);
  EXPECT_THROW(makeCompatible(row, pairs, 20), Failure);
  EXPECT_THROW(makeCompatible(row, {{0, 3, 1, 0}}), InvalidInput);
}

TEST(FitBorders, TellsHowAPartOfASideIsFollowed) {
  const auto f = [](double x, double y) { return std::sin(3 * x + 2 * y); };
  const Surface a = graph(0, 1, 2, 3, f), b = graph(1, 2, 2, 3, f);
  for (const bool turned : {false, true}) {
    const Surface low = subPatch(b, 1, 0, 0.37);
    Surface high = withDomain(subPatch(b, 1, 0.37, 1), 1, 3, 7);
    if (turned) high = reversed(high, 1);
    EXPECT_FALSE(fitBorders(a, 1, high, 0, 1e-6).compatible);
    const SidePart part{0.37, 1};
    const BorderFit fit = fitBorders(a, 1, high, 0, 1e-12, part);
    ASSERT_TRUE(fit.compatible) << fit.obstacle;
    EXPECT_EQ(fit.reversed, turned);
    EXPECT_TRUE(fit.partner.empty());
    EXPECT_EQ(fit.fromA.rows(), high.size(1));
    EXPECT_EQ(fit.fromA.cols(), a.size(1));
    EXPECT_LT((fit.fromA.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-14);
    // A border that moves takes its neighbours along.
    Surface moved = a, follower = high;
    const auto rowsA = borderRow(a, 1), rowsB = borderRow(high, 0);
    Net row(a.size(1), 3);
    for (std::size_t k = 0; k < rowsA.size(); ++k) {
      moved.net()(rowsA[k], 2) += 0.1 * static_cast<double>(k % 3);
      row.row(static_cast<Index>(k)) = moved.net().row(rowsA[k]);
    }
    const Net next = fit.fromA * row;
    for (std::size_t k = 0; k < rowsB.size(); ++k) follower.net().row(rowsB[k]) = next.row(static_cast<Index>(k));
    const auto joints = measureJoints({moved, low, follower}, {{0, 1, 1, 0, SidePart{0, 0.37}}, {0, 2, 1, 0, part}});
    EXPECT_GT(joints[0].gapMax, 0.01);
    EXPECT_LT(joints[1].gapMax, 1e-12);
    EXPECT_TRUE(joints[1].fit.compatible);
  }
  // Knots that one side lacks are handed over, in the part only.
  const std::vector<Surface> coarse{insertKnots(a, 1, {0.2, 0.6}), subPatch(b, 1, 0.37, 1)};
  const std::vector<SidePair> pairs{{0, 1, 1, 0, SidePart{0.37, 1}}};
  EXPECT_TRUE(measureJoints(coarse, pairs)[0].fit.differentKnots);
  const auto finer = makeCompatible(coarse, pairs);
  EXPECT_EQ(finer[0].knots(1), coarse[0].knots(1));
  EXPECT_EQ(finer[1].size(1), coarse[1].size(1) + 1);
  EXPECT_TRUE(measureJoints(finer, pairs)[0].fit.compatible);
  EXPECT_THROW(fitBorders(a, 1, b, 0, 1, SidePart{0.5, 1.5}), InvalidInput);
}

TEST(MeasureJoints, TellsFeaturesFromKinksAndSmoothOnes) {
  const double bend = 0.8;
  Surface round = graph(1, 2, 1, 3, [](double, double) { return 0.0; });
  for (Index j = 0; j < round.size(1); ++j) {  // z = bend / 2 (x - 1)^2, as a cubic
    round.net()(round.row({2, j}), 2) = bend / 6;
    round.net()(round.row({3, j}), 2) = bend / 2;
  }
  const std::vector<Surface> s{flat(0, 1), flat(1, 2), round, reversed(flat(1, 2), 1)};
  Surface roof = flat(1, 2, 0.2), kink = flat(1, 2, 0.01);
  roof.net().col(2).array() -= 0.2;
  kink.net().col(2).array() -= 0.01;
  std::vector<Surface> all = s;
  all.push_back(roof);
  all.push_back(kink);
  const auto joints = measureJoints(all, {{0, 1, 1, 0}, {0, 2, 1, 0}, {0, 3, 1, 0}, {0, 4, 1, 0}, {0, 5, 1, 0}});
  ASSERT_EQ(joints.size(), 5U);
  EXPECT_EQ(joints[0].kind, JointKind::g2);
  EXPECT_EQ(joints[1].kind, JointKind::g1);
  EXPECT_NEAR(joints[1].curvatureJumpMax, bend, 1e-9);
  EXPECT_NEAR(joints[1].angleMax, 0, 1e-6);
  EXPECT_EQ(joints[2].kind, JointKind::g2);
  EXPECT_FALSE(joints[2].sameNormals);
  EXPECT_EQ(joints[3].kind, JointKind::feature);
  EXPECT_NEAR(joints[3].angleMax, std::atan(0.2) * 180 / kPi, 1e-9);
  EXPECT_EQ(joints[4].kind, JointKind::g0);
  for (const Joint& joint : joints) {
    EXPECT_TRUE(joint.fit.compatible) << joint.fit.obstacle;
    EXPECT_NEAR(joint.gapMax, 0, 1e-12);
  }
  EXPECT_STREQ(jointKindName(JointKind::feature), "feature");
  EXPECT_STREQ(jointKindName(JointKind::g2), "G2");
  const auto open = freeSides(all.size(), {{0, 1, 1, 0}});
  EXPECT_EQ(open[0], (std::array{true, false, true, true}));
  EXPECT_EQ(open[1], (std::array{false, true, true, true}));
}

TEST(SymmetryPlane, HoldsTheBorderAndTheNormals) {
  // Even in x: perpendicular to x = 0 there.
  const Surface bowl = graph(0, 1, 3, 2, [](double x, double y) { return x * x * (1 + y) + y * y; });
  Surface even = bowl;
  for (const Index r : borderRow(bowl, 0, 1)) {
    even.net()(r, 2) = bowl.net()(borderRow(bowl, 0)[static_cast<std::size_t>(r % bowl.size(1))], 2);
  }
  const auto plane = symmetryPlane(even, 0);
  ASSERT_TRUE(plane);
  EXPECT_NEAR(plane->normal[0], 1, 1e-12);
  EXPECT_NEAR(plane->point[0], 0, 1e-12);
  EXPECT_FALSE(symmetryPlane(even, 1));  // slopes there
  // A straight border: the surface alone tells the plane.
  const auto straight = symmetryPlane(flat(0, 1), 0);
  ASSERT_TRUE(straight);
  EXPECT_NEAR(straight->normal[0], 1, 1e-12);
  // A border that leaves its plane.
  Surface bent = flat(0, 1);
  bent.net()(2, 0) += 1e-3;
  EXPECT_FALSE(symmetryPlane(bent, 0));
  EXPECT_TRUE(symmetryPlane(bent, 0, {.planarity = 1e-2, .angle = 1}));
}

}  // namespace
}  // namespace strak
