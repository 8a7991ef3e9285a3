// strak fit on measured points that nobody here made.

#include <cstdlib>

#include "tests/cli/program.h"

namespace strak {
namespace {

class FitOfRealData : public test::Program {
 protected:
  // Fits a file of the data folder; null, and the test is skipped, where the folder is absent.
  nlohmann::json fit(const std::string& name, std::vector<std::string> options) const {
    const char* named = std::getenv("STRAK_DATA");
    const std::filesystem::path file =
        std::filesystem::path(named != nullptr ? named : STRAK_SOURCE_DIR "/../shared/data") / name;
    if (!std::filesystem::exists(file)) return nullptr;
    options.insert(options.begin(), {"fit", std::filesystem::absolute(file).string(), "-o", path("out.step")});
    return json(options)["objects"][0];
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

TEST_F(FitOfRealData, AGeyser) {
  STRAK_FIT_OR_SKIP(object, "scan/lone_star_518k.ply", {"--kind", "surface", "--size", "20"});
  EXPECT_EQ(object["measured"], 518862);
  EXPECT_GT(object["drawing"]["rms"][0].get<double>(), 3);
  EXPECT_LT(object["rms"].get<double>(), 0.9);  // m, with steep walls: the drawing stops before a fold, and says so
  EXPECT_FALSE(object["warnings"].empty());
}

}  // namespace
}  // namespace strak
