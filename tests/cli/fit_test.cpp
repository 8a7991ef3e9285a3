// strak fit, as people use it.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "strak/spline/evaluate.h"
#include "tests/cli/program.h"

namespace strak {
namespace {

using test::Outcome;

class FitCommand : public test::Program {
 protected:
  // z = 1 + x - y / 2 + x y with repeatable errors of up to `noise`.
  std::string saddle(int perSide, double noise) const {
    std::string text = "# measured\nx,y,z\n";
    unsigned state = 1;
    for (int i = 0; i < perSide; ++i) {
      for (int j = 0; j < perSide; ++j) {
        state = state * 1664525U + 1013904223U;
        const double x = static_cast<double>(i) / (perSide - 1), y = 2.0 * j / (perSide - 1);
        const double z = 1 + x - y / 2 + x * y + noise * (static_cast<double>(state >> 8) / (1 << 23) - 1);
        text += std::to_string(x) + "," + std::to_string(y) + "," + std::to_string(z) + "\n";
      }
    }
    return write("saddle.csv", text);
  }
};

TEST_F(FitCommand, MakesTheGraphOfAFunction) {
  const auto result = json({"fit", saddle(40, 0.01), "-o", path("out.g2"), "--size", "12x9"});
  const auto& object = result["objects"][0];
  EXPECT_EQ(object["kind"], "function");
  EXPECT_EQ(object["measured"], 1600);
  EXPECT_EQ(object["points"], (std::vector<int>{12, 9}));
  EXPECT_EQ(object["degree"], (std::vector<int>{3, 3}));
  EXPECT_NEAR(object["rms"].get<double>(), 0.01 / std::sqrt(3.0), 5e-4);
  EXPECT_LT(object["smoothing"]["freedom"].get<double>(), 20);
  const Surface surface = test::readSurface(file("out.g2"));
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, {0.3, 1.7}, {1.0, 2.0}}) {
    const Point at = evaluate<2>(surface, {x, y});
    EXPECT_NEAR(at[0], x, 1e-12);
    EXPECT_NEAR(at[1], y, 1e-12);
    EXPECT_NEAR(at[2], 1 + x - y / 2 + x * y, 3e-3);
  }
}

TEST_F(FitCommand, KeepsATolerance) {
  std::string text;
  for (int i = 0; i < 2000; ++i) {
    const double t = 0.01 * i;
    text += std::to_string(std::cos(t) * (5 + t)) + " " + std::to_string(std::sin(t) * (5 + t)) + "\n";
  }
  const auto result = json({"fit", write("spiral.txt", text), "-o", path("out.json"), "--tolerance", "0.001"});
  const auto& object = result["objects"][0];
  EXPECT_EQ(object["kind"], "curve");
  EXPECT_TRUE(object["tolerance"]["reached"]);
  EXPECT_EQ(object["tolerance"]["inside"], 1);
  EXPECT_TRUE(object["tolerance"]["outside"].empty());
  EXPECT_LE(object["max"].get<double>(), 0.001);
  EXPECT_TRUE(object["warnings"].empty());
}

TEST_F(FitCommand, SaysWhatStaysOutsideAndWhere) {
  std::string text;
  for (int i = 0; i < 30; ++i) {
    for (int j = 0; j < 30; ++j) text += fmt::format("{} {} {}\n", i, j, i == 10 && j == 20 ? 9 : 0.01 * i * j);
  }
  const auto result = json({"fit", write("spike.xyz", text), "-o", path("out.g2"), "--tolerance", "0.05"});
  const auto& object = result["objects"][0];
  EXPECT_FALSE(object["tolerance"]["reached"]);
  EXPECT_EQ(object["worst"]["point"], 10 * 30 + 20 + 1);
  ASSERT_FALSE(object["tolerance"]["outside"].empty());
  EXPECT_LE(object["tolerance"]["outside"][0]["from"][0].get<double>(), 10);
  EXPECT_GE(object["tolerance"]["outside"][0]["to"][1].get<double>(), 20);
  EXPECT_EQ(object["warnings"].size(), 1);
  const auto most = json({"fit", path("spike.xyz"), "-o", path("out.g2"), "--tolerance", "0.05", "--share", "99"});
  EXPECT_TRUE(most["objects"][0]["tolerance"]["reached"]);
}

TEST_F(FitCommand, FitsSheetsInSpaceByTheirPlane) {
  std::string text, parameters = "u v x y z\n";
  for (int i = 0; i <= 40; ++i) {
    for (int j = 0; j <= 30; ++j) {
      const double u = i / 10.0, v = j / 10.0, h = 0.2 * std::sin(u) * v;
      // Upright: the heights are along y.
      text += fmt::format("{} {} {}\n", u, h, v);
      parameters += fmt::format("{} {} {} {} {}\n", u, v, u, h, v);
    }
  }
  const auto upright = json({"fit", write("upright.xyz", text), "-o", path("out.g2"), "--kind", "surface"});
  EXPECT_EQ(upright["objects"][0]["kind"], "surface");
  EXPECT_LT(upright["objects"][0]["max"].get<double>(), 1e-3);
  const auto given = json({"fit", write("given.txt", parameters), "-o", path("given.step")});
  EXPECT_EQ(given["objects"][0]["kind"], "surface");
  EXPECT_LT(given["objects"][0]["max"].get<double>(), 1e-3);
}

TEST_F(FitCommand, PassesThroughConditionsExactly) {
  write("through.csv", "x,y,z\n0.5,1,3\n0,0,1\n");
  json({"fit", saddle(20, 0.01), "-o", path("out.g2"), "--conditions", path("through.csv"), "--size", "8"});
  const Surface surface = test::readSurface(file("out.g2"));
  EXPECT_NEAR(evaluate<2>(surface, {0.5, 1})[2], 3, 1e-12);
  EXPECT_NEAR(evaluate<2>(surface, {0, 0})[2], 1, 1e-12);
}

TEST_F(FitCommand, ReachesAsFarAsItsConditions) {
  const std::string points = saddle(20, 0.01);
  write("corner.csv", "x,y,z\n1.25,2.5,3\n");
  json({"fit", points, "-o", path("out.g2"), "--conditions", path("corner.csv"), "--size", "8"});
  const Surface surface = test::readSurface(file("out.g2"));
  EXPECT_EQ(surface.knots(0).to(), 1.25);
  EXPECT_EQ(surface.knots(1).to(), 2.5);
  EXPECT_NEAR(evaluate<2>(surface, {1.25, 2.5})[2], 3, 1e-12);
  EXPECT_NE(refusal({"fit", points, "-o", path("no.g2"), "--conditions", path("corner.csv"), "--domain", "0,1,0,2"})
                .find("outside the domain"),
            std::string::npos);
}

TEST_F(FitCommand, SmoothsAsItIsTold) {
  const std::string points = saddle(30, 0.01);
  const auto noise = json({"fit", points, "-o", path("a.g2"), "--noise", "0.0055"});
  EXPECT_NEAR(noise["objects"][0]["rms"].get<double>(), 0.0055, 1e-5);
  const auto fixed = json({"fit", points, "-o", path("b.g2"), "--smoothing", "0.001", "--energy", "thin-plate"});
  EXPECT_EQ(fixed["objects"][0]["smoothing"]["lambda"], 0.001);
  EXPECT_EQ(fixed["objects"][0]["energy"]["name"], "thin-plate");
  const auto threads = json({"fit", points, "-o", path("c.g2"), "--noise", "0.0055", "--threads", "1"});
  EXPECT_EQ(text("a.g2"), text("c.g2"));
}

TEST_F(FitCommand, CorrectsTheParametersOfPointsInSpace) {
  std::string text;
  for (int i = 0; i <= 60; ++i) {
    for (int j = 0; j <= 60; ++j) {
      const double a = (i - 30) / 27.0, b = (j - 30) / 29.0;
      text += fmt::format("{} {} {}\n", std::sin(a), std::cos(a) * std::sin(b), std::cos(a) * std::cos(b));
    }
  }
  const std::string points = write("cap.xyz", text);
  const auto plain =
      json({"fit", points, "-o", path("a.g2"), "--kind", "surface", "--correct", "0", "--size", "9"})["objects"][0];
  EXPECT_FALSE(plain.contains("correction"));
  const auto corrected = json({"fit", points, "-o", path("b.g2"), "--kind", "surface", "--size", "9"})["objects"][0];
  EXPECT_GT(corrected["correction"]["rounds"], 0);
  EXPECT_GT(corrected["drawing"]["steps"], 3);
  EXPECT_FALSE(plain.contains("drawing"));
  EXPECT_LT(corrected["rms"].get<double>(), 0.7 * plain["rms"].get<double>());
  EXPECT_NE(refusal({"fit", points, "-o", path("no.g2"), "--correct", "3"}).find("--correct is for points in space"),
            std::string::npos);
}

TEST_F(FitCommand, DrawsBentSheetsAndRefusesLayers) {
  std::string half, layers;
  unsigned state = 1;
  for (int i = 0; i <= 80; ++i) {
    for (int j = 0; j <= 60; ++j) {
      state = state * 1664525U + 1013904223U;
      const double radius = 1 + 1e-3 * (static_cast<double>(state >> 8) / (1 << 23) - 1);
      const double a = (i - 40) * 0.0393;  // up to a right angle
      half += fmt::format("{} {} {}\n", radius * std::sin(a), j / 20.0, radius * std::cos(a));
      layers += fmt::format("{} {} {}\n{} {} {}\n", i, j, 2 * radius, i, j, 9 * radius);
    }
  }
  const std::string points = write("half.xyz", half);
  const auto bent = json({"fit", points, "-o", path("half.g2"), "--kind", "surface", "--size", "14"})["objects"][0];
  EXPECT_NEAR(bent["rms"].get<double>(), 1e-3 / std::sqrt(3.0), 1e-4);
  EXPECT_LT(bent["max"].get<double>(), 2e-3);
  EXPECT_GT(bent["drawing"]["stretch"], 1.1);
  EXPECT_EQ(bent["drawing"]["plane"], 0);
  EXPECT_TRUE(bent["warnings"].empty());
  const auto within =
      json({"fit", points, "-o", path("half.g2"), "--kind", "surface", "--tolerance", "0.004"})["objects"][0];
  EXPECT_TRUE(within["tolerance"]["reached"]);
  EXPECT_NE(refusal({"fit", write("layers.xyz", layers), "-o", path("no.g2"), "--kind", "surface", "--size", "14"})
                .find("the cloud is not one sheet"),
            std::string::npos);
  EXPECT_NE(refusal({"fit", points, "-o", path("no.g2"), "--kind", "surface", "--domain", "0,1,0,1"}).find("--domain"),
            std::string::npos);
}

TEST_F(FitCommand, IsNotMovedByOutliersWithAnotherLoss) {
  std::string text;
  unsigned state = 1;
  for (int i = 0; i < 200; ++i) {
    state = state * 1664525U + 1013904223U;
    const double noise = 0.01 * (static_cast<double>(state >> 8) / (1 << 23) - 1);
    text += fmt::format("{} {}\n", i, std::sin(0.03 * i) + noise + (i % 40 == 7 ? 4 : 0));
  }
  const std::string points = write("outliers.txt", text);
  for (const std::string loss : {"l1", "huber", "tukey"}) {
    const auto object =
        json({"fit", points, "-o", path(loss + ".json"), "--kind", "function", "--loss", loss})["objects"][0];
    EXPECT_EQ(object["loss"]["outliers"], 5) << loss;
    EXPECT_TRUE(object["loss"]["converged"]) << loss;
    EXPECT_LT(object["loss"]["gap"].get<double>(), 1.1e-3) << loss;
    const auto model = readModel(file(loss + ".json"));
    const auto& curve = std::get<Curve>(*model->objects()[0].spline);
    for (double x : {7.0, 47.0, 100.0}) EXPECT_NEAR(evaluate<1>(curve, {x})[1], std::sin(0.03 * x), 0.01) << loss;
  }
  EXPECT_NE(refusal({"fit", points, "-o", path("no.g2"), "--loss", "l9"}).find("there is no loss 'l9'"),
            std::string::npos);
  EXPECT_NE(refusal({"fit", points, "-o", path("no.g2"), "--loss", "l1", "--tolerance", "1"}).find("--tolerance"),
            std::string::npos);
}

TEST_F(FitCommand, MakesTheLargestErrorLeast) {
  std::string text;
  for (int i = 0; i <= 400; ++i) text += fmt::format("{} {}\n", i / 200.0 - 1, std::pow(i / 200.0 - 1, 4));
  const auto object = json({"fit", write("quartic.txt", text), "-o", path("out.g2"), "--kind", "function", "--size",
                            "4", "--smoothing", "0", "--loss", "linf"})["objects"][0];
  EXPECT_EQ(object["loss"]["name"], "linf");
  EXPECT_LE(object["loss"]["gap"].get<double>(), 0.02);
  EXPECT_NEAR(object["max"].get<double>(), 0.125, 0.002);  // Chebyshev's polynomial
}

TEST_F(FitCommand, StreamedFilesGiveTheSame) {
  const std::string points = saddle(120, 0.01);
  const auto kept = json({"fit", points, "-o", path("a.g2"), "--size", "20"})["objects"][0];
  const auto streamed = json({"fit", points, "-o", path("b.g2"), "--size", "20", "--memory", "0"})["objects"][0];
  EXPECT_FALSE(kept["streamed"]);
  EXPECT_TRUE(streamed["streamed"]);
  EXPECT_EQ(text("a.g2"), text("b.g2"));
  EXPECT_EQ(kept["worst"], streamed["worst"]);
  EXPECT_NE(refusal({"fit", points, "-o", path("no.g2"), "--memory", "0", "--loss", "l1"}).find("thin the points out"),
            std::string::npos);
}

TEST_F(FitCommand, RepeatedPointsCountAsOneMeasurement) {
  const std::string once = saddle(40, 0.01);
  const std::string all = text("saddle.csv"), rows = all.substr(all.find("x,y,z\n") + 6);
  const auto single = json({"fit", once, "-o", path("a.g2"), "--size", "12"})["objects"][0];
  const auto repeated =
      json({"fit", write("thrice.csv", rows + rows + rows), "-o", path("b.g2"), "--size", "12"})["objects"][0];
  EXPECT_NEAR(repeated["smoothing"]["freedom"].get<double>(), single["smoothing"]["freedom"].get<double>(), 1e-3);
  ASSERT_EQ(repeated["warnings"].size(), 1);
  EXPECT_NE(repeated["warnings"][0].get<std::string>().find("3200 points repeat others"), std::string::npos);
}

TEST_F(FitCommand, WarnsOfHeightsFarBeyondThePoints) {
  // A narrow strip along the diagonal says little of the corners beside it.
  std::string text = "x,y,z\n";
  for (int i = 0; i <= 100; ++i) {
    const double x = i / 100.0, y = x + (i % 3 - 1) * 0.01;
    text += fmt::format("{},{},{}\n", x, y, 50 * (x - y) * (x - y) + std::sin(3 * x));
  }
  const std::string strip = write("strip.csv", text);
  const Outcome outcome = strak({"fit", strip, "-o", path("out.g2"), "--size", "8"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.err.find("beside the points the surface reaches"), std::string::npos) << outcome.err;
  EXPECT_EQ(strak({"fit", saddle(20, 0.01), "-o", path("out.g2")}).err, "");
}

TEST_F(FitCommand, WarnsWhereThePointsAreFew) {
  const std::string points = write("few.xyz", "0 0 1\n1 0 2\n0 1 3\n1 1 5\n0.5 0.2 2\n0.3 0.8 2\n0.9 0.4 3\n");
  const Outcome outcome = strak({"fit", points, "-o", path("out.g2"), "--size", "6"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.err.find("36 control points are more than the 7 points determine"), outcome.err.npos);
  EXPECT_NE(refusal({"fit", points, "-o", path("no.g2"), "--size", "6", "--smoothing", "0"})
                .find("the points do not determine all 36 control points"),
            std::string::npos);
}

TEST_F(FitCommand, RefusesBadInputWithOneSentence) {
  const std::string good = saddle(5, 0), out = path("out.g2");
  EXPECT_NE(refusal({"fit", write("empty.xyz", ""), "-o", out}).find("is empty"), std::string::npos);
  EXPECT_NE(refusal({"fit", write("one.xyz", "1 2 3\n"), "-o", out}).find("a single point"), std::string::npos);
  EXPECT_NE(refusal({"fit", write("nan.xyz", "1 2 3\n4 nan 6\n"), "-o", out}).find("line 2: 'nan'"), std::string::npos);
  EXPECT_NE(refusal({"fit", write("text.xyz", "1 2 3\n4 5 6\n7 8 9O\n"), "-o", out}).find("line 3: '9O'"),
            std::string::npos);
  std::string line, same;
  for (int i = 0; i < 100; ++i) {
    line += fmt::format("{} {} {}\n", i, 3 * i, i);
    same += "1 2 3\n";
  }
  EXPECT_NE(refusal({"fit", write("line.xyz", line), "-o", out}).find("on a line"), std::string::npos);
  EXPECT_NE(refusal({"fit", path("line.xyz"), "-o", out, "--kind", "surface"}).find("on a line"), std::string::npos);
  EXPECT_NE(refusal({"fit", write("same.xyz", same), "-o", out}).find("a single point"), std::string::npos);
  EXPECT_NE(refusal({"fit", path("same.xyz"), "-o", out, "--kind", "curve"}).find("all points are the same"),
            std::string::npos);
  EXPECT_NE(refusal({"fit", good, "-o", path("out.xls")}).find("ending"), std::string::npos);
  EXPECT_NE(refusal({"fit", good, "-o", out, "--kind", "blob"}).find("--kind"), std::string::npos);
  EXPECT_NE(refusal({"fit", good, "-o", out, "--size", "2"}).find("at least 4"), std::string::npos);
  EXPECT_NE(refusal({"fit", good, "-o", out, "--size", "1000x1000"}).find("--most-points"), std::string::npos);
  EXPECT_NE(refusal({"fit", good, "-o", out, "--tolerance", "0"}).find("--tolerance"), std::string::npos);
  EXPECT_NE(refusal({"fit", good, "-o", out, "--tolerance", "1", "--share", "101"}).find("share"), std::string::npos);
  EXPECT_NE(refusal({"fit", good, "-o", out, "--smoothing", "-1"}).find("--smoothing"), std::string::npos);
  EXPECT_NE(refusal({"fit", good, "-o", out, "--domain", "5,6,7,8"}).find("no point lies inside"), std::string::npos);
  EXPECT_NE(refusal({"fit", good, "-o", out, "--domain", "1,0,0,1"}).find("--domain"), std::string::npos);
  EXPECT_NE(refusal({"fit", path("nothing.xyz"), "-o", out}).find("cannot read"), std::string::npos);
}

}  // namespace
}  // namespace strak
