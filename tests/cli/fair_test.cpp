// `strak fair` on files: what comes out, and what every option does to it.

#include <cmath>
#include <fstream>

#include "tests/cli/program.h"

namespace strak::test {
namespace {

class Fair : public Program {};

double largestMove(const Surface& a, const Surface& b) { return (a.net() - b.net()).rowwise().norm().maxCoeff(); }

// Whether the control points of the outer `rows` rows are the same to the bit.
bool bordersEqual(const Surface& a, const Surface& b, Index rows) {
  for (Index i = 0; i < a.size(0); ++i) {
    for (Index j = 0; j < a.size(1); ++j) {
      const bool border = i < rows || j < rows || i >= a.size(0) - rows || j >= a.size(1) - rows;
      if (border && a.net().row(a.row({i, j})) != b.net().row(b.row({i, j}))) return false;
    }
  }
  return true;
}

TEST_F(Fair, KeepsTheToleranceAndTheHeldRowsToTheBit) {
  const Surface input = wavySurface(3, 20, 16);
  write("in.g2", g2(input));
  const auto result =
      json({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01", "--energy", "thin-plate"});
  const Surface output = readSurface(file("out.g2"));
  EXPECT_EQ(output.knots(), input.knots());
  EXPECT_TRUE(bordersEqual(input, output, 3));
  EXPECT_FALSE(bordersEqual(input, output, 4));
  EXPECT_LE(largestMove(input, output), 0.01 * (1 + 1e-12));
  EXPECT_GT(largestMove(input, output), 0.005);
  const auto& object = result.at("objects").at(0);
  EXPECT_LE(object.at("deviation").at("certified").get<double>(), 0.01 * (1 + 1e-9));
  EXPECT_LE(object.at("deviation").at("lower").get<double>(), object.at("deviation").at("certified").get<double>());
  EXPECT_NEAR(object.at("deviation").at("control_points").get<double>(), largestMove(input, output), 1e-12);
  EXPECT_EQ(object.at("held_max_move").get<double>(), 0);
  EXPECT_LT(object.at("energy").at("after").get<double>(), object.at("energy").at("before").get<double>());
  EXPECT_LT(object.at("plate").at("after").get<double>(), object.at("plate").at("before").get<double>());
  EXPECT_LE(object.at("gap").get<double>(), 1e-6);
  EXPECT_EQ(object.at("stop_reason"), "gap");
}

// The default: the surface's own figures fall, the surface stays within the tolerance, its points need not.
TEST_F(Fair, ExactEnergiesAreTheDefault) {
  const Surface input = wavySurface(3, 20, 16);
  write("in.g2", g2(input));
  const auto result = json({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01"});
  EXPECT_EQ(result.at("tolerance_kind"), "surface");
  const Surface output = readSurface(file("out.g2"));
  EXPECT_EQ(output.knots(), input.knots());
  EXPECT_TRUE(bordersEqual(input, output, 3));
  EXPECT_FALSE(bordersEqual(input, output, 4));
  const auto& object = result.at("objects").at(0);
  EXPECT_EQ(object.at("energy").at("name"), "exact");
  EXPECT_LE(object.at("deviation").at("certified").get<double>(), 0.01 * (1 + 1e-9));
  EXPECT_EQ(object.at("held_max_move").get<double>(), 0);
  EXPECT_TRUE(object.at("gap").is_null()) << "not convex: nothing is proven";
  for (const char* figure : {"plate", "curvature_variation", "isophote_roughness"}) {
    EXPECT_LT(object.at("fairness").at("after").at(figure).get<double>(),
              object.at("fairness").at("before").at(figure).get<double>())
        << figure;
  }
  const auto points = json({"fair", path("in.g2"), "-o", path("points.g2"), "--tolerance", "0.01", "--energy", "exact",
                            "--tolerance-kind", "points"});
  EXPECT_LE(largestMove(input, readSurface(file("points.g2"))), 0.01 * (1 + 1e-12));
}

TEST_F(Fair, OptionsOfQuadraticEnergiesImplyOne) {
  write("in.g2", g2(wavySurface(3, 14, 14)));
  for (const auto& [option, value] :
       {std::pair{"--parameter-scale", "domain"}, {"--gap", "1e-4"}, {"--method", "local"}}) {
    const auto result = json({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01", option, value});
    EXPECT_EQ(result.at("objects").at(0).at("energy").at("name"), "thin-plate") << option;
    EXPECT_EQ(result.at("tolerance_kind"), "points") << option;
    EXPECT_EQ(strak({"fair", path("in.g2"), "-o", path("out.g2"), "--energy", "exact", option, value}).code, 2);
  }
}

TEST_F(Fair, JsonHasAllThatIsPromised) {
  write("in.g2", g2(wavySurface(3, 14, 14)));
  const auto result = json({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01"});
  for (const char* key : {"version", "command", "inputs", "objects", "seconds"})
    EXPECT_TRUE(result.contains(key)) << key;
  const auto& object = result.at("objects").at(0);
  for (const char* key : {"name", "degree", "points", "energy", "plate", "deviation", "held_max_move", "steps", "gap",
                          "stop_reason", "seconds"}) {
    EXPECT_TRUE(object.contains(key)) << key;
  }
  for (const char* key : {"name", "before", "after"}) EXPECT_TRUE(object.at("energy").contains(key)) << key;
  EXPECT_EQ(object.at("energy").at("name"), "exact");
  EXPECT_EQ(object.at("degree"), (nlohmann::json{3, 3}));
  EXPECT_EQ(object.at("points"), (nlohmann::json{14, 14}));
}

TEST_F(Fair, TableNamesTheObjectAndTheFilesAndNothingGoesToStderr) {
  write("in.g2", g2(wavySurface(3, 14, 14)));
  const Outcome outcome = strak({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.err, "");  // no progress bar when nobody watches
  EXPECT_NE(outcome.out.find("surface 1"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("14x14"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("wrote " + path("out.g2")), std::string::npos) << outcome.out;
  EXPECT_EQ(files(), (std::vector<std::string>{"in.g2", "out.g2"}));
}

TEST_F(Fair, QuietPrintsNothing) {
  write("in.g2", g2(wavySurface(3, 14, 14)));
  const Outcome outcome = strak({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01", "--quiet"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.out + outcome.err, "");
}

TEST_F(Fair, HoldsAsManyRowsAsAsked) {
  const Surface input = wavySurface(3, 16, 15);
  write("in.g2", g2(input));
  const std::vector<std::pair<std::string, Index>> cases{{"g0", 1}, {"g1", 2}, {"g2", 3}, {"5", 5}};
  for (const auto& [hold, rows] : cases) {
    json({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01", "--hold", hold});
    const Surface output = readSurface(file("out.g2"));
    EXPECT_TRUE(bordersEqual(input, output, rows)) << hold;
    EXPECT_FALSE(bordersEqual(input, output, rows + 1)) << hold;
  }
}

TEST_F(Fair, HoldsADifferentStripOnEachSide) {
  const Surface input = wavySurface(3, 16, 15);
  write("in.g2", g2(input));
  json({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01", "--hold", "1,4,2,3"});
  const Surface output = readSurface(file("out.g2"));
  const auto heldRow = [&](Index i, Index j) {
    return input.net().row(input.row({i, j})) == output.net().row(output.row({i, j}));
  };
  for (Index i = 0; i < 16; ++i) {
    for (Index j = 0; j < 15; ++j) {
      const bool held = i < 1 || i >= 12 || j < 2 || j >= 12;
      EXPECT_EQ(heldRow(i, j), held) << i << ", " << j;
    }
  }
}

TEST_F(Fair, SurfaceToleranceIsReachedButNeverPassed) {
  write("in.g2", g2(wavySurface(3, 20, 16)));
  const auto points =
      json({"fair", path("in.g2"), "-o", path("a.g2"), "--tolerance", "0.004", "--energy", "thin-plate"})
          .at("objects")
          .at(0);
  const auto surface = json({"fair", path("in.g2"), "-o", path("b.g2"), "--tolerance", "0.004", "--tolerance-kind",
                             "surface", "--energy", "thin-plate"})
                           .at("objects")
                           .at(0);
  EXPECT_LT(points.at("deviation").at("certified").get<double>(), 0.00399);
  EXPECT_LE(surface.at("deviation").at("certified").get<double>(), 0.004);
  EXPECT_GE(surface.at("deviation").at("certified").get<double>(), 0.00399);
  EXPECT_LT(surface.at("energy").at("after").get<double>(), points.at("energy").at("after").get<double>());
  EXPECT_GT(surface.at("deviation").at("control_points").get<double>(), 0.004);
}

TEST_F(Fair, ToleranceMayBeAPartOfTheSize) {
  write("in.g2", g2(wavySurface(3, 14, 14)));
  const double size = json({"info", path("in.g2")}).at("size").get<double>();
  json({"fair", path("in.g2"), "-o", path("a.g2"), "--tolerance", "0.001size"});
  json({"fair", path("in.g2"), "-o", path("b.g2"), "--tolerance", std::to_string(0.001 * size)});
  EXPECT_LT(largestMove(readSurface(file("a.g2")), readSurface(file("b.g2"))), 1e-6);
}

TEST_F(Fair, RescaledKnotsChangeNothing) {
  const Surface input = wavySurface(3, 16, 15);
  const Surface rescaled({input.knots(0).rescaled(-3, 70), input.knots(1).rescaled(0.5, 0.51)}, input.net());
  write("a.g2", g2(input));
  write("b.g2", g2(rescaled));
  for (const char* name : {"a", "b"}) {
    json({"fair", path(name + std::string(".g2")), "-o", path(name + std::string("-out.g2")), "--tolerance", "0.01",
          "--gap", "1e-10"});
  }
  EXPECT_LT(largestMove(readSurface(file("a-out.g2")), readSurface(file("b-out.g2"))), 1e-9 * 12);
}

TEST_F(Fair, ScaleUnitAndScaleDomainDiffer) {
  write("in.g2", g2(wavySurface(3, 16, 15)));
  std::vector<double> energies;
  for (const char* scale : {"lengths", "domain", "unit"}) {
    const auto result =
        json({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01", "--parameter-scale", scale});
    energies.push_back(result.at("objects").at(0).at("energy").at("before").get<double>());
  }
  EXPECT_NE(energies[0], energies[1]);
  EXPECT_NE(energies[1], energies[2]);
  EXPECT_NE(energies[0], energies[2]);
}

TEST_F(Fair, MethodsAgree) {
  write("in.g2", g2(wavySurface(3, 14, 12)));
  std::vector<double> energies;
  for (const char* method : {"optimal", "local"}) {
    const auto result =
        json({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01", "--method", method, "--gap", "1e-7"});
    EXPECT_EQ(result.at("objects").at(0).at("stop_reason"), "gap") << method;
    energies.push_back(result.at("objects").at(0).at("energy").at("after").get<double>());
  }
  EXPECT_NEAR(energies[0] / energies[1], 1, 2e-7);
}

TEST_F(Fair, LocalMethodsStopWhereTold) {
  write("in.g2", g2(wavySurface(3, 20, 20)));
  const auto run = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments{"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.005", "--method"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return json(arguments).at("objects").at(0);
  };
  const auto steps = run({"local", "--steps", "50"});
  EXPECT_EQ(steps.at("steps"), 50);
  EXPECT_EQ(steps.at("stop_reason"), "steps");
  EXPECT_EQ(run({"local", "--min-gain", "1e3"}).at("stop_reason"), "gain");
  const auto capped = run({"local", "--max-changes", "1"});
  EXPECT_LE(capped.at("steps").get<int>(), 14 * 14);
  const auto literal = run({"local-literal", "--max-changes", "3"});
  EXPECT_LE(literal.at("steps").get<int>(), 3 * 14 * 14);
  EXPECT_GT(literal.at("steps").get<int>(), 0);
  EXPECT_GT(run({"local", "--points-per-list", "20", "--steps", "40"}).at("steps").get<int>(), 0);
}

TEST_F(Fair, EnergiesAndMixtures) {
  write("in.g2", g2(wavySurface(4, 16, 16)));
  for (const char* name :
       {"thin-plate", "laplacian", "laplacian-gradient", "third-derivatives", "thin-plate+0.01*third-derivatives"}) {
    const auto object = json({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01", "--energy", name})
                            .at("objects")
                            .at(0);
    EXPECT_LT(object.at("energy").at("after").get<double>(), object.at("energy").at("before").get<double>()) << name;
  }
}

TEST_F(Fair, WithoutToleranceOnlyTheHeldRowsKeepTheShape) {
  const Surface input = wavySurface(3, 16, 16);
  write("in.g2", g2(input));
  const auto limited = json({"fair", path("in.g2"), "-o", path("a.g2"), "--tolerance", "0.01"}).at("objects").at(0);
  const auto unlimited = json({"fair", path("in.g2"), "-o", path("b.g2")});
  EXPECT_TRUE(unlimited.at("tolerance").is_null());
  EXPECT_LT(unlimited.at("objects").at(0).at("energy").at("after").get<double>(),
            limited.at("energy").at("after").get<double>());
  EXPECT_TRUE(bordersEqual(input, readSurface(file("b.g2")), 3));
}

TEST_F(Fair, CurvesAreFairedToo) {
  const Curve input = wavyCurve(3, 40);
  write("in.g2", g2(input));
  const auto object =
      json({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.03", "--tolerance-kind", "points"})
          .at("objects")
          .at(0);
  const Curve output = std::get<Curve>(readModel(file("out.g2"))->objects().at(0).spline.value());
  EXPECT_LT(object.at("energy").at("after").get<double>(), 0.9 * object.at("energy").at("before").get<double>());
  EXPECT_LT(object.at("plate").at("after").get<double>(), object.at("plate").at("before").get<double>());
  EXPECT_LE((input.net() - output.net()).rowwise().norm().maxCoeff(), 0.03 * (1 + 1e-12));
  EXPECT_EQ(input.net().topRows(3), output.net().topRows(3));
  EXPECT_EQ(input.net().bottomRows(3), output.net().bottomRows(3));
  // By default the tolerance is that of the curve: control points may move further.
  const auto further = json({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.03"}).at("objects").at(0);
  EXPECT_LE(further.at("deviation").at("certified").get<double>(), 0.03);
  EXPECT_LT(further.at("energy").at("after").get<double>(), object.at("energy").at("after").get<double>());
}

TEST_F(Fair, ChosenFacesChangeAndTheOthersStayToTheBit) {
  const Surface first = wavySurface(3, 14, 14);
  const Surface second = wavySurface(3, 15, 13);
  const Surface third = wavySurface(3, 16, 12);
  write("in.g2", g2(first) + g2(second) + g2(third) + g2(wavyCurve(3, 30)));
  const auto result =
      json({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01", "--faces", "1,3-3,curve 4"});
  const auto model = readModel(file("out.g2"));
  EXPECT_NE(std::get<Surface>(*model->objects().at(0).spline), first);
  EXPECT_EQ(std::get<Surface>(*model->objects().at(1).spline), second);
  EXPECT_NE(std::get<Surface>(*model->objects().at(2).spline), third);
  EXPECT_EQ(result.at("objects").size(), 4U);
  EXPECT_EQ(result.at("objects").at(1).at("left_alone"), "not named by --faces");
  EXPECT_TRUE(result.at("objects").at(3).at("left_alone").is_null());
}

TEST_F(Fair, WhatCannotBeFairedIsListedWithItsReason) {
  Surface rational = wavySurface(3, 12, 12);
  Net homogeneous(rational.net().rows(), 4);
  homogeneous << rational.net(), Eigen::VectorXd::Ones(rational.net().rows());
  const Surface flat = wavySurface(3, 14, 14);
  write("in.g2", g2(flat) + g2(Surface(rational.knots(), homogeneous, true)));
  const Outcome outcome =
      strak({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01", "--energy", "thin-plate"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("left alone"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("rational"), std::string::npos) << outcome.out;
}

TEST_F(Fair, ThreadsDoNotChangeABit) {
  write("in.g2", g2(wavySurface(3, 20, 18)) + g2(wavySurface(4, 17, 19)) + g2(wavySurface(5, 18, 16)));
  for (const char* threads : {"1", "2"}) {
    json({"fair", path("in.g2"), "-o", path(std::string("out") + threads + ".g2"), "--tolerance", "0.01", "--threads",
          threads});
  }
  EXPECT_EQ(text("out1.g2"), text("out2.g2"));
}

TEST_F(Fair, OntoAnExistingFileAndOntoTheInput) {
  write("in.g2", g2(wavySurface(3, 14, 14)));
  write("out.g2", "something else");
  json({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01"});
  json({"fair", path("in.g2"), "-o", path("in.g2"), "--tolerance", "0.01"});
  EXPECT_EQ(text("in.g2"), text("out.g2"));
  EXPECT_EQ(files(), (std::vector<std::string>{"in.g2", "out.g2"}));
}

TEST_F(Fair, ReportIsAPageThatNeedsNothingElse) {
  write("in.g2", g2(wavySurface(3, 14, 14)));
  const Outcome outcome =
      strak({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01", "--report", path("report.html")});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const std::string page = text("report.html");
  EXPECT_NE(page.find("<html"), std::string::npos);
  EXPECT_NE(page.find("--tolerance 0.01"), std::string::npos);  // the command that made it
  EXPECT_EQ(page.find("src=\"http"), std::string::npos);
}

TEST_F(Fair, KnotsAreInsertedWhereNothingIsFreeUnlessForbidden) {
  const Surface input = wavySurface(3, 6, 6, 0);
  Net net = input.net();
  net(input.row({2, 2}), 2) += 0.3;
  write("in.g2", g2(Surface(input.knots(), net)));
  json({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.1"});
  EXPECT_GT(readSurface(file("out.g2")).net().rows(), 36);
  const Outcome refused = strak({"fair", path("in.g2"), "-o", path("no.g2"), "--tolerance", "0.1", "--no-refine"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_EQ(files(), (std::vector<std::string>{"in.g2", "out.g2"}));
}

}  // namespace
}  // namespace strak::test
