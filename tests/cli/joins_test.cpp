// What info and fair say about the edges where faces meet.

#include <cmath>

#include "strak/spline/periodic.h"
#include "strak/spline/reparametrize.h"
#include "tests/cli/program.h"

namespace strak::test {
namespace {

class Joins : public Program {
 protected:
  // One surface cut into two along u, the second one perhaps lifted at its far end: a kink at the cut.
  std::string twoHalves(double lift) const {
    const Surface whole = wavySurface(3, 12, 10);
    const Surface left = subPatch(whole, 0, 0, 0.5);
    Surface right = subPatch(whole, 0, 0.5, 1);
    for (Index i = 1; i < right.size(0); ++i) {
      for (Index j = 0; j < right.size(1); ++j) right.net()(right.row({i, j}), 2) += lift * static_cast<double>(i);
    }
    return write("halves.g2", g2(left) + g2(right));
  }
};

// Three patches, two short ones beside a long one, each with noise of its own.
std::string threePatches() {
  const Surface sheet = wavySurface(3, 14, 16, 0);
  const Surface right = subPatch(sheet, 0, 0.5, 1);
  std::string text;
  std::uint32_t state = 12345;
  for (Surface patch : {subPatch(sheet, 0, 0, 0.5), subPatch(right, 1, 0, 0.7), subPatch(right, 1, 0.7, 2)}) {
    for (Index i = 1; i + 1 < patch.size(0); ++i) {
      for (Index j = 1; j + 1 < patch.size(1); ++j) {
        const bool atJoin = i == 1 || i + 2 == patch.size(0) || j == 1 || j + 2 == patch.size(1);
        state = 1664525 * state + 1013904223;
        patch.net()(patch.row({i, j}), 2) += (atJoin ? 0.002 : 0.01) * (static_cast<double>(state) / 2147483648.0 - 1);
      }
    }
    text += g2(patch);
  }
  return text;
}

TEST_F(Joins, ShortSidesMoveWithTheLongOne) {
  const std::string input = write("three.g2", threePatches());
  std::vector<std::string> inputs{input};
#ifdef STRAK_WITH_CAD
  EXPECT_EQ(strak({"convert", input, "-o", path("three.step")}).code, 0);
  inputs.push_back(path("three.step"));
#endif
  for (const std::string& in : inputs) {
    const std::string out = path("out" + in.substr(in.rfind('.')));
    const auto result = json({"fair", in, "-o", out, "--tolerance", "0.02", "--hold", "1", "--join", "g2"});
    ASSERT_EQ(result.at("joins").size(), 3U);
    for (std::size_t j = 0; j < 3; ++j) {
      const auto& join = result.at("joins")[j];
      EXPECT_LT(join.at("gap").at("after").get<double>(), 1e-11);
      EXPECT_LT(join.at("angle").at("after").get<double>(), 0.5 * join.at("angle").at("before").get<double>());
    }
    for (const auto& object : result.at("objects")) {
      EXPECT_EQ(object.at("notes").back(), "faired as one with 2 neighbours");
      EXPECT_LE(object.at("deviation").at("certified").get<double>(), 0.02 * (1 + 1e-9));
    }
    EXPECT_TRUE(result.at("audit").at("after").at("valid").get<bool>());
    EXPECT_EQ(strak({"info", out}).code, 0);
  }
}

TEST_F(Joins, HalvesMoveInTheirPlaneOfSymmetry) {
  Surface half = wavySurface(3, 10, 12, 0.01);
  for (Index j = 0; j < half.size(1); ++j) {
    half.net()(half.row({0, j}), 0) = 0;
    half.net().row(half.row({1, j})) = half.net().row(half.row({0, j})) + 0.5 * Eigen::RowVector3d::UnitX();
    if (j > 2 && j + 3 < half.size(1)) {
      for (Index i : {0, 1}) half.net()(half.row({i, j}), 2) += j % 2 == 0 ? 0.005 : -0.005;
    }
  }
  const std::string input = write("half.g2", g2(half));
  const auto result =
      json({"fair", input, "-o", path("out.g2"), "--tolerance", "0.02", "--join", "g2", "--symmetry", "x"});
  EXPECT_NE(result.at("objects")[0].at("notes").back().get<std::string>().find("mirror image across u low"),
            std::string::npos);
  const Surface after = readSurface(path("out.g2"));
  double moved = 0;
  for (Index j = 0; j < after.size(1); ++j) EXPECT_EQ(after.net()(after.row({0, j}), 0), 0);
  ASSERT_EQ(after.size(1), half.size(1));
  for (Index j = 0; j < after.size(1); ++j) {
    moved = std::max(moved, std::abs(after.net()(after.row({0, j}), 2) - half.net()(half.row({0, j}), 2)));
  }
  EXPECT_GT(moved, 1e-3);
  // Another axis: nothing lies in such a plane.
  const auto other =
      json({"fair", input, "-o", path("out.g2"), "--tolerance", "0.02", "--join", "g2", "--symmetry", "z"});
  EXPECT_EQ(other.dump().find("mirror"), std::string::npos);
  EXPECT_EQ(strak({"fair", input, "-o", path("out.g2"), "--symmetry", "x"}).code, 2);
  EXPECT_EQ(strak({"fair", input, "-o", path("out.g2"), "--join", "g2", "--symmetry", "w"}).code, 2);
}

#ifdef STRAK_WITH_CAD
TEST_F(Joins, ClosedFacesMoveAcrossTheirSeam) {
  // A period of 12 points, knots that go on; noise between the ends.
  const KnotVector v = KnotVector::uniformClamped(3, 6);
  const Index n = 12, m = v.size();
  Net net((n + 3) * m, 3);
  for (Index i = 0; i < n + 3; ++i) {
    for (Index j = 0; j < m; ++j) {
      const double angle = 2 * M_PI * static_cast<double>(i % n) / static_cast<double>(n);
      const double r = j > 2 && j + 3 < m ? 1 + 0.002 * std::sin(37.0 * static_cast<double>(i % n * m + j)) : 1;
      net.row(i * m + j) << r * std::cos(angle), r * std::sin(angle), static_cast<double>(j);
    }
  }
  std::vector<double> knots;
  for (Index i = 0; i < n + 7; ++i) knots.push_back(static_cast<double>(i));
  const Surface tube = toClamped(Surface({KnotVector(3, knots), v}, net), 0);
  EXPECT_EQ(strak({"convert", write("tube.g2", g2(tube)), "-o", path("tube.step")}).code, 0);
  const auto result = json({"fair", path("tube.step"), "-o", path("out.step"), "--tolerance", "0.02", "--join", "g2"});
  ASSERT_EQ(result.at("joins").size(), 1U);
  EXPECT_LT(result.at("joins")[0].at("gap").at("after").get<double>(), 1e-12);
  EXPECT_EQ(result.at("objects")[0].at("notes").back(), "faired as one across its seam");
  EXPECT_EQ(strak({"convert", path("out.step"), "-o", path("out.g2")}).code, 0);
  EXPECT_EQ(seamSmoothness(readSurface(path("out.g2")), 0), 2);
  EXPECT_TRUE(result.at("audit").at("after").at("valid").get<bool>());
}
#endif

TEST_F(Joins, InfoCountsThemByKind) {
  const Outcome smooth = strak({"info", twoHalves(0)});
  EXPECT_EQ(smooth.code, 0);
  EXPECT_NE(smooth.out.find("1 join: 1 G2;"), std::string::npos) << smooth.out;
  const Outcome kinked = strak({"info", twoHalves(0.002)});
  EXPECT_NE(kinked.out.find("1 join: 1 G0;"), std::string::npos) << kinked.out;
  EXPECT_NE(strak({"info", twoHalves(1)}).out.find("1 feature"), std::string::npos);
  write("one.g2", g2(wavySurface(3, 12, 10)));
  EXPECT_EQ(strak({"info", path("one.g2")}).out.find("join"), std::string::npos);
  const auto joins = json({"info", twoHalves(0.002)}).at("joins");
  ASSERT_EQ(joins.size(), 1U);
  EXPECT_EQ(joins[0].at("faces"), nlohmann::json({1, 2}));
  EXPECT_GT(joins[0].at("angle").get<double>(), 0.1);
  EXPECT_LT(joins[0].at("gap").get<double>(), 1e-12);
}

TEST_F(Joins, FairReportsThemBeforeAndAfter) {
  const std::string input = twoHalves(0.002);
  const auto joins = json({"fair", input, "-o", path("out.g2"), "--tolerance", "0.01"}).at("joins");
  ASSERT_EQ(joins.size(), 1U);
  const auto before = json({"info", input}).at("joins"), after = json({"info", path("out.g2")}).at("joins");
  for (const char* key : {"gap", "angle", "curvature"}) {
    EXPECT_EQ(joins[0].at(key).at("before"), before[0].at(key)) << key;
    EXPECT_NEAR(joins[0].at(key).at("after").get<double>(), after[0].at(key).get<double>(), 1e-9) << key;
  }
  const Outcome text = strak({"fair", input, "-o", path("out.g2"), "--tolerance", "0.01"});
  EXPECT_NE(text.out.find("1 join: largest angle"), std::string::npos) << text.out;
}

}  // namespace
}  // namespace strak::test
