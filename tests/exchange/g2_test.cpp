#include "strak/exchange/g2.h"

#include "tests/exchange/samples.h"

namespace strak {
namespace {

using namespace test;

const char* const kPatch =
    "200 1 0 0\n"
    "3 0\n"
    "2 2\n"
    "0 0 1 1\n"
    "3 3\n"
    "0 0 0 2 2 2\n"
    "0 0 0\n"
    "1 0 0\n"
    "0 1 0.5\n"
    "1 1 0.25\n"
    "0 2 0\n"
    "1 2 0\n";

TEST(G2, DirectionOneIsFastestInTheFileAndSlowestInTheNet) {
  const auto objects = parseG2(kPatch);
  ASSERT_EQ(objects.size(), 1U);
  const Surface& surface = std::get<Surface>(*objects[0].spline);
  EXPECT_EQ(surface.degree(0), 1);
  EXPECT_EQ(surface.degree(1), 2);
  EXPECT_EQ(surface.net().row(surface.row({1, 0})), Eigen::RowVector3d(1, 0, 0));
  EXPECT_EQ(surface.net().row(surface.row({0, 1})), Eigen::RowVector3d(0, 1, 0.5));
  EXPECT_EQ(surface.net().row(surface.row({1, 2})), Eigen::RowVector3d(1, 2, 0));
}

TEST(G2, RoundTripKeepsEveryBit) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 40; ++trial) {
    std::vector<PlainObject> objects;
    for (int i = 0; i < 3; ++i) {
      const int dimension = 1 + static_cast<int>(random() % 4);
      const bool rational = random() % 2 == 0;
      objects.push_back({"", randomSpline<1>(random, dimension, rational), "", ""});
      objects.push_back({"", randomSpline<2>(random, dimension, rational), "", ""});
      objects.push_back({"", randomSpline<3>(random, dimension, rational), "", ""});
    }
    const auto back = parseG2(formatG2(objects));
    ASSERT_EQ(back.size(), objects.size());
    for (std::size_t i = 0; i < back.size(); ++i) EXPECT_EQ(*back[i].spline, *objects[i].spline);
  }
}

TEST(G2, ExtremeNumbersSurvive) {
  const Curve curve({KnotVector(1, {-1e300, -1e300, 5e-324, 5e-324})},
                    (Net(2, 2) << 5e-324, -0.0, 1.7976931348623157e308, 0.1).finished());
  const auto back = parseG2(formatG2({{"", curve, "", ""}}));
  EXPECT_EQ(std::get<Curve>(*back[0].spline), curve);
}

TEST(G2, OtherClassesAreKeptAsTheyAre) {
  const std::string cloud = "400 1 0 4 255 255 0 255\n3\n0 0 0\n1.50 0 0\n 0 1 0\n\n";
  const std::string trimmed = "210 1 0 0\n200\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0 1 0 0 0 1 0 1 1 0\n1\n";
  const auto objects = parseG2(cloud + kPatch + trimmed + kPatch);
  ASSERT_EQ(objects.size(), 4U);
  EXPECT_EQ(objects[0].kind, "point cloud");
  EXPECT_EQ(objects[0].text, cloud);
  EXPECT_EQ(objects[2].kind, "trimmed surface");
  EXPECT_EQ(objects[2].text, trimmed);
  const auto again = parseG2(formatG2(objects));
  ASSERT_EQ(again.size(), 4U);
  EXPECT_EQ(again[0].text, cloud);
  EXPECT_EQ(again[2].text, trimmed);
  EXPECT_EQ(*again[3].spline, *objects[1].spline);
}

TEST(G2, ErrorsNameTheLine) {
  const std::string text = kPatch;
  const auto refused = [](const std::string& broken) { return refusal([&] { parseG2(broken); }); };
  EXPECT_EQ(refused(""), "line 1: the file is empty, an object was expected");
  EXPECT_NE(refused(text.substr(0, text.size() - 8)).find("it is cut off"), std::string::npos);
  std::string broken = text;
  broken.replace(broken.find("0.25"), 4, "oops");
  EXPECT_EQ(refused(broken), "line 10: 'oops' is not a coordinate, a finite number was expected");
  broken = text;
  broken.replace(broken.find("0.25"), 4, "nan ");
  EXPECT_NE(refused(broken).find("line 10"), std::string::npos);
  broken = text;
  broken.replace(broken.find("0 0 1 1"), 7, "0 1 0 1");
  EXPECT_NE(refused(broken).find("line 4"), std::string::npos);
  broken = text;
  broken.replace(broken.find("2 2\n"), 3, "2 5");
  EXPECT_NE(refused(broken).find("line 3: direction u has 2 control points and order 5"), std::string::npos);
  EXPECT_NE(refused("17 1 0 0").find("17 is no class"), std::string::npos);
}

TEST(G2, AHugeCountIsRefusedBeforeAnythingIsAllocated) {
  std::string text = kPatch;
  text.replace(text.find("2 2\n"), 3, "1000000000000000 2");
  EXPECT_NE(refusal([&] { parseG2(text); }).find("more than the rest of the file can hold"), std::string::npos);
  text = kPatch;
  text.replace(text.find("3 0"), 3, "9000000000000000000 1");
  EXPECT_NE(refusal([&] { parseG2(text); }).find("dimension"), std::string::npos);
  EXPECT_FALSE(refusal([] { parseG2("400 1 0 9223372036854775807\n"); }).empty());
}

TEST(G2, MutatedFilesAreReadOrRefused) {
  std::mt19937 random(11);
  std::vector<PlainObject> objects{{"", randomSpline<2>(random), "", ""},
                                   {"", randomSpline<1>(random, 2, true), "", ""}};
  const std::string text = formatG2(objects) + "400 1 0 0\n1\n0 0 0\n";
  int read = 0, refused = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    try {
      const auto back = parseG2(mutated(text, random));
      EXPECT_EQ(parseG2(formatG2(back)).size(), back.size());
      ++read;
    } catch (const InvalidInput& error) {
      EXPECT_EQ(std::string(error.what()).find("line "), 0U) << error.what();
      ++refused;
    }
  }
  EXPECT_GT(read, 0);
  EXPECT_GT(refused, 1000);
}

TEST(G2, RealFilesComeBackToTheBit) {
  for (const char* name : {"gotools/surface.g2", "gotools/nut_top.g2", "gotools/m36_outx_vols.g2",
                           "gotools/midship_section_curves.g2", "iga/ifem_3d_uneven_12.g2"}) {
    const auto path = dataFile(name);
    if (path.empty()) GTEST_SKIP() << name << " is not here: set STRAK_DATA";
    const auto objects = parseG2(readFile(path));
    const auto back = parseG2(formatG2(objects));
    ASSERT_EQ(back.size(), objects.size());
    for (std::size_t i = 0; i < back.size(); ++i) EXPECT_EQ(*back[i].spline, *objects[i].spline);
  }
}

}  // namespace
}  // namespace strak
