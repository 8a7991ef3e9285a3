#include "strak/report/edge_joins.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "strak/report/fair_report.h"
#include "tests/report/shapes.h"

namespace strak {
namespace {

using nlohmann::json;

// The plane z = slope (x - 1) for x in [x0, x0 + 1], y in [0, 1].
Surface plane(double x0, double slope, double lift = 0) {
  Net net(4, 3);
  const double left = slope * (x0 - 1) + lift, right = slope * x0 + lift;
  net << x0, 0, left, x0, 1, left, x0 + 1, 0, right, x0 + 1, 1, right;
  return {{KnotVector::uniformClamped(1, 1), KnotVector::uniformClamped(1, 1)}, net};
}

FairReport twoSheets(const Surface& right, const Surface& rightAfter) {
  const auto model = modelOf({plane(0, 0), right}, {"left", "<right>"});
  FairReport report;
  for (const Object& object : model->objects()) report.objects.push_back(describe(object));
  report.objects[1].after = rightAfter;
  const auto before = surfacesOf(model->objects());
  report.joins = measureJoins(model->sharedEdges(), before, {before[0], &rightAfter});
  return report;
}

TEST(EdgeJoins, MeasureBeforeAndAfter) {
  const double slope = std::tan(0.02), less = std::tan(0.005);
  const FairReport report = twoSheets(plane(1, slope), plane(1, less, 0.001));
  ASSERT_EQ(report.joins.size(), 1U);
  const EdgeJoin& join = report.joins[0];
  EXPECT_EQ(join.name, "left / <right>");
  EXPECT_EQ(join.faceA, 0);
  EXPECT_EQ(join.faceB, 1);
  EXPECT_NEAR(join.gap.before, 0, 1e-12);
  EXPECT_NEAR(join.gap.after, 0.001, 1e-12);
  EXPECT_NEAR(join.angle.before, 0.02 * 180 / M_PI, 1e-9);
  EXPECT_NEAR(join.angle.after, 0.005 * 180 / M_PI, 1e-9);
  EXPECT_NEAR(join.curvature.before, 0, 1e-12);
  EXPECT_EQ(join.kindBefore, JointKind::g0);
  EXPECT_EQ(join.lineBefore.size(), join.lineAfter.size());
  EXPECT_EQ(join.lineBefore.front()[0], 1);
  const JoinSummary summary = summaryOf(report.joins);
  EXPECT_EQ(summary.before, (std::array<Index, 4>{0, 1, 0, 0}));
  EXPECT_EQ(summary.angle.after, join.angle.after);
  EXPECT_NEAR(join.length, 1, 1e-12);
  EXPECT_NEAR(summary.angleMean.before, 0.02 * 180 / M_PI, 1e-9);  // the same all along
  EXPECT_NEAR(summary.angleMean.after, 0.005 * 180 / M_PI, 1e-9);
}

TEST(EdgeJoins, FeaturesDoNotCountAsKinks) {
  const FairReport report = twoSheets(plane(1, 1), plane(1, 1));
  const JoinSummary summary = summaryOf(report.joins);
  EXPECT_EQ(summary.before[static_cast<std::size_t>(JointKind::feature)], 1);
  EXPECT_NEAR(report.joins[0].angle.before, 45, 1e-9);
  EXPECT_EQ(summary.angle.before, 0);
}

TEST(EdgeJoins, StandInTheJsonAndInThePage) {
  const FairReport report = twoSheets(plane(1, 0.01), plane(1, 0.005));
  const json joins = json::parse(fairReportJson(report))["joins"];
  ASSERT_EQ(joins.size(), 1U);
  EXPECT_EQ(joins[0]["edge"], "left / <right>");
  EXPECT_EQ(joins[0]["faces"], json({1, 2}));
  for (const char* key : {"gap", "angle", "curvature"}) {
    EXPECT_TRUE(joins[0][key]["before"].is_number()) << key;
    EXPECT_TRUE(joins[0][key]["after"].is_number()) << key;
  }
  EXPECT_EQ(joins[0]["angle"]["before"], report.joins[0].angle.before);
  EXPECT_EQ(joins[0]["kind"]["before"], "G0");
  const std::string page = fairReportHtml(report);
  EXPECT_NE(page.find("<h2>Joins</h2>"), page.npos);
  EXPECT_NE(page.find("left / &lt;right&gt;"), page.npos);
  const std::size_t at = page.find("id=\"scene\"");
  ASSERT_NE(at, page.npos);
  const std::size_t start = page.find('>', at) + 1;
  const json scene = json::parse(page.substr(start, page.find("</script", start) - start));
  EXPECT_EQ(scene["joins"]["faces"], json({{0, 1}}));
  EXPECT_EQ(scene["joins"]["angle"][0][1], report.joins[0].angle.after);
  EXPECT_EQ(scene["joins"]["lines"].size(), 2U);
}

}  // namespace
}  // namespace strak
