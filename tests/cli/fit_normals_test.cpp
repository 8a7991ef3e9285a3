// strak fit --normals, as people use it.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "strak/spline/evaluate.h"
#include "tests/cli/program.h"

namespace strak {
namespace {

using test::Outcome;

class FitNormals : public test::Program {
 protected:
  static double height(double x, double y) { return 0.2 * std::sin(3 * x) * y + 0.1 * x * y * y; }

  static Eigen::Vector3d tilted(double x, double y, double degrees) {
    const Eigen::Vector3d normal(-0.6 * std::cos(3 * x) * y - 0.1 * y * y, -0.2 * std::sin(3 * x) - 0.2 * x * y, 1);
    return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Eigen::Vector3d(0, 1, 0)) * normal.normalized();
  }

  std::string points() const {
    std::string text;
    for (int i = 0; i <= 40; ++i) {
      for (int j = 0; j <= 40; ++j) text += fmt::format("{} {} {}\n", i / 40.0, j / 40.0, height(i / 40.0, j / 40.0));
    }
    return write("points.xyz", text);
  }

  static double angle(const Surface& surface, double u, double v, const Eigen::Vector3d& normal) {
    const Net d = derivatives<2>(surface, {u, v}, 1);
    const Eigen::Vector3d n = Eigen::Vector3d(d.row(1).transpose()).cross(Eigen::Vector3d(d.row(2).transpose()));
    return std::atan2(n.cross(normal).norm(), std::abs(n.dot(normal))) * 180 / std::numbers::pi;
  }
};

TEST_F(FitNormals, TiltTheGraphOfAFunction) {
  const Eigen::Vector3d n = tilted(0.43, 0.61, 5);
  write("normals.txt", fmt::format("0.43 0.61 {} {} {}\n", n[0], n[1], n[2]));
  const auto result =
      json({"fit", points(), "-o", path("out.g2"), "--size", "12", "--normals", path("normals.txt")})["objects"][0];
  EXPECT_EQ(result["normals"]["stop"], "met");
  EXPECT_NEAR(result["normals"]["angle"]["largest_before"].get<double>(), 5, 0.2);
  EXPECT_LE(result["normals"]["angle"]["largest"].get<double>(), 1e-3);
  EXPECT_LT(result["normals"]["errors_before"]["rms"].get<double>(), result["rms"].get<double>());
  EXPECT_LT(result["rms"].get<double>(), 2e-3);
  EXPECT_EQ(result["warnings"].dump().find("normals"), std::string::npos);
  EXPECT_LT(angle(test::readSurface(file("out.g2")), 0.43, 0.61, n), 1e-3);
}

TEST_F(FitNormals, TiltASheetAtTheFootOfAPlace) {
  const Eigen::Vector3d n = tilted(0.43, 0.61, 5);
  write("normals.csv",
        fmt::format("x,y,z,nx,ny,nz,weight\n0.43,0.61,{},{},{},{},2\n", height(0.43, 0.61), n[0], n[1], n[2]));
  const auto result = json({"fit", points(), "-o", path("out.g2"), "--size", "12", "--kind", "surface", "--normals",
                            path("normals.csv")})["objects"][0];
  EXPECT_EQ(result["normals"]["stop"], "met");
  const auto& at = result["normals"]["worst"]["at"];
  EXPECT_LT(angle(test::readSurface(file("out.g2")), at[0].get<double>(), at[1].get<double>(), n), 2e-3);
  const auto soft = json({"fit", points(), "-o", path("out.g2"), "--size", "12", "--kind", "surface", "--normals",
                          path("normals.csv"), "--normals-weight", "1e-4"})["objects"][0];
  EXPECT_EQ(soft["normals"]["stop"], "settled");
  EXPECT_GT(soft["normals"]["angle"]["largest"].get<double>(), 0.1);
  EXPECT_LT(soft["rms"].get<double>(), result["rms"].get<double>());
}

TEST_F(FitNormals, TiltASurfaceThatIsThereAlready) {
  json({"fit", points(), "-o", path("given.g2"), "--size", "12"});
  const Eigen::Vector3d n = tilted(0.43, 0.61, 5);
  write("normals.txt", fmt::format("0.43 0.61 {} {} {}\n", n[0], n[1], n[2]));
  const Surface before = test::readSurface(file("given.g2"));
  const auto result =
      json({"fit", path("given.g2"), "-o", path("out.g2"), "--normals", path("normals.txt")})["objects"][0];
  EXPECT_EQ(result["normals"]["stop"], "met");
  const Surface after = test::readSurface(file("out.g2"));
  EXPECT_LT(angle(after, 0.43, 0.61, n), 1e-3);
  EXPECT_GE(result["deviation"]["certified"].get<double>(), result["deviation"]["lower"].get<double>());
  EXPECT_LT(result["deviation"]["certified"].get<double>(), 0.02);
  json({"fit", path("given.g2"), "-o", path("held.g2"), "--normals", path("normals.txt"), "--normals-hold", "2"});
  const Surface held = test::readSurface(file("held.g2"));
  EXPECT_EQ(held.net().topRows(24), before.net().topRows(24));
  EXPECT_LT(angle(held, 0.43, 0.61, n), 1e-3);
}

TEST_F(FitNormals, SayWhatIsNotMet) {
  std::string text = "u v nx ny nz\n";
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) {
      text += fmt::format("{} {} {} {} 1\n", (i + 0.5) / 20, (j + 0.5) / 20, (i * 7 + j * 3) % 5 / 20.0 - 0.1,
                          (i * 3 + j * 11) % 7 / 30.0 - 0.1);
    }
  }
  write("normals.txt", text);
  const auto result =
      json({"fit", points(), "-o", path("out.g2"), "--size", "8", "--normals", path("normals.txt")})["objects"][0];
  EXPECT_EQ(result["normals"]["stop"], "contradictory");
  ASSERT_EQ(result["warnings"].size(), 1);
  EXPECT_NE(result["warnings"][0].get<std::string>().find("of 400 normals are left with more than"), std::string::npos);
}

TEST_F(FitNormals, RefuseWhatIsNotThere) {
  const std::string cloud = points();
  const auto fails = [&](const std::string& normals, const std::vector<std::string>& more = {}) {
    write("normals.txt", normals);
    std::vector<std::string> arguments{"fit", cloud, "-o", path("out.g2"), "--normals", path("normals.txt")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return refusal(arguments);
  };
  EXPECT_NE(fails("0.5 0.5 0 0\n").find("normals need five"), std::string::npos);
  EXPECT_NE(fails("0.5 0.5 0 0 0\n").find("zero"), std::string::npos);
  EXPECT_NE(fails("0.5 1.5 0 0 1\n").find("outside the domain"), std::string::npos);
  EXPECT_NE(fails("0.5 0.5 0 0 1\n0.5 0.5 0 1 1\n").find("contradict"), std::string::npos);
  EXPECT_NE(fails("0.5 0.5 0 1 0\n").find("horizontal"), std::string::npos);
  fails("0.5 0.5 0 x 1\n");
  fails("");
  fails("0.5 0.5 0 0 1\n", {"--normals-weight", "-1"});
  fails("0.5 0.5 0 0 1\n", {"--normals-angle", "0"});
  fails("0.5 0.5 0 0 1\n", {"--normals-hold", "1"});
  write("curve.txt", "0 0\n1 1\n2 0\n3 1\n4 4\n5 5\n");
  EXPECT_NE(refusal({"fit", path("curve.txt"), "-o", path("out.g2"), "--normals", path("normals.txt")}).find("curves"),
            std::string::npos);
  json({"fit", cloud, "-o", path("given.g2"), "--size", "8"});
  EXPECT_NE(refusal({"fit", path("given.g2"), "-o", path("out.g2"), "--normals", path("normals.txt"), "--size", "9"})
                .find("--size is for points"),
            std::string::npos);
}

}  // namespace
}  // namespace strak
