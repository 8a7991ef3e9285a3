// strak fit --trim: surfaces that end where their points do.

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <random>

#include "tests/cli/program.h"

#ifdef STRAK_WITH_CAD

namespace strak {
namespace {

using test::Outcome;

class FitTrim : public test::Program {
 protected:
  // A hill of 100 x 100 units with a round hole of radius 15 and a square one with side 20.
  std::string sheet(const std::string& name, bool bent = false) const {
    std::string text = "x,y,z\n";
    std::mt19937 random(1);
    std::uniform_real_distribution<double> number(0, 100);
    for (int count = 0; count < 5000;) {
      const double x = number(random), y = number(random);
      if (std::hypot(x - 30, y - 35) < 15 || (x > 60 && x < 80 && y > 55 && y < 75)) continue;
      ++count;
      const double angle = x / 50;  // bent: along a cylinder of radius 50
      text += bent ? fmt::format("{},{},{}\n", 50 * std::sin(angle), y, 50 * std::cos(angle))
                   : fmt::format("{},{},{}\n", x, y, 5 * std::sin(x / 30) * std::cos(y / 40));
    }
    return write(name, text);
  }
};

constexpr double kHoles = 3.14159 * 15 * 15 + 400;
constexpr double kStrip = 1.5;  // the points' spacing: how uncertain a border is

TEST_F(FitTrim, AHeightFieldWithTwoHoles) {
  for (const char* name : {"out.step", "out.igs"}) {
    const auto object = json({"fit", sheet("in.csv"), "--trim", "-o", path(name), "--size", "12"})["objects"][0];
    const auto& trimming = object["trimming"];
    EXPECT_EQ(trimming["faces"], 1);
    ASSERT_EQ(trimming["loops"].size(), 3U);
    EXPECT_TRUE(trimming["valid"]);
    EXPECT_LT(trimming["largest_gap"].get<double>(), 1e-6);
    EXPECT_NEAR(trimming["area"].get<double>(), 1e4 - kHoles, kStrip * 400);
    EXPECT_NEAR(trimming["area"].get<double>(), trimming["area_of_triangles"].get<double>(), 100);
    EXPECT_NEAR(trimming["loops"][0]["length"].get<double>(), 400, 6);
    EXPECT_FALSE(trimming["loops"][0]["hole"]);
    for (const auto& loop : trimming["loops"]) {
      EXPECT_LE(loop["deviation"], loop["tolerance"]);
      EXPECT_EQ(loop["pinned"], 0);
    }
    EXPECT_TRUE(object["warnings"].empty());
    // What is written is what other commands see.
    const auto info = json({"info", path(name)});
    EXPECT_EQ(info["objects"].size(), 1U);
    EXPECT_TRUE(info["audit"]["valid"]);
    EXPECT_EQ(strak({"render", path(name), "-o", path("out.svg")}).code, 0);
  }
}

TEST_F(FitTrim, ABentSheetIsMeasuredInItsOwnLengths) {
  const auto object = json({"fit", sheet("in.csv", true), "-o", path("out.step"), "--kind", "surface", "--size", "12",
                            "--trim", "12"})["objects"][0];
  const auto& trimming = object["trimming"];
  EXPECT_EQ(trimming["faces"], 1);
  EXPECT_EQ(trimming["loops"].size(), 3U);
  EXPECT_TRUE(trimming["valid"]);
  EXPECT_EQ(trimming["gap"], 12);
  EXPECT_NEAR(trimming["area"].get<double>(), 1e4 - kHoles, kStrip * 500);
}

TEST_F(FitTrim, AWideGapClosesTheHoles) {
  const auto object =
      json({"fit", sheet("in.csv"), "-o", path("out.step"), "--size", "12", "--trim", "40"})["objects"][0];
  EXPECT_EQ(object["trimming"]["loops"].size(), 1U);
  EXPECT_GT(object["trimming"]["area_share"], 0.95);
}

TEST_F(FitTrim, SaysWhatItDid) {
  const Outcome outcome = strak({"fit", sheet("in.csv"), "-o", path("out.step"), "--size", "12", "--trim", "auto"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("1 face with 2 holes"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("valid"), std::string::npos);
}

TEST_F(FitTrim, RefusesWhatHasNoTrimming) {
  const std::string in = sheet("in.csv");
  EXPECT_NE(refusal({"fit", in, "-o", path("out.g2"), "--trim", "auto"}).find(".step"), std::string::npos);
  EXPECT_NE(refusal({"fit", in, "-o", path("out.step"), "--trim", "-1"}).find("--trim"), std::string::npos);
  EXPECT_NE(refusal({"fit", in, "-o", path("out.step"), "--trim", "wide"}).find("--trim"), std::string::npos);
  EXPECT_NE(refusal({"fit", in, "-o", path("out.step"), "--trim-tolerance", "1"}).find("--trim"), std::string::npos);
  EXPECT_NE(refusal({"fit", in, "-o", path("out.step"), "--trim", "0.001"}).find("gap"), std::string::npos);
  EXPECT_NE(refusal({"fit", in, "-o", path("out.step"), "--trim", "auto", "--memory", "0"}).find("memory"),
            std::string::npos);
  const std::string curve = write("curve.txt", "0 0\n1 1\n2 0\n3 1\n4 0\n");
  EXPECT_NE(refusal({"fit", curve, "-o", path("out.step"), "--kind", "curve", "--trim", "auto"}).find("curve"),
            std::string::npos);
}

TEST_F(FitTrim, AMeasuredSheetWithBays) {
  const char* named = std::getenv("STRAK_DATA");
  const std::filesystem::path data = named != nullptr ? named : STRAK_SOURCE_DIR "/../shared/data";
  const auto input = data / "scan/ALSTOM_TEST4.off";
  if (!std::filesystem::exists(input)) GTEST_SKIP() << "measured points are not here: set STRAK_DATA";
  const auto object = json({"fit", std::filesystem::absolute(input).string(), "-o", path("out.step"), "--kind",
                            "surface", "--tolerance", "0.5", "--share", "99", "--trim", "auto"})["objects"][0];
  const auto& trimming = object["trimming"];
  EXPECT_EQ(trimming["faces"], 1);
  EXPECT_TRUE(trimming["valid"]);
  EXPECT_EQ(trimming["left_out"], 0);
  EXPECT_LT(trimming["largest_gap"].get<double>(), 1e-5);
  const double area = trimming["area"], triangles = trimming["area_of_triangles"];
  EXPECT_NEAR(area, triangles, 0.02 * triangles);
  // Distances of its border points vary from 0.5 to 72.
  for (const char* tolerance : {"5", "0.5", "0.02"}) {
    const auto tight = json({"fit", std::filesystem::absolute(input).string(), "-o", path("out.step"), "--kind",
                             "surface", "--tolerance", "0.5", "--share", "99", "--trim", "auto", "--trim-tolerance",
                             tolerance})["objects"][0]["trimming"];
    EXPECT_TRUE(tight["valid"]);
    EXPECT_LE(tight["loops"][0]["deviation"].get<double>(), std::stod(tolerance));
    EXPECT_EQ(tight["loops"][0]["pinned"], 0);
    EXPECT_LE(tight["loops"][0]["corners"], 8);
  }
}

}  // namespace
}  // namespace strak

#endif
