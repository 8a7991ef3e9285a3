// strak inspect and strak info --ring: measured points against a surface, and the surface's form.

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "tests/cli/program.h"

namespace strak {
namespace {

class Inspect : public test::Program {
 protected:
  // Points of z = height(x, y) on [-2, 2]^2, 40 x 40.
  template <class Height>
  std::string grid(const std::string& name, Height height) const {
    std::string text = "x,y,z\n";
    for (int i = 0; i < 40; ++i) {
      for (int j = 0; j < 40; ++j) {
        const double x = -2 + 4.0 * i / 39, y = -2 + 4.0 * j / 39;
        text += fmt::format("{:.17g},{:.17g},{:.17g}\n", x, y, height(x, y));
      }
    }
    return write(name, text);
  }
  std::string dome(double bump = 0) const {
    return grid("dome.csv", [&](double x, double y) {
      return std::sqrt(7.8 * 7.8 - x * x - y * y) + (x == 2 && y == 2 ? bump : 0);
    });
  }
};

TEST_F(Inspect, TellsTheRadiusAndThePowerOfADome) {
  const std::string points = dome();
  json({"fit", points, "-o", path("fit.g2"), "--degree", "5", "--size", "14", "--smoothing", "1e-14"});
  const auto result = json({"inspect", points, path("fit.g2"), "--remove", "sphere", "--tolerance", "1e-5"});
  EXPECT_EQ(result["along"], "height");
  EXPECT_EQ(result["measured"], 1600);
  EXPECT_EQ(result["tolerance"]["inside"], 1.0);
  EXPECT_LT(result["deviation"]["rms"].get<double>(), 1e-6);
  EXPECT_NEAR(result["form"]["model"]["radius"].get<double>(), 7.8, 1e-4);
  EXPECT_LT(result["form"]["model"]["peak_to_valley"].get<double>(), 1e-5);
  EXPECT_LT(result["form"]["points"]["peak_to_valley"].get<double>(), 1e-12);
  const auto ring = json({"info", path("fit.g2"), "--ring", "0,0,1.5", "--index", "1.3375"})["objects"][0]["ring"];
  EXPECT_NEAR(ring["power"]["mean"].get<double>(), 43.269, 1e-3);
  EXPECT_NEAR(ring["power"]["flattest"].get<double>(), 43.269, 2e-3);
  EXPECT_NEAR(ring["power"]["steepest"].get<double>(), 43.269, 2e-3);
  EXPECT_NEAR(ring["mean"].get<double>(), 1 / 7.8, 1e-6);
}

TEST_F(Inspect, FindsThePointThatIsOffAndDrawsIt) {
  const std::string clean = dome();
  json({"fit", clean, "-o", path("fit.step"), "--size", "20"});
  const std::string points = dome(0.25);
  const auto result = json({"inspect", points, path("fit.step"), "--along", "normal", "--tolerance", "0.01", "--remove",
                            "mean", "--picture", path("deviation.svg")});
  EXPECT_EQ(result["deviation"]["worst"]["point"], 1600);
  EXPECT_EQ(result["deviation"]["worst"]["at"][0], 2.0);
  const double slope = 2 / std::sqrt(7.8 * 7.8 - 8);
  EXPECT_NEAR(result["deviation"]["highest"].get<double>(), 0.25 / std::sqrt(1 + 2 * slope * slope), 0.003);
  EXPECT_EQ(result["tolerance"]["inside"], 1599.0 / 1600);
  const std::string picture = text("deviation.svg");
  EXPECT_NE(picture.find("class=\"points\""), std::string::npos);
  EXPECT_NE(picture.find("Deviation of the points"), std::string::npos);
  EXPECT_NE(strak({"inspect", points, path("fit.step")}).out.find("1600 points, heights over the graph"),
            std::string::npos);
}

#ifdef STRAK_WITH_CAD
// Points in the hole of a trimmed face, where nothing was fitted, say nothing about it.
TEST_F(Inspect, CountsWhatTheTrimsLeaveOnly) {
  std::string around = "x,y,z\n", all = around;
  int beside = 0, within = 0;
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 40; ++j) {
      const double x = -2 + 4.0 * i / 39, y = -2 + 4.0 * j / 39, z = 0.1 * x * y;
      const bool hole = std::hypot(x, y) < 1;
      const bool deep = std::hypot(x, y) < 0.8;
      if (!hole) around += fmt::format("{},{},{}\n", x, y, z);
      all += fmt::format("{},{},{}\n", x, y, deep ? z + 1 : z);
      beside += std::hypot(x, y) > 1.1 && std::max(std::abs(x), std::abs(y)) < 1.95 ? 1 : 0;
      within += deep ? 1 : 0;
    }
  }
  const std::string points = write("all.csv", all);
  for (const char* kind : {"function", "surface"}) {
    for (const char* output : {"fit.step", "fit.igs"}) {
      json({"fit", write("around.csv", around), "-o", path(output), "--kind", kind, "--size", "8", "--trim", "auto"});
      const auto result = json({"inspect", points, path(output)});
      EXPECT_GE(result["measured"], beside) << kind;
      EXPECT_GE(result["missed"], within) << kind;
      EXPECT_EQ(result["measured"].get<int>() + result["missed"].get<int>(), 1600) << kind;
      EXPECT_LT(result["deviation"]["highest"].get<double>(), 0.01) << kind << output;
      EXPECT_NE(strak({"inspect", points, path(output)}).out.find("trims"), std::string::npos);
    }
  }
  // Without the trims they count.
  json({"fit", path("around.csv"), "-o", path("fit.g2"), "--kind", "function", "--size", "8"});
  const auto whole = json({"inspect", points, path("fit.g2")});
  EXPECT_EQ(whole["measured"], 1600);
  EXPECT_GT(whole["deviation"]["highest"].get<double>(), 0.9);
}
#endif

TEST_F(Inspect, ChoosesColumnsOfAProfile) {
  std::string table = "X(mm) what height (nm) slope\n";
  for (int i = 0; i < 300; ++i) {
    const double x = 0.1 * i;
    table += fmt::format("7 {:.17g} {:.17g} 1\n", x, 2 + x + 3 * x * x + std::sin(x));
  }
  const std::string points = write("profile.dat", table);
  json({"fit", points, "--columns", "2,3", "--kind", "function", "-o", path("fit.g2")});
  const auto result = json({"inspect", points, path("fit.g2"), "--columns", "2,3", "--remove", "quadric"});
  EXPECT_EQ(result["measured"], 300);
  EXPECT_LT(result["deviation"]["rms"].get<double>(), 1e-4);
  const double fitted = result["form"]["model"]["rms"].get<double>();
  EXPECT_NEAR(fitted, result["form"]["points"]["rms"].get<double>(), 1e-4);
  EXPECT_NEAR(fitted, 0.7, 0.05);  // of the wave, which the parabola takes little of
  EXPECT_NE(refusal({"fit", points, "--columns", "2,5", "-o", path("x.g2")}).find("--columns"), std::string::npos);
}

TEST_F(Inspect, DrawsTheDeviationsAlongACurve) {
  std::string arc = "x,y\n", profile = "x,z\n";
  for (int i = 0; i <= 200; ++i) {
    const double t = std::numbers::pi * i / 200;
    arc += fmt::format("{:.17g},{:.17g}\n", -10 * std::cos(t), 10 * std::sin(t) + (i == 100 ? 0.5 : 0));
    profile += fmt::format("{:.17g},{:.17g}\n", 5 + t, std::sin(t));
  }
  const std::string points = write("arc.csv", arc);
  json({"fit", points, "--kind", "curve", "--size", "12", "--loss", "tukey", "-o", path("arc.g2")});
  const auto result = json({"inspect", points, path("arc.g2"), "--tolerance", "0.1", "--picture", path("arc.svg")});
  EXPECT_EQ(result["deviation"]["worst"]["point"], 101);
  EXPECT_NE(text("arc.svg").find("deviations of 201 points, 1 outside the tolerance"), std::string::npos);
  EXPECT_NE(text("arc.svg").find("arc length"), std::string::npos);
  const std::string heights = write("profile.csv", profile);
  json({"fit", heights, "--kind", "function", "-o", path("profile.g2")});
  json({"inspect", heights, path("profile.g2"), "--picture", path("profile.svg")});
  EXPECT_EQ(text("profile.svg").find("arc length"), std::string::npos);
  EXPECT_NE(text("profile.svg").find("deviations of 201 points"), std::string::npos);
}

TEST_F(Inspect, RefusesWithASentence) {
  const std::string points = dome();
  json({"fit", points, "-o", path("fit.g2"), "--size", "9"});
  const std::string fit = path("fit.g2");
  EXPECT_NE(refusal({"inspect", points, fit, "--remove", "tilt"}).find("--remove"), std::string::npos);
  EXPECT_NE(refusal({"inspect", points, fit, "--along", "z"}).find("--along"), std::string::npos);
  EXPECT_NE(refusal({"inspect", points, fit, "--picture", path("a.png")}).find(".svg"), std::string::npos);
  EXPECT_NE(refusal({"inspect", points, fit, "--picture", path("a.svg"), "--size", "900"}).find("--size"),
            std::string::npos);
  const std::string far = write("far.csv", "x,y,z\n50,50,1\n51,50,1\n");
  EXPECT_NE(refusal({"inspect", far, fit}).find("no point lies over the surface"), std::string::npos);
  const std::string flat = write("flat.csv", "x,y\n0,0\n1,0\n");
  EXPECT_EQ(strak({"inspect", flat, fit}).code, 2);
  EXPECT_NE(refusal({"info", fit, "--ring", "0,0,9"}).find("smaller ring"), std::string::npos);
  EXPECT_NE(refusal({"info", fit, "--ring", "0,0"}).find("--ring"), std::string::npos);
}

// Measured lenses, mirrors and corneas: their makers' own figures come out of the fitted surface.
class Measured : public Inspect {
 protected:
  // Empty, and the test is skipped, where the folder is absent.
  static std::string real(const std::string& name) {
    const char* named = std::getenv("STRAK_DATA");
    const std::filesystem::path file =
        std::filesystem::path(named != nullptr ? named : STRAK_SOURCE_DIR "/../shared/data") / name;
    return std::filesystem::exists(file) ? std::filesystem::absolute(file).string() : "";
  }
};

#define STRAK_REAL_OR_SKIP(variable, name) \
  const std::string variable = real(name); \
  if ((variable).empty()) GTEST_SKIP() << "measured points are not here: set STRAK_DATA"

TEST_F(Measured, AnInterferogramHasItsPublishedFigures) {
  STRAK_REAL_OR_SKIP(file, "lens/zygo_interferogram.dat");
  json({"fit", file, "-o", path("fit.g2"), "--degree", "2", "--size", "345x350", "--smoothing", "1e-22",
        "--most-points", "130000"});
  const auto form = json({"inspect", file, path("fit.g2"), "--remove", "mean"})["form"];
  EXPECT_NEAR(form["points"]["peak_to_valley"].get<double>(), 330.7e-6, 0.001e-6);  // mm
  EXPECT_NEAR(form["points"]["rms"].get<double>(), 44.591e-6, 0.001e-6);
  EXPECT_NEAR(form["model"]["peak_to_valley"].get<double>(), 330.7e-6, 3.307e-6);
  EXPECT_NEAR(form["model"]["rms"].get<double>(), 44.591e-6, 0.446e-6);
}

TEST_F(Measured, MirrorsHaveTheHeightsThatTheirMakersDeclare) {
  STRAK_REAL_OR_SKIP(first, "profile/dabam-010.dat");
  for (const auto& [name, rms] :
       {std::pair{"010", 3.048414}, {"012", 2.5052773}, {"015", 97.355965}, {"017", 47.577432}}) {
    const std::string file = real(fmt::format("profile/dabam-{}.dat", name));
    json({"fit", file, "--columns", "1,2", "--kind", "function", "-o", path("fit.g2")});
    const auto form = json({"inspect", file, path("fit.g2"), "--columns", "1,2", "--remove", "quadric"})["form"];
    EXPECT_NEAR(form["model"]["rms"].get<double>(), rms, 0.01 * rms) << name;  // nm
  }
}

TEST_F(Measured, CorneasHaveThePowersThatTheTopographerTells) {
  STRAK_REAL_OR_SKIP(first, "lens/cornea_N01.txt");
  struct Eye {
    const char* name;
    double flat, steep;  // dioptres
  };
  for (const Eye& eye : {Eye{"N01", 41.46, 41.98}, Eye{"S01", 40.94, 44.73}, Eye{"K03", 44.08, 46.26}}) {
    const std::string file = real(fmt::format("lens/cornea_{}.txt", eye.name));
    json({"fit", file, "-o", path("fit.g2")});
    const auto power =
        json({"info", path("fit.g2"), "--ring", "0,0,1.5", "--index", "1.3375"})["objects"][0]["ring"]["power"];
    EXPECT_NEAR(power["flattest"].get<double>(), eye.flat, 0.25) << eye.name;
    EXPECT_NEAR(power["steepest"].get<double>(), eye.steep, 0.25) << eye.name;
  }
}

}  // namespace
}  // namespace strak
