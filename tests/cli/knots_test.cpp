// strak fair --simplify and --smooth-knots, strak convert --rebuild.

#include <algorithm>
#include <cmath>

#include "strak/metrology/deviation.h"
#include "strak/spline/bezier.h"
#include "strak/spline/knot_insertion.h"
#include "tests/cli/program.h"

namespace strak::test {
namespace {

class Knots : public Program {};

TEST_F(Knots, SimplifyTakesOutWhatIsNotNeeded) {
  const Surface coarse = wavySurface(3, 9, 8, 0);
  const Surface input = insertKnots(insertKnots(coarse, 0, {0.11, 0.31, 0.47, 0.58}), 1, {0.33, 1.11, 1.71});
  write("in.g2", g2(input));
  const auto result = json(
      {"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.001", "--energy", "thin-plate", "--simplify"});
  const auto& object = result.at("objects").at(0);
  const Surface output = readSurface(file("out.g2"));
  const int removed = object.at("simplified").at("knotsRemoved").get<int>();
  EXPECT_GE(removed, 7);
  EXPECT_EQ(removed, input.size(0) + input.size(1) - output.size(0) - output.size(1));
  EXPECT_EQ(object.at("simplified").at("pointsBefore"), 13 * 11);
  EXPECT_EQ(object.at("simplified").at("pointsAfter"), output.net().rows());
  EXPECT_EQ(object.at("points"), (nlohmann::json{output.size(0), output.size(1)}));
  EXPECT_LE(object.at("deviation").at("certified").get<double>(), 0.001);
  EXPECT_LE(certifyDeviation(input, output).upper, 0.001);
}

TEST_F(Knots, BordersMayBeSimplifiedToo) {
  Surface input = wavySurface(3, 24, 20, 0.005);
  for (Index i = 1; i < 24; i += 2) input.net()(input.row({i, 0}), 2) += 0.005;
  for (Index j = 1; j < 20; j += 2) input.net()(input.row({0, j}), 2) += 0.005;
  write("in.g2", g2(input));
  const std::vector<std::string> common{"fair", path("in.g2"), "-o",         path("out.g2"), "--tolerance",
                                        "0.05", "--energy",    "thin-plate", "--hold",       "g1"};
  auto exact = common, near = common;
  exact.emplace_back("--simplify");
  near.emplace_back("--simplify-borders");
  // The noisy borders need every knot; without them few are left.
  EXPECT_EQ(json(exact).at("objects").at(0).at("simplified").at("knotsRemoved"), 0);
  const auto result = json(near).at("objects").at(0);
  EXPECT_GT(result.at("simplified").at("knotsRemoved").get<int>(), 5);
  EXPECT_LE(certifyDeviation(input, readSurface(file("out.g2"))).upper, 0.05);
}

TEST_F(Knots, SmoothKnotsMakesBezierPiecesOneSurface) {
  Surface input = bezierForm(wavySurface(3, 8, 7, 0));
  const Index row = input.row({3, 5});
  input.net()(row, 2) += 2e-4;  // a crease too small to be meant
  write("in.g2", g2(input));
  const std::vector<std::string> common{"fair", path("in.g2"), "-o",         path("out.g2"), "--tolerance",
                                        "0.01", "--energy",    "thin-plate", "--hold",       "1"};
  auto smooth = common;
  smooth.emplace_back("--smooth-knots");
  const auto result = json(smooth).at("objects").at(0);
  const auto lines = result.at("smoothed_knots");
  EXPECT_EQ(lines.at("kept"), 0);
  EXPECT_EQ(lines.at("smoothed"), input.knots(0).innerKnots().size() + input.knots(1).innerKnots().size());
  EXPECT_LE(lines.at("deviation").get<double>(), 0.005);
  const Surface output = readSurface(file("out.g2"));
  for (int k : {0, 1}) {
    for (const auto& knot : output.knots(k).innerKnots()) EXPECT_EQ(knot.multiplicity, 1);
  }
  EXPECT_LE(certifyDeviation(input, output).upper, 0.01);
  EXPECT_NE(result.at("notes").dump().find("made smooth"), std::string::npos);
  // With the angle at zero that crease stays.
  smooth.insert(smooth.end(), {"--crease-angle", "0"});
  EXPECT_GT(json(smooth).at("objects").at(0).at("smoothed_knots").at("kept").get<int>(), 0);
}

TEST_F(Knots, WrongOptionsAreRefused) {
  write("in.g2", g2(wavySurface(3, 8, 8)));
  const auto refused = [&](std::vector<std::string> options, const std::string& word) {
    std::vector<std::string> all{"fair", path("in.g2"), "-o", path("out.g2")};
    all.insert(all.end(), options.begin(), options.end());
    const Outcome outcome = strak(all);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
  };
  refused({"--simplify"}, "--tolerance");
  refused({"--smooth-knots"}, "--tolerance");
  refused({"--smooth-knots", "--tolerance", "1", "--crease-angle", "-3"}, "--crease-angle");
}

TEST_F(Knots, RebuildGivesTheDegreeAndTheSpansAskedFor) {
  const Surface input = wavySurface(3, 20, 16, 0);
  write("in.g2", g2(input));
  const auto result = json({"convert", path("in.g2"), "-o", path("out.g2"), "--rebuild", "6,5,1,2"});
  const Surface output = readSurface(file("out.g2"));
  EXPECT_EQ(output.degree(0), 6);
  EXPECT_EQ(output.degree(1), 5);
  EXPECT_EQ(output.size(0), 7);
  EXPECT_EQ(output.size(1), 7);
  const auto& deviation = result.at("objects").at(0).at("deviation");
  EXPECT_NEAR(deviation.at("certified").get<double>(), certifyDeviation(input, output).upper, 1e-12);
  EXPECT_LE(deviation.at("lower").get<double>(), deviation.at("certified").get<double>());
  const Outcome text = strak({"convert", path("in.g2"), "-o", path("out.g2"), "--rebuild", "5,3"});
  EXPECT_NE(text.out.find("certified deviation at most"), std::string::npos) << text.out;
}

TEST_F(Knots, RebuildRefusesAboveTheTolerance) {
  write("in.g2", g2(wavySurface(3, 20, 16)));
  const Outcome outcome =
      strak({"convert", path("in.g2"), "-o", path("out.g2"), "--rebuild", "3,1", "--tolerance", "1e-6"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("above the tolerance"), std::string::npos) << outcome.err;
  const auto written = files();
  EXPECT_EQ(std::count(written.begin(), written.end(), "out.g2"), 0);
  for (const char* wish : {"5", "5,1,2", "x,1", "0,1", "16,1", "5,0", "5,1,1,1,1,1"}) {
    EXPECT_EQ(strak({"convert", path("in.g2"), "-o", path("out.g2"), "--rebuild", wish}).code, 2) << wish;
  }
  EXPECT_EQ(strak({"convert", path("in.g2"), "-o", path("out.g2"), "--tolerance", "1"}).code, 2);
}

#ifdef STRAK_WITH_CAD
TEST_F(Knots, CadFacesTakeFewerKnotsInPlace) {
  const Surface coarse = wavySurface(3, 9, 8, 0);
  write("in.g2", g2(insertKnots(insertKnots(coarse, 0, {0.11, 0.31, 0.58}), 1, {0.33, 1.71})));
  for (const char* ending : {"step", "igs", "brep"}) {
    const std::string input = path(std::string("in.") + ending), output = path(std::string("out.") + ending);
    ASSERT_EQ(strak({"convert", path("in.g2"), "-o", input}).code, 0);
    const auto result =
        json({"fair", input, "-o", output, "--tolerance", "0.001", "--energy", "thin-plate", "--simplify"});
    const auto& object = result.at("objects").at(0);
    const int removed = object.at("simplified").at("knotsRemoved").get<int>();
    EXPECT_GE(removed, 5) << ending;
    const auto written = json({"info", output}).at("objects").at(0).at("points");
    EXPECT_EQ(written, object.at("points")) << ending;
    EXPECT_EQ(written.at(0).get<int>() + written.at(1).get<int>(), 9 + 8 + 5 - removed) << ending;
    EXPECT_LE(json({"compare", input, output}).at("largest_deviation").get<double>(), 0.001) << ending;
    EXPECT_TRUE(result.at("audit").at("after").at("valid").get<bool>()) << ending;
    EXPECT_LE(result.at("audit").at("after").at("largest_gap").get<double>(),
              result.at("audit").at("before").at("largest_gap").get<double>() + 1e-9)
        << ending;
  }
}

// A knot line that is only C1, across the border too: it can go only if the border moves.
TEST_F(Knots, CadFacesGetSmoothWhereTheirBordersMay) {
  Surface input = insertKnots(wavySurface(3, 9, 8, 0.0), 0, {0.5, 0.5});
  const Index s = input.knots(0).findSpan(0.5);
  for (Index j = 0; j < input.size(1); ++j) input.net()(input.row({s - 1, j}), 2) += 2e-4;
  write("in.g2", g2(input));
  for (const char* ending : {"step", "igs"}) {
    const std::string given = path(std::string("in.") + ending), output = path(std::string("out.") + ending);
    ASSERT_EQ(strak({"convert", path("in.g2"), "-o", given}).code, 0);
    const auto result = json({"fair", given, "-o", output, "--tolerance", "0.01", "--smooth-knots", "--hold", "g1"});
    const auto& object = result.at("objects").at(0);
    EXPECT_GE(object.at("smoothed_knots").at("smoothed"), 1) << ending << object.dump(1);
    EXPECT_EQ(object.at("smoothed_knots").at("kept"), 0) << ending;
    EXPECT_EQ(json({"info", output}).at("objects").at(0).at("continuity"), 2) << ending;
    EXPECT_LE(json({"compare", given, output}).at("largest_deviation").get<double>(), 0.01) << ending;
    const auto& audit = result.at("audit");
    EXPECT_TRUE(audit.at("after").at("valid").get<bool>()) << ending;
    EXPECT_LE(audit.at("after").at("largest_gap").get<double>(),
              audit.at("before").at("largest_gap").get<double>() + 1e-9)
        << ending;
    const auto& fairness = object.at("fairness");
    EXPECT_LT(fairness.at("after").at("plate"), 1.002 * fairness.at("before").at("plate").get<double>());
  }
}

// Two such faces, mirrored at a border that they share: it moves with both.
TEST_F(Knots, CadFacesGetSmoothTogether) {
  Surface one = insertKnots(wavySurface(3, 9, 8, 0.0), 0, {0.5, 0.5});
  const Index s = one.knots(0).findSpan(0.5), last = one.size(1) - 1;
  for (Index j = 0; j <= last; ++j) one.net()(one.row({s - 1, j}), 2) += 2e-4;
  Surface other = one;
  const double border = one.net()(one.row({0, last}), 1);
  for (Index i = 0; i < one.size(0); ++i) {
    for (Index j = 0; j <= last; ++j) {
      other.net().row(other.row({i, j})) = one.net().row(one.row({i, last - j}));
      other.net()(other.row({i, j}), 1) = 2 * border - one.net()(one.row({i, last - j}), 1);
    }
  }
  write("in.g2", g2(one) + g2(other));
  ASSERT_EQ(strak({"convert", path("in.g2"), "-o", path("in.igs")}).code, 0);
  const auto result =
      json({"fair", path("in.igs"), "-o", path("out.igs"), "--tolerance", "0.01", "--smooth-knots", "--hold", "g1"});
  for (const auto& object : result.at("objects")) {
    EXPECT_EQ(object.at("smoothed_knots").at("smoothed"), 1) << object.dump(1);
    EXPECT_EQ(object.at("smoothed_knots").at("kept"), 0);
  }
  ASSERT_EQ(result.at("joins").size(), 1);
  EXPECT_LE(result.at("joins").at(0).at("gap").at("after").get<double>(), 1e-8);
  EXPECT_TRUE(result.at("audit").at("after").at("valid").get<bool>());
}
#endif

}  // namespace
}  // namespace strak::test
