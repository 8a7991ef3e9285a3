// strak fit --start, --hold and --conditions, points of every kind, and points that are packed.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "strak/metrology/closest_point.h"
#include "strak/spline/evaluate.h"
#include "tests/cli/program.h"

namespace strak::test {
namespace {

class FitStart : public Program {
 protected:
  // A wavy function over [0, 1] x [0, 2] with errors, as "x,y,z" or with parameters as "u v x y z".
  std::string points(bool inSpace) const {
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0, 0.01);
    std::string text = inSpace ? "u v x y z\n" : "x,y,z\n";
    for (int i = 0; i <= 30; ++i) {
      for (int j = 0; j <= 40; ++j) {
        const double x = i / 30.0, y = j / 20.0,
                     z = 1 + x * y + 0.2 * std::sin(5 * x) * std::sin(3 * y) + noise(random);
        text += inSpace ? fmt::format("{} {} {} {} {}\n", x, y, x, z, y) : fmt::format("{},{},{}\n", x, y, z);
      }
    }
    return text;
  }
};

// Rows of the border equal to the bit, others not.
void expectHeld(const Surface& start, const Surface& fitted, Index rows) {
  ASSERT_EQ(start.knots(), fitted.knots());
  const Index nu = start.size(0), nv = start.size(1);
  Index moved = 0;
  for (Index i = 0; i < nu; ++i) {
    for (Index j = 0; j < nv; ++j) {
      const bool held = std::min({i, j, nu - 1 - i, nv - 1 - j}) < rows;
      const bool same = start.net().row(i * nv + j) == fitted.net().row(i * nv + j);
      if (held) {
        EXPECT_TRUE(same) << i << " " << j;
      }
      moved += same ? 0 : 1;
    }
  }
  EXPECT_EQ(moved, (nu - 2 * rows) * (nv - 2 * rows));
}

TEST_F(FitStart, BordersOfFunctionsStayToTheBit) {
  write("in.csv", points(false));
  const auto stiff = json({"fit", path("in.csv"), "-o", path("start.g2"), "--size", "11x13", "--smoothing", "1"});
  for (const char* hold : {"g0", "2"}) {
    const auto result =
        json({"fit", path("in.csv"), "-o", path("out.g2"), "--start", path("start.g2"), "--hold", hold});
    expectHeld(readSurface(file("start.g2")), readSurface(file("out.g2")), *hold == 'g' ? 1 : 2);
    EXPECT_LT(result["objects"][0]["rms"], 0.7 * stiff["objects"][0]["rms"].get<double>());
  }
}

TEST_F(FitStart, BordersInSpaceStayToTheBit) {
  write("in.txt", points(true));
  json({"fit", path("in.txt"), "-o", path("start.g2"), "--size", "10x9", "--smoothing", "1"});
  json({"fit", path("in.txt"), "-o", path("out.g2"), "--start", path("start.g2"), "--hold", "g1"});
  expectHeld(readSurface(file("start.g2")), readSurface(file("out.g2")), 2);
  // Without parameters the points get those of their closest points on the start, and these are corrected.
  std::string bare;
  const Surface surface = readSurface(file("out.g2"));
  for (int i = 0; i <= 900; ++i) {
    const Point at = evaluate(surface, {i % 31 / 30.0, i / 31 / 15.0});
    bare += fmt::format("{} {} {}\n", at[0], at[1], at[2]);
  }
  write("bare.xyz", bare);
  const auto again = json({"fit", path("bare.xyz"), "-o", path("again.g2"), "--kind", "surface", "--start",
                           path("start.g2"), "--hold", "2", "--correct", "40", "--smoothing", "1e-9"});
  EXPECT_LT(again["objects"][0]["rms"], 0.8 * again["objects"][0]["correction"]["rms"][0].get<double>());
  EXPECT_GE(again["objects"][0]["correction"]["rounds"], 1);
  expectHeld(readSurface(file("start.g2")), readSurface(file("again.g2")), 2);
}

TEST_F(FitStart, EndsOfCurvesStayToTheBit) {
  std::string text = "t x y\n";
  for (int i = 0; i <= 100; ++i) {
    const double t = i / 100.0;
    text += fmt::format("{} {} {}\n", t, std::cos(3 * t), std::sin(3 * t) + 0.01 * std::sin(50 * t));
  }
  write("in.txt", text);
  json({"fit", path("in.txt"), "-o", path("start.g2"), "--kind", "curve", "--size", "9", "--smoothing", "1e-3"});
  json({"fit", path("in.txt"), "-o", path("out.g2"), "--kind", "curve", "--start", path("start.g2"), "--hold", "2,1"});
  const auto read = [&](const char* name) { return std::get<Curve>(*readModel(file(name))->objects()[0].spline); };
  const Curve start = read("start.g2"), fitted = read("out.g2");
  ASSERT_EQ(start.knots(), fitted.knots());
  for (Index i = 0; i < 9; ++i) {
    EXPECT_EQ(start.net().row(i) == fitted.net().row(i), i < 2 || i == 8) << i;
  }
}

TEST_F(FitStart, StartsThatDoNotFitAreRefused) {
  write("in.csv", points(false));
  write("in.txt", points(true));
  json({"fit", path("in.csv"), "-o", path("f.g2"), "--size", "8"});
  json({"fit", path("in.txt"), "-o", path("s.g2"), "--size", "8"});
  write("c.g2", g2(wavyCurve(3, 9)));
  const auto with = [&](const char* start, std::vector<std::string> more = {}) {
    std::vector<std::string> all{"fit", path("in.csv"), "-o", path("out.g2"), "--start", path(start)};
    all.insert(all.end(), more.begin(), more.end());
    return refusal(all);
  };
  EXPECT_NE(with("s.g2").find("no graph"), std::string::npos);
  EXPECT_NE(with("c.g2").find("no B-spline surface"), std::string::npos);
  EXPECT_NE(with("f.g2", {"--hold", "4"}).find("leaves no control point"), std::string::npos);
  EXPECT_NE(with("f.g2", {"--tolerance", "0.1"}).find("--tolerance"), std::string::npos);
  with("f.g2", {"--size", "9"});
  with("none.g2");
  refusal({"fit", path("in.csv"), "-o", path("out.g2"), "--hold", "1"});
}

TEST_F(FitStart, ConditionsHoldForEveryKindAndStreamed) {
  write("in.csv", points(false));
  write("in.txt", points(true));
  write("through.csv", "x,y,z\n0.5,1,1.6\n0,0,1.1\n");
  write("through.txt", "u v x y z\n0.3 1.2 0.31 1.4 1.19\n");
  for (const char* memory : {"512", "0"}) {
    for (const auto& more : {std::vector<std::string>{}, {"--loss", "huber"}, {"--smoothing", "reml"}}) {
      if (*memory == '0' && !more.empty() && more[0] == "--loss") continue;
      std::vector<std::string> all{"fit",          path("in.csv"),      "-o",       path("out.g2"),
                                   "--conditions", path("through.csv"), "--memory", memory};
      all.insert(all.end(), more.begin(), more.end());
      EXPECT_EQ(json(all)["objects"][0]["kind"], "function");
      const Surface f = readSurface(file("out.g2"));
      EXPECT_NEAR(evaluate<2>(f, {0.5, 1})[2], 1.6, 1e-12);
      EXPECT_NEAR(evaluate<2>(f, {0, 0})[2], 1.1, 1e-12);
    }
    json({"fit", path("in.txt"), "-o", path("s.g2"), "--conditions", path("through.txt"), "--memory", memory});
    EXPECT_LT((evaluate<2>(readSurface(file("s.g2")), {0.3, 1.2}) - Point(Eigen::RowVector3d(0.31, 1.4, 1.19))).norm(),
              1e-12);
  }
  write("curve.txt", "t x y\n0 0 0\n0.2 1 1\n0.4 2 0\n0.6 3 1\n0.8 4 0\n1 5 1\n");
  write("at.txt", "t x y\n0.5 2.5 0.7\n");
  json(
      {"fit", path("curve.txt"), "-o", path("c.g2"), "--kind", "curve", "--conditions", path("at.txt"), "--size", "5"});
  const Curve curve = std::get<Curve>(*readModel(file("c.g2"))->objects()[0].spline);
  EXPECT_NEAR(evaluate<1>(curve, {0.5})[0], 2.5, 1e-12);
  EXPECT_NEAR(evaluate<1>(curve, {0.5})[1], 0.7, 1e-12);
}

// Conditions without parameters: the fit passes through them wherever they lie on it.
TEST_F(FitStart, ConditionsWithoutParametersHoldToo) {
  std::string cloud, curve;
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 900; ++i) {
    const double a = 1.2 * unit(random), y = unit(random);
    cloud += fmt::format("{} {} {}\n", std::sin(a), y, std::cos(a) + 0.003 * unit(random));
    curve += fmt::format("{} {}\n", std::cos(0.005 * i), std::sin(0.005 * i) + 0.003 * unit(random));
  }
  write("cloud.xyz", cloud);
  write("curve.txt", curve);
  write("on.xyz", fmt::format("{} 0.3 {}\n{} -0.8 {}\n", std::sin(0.4), std::cos(0.4) + 0.01, std::sin(-1.0),
                              std::cos(-1.0) - 0.005));
  write("on.txt", fmt::format("{} {}\n1 0\n", 1.01 * std::cos(2), 1.01 * std::sin(2)));
  const auto check = [&](const nlohmann::json& result, Index count) {
    const auto& conditions = result.at("objects").at(0).at("conditions");
    EXPECT_EQ(conditions.at("count"), count);
    EXPECT_GT(conditions.at("largest_before").get<double>(), 1e-4);
    EXPECT_LT(conditions.at("largest").get<double>(), 1e-9);
  };
  for (const auto& more : {std::vector<std::string>{},
                           {"--loss", "tukey"},
                           {"--tolerance", "0.01"},
                           {"--energy", "data-dependent-plate"}}) {
    std::vector<std::string> all{"fit", path("cloud.xyz"), "-o", path("s.g2"), "--kind", "surface", "--size", "9"};
    if (!more.empty() && more[0] == "--tolerance") all.resize(6);
    all.insert(all.end(), {"--conditions", path("on.xyz")});
    all.insert(all.end(), more.begin(), more.end());
    check(json(all), 2);
    const Surface surface = readSurface(file("s.g2"));
    for (const auto& [a, y, lift] : {std::tuple{0.4, 0.3, 0.01}, {-1.0, -0.8, -0.005}}) {
      const Point at = Eigen::RowVector3d(std::sin(a), y, std::cos(a) + lift);
      EXPECT_LT(closestPoint<2>(surface, at).distance, 1e-9);
    }
  }
  check(json({"fit", path("curve.txt"), "-o", path("c.g2"), "--conditions", path("on.txt"), "--size", "12"}), 2);
  // Points that have parameters may have conditions without.
  write("in.txt", points(true));
  write("through.txt", "0.31 1.4 1.19\n");
  check(json({"fit", path("in.txt"), "-o", path("s.g2"), "--conditions", path("through.txt"), "--memory", "0"}), 1);
  write("far.xyz", "0 0 0\n");
  EXPECT_NE(
      refusal({"fit", path("cloud.xyz"), "-o", path("s.g2"), "--kind", "surface", "--conditions", path("far.xyz")})
          .find("another shape"),
      std::string::npos);
  write("t.txt", "t x y\n0.5 1 0\n");
  refusal({"fit", path("curve.txt"), "-o", path("c.g2"), "--conditions", path("t.txt")});
}

// A gzip file of stored blocks, by the format's description (RFC 1952).
std::string gzip(const std::string& content) {
  const auto little = [](std::uint32_t value, int bytes) {
    std::string result;
    for (int i = 0; i < bytes; ++i) result += static_cast<char>(value >> (8 * i) & 0xff);
    return result;
  };
  std::string text = std::string("\x1f\x8b\x08\0\0\0\0\0\0\xff", 10);
  std::uint32_t check = 0xffffffffU;
  for (const char c : content) {
    check ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) check = check >> 1 ^ ((check & 1) != 0 ? 0xedb88320U : 0);
  }
  for (std::size_t from = 0; from < content.size(); from += 60000) {
    const std::string block = content.substr(from, 60000);
    const auto size = static_cast<std::uint32_t>(block.size());
    text += static_cast<char>(from + 60000 >= content.size() ? 1 : 0);
    text += little(size, 2) + little(~size & 0xffff, 2) + block;
  }
  return text + little(~check, 4) + little(static_cast<std::uint32_t>(content.size()), 4);
}

TEST_F(FitStart, PackedPointsAreReadAsTheyAre) {
  const std::string content = points(false), packed = gzip(content);
  write("in.csv", content);
  write("in.csv.gz", packed);
  for (const char* memory : {"512", "0"}) {
    json({"fit", path("in.csv"), "-o", path("a.g2"), "--size", "9", "--memory", memory});
    json({"fit", path("in.csv.gz"), "-o", path("b.g2"), "--size", "9", "--memory", memory});
    EXPECT_TRUE(json({"compare", path("a.g2"), path("b.g2")}).at("identical").get<bool>());
  }
  write("cut.csv.gz", packed.substr(0, packed.size() / 2));
  std::string wrong = packed;
  wrong[wrong.size() / 2] ^= 1;
  write("wrong.csv.gz", wrong);
  for (const char* name : {"cut.csv.gz", "wrong.csv.gz"}) {
    EXPECT_NE(refusal({"fit", path(name), "-o", path("x.g2")}).find("damaged or cut off"), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace strak::test
