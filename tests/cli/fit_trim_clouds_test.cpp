// strak fit --trim beside other options, and on clouds of every shape: whatever is written is a valid trimmed face.

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "tests/cli/program.h"

#ifdef STRAK_WITH_CAD

namespace strak {
namespace {

constexpr double kHeight = 5;

double hill(double x, double y) { return kHeight * std::sin(x / 30) * std::cos(y / 40); }

class FitTrimClouds : public test::Program {
 protected:
  using Inside = std::function<bool(double, double)>;

  // Random points of 100 x 100 units where `inside` says so; bent: along a cylinder of radius 50.
  static std::string random(int count, const Inside& inside, bool bent = false, unsigned seed = 1) {
    std::string text;
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> number(0, 100);
    while (count > 0) {
      const double x = number(engine), y = number(engine);
      if (!inside(x, y)) continue;
      --count;
      text += bent ? fmt::format("{} {} {}\n", 50 * std::sin(x / 50), y, 50 * std::cos(x / 50))
                   : fmt::format("{} {} {}\n", x, y, hill(x, y));
    }
    return text;
  }

  static bool round(double x, double y) { return std::hypot(x - 40, y - 45) >= 20; }

  // Fits, and looks at the file again. Returns what the fit says of the object.
  nlohmann::json trimmed(std::vector<std::string> arguments, const std::string& output = "out.step") const {
    arguments.insert(arguments.begin(), "fit");
    for (const std::string& more : {std::string("-o"), path(output), std::string("--trim"), std::string("auto")}) {
      arguments.push_back(more);
    }
    auto object = json(arguments)["objects"][0];
    const auto& trimming = object["trimming"];
    EXPECT_TRUE(trimming["valid"].get<bool>()) << output;
    for (const auto& loop : trimming["loops"]) {
      EXPECT_LE(loop["deviation"].get<double>(), loop["tolerance"].get<double>());
      EXPECT_EQ(loop["hole"].get<bool>(), loop["area"].get<double>() < 0);
    }
    const auto info = json({"info", path(output)});
    EXPECT_TRUE(info["audit"]["valid"].get<bool>()) << output;
    EXPECT_EQ(info["objects"].size(), trimming["faces"].get<std::size_t>()) << output;
    return object;
  }
};

TEST_F(FitTrimClouds, StandsBesideAllOtherWaysToFit) {
  const std::string in = write("bent.xyz", random(800, round, true));
  const std::string normals =
      write("normals.txt", fmt::format("x y z nx ny nz\n{} 80 {} {} 0.02 {}\n", 50 * std::sin(1.5), 50 * std::cos(1.5),
                                       std::sin(1.5), std::cos(1.5)));
  const std::vector<std::vector<std::string>> ways{{},
                                                   {"--loss", "l1"},
                                                   {"--loss", "huber"},
                                                   {"--energy", "data-dependent"},
                                                   {"--normals", normals},
                                                   {"--degree", "2,4"}};
  for (const auto& way : ways) {
    std::vector<std::string> arguments{in, "--kind", "surface", "--size", "8"};
    arguments.insert(arguments.end(), way.begin(), way.end());
    const auto trimming = trimmed(arguments)["trimming"];
    const std::string said = way.empty() ? "" : way.front() + " " + way.back();
    EXPECT_EQ(trimming["faces"], 1) << said;
    ASSERT_EQ(trimming["loops"].size(), 2U) << said;
    const double triangles = trimming["area_of_triangles"];
    EXPECT_NEAR(trimming["area"].get<double>(), triangles, 0.05 * triangles) << said;
  }
}

TEST_F(FitTrimClouds, KeepsTheKnotsAndTheBorderOfAStart) {
  const std::string in = write("bent.xyz", random(1000, round, true));
  ASSERT_EQ(strak({"fit", in, "-o", path("start.g2"), "--kind", "surface", "--size", "9x11"}).code, 0);
  for (const char* rows : {"g0", "g1"}) {
    const auto object = trimmed({in, "--kind", "surface", "--start", path("start.g2"), "--hold", rows});
    EXPECT_EQ(object["points"], nlohmann::json({9, 11}));
    EXPECT_EQ(object["trimming"]["loops"].size(), 2U);
    ASSERT_EQ(strak({"convert", path("out.step"), "-o", path("out.g2")}).code, 0);
    const Surface start = test::readSurface(file("start.g2")), fit = test::readSurface(file("out.g2"));
    const Index held = rows == std::string("g0") ? 1 : 2;
    double border = 0, inside = 0;
    for (Index i = 0; i < 9; ++i) {
      for (Index j = 0; j < 11; ++j) {
        const bool isHeld = std::min({i, j, 8 - i, 10 - j}) < held;
        const double moved = (fit.net().row(11 * i + j) - start.net().row(11 * i + j)).norm();
        (isHeld ? border : inside) = std::max(isHeld ? border : inside, moved);
      }
    }
    EXPECT_LT(border, 1e-9) << rows;
    EXPECT_GT(inside, 1e-6) << rows;
  }
  // A start that covers a part of the points.
  const std::string part = write("part.xyz", random(
                                                 1000, [](double, double y) { return y < 60; }, true));
  ASSERT_EQ(strak({"fit", part, "-o", path("part.g2"), "--kind", "surface", "--size", "9"}).code, 0);
  const auto object = trimmed({in, "--kind", "surface", "--start", path("part.g2")});
  EXPECT_LT(object["trimming"]["area"].get<double>(), 6200);
}

TEST_F(FitTrimClouds, AStrayPointIsLeftOut) {
  const std::string cloud = random(1500, round);
  const auto trimming = trimmed({write("in.xyz", cloud + "300 300 0\n"), "--size", "10"})["trimming"];
  EXPECT_EQ(trimming["left_out"], 1);
  EXPECT_EQ(trimming["faces"], 1);
  EXPECT_NEAR(trimming["area"].get<double>(), 1e4 - std::numbers::pi * 400, 600);
  // Many in a wide area are no face, either, and that is said.
  std::string strays = cloud;
  for (int i = 0; i < 25; ++i) strays += fmt::format("{} {} 0\n", 300 + 200 * (i % 5) + i, 200 * (i / 5));
  const auto many = trimmed({write("many.xyz", strays), "--size", "10"});
  EXPECT_EQ(many["trimming"]["left_out"], 25);
  EXPECT_EQ(many["trimming"]["faces"], 1);
  EXPECT_NE(many["warnings"].dump().find("beyond the trimmed faces"), std::string::npos);
  // Where one drags a surface in space away its lengths are still those at the points.
  const auto space =
      trimmed({write("space.xyz", cloud + "300 300 0\n"), "--size", "10", "--kind", "surface"})["trimming"];
  EXPECT_NEAR(space["area"].get<double>(), trimming["area"].get<double>(), 400);
}

TEST_F(FitTrimClouds, IslandsAreFacesOnOneSurface) {
  const auto apart = [](double x, double y) { return (x < 35 || x > 65) && (y < 35 || y > 65); };
  for (const char* output : {"out.step", "out.igs", "out.brep"}) {
    const auto object = trimmed({write("in.xyz", random(2000, apart)), "--size", "10"}, output);
    EXPECT_EQ(object["trimming"]["faces"], 4);
    EXPECT_EQ(object["trimming"]["loops"].size(), 4U);
    ASSERT_EQ(object["warnings"].size(), 1U);
    EXPECT_NE(object["warnings"][0].get<std::string>().find("4 separate parts"), std::string::npos);
  }
}

TEST_F(FitTrimClouds, RepeatedPointsChangeNothing) {
  const std::string cloud = random(1000, round);
  const auto once = trimmed({write("once.xyz", cloud), "--size", "8"})["trimming"];
  const auto thrice = trimmed({write("thrice.xyz", cloud + cloud + cloud), "--size", "8"})["trimming"];
  EXPECT_EQ(once["loops"].size(), thrice["loops"].size());
  EXPECT_NEAR(once["area"].get<double>(), thrice["area"].get<double>(), 1e-3 * once["area"].get<double>());
}

TEST_F(FitTrimClouds, SpikyBorders) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const auto star = [](double x, double y) {
      const double turn = std::atan2(y - 50, x - 50) * 12 / std::numbers::pi;
      return std::hypot(x - 50, y - 50) < 25 + 20 * std::abs(turn - 2 * std::floor(turn / 2) - 1);
    };
    const std::string in = write("in.xyz", random(2500, star, false, seed));
    for (const char* tolerance : {"", "0.5"}) {
      std::vector<std::string> arguments{in, "--size", "8"};
      if (*tolerance != 0) arguments.insert(arguments.end(), {"--trim-tolerance", tolerance});
      const auto trimming = trimmed(arguments, seed == 2 ? "out.igs" : "out.step")["trimming"];
      EXPECT_EQ(trimming["faces"], 1);
      EXPECT_EQ(trimming["loops"][0]["pinned"], 0);
      const double triangles = trimming["area_of_triangles"];
      EXPECT_NEAR(trimming["area"].get<double>(), triangles, 0.03 * triangles);
    }
  }
}

TEST_F(FitTrimClouds, ThinStripsAndFewPoints) {
  std::string grid, random = "", thin;
  std::mt19937 engine(4);
  std::uniform_real_distribution<double> number(0, 1);
  for (int i = 0; i < 300; ++i) {
    for (int j = 0; j < 2; ++j) grid += fmt::format("{} {} {}\n", i, j, hill(i, j));
    for (int j = 0; j < 3; ++j) thin += fmt::format("{} {} {}\n", i, 0.001 * j, hill(i, 0));
    for (int j = 0; j < 5; ++j) {
      const double x = 1000 * number(engine), y = number(engine);
      random += fmt::format("{} {} {}\n", x, y, hill(x, y));
    }
  }
  EXPECT_NEAR(trimmed({write("grid.xyz", grid), "--size", "20x2", "--degree", "3,1"})["trimming"]["area"].get<double>(),
              299, 0.01);
  EXPECT_NEAR(trimmed({write("thin.xyz", thin), "--size", "20x2", "--degree", "3,1"})["trimming"]["area"].get<double>(),
              0.598, 0.01);
  trimmed({write("random.xyz", random), "--size", "20x2", "--degree", "3,1"});
  const auto four = trimmed({write("four.xyz", "0 0 0\n1 0 0\n0 1 0\n1 1 1\n"), "--size", "2", "--degree", "1"});
  EXPECT_NEAR(four["trimming"]["area"].get<double>(), 1, 1e-9);
}

TEST_F(FitTrimClouds, WhatAGridLeavesBlankIsAHole) {
  std::string grid = "ncols 60\nnrows 50\nxllcorner 500000\nyllcorner 4000000\ncellsize 10\nNODATA_value -9999\n";
  for (int row = 0; row < 50; ++row) {
    for (int column = 0; column < 60; ++column) {
      const bool blank = std::hypot(column - 25, row - 20) < 10 || (column > 45 && row > 30) || column < 3;
      grid += blank ? "-9999 " : fmt::format("{:.4f} ", hill(column, row));
    }
    grid += "\n";
  }
  for (const char* name : {"in.asc", "in.dem"}) {
    for (const char* output : {"out.step", "out.igs"}) {
      const auto object = trimmed({write(name, grid), "--size", "12"}, output);
      const auto& trimming = object["trimming"];
      EXPECT_EQ(trimming["faces"], 1);
      ASSERT_EQ(trimming["loops"].size(), 2U);
      EXPECT_EQ(trimming["left_out"], 0);
      const double hole = trimming["loops"][1]["area"];
      EXPECT_NEAR(hole, -std::numbers::pi * 1e4, 2000);
      EXPECT_NEAR(trimming["loops"][0]["area"].get<double>(), 560 * 490 - 140 * 190, 1);
      EXPECT_TRUE(object["warnings"].empty());
    }
  }
}

}  // namespace
}  // namespace strak

#endif
