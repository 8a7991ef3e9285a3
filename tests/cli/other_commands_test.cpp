// info, compare, convert, render and what all commands share.

#include "tests/cli/program.h"

namespace strak::test {
namespace {

class Commands : public Program {};

TEST_F(Commands, VersionAndHelp) {
  const Outcome version = strak({"--version"});
  EXPECT_EQ(version.code, 0);
  EXPECT_TRUE(version.out.starts_with("strak ")) << version.out;
  for (const char* command : {"info", "fair", "compare", "convert", "render"}) {
    const Outcome help = strak({command, "--help"});
    EXPECT_EQ(help.code, 0) << command;
    EXPECT_NE(help.out.find("Example:\n  strak " + std::string(command)), std::string::npos) << help.out;
    EXPECT_EQ(help.err, "") << command;
  }
}

TEST_F(Commands, InfoTellsWhatIsInside) {
  write("in.g2", g2(wavySurface(3, 14, 12)) + g2(wavyCurve(2, 9)));
  const auto info = json({"info", path("in.g2"), "--fairness"});
  EXPECT_EQ(info.at("command"), "strak info " + path("in.g2") + " --fairness --json");
  EXPECT_EQ(info.at("format"), "g2");
  EXPECT_NEAR(info.at("size").get<double>(), 12.9, 0.2);
  const auto& surface = info.at("objects").at(0);
  EXPECT_EQ(surface.at("degree"), (nlohmann::json{3, 3}));
  EXPECT_EQ(surface.at("points"), (nlohmann::json{14, 12}));
  EXPECT_EQ(surface.at("continuity"), 2);
  EXPECT_EQ(surface.at("rational"), false);
  EXPECT_EQ(surface.at("free_points"), 8 * 6);
  EXPECT_TRUE(surface.at("left_alone").is_null());
  EXPECT_GT(surface.at("fairness").at("plate").get<double>(), 0);
  EXPECT_EQ(info.at("objects").at(1).at("continuity"), 1);
  EXPECT_GT(info.at("objects").at(1).at("fairness").at("length").get<double>(), 10);
  const Outcome table = strak({"info", path("in.g2")});
  EXPECT_NE(table.out.find("14x12"), std::string::npos) << table.out;
  EXPECT_NE(table.out.find("yes, 48 points free"), std::string::npos) << table.out;
}

TEST_F(Commands, CompareCertifiesTheDeviation) {
  const Surface a = wavySurface(3, 14, 12, 0);
  Net net = a.net();
  net.col(2).array() += 0.25;
  write("a.g2", g2(a));
  write("b.g2", g2(Surface(a.knots(), net)));
  const auto object = json({"compare", path("a.g2"), path("b.g2")}).at("objects").at(0);
  EXPECT_FALSE(object.at("identical").get<bool>());
  EXPECT_NEAR(object.at("deviation").at("certified").get<double>(), 0.25, 1e-4);
  EXPECT_GE(object.at("deviation").at("certified").get<double>(), 0.25 - 1e-15);
  EXPECT_NEAR(object.at("deviation").at("control_points").get<double>(), 0.25, 1e-12);
  const auto same = json({"compare", path("a.g2"), path("a.g2")});
  EXPECT_TRUE(same.at("identical").get<bool>());
  EXPECT_EQ(same.at("largest_deviation").get<double>(), 0);
}

TEST_F(Commands, CompareMeasuresSurfacesWithOtherParametersByHausdorffDistance) {
  const Surface a = wavySurface(3, 14, 12, 0);
  Net net = a.net();
  net.col(2).array() += 0.25;
  write("a.g2", g2(a));
  write("b.g2", g2(Surface({a.knots(0).rescaled(0, 5), a.knots(1)}, net)));
  const auto object = json({"compare", path("a.g2"), path("b.g2")}).at("objects").at(0);
  EXPECT_NEAR(object.at("deviation").at("certified").get<double>(), 0.25, 1e-4);
  EXPECT_LE(object.at("hausdorff").get<double>(), 0.25 * (1 + 1e-12));
  EXPECT_GE(object.at("hausdorff").get<double>(), 0.2);
}

TEST_F(Commands, CompareOfUnlikeFilesSaysSo) {
  write("a.g2", g2(wavySurface(3, 14, 12)) + g2(wavySurface(3, 8, 8)));
  write("b.g2", g2(wavyCurve(3, 12)));
  const auto result = json({"compare", path("a.g2"), path("b.g2")});
  EXPECT_EQ(result.at("object_counts"), (nlohmann::json{2, 1}));
  EXPECT_FALSE(result.at("identical").get<bool>());
  EXPECT_FALSE(result.at("objects").at(0).at("note").is_null());
  EXPECT_EQ(strak({"compare", path("a.g2"), path("b.g2")}).code, 0);
}

TEST_F(Commands, ConvertKeepsEveryBitThroughJson) {
  write("a.g2", g2(wavySurface(3, 14, 12)) + g2(wavyCurve(4, 12)));
  EXPECT_EQ(strak({"convert", path("a.g2"), "-o", path("b.json")}).code, 0);
  EXPECT_EQ(strak({"convert", path("b.json"), "-o", path("c.g2")}).code, 0);
  EXPECT_TRUE(json({"compare", path("a.g2"), path("c.g2")}).at("identical").get<bool>());
}

TEST_F(Commands, ElevatedAndBezierFormsAreTheSameSurface) {
  const Surface input = wavySurface(3, 9, 8);
  write("a.g2", g2(input));
  json({"convert", path("a.g2"), "-o", path("elevated.g2"), "--elevate", "5"});
  EXPECT_EQ(readSurface(file("elevated.g2")).degree(0), 5);
  EXPECT_EQ(readSurface(file("elevated.g2")).degree(1), 5);
  EXPECT_LT(json({"compare", path("a.g2"), path("elevated.g2")}).at("largest_deviation").get<double>(), 1e-11);
  const auto result = json({"convert", path("a.g2"), "-o", path("bezier.g2"), "--to-bezier"});
  EXPECT_EQ(result.at("objects").size(), 6U * 5U);
  EXPECT_EQ(readModel(file("bezier.g2"))->objects().size(), 6U * 5U);
  EXPECT_EQ(readSurface(file("bezier.g2")).net().rows(), 16);
  EXPECT_EQ(strak({"convert", path("a.g2"), "-o", path("x.g2"), "--elevate", "2"}).code, 2);
}

TEST_F(Commands, RenderDrawsLinesAndPages) {
  write("a.g2", g2(wavySurface(3, 10, 9)));
  for (const char* kind : {"isophotes", "zebra", "isolines", "combs", "gaussian", "mean"}) {
    const auto result = json({"render", path("a.g2"), "-o", path("out.svg"), "--kind", kind, "--lines", "8"});
    EXPECT_EQ(result.at("kind"), kind);
    const std::string drawing = text("out.svg");
    EXPECT_NE(drawing.find("<svg"), std::string::npos) << kind;
    EXPECT_NE(drawing.find("<path"), std::string::npos) << kind;
  }
  EXPECT_EQ(strak({"render", path("a.g2"), "-o", path("out.html"), "--view", "1,1,1", "--light=-1,0,2"}).code, 0);
  EXPECT_NE(text("out.html").find("<html"), std::string::npos);
}

TEST_F(Commands, RenderShowsTheDeviationFromAnotherFile) {
  write("a.g2", g2(wavySurface(3, 10, 9)));
  write("b.g2", g2(wavySurface(3, 10, 9, 0)));
  json({"render", path("a.g2"), "-o", path("out.svg"), "--kind", "deviation", "--reference", path("b.g2")});
  EXPECT_NE(text("out.svg").find("<svg"), std::string::npos);
}

TEST_F(Commands, AFullPipeIsAFailure) {
  write("a.g2", g2(wavySurface(3, 10, 9)));
  const std::string command = std::string("'") + STRAK_PROGRAM + "' info '" + path("a.g2") + "' >/dev/full 2>/dev/null";
  const int status = std::system(command.c_str());
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1);
}

}  // namespace
}  // namespace strak::test
