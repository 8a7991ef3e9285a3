// strak fair and strak render on digitised curves.

#include <fmt/format.h>

#include <cmath>

#include "tests/cli/program.h"

namespace strak::test {
namespace {

class Curves : public Program {
 protected:
  // An arch as a table of points with noise in the fourth decimal.
  std::string arch() const {
    std::string text = "x,y,width\n";
    for (int i = 0; i <= 60; ++i) {
      const double x = i / 60.0, noise = 4e-4 * std::sin(7.1 * i * i);
      text += fmt::format("{:.6f},{:.6f},{}\n", x, 0.6 * x * (1 - x) + noise, i);
    }
    return write("arch.csv", text);
  }
};

TEST_F(Curves, AreFairedExactlyAndWrittenBack) {
  const auto json = this->json({"fair", arch(), "-o", path("out.csv"), "--energy", "exact", "--tolerance", "0.001",
                                "--hold", "g0", "--report", path("out.html"), "--json"});
  const auto& object = json["objects"][0];
  EXPECT_EQ(object["kind"], "digitised curve");
  EXPECT_GT(object["curvature_extrema"]["before"], 20);
  EXPECT_LT(object["curvature_extrema"]["after"], 6);
  EXPECT_LE(object["deviation"]["certified"], 0.001);
  EXPECT_LT(object["curve"]["after"]["curvature_variation"], object["curve"]["before"]["curvature_variation"]);
  EXPECT_NE(text("out.html").find("Curvature of the curves"), std::string::npos);
  const std::string table = text("out.csv");
  EXPECT_EQ(table.substr(0, 10), "x,y,width\n");
  EXPECT_NE(table.find(",60\n"), std::string::npos);
  for (const char* other : {"out.g2", "out.json"}) {
    EXPECT_EQ(strak({"fair", path("arch.csv"), "-o", path(other), "--energy", "exact", "--tolerance", "0.001"}).code,
              0);
  }
}

TEST_F(Curves, GetNoMoreExtremaThanWished) {
  const auto json = this->json({"fair", arch(), "-o", path("out.g2"), "--energy", "exact", "--tolerance", "0.002",
                                "--hold", "g0", "--curvature-extrema", "1", "--json"});
  EXPECT_LE(json["objects"][0]["curvature_extrema"]["after"], 1);
  const auto tight = this->json({"fair", arch(), "-o", path("out.g2"), "--energy", "exact", "--tolerance", "1e-6",
                                 "--hold", "g0", "--curvature-extrema", "1", "--json"});
  EXPECT_NE(tight["objects"][0]["notes"].dump().find("fewest that were reached"), std::string::npos);
  const auto wrong = strak({"fair", arch(), "-o", path("out.g2"), "--energy", "thin-plate", "--tolerance", "0.1",
                            "--curvature-extrema", "1"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.err.find("--energy exact"), std::string::npos);
}

TEST_F(Curves, ClassicalMethodsKeepTheTolerance) {
  arch();
  for (const char* method : {"eck-hadenfeld", "eck-hadenfeld-3", "farin-sapidis", "farin-degree", "kjellander"}) {
    const auto json = this->json({"fair", path("arch.csv"), "-o", path("out.g2"), "--method", method, "--tolerance",
                                  "0.001", "--hold", "g1", "--json"});
    const auto& object = json["objects"][0];
    EXPECT_LE(object["deviation"]["certified"], 0.001 * (1 + 1e-6)) << method;
    EXPECT_LT(object["curvature_extrema"]["after"], object["curvature_extrema"]["before"]) << method;
  }
  const std::string surface = write("s.g2", g2(wavySurface(3, 10, 10)));
  EXPECT_EQ(strak({"fair", surface, "-o", path("k.g2"), "--method", "kjellander", "--tolerance", "0.1"}).code, 0);
  const auto wrong = strak({"fair", surface, "-o", path("k.g2"), "--method", "farin-sapidis", "--tolerance", "0.1"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.err.find("is for curves"), std::string::npos);
}

TEST_F(Curves, AreDrawnAsDiagrams) {
  arch();
  ASSERT_EQ(strak({"fair", path("arch.csv"), "-o", path("out.csv"), "--energy", "exact", "--tolerance", "0.001"}).code,
            0);
  for (const char* kind : {"curvature-plot", "tolerance-band", "k-orthotomic"}) {
    const auto drawn = strak({"render", path("out.csv"), "-o", path("out.svg"), "--kind", kind, "--reference",
                              path("arch.csv"), "--tolerance", "0.001"});
    EXPECT_EQ(drawn.code, 0) << drawn.err;
    EXPECT_NE(text("out.svg").find("<path"), std::string::npos);
    EXPECT_EQ(text("out.svg").find("nan"), std::string::npos);
  }
  EXPECT_EQ(strak({"render", path("out.csv"), "-o", path("o.svg"), "--kind", "tolerance-band"}).code, 2);
  EXPECT_EQ(strak({"render", path("out.csv"), "-o", path("o.svg"), "--kind", "k-orthotomic", "--pole", "1"}).code, 2);
  EXPECT_EQ(strak({"render", path("out.csv"), "-o", path("o.html"), "--kind", "curvature-plot"}).code, 2);
}

TEST_F(Curves, BrokenTablesEndInASentence) {
  for (const char* bad : {"name\n", "0 0\n1 1\n", "a\n0 0\n1 1\n2 2\nx y\n3 3\n", "x,y\n0,0\n0,0\n0,0\n0,0\n0,0\n"}) {
    const auto outcome =
        strak({"fair", write("bad.dat", bad), "-o", path("out.g2"), "--energy", "exact", "--tolerance", "1"});
    EXPECT_EQ(outcome.code, 2) << bad;
    EXPECT_NE(outcome.err.find("bad.dat"), std::string::npos);
  }
  const auto wrong = strak({"convert", write("c.g2", g2(wavyCurve(3, 10))), "-o", path("c.dat")});
  EXPECT_EQ(wrong.code, 2);
}

}  // namespace
}  // namespace strak::test
