// strak fit on measured points that nobody here made.

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "strak/exchange/point_file.h"
#include "tests/cli/program.h"

namespace strak {
namespace {

class FitOfRealData : public test::Program {
 protected:
  // Fits a file of the data folder; null, and the test is skipped, where the folder is absent.
  nlohmann::json fit(const std::string& name, std::vector<std::string> options) const {
    const std::string file = real(name);
    if (file.empty()) return nullptr;
    options.insert(options.begin(), {"fit", file, "-o", path("out.step")});
    return json(options)["objects"][0];
  }
  // Its path; empty where the folder is absent.
  static std::string real(const std::string& name) {
    const char* named = std::getenv("STRAK_DATA");
    const std::filesystem::path file =
        std::filesystem::path(named != nullptr ? named : STRAK_SOURCE_DIR "/../shared/data") / name;
    return std::filesystem::exists(file) ? std::filesystem::absolute(file).string() : "";
  }
};

#define STRAK_FIT_OR_SKIP(variable, ...)  \
  const auto variable = fit(__VA_ARGS__); \
  if ((variable).is_null()) GTEST_SKIP() << "measured points are not here: set STRAK_DATA"

TEST_F(FitOfRealData, GeoidHeights) {
  STRAK_FIT_OR_SKIP(object, "grid/egm96_15.gtx", {"--size", "120x80", "--tolerance", "4", "--share", "95"});
  EXPECT_EQ(object["measured"], 1038240);
  EXPECT_TRUE(object["tolerance"]["reached"]);
  EXPECT_LT(object["rms"].get<double>(), 1.2);  // of heights from -107 to 85 m
}

TEST_F(FitOfRealData, AVolcano) {
  STRAK_FIT_OR_SKIP(object, "grid/SainteHelens.dem", {"--tolerance", "20", "--share", "99"});
  EXPECT_EQ(object["measured"], 148885);
  EXPECT_TRUE(object["tolerance"]["reached"]);
  EXPECT_LT(object["rms"].get<double>(), 6);  // m; the mountain is 1861 m high
  EXPECT_LT(object["max"].get<double>(), 60);
}

TEST_F(FitOfRealData, ACornea) {
  STRAK_FIT_OR_SKIP(object, "lens/cornea_N01.txt", {"--kind", "surface", "--tolerance", "0.001", "--share", "99"});
  EXPECT_EQ(object["measured"], 5384);
  EXPECT_TRUE(object["tolerance"]["reached"]);
  EXPECT_LT(object["rms"].get<double>(), 4e-4);  // mm
  EXPECT_TRUE(object["warnings"].empty());
}

TEST_F(FitOfRealData, ASheetWithHoles) {
  STRAK_FIT_OR_SKIP(object, "scan/ALSTOM_TEST4.off", {"--kind", "surface", "--tolerance", "0.5", "--share", "99"});
  EXPECT_EQ(object["measured"], 1138);
  EXPECT_TRUE(object["tolerance"]["reached"]);
  EXPECT_LT(object["rms"].get<double>(), 0.1);  // of a length of 863
}

TEST_F(FitOfRealData, AFaceThatStandsOnItsRim) {
  STRAK_FIT_OR_SKIP(object, "scan/head.off", {"--kind", "surface"});
  EXPECT_NE(object["drawing"]["plane"], 0);
  EXPECT_LT(object["rms"].get<double>(), 0.1);  // of a height of 17
  EXPECT_GT(object["drawing"]["stretch"], 1.5);
}

TEST_F(FitOfRealData, ABonnet) {
  const std::string packed = real("scan/drivaer_fastback_body.obj.gz");
  if (packed.empty()) GTEST_SKIP() << "measured points are not here: set STRAK_DATA";
  const Net body = readPoints(PointFile(packed));
  EXPECT_EQ(body.rows(), 125446);
  std::string bonnet = "x,y,z\n";
  for (Index r = 0; r < body.rows(); ++r) {
    if (body(r, 0) > -0.5 && body(r, 0) < 0.35 && std::abs(body(r, 1)) < 0.6 && body(r, 2) > 0.62) {
      bonnet += fmt::format("{},{},{}\n", body(r, 0), body(r, 1), body(r, 2));
    }
  }
  const std::string points = write("bonnet.csv", bonnet);
  const auto object = json({"fit", points, "-o", path("out.step"), "--kind", "surface"})["objects"][0];
  EXPECT_EQ(object["measured"], 2100);
  EXPECT_LT(object["rms"].get<double>(), 4e-4);  // m, of a length of 0.85
  EXPECT_LT(object["max"].get<double>(), 4e-3);
  const auto seen = json({"inspect", points, path("out.step"), "--tolerance", "0.001"});
  EXPECT_EQ(seen["along"], "normal");
  EXPECT_GT(seen["tolerance"]["inside"].get<double>(), 0.95);
  EXPECT_LE(seen["deviation"]["rms"].get<double>(), object["rms"].get<double>() * (1 + 1e-6));
}

TEST_F(FitOfRealData, AGeyser) {
  STRAK_FIT_OR_SKIP(object, "scan/lone_star_518k.ply", {"--kind", "surface", "--size", "20"});
  EXPECT_EQ(object["measured"], 518862);
  EXPECT_GT(object["drawing"]["rms"][0].get<double>(), 3);
  EXPECT_LT(object["rms"].get<double>(), 0.9);  // m, with steep walls: the drawing stops before a fold, and says so
  EXPECT_FALSE(object["warnings"].empty());
}

}  // namespace
}  // namespace strak
