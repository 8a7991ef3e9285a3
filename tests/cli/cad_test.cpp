// The commands on CAD files: made from splines by the program itself, and real ones where the data folder is there.

#include <cstdlib>

#include "tests/cli/program.h"

#ifdef STRAK_WITH_CAD

namespace strak::test {
namespace {

class Cad : public Program {
 protected:
  // A file of the data folder; empty if it is not there.
  static std::string data(const std::string& name) {
    const char* folder = std::getenv("STRAK_DATA");
    const auto file = std::filesystem::path(folder != nullptr ? folder : STRAK_SOURCE_DIR "/../shared/data") / name;
    return std::filesystem::exists(file) ? file.string() : "";
  }

  // info, fair with 1e-4 of the size, compare with the input: the promises that hold for every file.
  void fairAndCompare(const std::string& input, const std::string& output) {
    const auto before = json({"info", input});
    const auto fair = json({"fair", input, "-o", output, "--tolerance", "0.0001size"});
    const double tolerance = fair.at("tolerance").get<double>();
    EXPECT_NEAR(tolerance, 1e-4 * before.at("size").get<double>(), 1e-6 * tolerance);
    const auto& audit = fair.at("audit");
    EXPECT_GE(audit.at("after").at("valid").get<bool>(), audit.at("before").at("valid").get<bool>());
    EXPECT_LE(audit.at("after").at("largest_tolerance").get<double>(),
              audit.at("before").at("largest_tolerance").get<double>());
    EXPECT_LE(audit.at("after").at("largest_gap").get<double>(),
              audit.at("before").at("largest_gap").get<double>() + 1e-7 * tolerance);
    for (const auto& object : fair.at("objects")) {
      const auto name = object.at("name").get<std::string>();
      if (!object.at("left_alone").is_null()) {
        EXPECT_NE(object.at("left_alone"), "") << name;
        continue;
      }
      EXPECT_LE(object.at("deviation").at("certified").get<double>(), tolerance * (1 + 1e-9)) << name;
      EXPECT_LE(object.at("energy").at("after").get<double>(), object.at("energy").at("before").get<double>()) << name;
      EXPECT_EQ(object.at("held_max_move").get<double>(), 0) << name;
    }
    const auto compare = json({"compare", input, output});
    EXPECT_LE(compare.at("largest_deviation").get<double>(), tolerance * (1 + 1e-6));
    EXPECT_EQ(compare.at("units").at(0), compare.at("units").at(1));
    EXPECT_EQ(compare.at("object_counts").at(0), compare.at("object_counts").at(1));
    EXPECT_GE(compare.at("audits").at(1).at("valid").get<bool>(), compare.at("audits").at(0).at("valid").get<bool>());
  }
};

TEST_F(Cad, FacesMadeFromSplinesAreFairedInEveryFormat) {
  write("in.g2", g2(wavySurface(3, 16, 14)));
  for (const char* ending : {"step", "igs", "brep"}) {
    const std::string input = path(std::string("in.") + ending);
    const std::string output = path(std::string("out.") + ending);
    EXPECT_EQ(strak({"convert", path("in.g2"), "-o", input}).code, 0) << ending;
    fairAndCompare(input, output);
    EXPECT_FALSE(json({"compare", input, output}).at("identical").get<bool>()) << ending;
  }
}

TEST_F(Cad, TheFormatMayChangeOnTheWay) {
  write("in.g2", g2(wavySurface(3, 16, 14)));
  json({"fair", path("in.g2"), "-o", path("out.step"), "--tolerance", "0.01"});
  json({"fair", path("in.g2"), "-o", path("out.g2"), "--tolerance", "0.01"});
  const auto same = json({"compare", path("out.g2"), path("out.step")});
  EXPECT_LE(same.at("largest_deviation").get<double>(), 1e-9);
}

TEST_F(Cad, FacesThatShareASurfaceAreFairedOnceAndSaidSo) {
  write("one.g2", g2(wavySurface(3, 16, 14)));
  EXPECT_EQ(strak({"convert", path("one.g2"), "-o", path("one.brep")}).code, 0);
  // A second instance of the face, 20 units beside the first.
  std::string brep = text("one.brep");
  const auto replace = [&](const std::string& from, const std::string& to) {
    const auto place = brep.rfind(from);
    ASSERT_NE(place, std::string::npos) << from;
    brep.replace(place, from.size(), to);
  };
  replace("Locations 0\n", "Locations 1\n1\n1 0 0 20\n0 1 0 0\n0 0 1 0\n");
  replace("+2 0 *", "+2 0 +2 1 *");
  write("two.brep", brep);
  const auto before = json({"info", path("two.brep")}).at("objects");
  ASSERT_EQ(before.size(), 2U);
  EXPECT_EQ(before.at(0).at("shared_with"), nlohmann::json{2});
  const auto after = json({"fair", path("two.brep"), "-o", path("out.brep"), "--tolerance", "0.01"}).at("objects");
  EXPECT_TRUE(after.at(0).at("left_alone").is_null());
  EXPECT_NE(after.at(0).at("notes").dump().find("object 2"), std::string::npos);
  EXPECT_NE(after.at(1).at("left_alone").dump().find("object 1"), std::string::npos);
  const auto compare = json({"compare", path("two.brep"), path("out.brep")}).at("objects");
  for (const auto& object : compare) EXPECT_GT(object.at("deviation").at("lower").get<double>(), 0.001);
}

TEST_F(Cad, BrokenFilesAreRefused) {
  write("in.g2", g2(wavySurface(3, 8, 8)));
  for (const char* ending : {"step", "igs", "brep"}) {
    const std::string good = std::string("good.") + ending;
    EXPECT_EQ(strak({"convert", path("in.g2"), "-o", path(good)}).code, 0) << ending;
    const std::string content = text(good);
    for (const double part : {0.1, 0.5, 0.9}) {
      const auto length = static_cast<std::size_t>(part * static_cast<double>(content.size()));
      const std::string half = write(std::string("half.") + ending, content.substr(0, length));
      const Outcome outcome = strak({"fair", half, "-o", path("out.step"), "--tolerance", "0.01"});
      EXPECT_EQ(outcome.code, 2) << ending << " " << part << "\n" << outcome.err;
      EXPECT_TRUE(outcome.err.starts_with("strak: ")) << ending << " " << outcome.err;
      EXPECT_FALSE(std::filesystem::exists(file("out.step"))) << ending;
    }
  }
}

TEST_F(Cad, RealFilesKeepEveryPromise) {
  const char* names[] = {"cad/car_hood_capot.step", "hull/hull_160m.igs", "hull/series60.step", "cad/as1-oc-214.stp"};
  for (const char* name : names) {
    const std::string input = data(name);
    if (input.empty()) GTEST_SKIP() << "no data folder: set STRAK_DATA to run on real CAD files";
    SCOPED_TRACE(name);
    fairAndCompare(input, path(std::filesystem::path(name).filename().string()));
  }
}

}  // namespace
}  // namespace strak::test

#endif
