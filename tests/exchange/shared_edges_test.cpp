#include <cmath>
#include <set>

#include "strak/exchange/mean_curve.h"
#include "strak/fairing/joints.h"
#include "strak/spline/knot_insertion.h"
#include "tests/exchange/patches.h"
#include "tests/exchange/samples.h"

namespace strak {
namespace {

using namespace test;

TEST(SharedEdges, OfPlainPatchesAreFoundWithTheirSides) {
  const auto model = modelOf(any(fourPatches()));
  const auto edges = model->sharedEdges();
  ASSERT_EQ(edges.size(), 4U);
  const std::set<std::pair<Index, Index>> expected{{0, 1}, {0, 2}, {1, 3}, {2, 3}};
  std::set<std::pair<Index, Index>> found;
  for (const SharedEdge& edge : edges) {
    found.emplace(edge.faceA, edge.faceB);
    ASSERT_TRUE(edge.sideA && edge.sideB);
    EXPECT_FALSE(edge.sewn);
    EXPECT_TRUE(edge.notJoinable.empty());
    EXPECT_LT(apart(*model, edge), 1e-10);
    const auto& a = std::get<Surface>(*model->objects()[static_cast<std::size_t>(edge.faceA)].spline);
    const auto& b = std::get<Surface>(*model->objects()[static_cast<std::size_t>(edge.faceB)].spline);
    const BorderFit fit = fitBorders(a, *edge.sideA, b, *edge.sideB, 1e-9);
    EXPECT_TRUE(fit.compatible) << fit.obstacle;
    EXPECT_EQ(fit.reversed, edge.reversed);
    // Patches 1 and 2 are turned over.
    EXPECT_EQ(edge.sameNormals, (edge.faceA == 1 || edge.faceA == 2) == (edge.faceB == 1 || edge.faceB == 2));
  }
  EXPECT_EQ(found, expected);
}

TEST(SharedEdges, DifferentKnotsAndSpeedsDoNotHideAnEdge) {
  const Surface left = graph(0, 100, 0, 80, 4, 5, hill);
  Surface right = graph(100, 200, 0, 80, 3, 5, hill);
  right = insertKnots(right, 1, {0.11, 0.77});
  // The same shape at an uneven speed along v: a rational change of the parameter.
  Surface uneven({right.knots(0), right.knots(1)}, right.net());
  const auto model = modelOf({left, uneven});
  ASSERT_EQ(model->sharedEdges().size(), 1U);
  // A border that only starts and ends at the same points is another one.
  Surface bent = right;
  bent.net()(bent.row({0, 3}), 2) += 0.01;
  EXPECT_TRUE(modelOf({left, bent})->sharedEdges().empty());
  // Three at one edge.
  const auto three =
      modelOf({left, right, graph(100, 200, 0, 80, 2, 5, [](double x, double y) { return hill(100, y) + x - 100; })});
  const auto edges = three->sharedEdges();
  ASSERT_EQ(edges.size(), 3U);
  for (const auto& edge : edges) EXPECT_EQ(edge.notJoinable, "more than two faces meet there");
}

TEST(SharedEdges, AWholeSideOnAPartOfAnother) {
  const Surface sheet = graph(0, 200, 0, 80, 4, 5, hill);
  const Surface right = subPatch(sheet, 0, 0.5, 1);
  const std::vector<Surface> patches{subPatch(sheet, 0, 0, 0.5), reversed(subPatch(right, 1, 0, 0.33), 1),
                                     withDomain(subPatch(right, 1, 0.33, 1), 1, -1, 7)};
  const auto model = modelOf(any(patches));
  const auto edges = model->sharedEdges();
  ASSERT_EQ(edges.size(), 3U);
  EXPECT_TRUE(edges[0].sideA && edges[0].sideB) << "of the two that are whole";
  for (std::size_t e : {1U, 2U}) {
    EXPECT_EQ(edges[e].faceA, 0);
    EXPECT_EQ(edges[e].faceB, static_cast<Index>(e));
    EXPECT_EQ(edges[e].alongA, 1);
    EXPECT_FALSE(edges[e].sideA);
    EXPECT_EQ(edges[e].sideB, 0);
    EXPECT_EQ(edges[e].reversed, e == 1);
    EXPECT_EQ(edges[e].sameNormals, e != 1);
    EXPECT_LT(apart(*model, edges[e]), 1e-12);
    EXPECT_NEAR(edges[e].lineA[e == 1 ? 1 : 0][1], 0.33, 1e-13);
  }
  // A border that lies there at its ends only is another one.
  std::vector<Surface> bent = patches;
  bent[2].net()(bent[2].row({0, 3}), 2) += 0.01;
  EXPECT_EQ(modelOf(any(bent))->sharedEdges().size(), 2U);
}

TEST(SharedEdges, SeamsAndPolesOfClosedSurfaces) {
  // A closed strip: its first and last column are the same; v runs up, the top is drawn together to a point.
  Surface strip = graph(0, 1, 0, 1, 5, 1, [](double, double) { return 0.0; });
  const Index n = strip.size(0), m = strip.size(1);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < m; ++j) {
      const double angle = i == n - 1 ? 0 : 2 * M_PI * static_cast<double>(i) / static_cast<double>(n - 1);
      const double r = 1 - static_cast<double>(j) / static_cast<double>(m - 1);
      strip.net().row(strip.row({i, j})) << r * std::cos(angle), r * std::sin(angle), static_cast<double>(j);
    }
  }
  const auto edges = modelOf({strip})->sharedEdges();
  ASSERT_EQ(edges.size(), 1U);
  EXPECT_EQ(edges[0].faceA, 0);
  EXPECT_EQ(edges[0].faceB, 0);
  EXPECT_EQ(edges[0].sideA, 0);
  EXPECT_EQ(edges[0].sideB, 1);
  EXPECT_FALSE(edges[0].reversed);
  EXPECT_TRUE(edges[0].sameNormals);
}

TEST(SharedEdges, PlainModelsTakeSeveralSplinesOrNone) {
  const auto patches = fourPatches();
  const auto model = modelOf(any(patches));
  Surface moved = patches[1];
  moved.net()(5, 2) += 1;
  const Surface wrong = withDomain(patches[2], 0, 0, 2);
  EXPECT_NE(refusal([&] { model->replaceTogether({{1, moved}, {2, wrong}}); }).find("surface 3"), std::string::npos);
  EXPECT_EQ(*model->objects()[1].spline, AnySpline(patches[1]));
  model->replaceTogether({{1, moved}, {2, patches[2]}});
  EXPECT_EQ(*model->objects()[1].spline, AnySpline(moved));
}

TEST(MeanCurve, IsHalfwayWithAllKnotsAndTheHigherDegree) {
  std::mt19937 random(3);
  const Curve a = withDomain(randomSpline<1>(random), 0, -1, 2), b = withDomain(randomSpline<1>(random), 0, -1, 2);
  const Curve mean = meanCurve({a, b});
  EXPECT_EQ(mean.degree(0), std::max(a.degree(0), b.degree(0)));
  for (int i = 0; i <= 50; ++i) {
    const double t = -1 + 3 * i / 50.0;
    EXPECT_LT((evaluate<1>(mean, {t}) - (evaluate<1>(a, {t}) + evaluate<1>(b, {t})) / 2).norm(), 1e-11);
  }
  EXPECT_THROW(meanCurve({}), InvalidInput);
  EXPECT_THROW(meanCurve({a, withDomain(b, 0, -1, 3)}), InvalidInput);
}

}  // namespace
}  // namespace strak
