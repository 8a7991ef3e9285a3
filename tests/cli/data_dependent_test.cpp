// `strak fair --energy data-dependent`: what comes out, and which options do not go with it.

#include <fmt/format.h>

#include <cmath>

#include "strak/spline/evaluate.h"
#include "tests/cli/program.h"

namespace strak::test {
namespace {

class DataDependent : public Program {};

TEST_F(DataDependent, KeepsToleranceHeldRowsAndFigures) {
  const Surface input = wavySurface(3, 20, 16);
  write("in.g2", g2(input));
  const auto result =
      json({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01", "--energy", "data-dependent"});
  EXPECT_EQ(result.at("tolerance_kind"), "surface");
  const auto& object = result.at("objects").at(0);
  EXPECT_EQ(object.at("energy").at("name"), "data-dependent");
  EXPECT_LT(object.at("energy").at("after").get<double>(), object.at("energy").at("before").get<double>());
  EXPECT_LE(object.at("deviation").at("certified").get<double>(), 0.01 * (1 + 1e-9));
  EXPECT_EQ(object.at("held_max_move").get<double>(), 0);
  EXPECT_TRUE(object.at("gap").is_null()) << "not convex: nothing is proven";
  for (const char* figure : {"plate", "curvature_variation", "isophote_roughness"}) {
    EXPECT_LT(object.at("fairness").at("after").at(figure).get<double>(),
              object.at("fairness").at("before").at(figure).get<double>())
        << figure;
  }
  json({"fair", path("in.g2"), "-o", path("same.g2"), "--tolerance", "0.01", "--energy", "beltrami"});
  EXPECT_EQ(text("same.g2"), text("out.g2"));
}

TEST_F(DataDependent, ToleranceOnPointsBoundsTheMoves) {
  const Surface input = wavySurface(3, 20, 16);
  write("in.g2", g2(input));
  json({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01", "--energy", "data-dependent",
        "--tolerance-kind", "points"});
  const double move = (readSurface(file("out.g2")).net() - input.net()).rowwise().norm().maxCoeff();
  EXPECT_LE(move, 0.01 * (1 + 1e-12));
  EXPECT_GT(move, 0.005);
}

TEST_F(DataDependent, RefusesWhatBelongsToOtherEnergies) {
  write("in.g2", g2(wavySurface(3, 14, 14)));
  for (const auto& [option, value] : {std::pair{"--join", "g2"},
                                      {"--join", "g1"},
                                      {"--gap", "1e-4"},
                                      {"--parameter-scale", "unit"},
                                      {"--method", "local"},
                                      {"--curvature-extrema", "3"}}) {
    const Outcome outcome = strak({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01", "--energy",
                                   "data-dependent", option, value});
    EXPECT_EQ(outcome.code, 2) << option;
    EXPECT_NE(outcome.err.find(option), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("--energy"), std::string::npos) << outcome.err;
  }
  EXPECT_EQ(files(), std::vector<std::string>{"in.g2"});
}

TEST_F(DataDependent, RationalSurfacesKeepTheirWeights) {
  const Surface plain = wavySurface(3, 16, 14);
  Net net(plain.net().rows(), 4);
  for (Index r = 0; r < net.rows(); ++r) {
    const double weight = 1 + 0.3 * std::sin(0.1 * static_cast<double>(r));
    net.row(r) << weight * plain.net().row(r), weight;
  }
  write("in.g2", g2(Surface(plain.knots(), net, true)));
  const auto object = json(
      {"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01", "--energy", "data-dependent"})["objects"][0];
  EXPECT_LT(object.at("plate").at("after").get<double>(), object.at("plate").at("before").get<double>());
  EXPECT_LE(object.at("deviation").at("certified").get<double>(), 0.01 * (1 + 1e-9));
  const Surface after = readSurface(file("out.g2"));
  ASSERT_TRUE(after.isRational());
  EXPECT_LT((after.net().col(3) - net.col(3)).cwiseAbs().maxCoeff(), 1e-15);
}

#ifdef STRAK_WITH_CAD

TEST_F(DataDependent, FacesOfCadFilesAreFairedOneByOne) {
  write("in.g2", g2(wavySurface(3, 16, 14)) + g2(wavySurface(4, 14, 14)));
  ASSERT_EQ(strak({"convert", path("in.g2"), "-o", path("in.step")}).code, 0);
  const auto result =
      json({"fair", path("in.step"), "-o", path("out.step"), "--tolerance", "0.01", "--energy", "data-dependent"});
  EXPECT_TRUE(result.at("audit").at("after").at("valid").get<bool>());
  ASSERT_EQ(result.at("objects").size(), 2U);
  for (const auto& object : result.at("objects")) {
    EXPECT_EQ(object.at("energy").at("name"), "data-dependent");
    EXPECT_LT(object.at("plate").at("after").get<double>(), object.at("plate").at("before").get<double>());
    EXPECT_LE(object.at("deviation").at("certified").get<double>(), 0.01 * (1 + 1e-9));
  }
  EXPECT_FALSE(json({"compare", path("in.step"), path("out.step")}).at("identical").get<bool>());
}

#endif

TEST_F(DataDependent, CurvesAreLeftAlone) {
  write("curve.g2", g2(wavyCurve(3, 20)));
  const Outcome outcome =
      strak({"fair", path("curve.g2"), "-o", path("out.g2"), "--tolerance", "0.01", "--energy", "data-dependent"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("surfaces"), std::string::npos) << outcome.err;
}

TEST_F(DataDependent, IsAnEnergyOfFits) {
  std::string points;
  for (int i = 0; i <= 30; ++i) {
    for (int j = 0; j <= 30; ++j) {
      const double x = i / 10.0, y = j / 10.0;
      points += fmt::format("{} {} {}\n", x, y, std::sin(x) * std::cos(y) + 0.01 * ((i * 7 + j * 13) % 5 - 2));
    }
  }
  write("points.xyz", points);
  for (const char* energy : {"data-dependent", "data-dependent-plate"}) {
    for (const char* kind : {"function", "surface"}) {
      const auto object = json({"fit", path("points.xyz"), "-o", path("out.g2"), "--size", "12", "--energy", energy,
                                "--kind", kind})["objects"][0];
      EXPECT_EQ(object["energy"]["name"], energy);
      EXPECT_TRUE(object["following"]["settled"]) << energy << ' ' << kind;
      EXPECT_GT(object["smoothing"]["lambda"].get<double>(), 0);
      EXPECT_LT(object["rms"].get<double>(), 0.016);
    }
  }
  // A hole, and points of weight zero in it, which are none.
  std::string holed = "x y z weight\n", empty = holed;
  for (int i = 0; i <= 30; ++i) {
    for (int j = 0; j <= 30; ++j) {
      const double x = i / 10.0, y = j / 10.0;
      const bool hole = std::hypot(x - 1.4, y - 1.6) < 0.5;
      const std::string at = fmt::format("{} {} ", x, y);
      const std::string z = fmt::format("{}", std::sin(x) * std::cos(y) + 0.01 * ((i * 7 + j * 13) % 5 - 2));
      holed += at + (hole ? "7 0\n" : z + " 1\n");
      if (!hole) empty += at + z + " 1\n";
    }
  }
  write("holed.txt", holed);
  write("empty.txt", empty);
  for (const char* energy : {"data-dependent", "data-dependent-plate"}) {
    const auto fitted = [&](const char* name) {
      json({"fit", path(name), "-o", path("out.g2"), "--size", "12", "--energy", energy, "--kind", "function"});
      return readSurface(file("out.g2"));
    };
    const Surface with = fitted("holed.txt"), without = fitted("empty.txt");
    EXPECT_LT((with.net() - without.net()).cwiseAbs().maxCoeff(), 1e-6) << energy;
    EXPECT_NEAR(evaluate<2>(without, {1.4, 1.6})[2], std::sin(1.4) * std::cos(1.6), 0.02) << energy;
  }
  const auto within = json({"fit", path("points.xyz"), "-o", path("out.g2"), "--tolerance", "0.05", "--energy",
                            "data-dependent"})["objects"][0];
  EXPECT_TRUE(within["tolerance"]["reached"]);
  EXPECT_EQ(within["energy"]["name"], "data-dependent");
  write("curve.txt", "0 0\n1 1\n2 0\n3 1\n4 4\n5 5\n");
  const Outcome outcome = strak({"fit", path("curve.txt"), "-o", path("no.g2"), "--energy", "data-dependent"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("surfaces"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace strak::test
