// Input that is well-formed but bad to work with: folds, no area, weights of all sizes. The program says so or works.

#include <cmath>

#include "tests/cli/program.h"

namespace strak::test {
namespace {

class Hopeless : public Program {
 protected:
  // Fairs in.g2; it works, within the tolerance and without a number that is none, or it says in one sentence why not.
  void expectWorksOrSays(const std::string& tolerance, const std::string& what,
                         const std::string& energy = "exact") const {
    const Outcome outcome =
        strak({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", tolerance, "--energy", energy, "--json"});
    if (outcome.code == 2) {
      EXPECT_TRUE(outcome.err.starts_with("strak: ")) << what << outcome.err;
      EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << what << outcome.err;
      return;
    }
    ASSERT_EQ(outcome.code, 0) << what << outcome.err;
    const auto result = nlohmann::json::parse(outcome.out);
    const auto& object = result.at("objects").at(0);
    EXPECT_LE(object.at("deviation").at("certified").get<double>(), std::stod(tolerance) * (1 + 1e-9)) << what;
    EXPECT_LE(object.at("energy").at("after").get<double>(), object.at("energy").at("before").get<double>()) << what;
    EXPECT_TRUE(readSurface(file("out.g2")).net().allFinite()) << what;
  }
};

// The text of a rational surface; the weights as they are given.
std::string rationalText(const std::vector<std::string>& weights) {
  std::string text = "200 1 0 0\n3 1\n4 4\n0 0 0 0 1 1 1 1\n4 4\n0 0 0 0 1 1 1 1\n";
  for (std::size_t r = 0; r < 16; ++r) {
    text += std::to_string(r % 4) + " " + std::to_string(r / 4) + " 0.5 " + weights[r % weights.size()] + "\n";
  }
  return text;
}

TEST_F(Hopeless, FacesThatFold) {
  Surface folded = wavySurface(3, 10, 10);
  // Rows 4 and 6 exchanged: the surface runs back and forth there, and J < 0 between.
  for (Index j = 0; j < 10; ++j) folded.net().row(folded.row({4, j})).swap(folded.net().row(folded.row({6, j})));
  write("in.g2", g2(folded));
  expectWorksOrSays("0.05", "folded");
  Surface twisted = wavySurface(3, 10, 10);
  for (Index i = 5; i < 10; ++i) {
    for (Index j = 0; j < 5; ++j) {
      twisted.net().row(twisted.row({i, j})).swap(twisted.net().row(twisted.row({i, 9 - j})));
    }
  }
  write("in.g2", g2(twisted));
  expectWorksOrSays("0.05", "crosses itself");
}

TEST_F(Hopeless, SurfacesThatMeetThemselves) {
  // A loop drawn along a line, and the same without.
  Net net(8, 3);
  const double loop[4][2] = {{0, 0}, {3, 2}, {-2, 2}, {1, 0}};
  for (Index i = 0; i < 4; ++i) {
    for (Index j = 0; j < 2; ++j) net.row(2 * i + j) << loop[i][0], 2.0 * static_cast<double>(j), loop[i][1];
  }
  const Surface crossing({KnotVector::uniformClamped(3, 1), KnotVector::uniformClamped(1, 1)}, net);
  write("in.g2", g2(crossing) + g2(wavySurface(3, 14, 14)));
  const auto objects = json({"info", path("in.g2"), "--self-intersections"}).at("objects");
  EXPECT_EQ(objects.at(0).at("self_intersection"), "intersects");
  EXPECT_EQ(objects.at(1).at("self_intersection"), "free");
  EXPECT_NE(strak({"info", path("in.g2"), "--self-intersections"}).out.find("intersects"), std::string::npos);
  // What was there before is no reason to refuse the rest.
  const auto faired = json({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01"}).at("objects");
  EXPECT_EQ(faired.at(1).at("self_intersection"), "free");
}

TEST_F(Hopeless, FacesWithoutArea) {
  Surface line = wavySurface(3, 12, 12);
  for (Index i = 0; i < 12; ++i) {
    for (Index j = 0; j < 12; ++j) line.net().row(line.row({i, j})) << static_cast<double>(i), 0, 0;
  }
  write("in.g2", g2(line));
  expectWorksOrSays("0.01", "a line");
  expectWorksOrSays("0.01", "a line", "data-dependent");
  Surface doubled = wavySurface(3, 12, 12);
  for (Index j = 0; j < 12; ++j) {
    for (Index i = 0; i < 12; ++i) doubled.net()(doubled.row({i, j}), 1) = doubled.net()(doubled.row({i, j}), 0);
  }
  write("in.g2", g2(doubled));
  expectWorksOrSays("0.01", "u along v");
  expectWorksOrSays("0.01", "u along v", "data-dependent");
  Surface point = wavySurface(3, 12, 12);
  point.net().setConstant(2.5);
  write("in.g2", g2(point));
  const Outcome outcome = strak({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("one point"), std::string::npos) << outcome.err;
}

TEST_F(Hopeless, WeightsThatAreNone) {
  for (const char* weight : {"0", "-1", "nan", "inf", "-0.0", "1e999"}) {
    write("in.g2", rationalText({"1", "1", weight}));
    for (const auto& command : {std::vector<std::string>{"info", path("in.g2")},
                                std::vector<std::string>{"convert", path("in.g2"), "-o", path("out.json")},
                                std::vector<std::string>{"fair", path("in.g2"), "-o", path("out.g2")}}) {
      const Outcome outcome = strak(command);
      EXPECT_EQ(outcome.code, 2) << weight << outcome.err;
      EXPECT_NE(outcome.err.find("line "), std::string::npos) << weight << outcome.err;
      EXPECT_FALSE(std::filesystem::exists(file("out.g2")));
    }
  }
}

TEST_F(Hopeless, WeightsOfVeryDifferentSize) {
  for (const auto& [small, large] : {std::pair{"1e-12", "1e12"}, std::pair{"1e-150", "1e150"},
                                     std::pair{"1e-308", "1e308"}, std::pair{"5e-324", "1"}}) {
    write("in.g2", rationalText({small, large, "1"}));
    for (const auto& command : {std::vector<std::string>{"info", path("in.g2")},
                                std::vector<std::string>{"compare", path("in.g2"), path("in.g2")},
                                std::vector<std::string>{"convert", path("in.g2"), "-o", path("out.json")}}) {
      const Outcome outcome = strak(command);
      EXPECT_TRUE(outcome.code == 0 || (outcome.code == 2 && outcome.err.starts_with("strak: ")))
          << command[0] << small << outcome.err << outcome.code;
    }
    const Outcome outcome =
        strak({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01", "--energy", "thin-plate"});
    EXPECT_EQ(outcome.code, 2) << outcome.err;  // the quadratic energies do not know weights
    EXPECT_NE(outcome.err.find("rational"), std::string::npos) << outcome.err;
  }
}

#ifdef STRAK_WITH_CAD

TEST_F(Hopeless, WeightsThatAreNoneInCadFiles) {
  write("in.g2", rationalText({"1", "0.731"}));
  ASSERT_EQ(strak({"convert", path("in.g2"), "-o", path("good.step")}).code, 0);
  const std::string good = text("good.step");
  const std::string weightThere = "7.3099999999999998E-01";
  ASSERT_NE(good.find(weightThere), std::string::npos);
  for (const char* weight : {"0.", "-0.7", "1.E-320", "1.E300"}) {
    std::string bad = good;
    bad.replace(bad.find(weightThere), weightThere.size(), weight);
    write("in.step", bad);
    for (const auto& command : {std::vector<std::string>{"info", path("in.step")},
                                std::vector<std::string>{"fair", path("in.step"), "-o", path("out.step")},
                                std::vector<std::string>{"convert", path("in.step"), "-o", path("out.json")}}) {
      const Outcome outcome = strak(command);
      EXPECT_TRUE(outcome.code == 0 || ((outcome.code == 2 || outcome.code == 1) && outcome.err.starts_with("strak: ")))
          << command[0] << weight << outcome.err << outcome.code;
    }
  }
}

TEST_F(Hopeless, AnalyticFacesAreMadeSplinesWhereTheyAreNamed) {
  write("in.g2", g2(wavySurface(3, 8, 8)));
  const Outcome unnamed = strak({"fair", path("in.g2"), "-o", path("out.g2"), "--convert-analytic"});
  EXPECT_EQ(unnamed.code, 2);
  EXPECT_NE(unnamed.err.find("--faces"), std::string::npos) << unnamed.err;
  EXPECT_EQ(strak({"convert", path("in.g2"), "-o", path("out.g2"), "--analytic-to-bspline", "1"}).code, 0);
  const Outcome wrong = strak({"convert", path("in.g2"), "-o", path("out.g2"), "--analytic-to-bspline", "4"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.err.find("--analytic-to-bspline"), std::string::npos) << wrong.err;
}

#endif

}  // namespace
}  // namespace strak::test
