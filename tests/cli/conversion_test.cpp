// strak convert --uniform, --uniform-cubic and --nonuniform.

#include <cmath>

#include "strak/spline/degree_elevation.h"
#include "tests/cli/program.h"

namespace strak::test {
namespace {

class Conversion : public Program {};

TEST_F(Conversion, UniformCubicsComeBackToTheBit) {
  write("in.g2", g2(wavySurface(3, 12, 9)) + g2(wavyCurve(3, 15)));
  const auto result = json({"convert", path("in.g2"), "-o", path("out.g2"), "--uniform-cubic", "--tolerance", "1e-6"});
  for (const auto& object : result.at("objects")) EXPECT_TRUE(object.at("unchanged").get<bool>());
  EXPECT_TRUE(json({"compare", path("in.g2"), path("out.g2")}).at("identical").get<bool>());
}

TEST_F(Conversion, TheSameCubicOfHigherDegreeIsFoundAgain) {
  const Surface cubic = wavySurface(3, 12, 9);
  write("in.g2", g2(elevateDegree(elevateDegree(cubic, 0, 2), 1, 1)));
  json({"convert", path("in.g2"), "-o", path("out.g2"), "--uniform-cubic", "--tolerance", "1e-8"});
  const Surface found = readSurface(file("out.g2"));
  ASSERT_EQ(found.sizes(), cubic.sizes());
  EXPECT_LT((found.net() - cubic.net()).cwiseAbs().maxCoeff(), 1e-12 * cubic.net().cwiseAbs().maxCoeff());
}

TEST_F(Conversion, TheDeviationIsCertifiedSideBySide) {
  write("in.g2", g2(wavySurface(5, 14, 12)) + g2(wavyCurve(4, 20)));
  for (const char* wish : {"--uniform", "--nonuniform"}) {
    const auto result = json({"convert", path("in.g2"), "-o", path("out.g2"), wish, "3", "--tolerance", "0.01"});
    const auto measured = json({"compare", path("in.g2"), path("out.g2")});
    for (std::size_t i = 0; i < 2; ++i) {
      const auto& object = result.at("objects").at(i);
      const double certified = object.at("deviation").at("certified").get<double>();
      EXPECT_LE(certified, 0.01);
      EXPECT_GE(certified * (1 + 1e-9), measured.at("objects").at(i).at("deviation").at("lower").get<double>());
      EXPECT_EQ(object.at("sides").size(), i == 0 ? 4U : 2U);
      for (const auto& side : object.at("sides")) EXPECT_LE(side.get<double>(), certified * (1 + 1e-3));
      for (const auto& degree : object.at("degree")) EXPECT_EQ(degree, 3);
    }
  }
  const Outcome table = strak({"convert", path("in.g2"), "-o", path("out.g2"), "--uniform", "2"});
  EXPECT_EQ(table.code, 0);
  EXPECT_NE(table.out.find("of the sides"), std::string::npos) << table.out;
}

TEST_F(Conversion, WhatIsNotReachedIsNotWritten) {
  write("in.g2", g2(wavySurface(5, 14, 12)));
  const Outcome outcome = strak({"convert", path("in.g2"), "-o", path("out.g2"), "--uniform-cubic", "--tolerance",
                                 "1e-9", "--most-points", "500"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("is still up to"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("--most-points"), std::string::npos) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(file("out.g2")));
}

TEST_F(Conversion, WishesThatMakeNoSense) {
  write("in.g2", g2(wavySurface(5, 14, 12)));
  const auto refused = [&](std::vector<std::string> more) {
    std::vector<std::string> all{"convert", path("in.g2"), "-o", path("out.g2")};
    all.insert(all.end(), more.begin(), more.end());
    const Outcome outcome = strak(all);
    EXPECT_EQ(outcome.code, 2) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(file("out.g2")));
  };
  refused({"--uniform", "0"});
  refused({"--uniform", "16"});
  refused({"--uniform", "three"});
  refused({"--uniform", "3", "--nonuniform", "3"});
  refused({"--uniform-cubic", "--rebuild", "3,1"});
  refused({"--uniform-cubic", "--tolerance", "-1"});
  refused({"--uniform-cubic", "--most-points", "10"});
  refused({"--most-points", "1000"});
}

#ifdef STRAK_WITH_CAD

// Faces stay faces: in their file, with their edges.
TEST_F(Conversion, FacesOfCadFilesStayInTheirPlaces) {
  write("in.g2", g2(wavySurface(5, 14, 12)));
  for (const char* ending : {"step", "igs", "brep"}) {
    const std::string input = path(std::string("in.") + ending), output = path(std::string("out.") + ending);
    EXPECT_EQ(strak({"convert", path("in.g2"), "-o", input}).code, 0) << ending;
    const auto result = json({"convert", input, "-o", output, "--uniform-cubic", "--tolerance", "0.01"});
    EXPECT_LE(result.at("edges").at("gap").get<double>(), 0.01) << ending;
    EXPECT_GT(result.at("edges").at("gap").get<double>(), 1e-6) << ending;
    const auto audit = json({"compare", input, output}).at("audits").at(1);
    EXPECT_TRUE(audit.at("valid").get<bool>()) << ending;
    EXPECT_LE(audit.at("largest_gap").get<double>(), 0.01) << ending;
    EXPECT_EQ(result.at("objects").at(0).at("degree"), (nlohmann::json{3, 3})) << ending;
  }
}

#endif

}  // namespace
}  // namespace strak::test
