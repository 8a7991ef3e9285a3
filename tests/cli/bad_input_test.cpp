// Bad input of all kinds: one clear sentence on stderr, exit code 2 (bad input) or 1 (failure), no file left behind.

#include <sys/resource.h>

#include <random>

#include "tests/cli/program.h"

namespace strak::test {
namespace {

class BadInput : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    write("in.g2", g2(wavySurface(3, 10, 10)));
  }

  // The run fails with `code` and one line of explanation that has `word` in it, and leaves no file behind.
  void expectRefused(const std::vector<std::string>& arguments, int code, const std::string& word) const {
    const auto before = files();
    const Outcome outcome = strak(arguments);
    std::string line;
    for (const auto& argument : arguments) line += argument + " ";
    EXPECT_EQ(outcome.code, code) << line << outcome.err;
    EXPECT_EQ(outcome.out, "") << line;
    EXPECT_TRUE(outcome.err.starts_with("strak: ")) << line << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << line << outcome.err;
    EXPECT_NE(outcome.err.find(word), std::string::npos) << line << outcome.err;
    EXPECT_EQ(files(), before) << line;
  }

  std::vector<std::string> fair(std::vector<std::string> more) const {
    std::vector<std::string> arguments{"fair", path("in.g2"), "-o", path("out.g2")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
};

TEST_F(BadInput, OptionValues) {
  const std::vector<std::tuple<std::string, std::string, std::string>> cases{
      {"--tolerance", "0", "--tolerance"},
      {"--tolerance", "-1", "--tolerance"},
      {"--tolerance", "nan", "--tolerance"},
      {"--tolerance", "inf", "--tolerance"},
      {"--tolerance", "1e-4x", "--tolerance"},
      {"--tolerance", "size", "--tolerance"},
      {"--tolerance", "-0.1size", "--tolerance"},
      {"--tolerance", "", "--tolerance"},
      {"--tolerance-kind", "both", "surface"},
      {"--hold", "g3", "--hold"},
      {"--hold", "-1", "--hold"},
      {"--hold", "1,2,3", "--hold"},
      {"--hold", "1,2,3,4,5,6", "surface"},
      {"--hold", "", "--hold"},
      {"--energy", "bending", "thin-plate"},
      {"--energy", "thin-plate+", "energy"},
      {"--parameter-scale", "metres", "lengths"},
      {"--method", "best", "optimal"},
      {"--gap", "0", "--gap"},
      {"--gap", "-1e-6", "--gap"},
      {"--gap", "nan", "--gap"},
      {"--steps", "0", "--steps"},
      {"--steps", "many", "--steps"},
      {"--steps", "1.5", "--steps"},
      {"--steps", "99999999999999999999", "--steps"},
      {"--min-gain", "-1", "--min-gain"},
      {"--max-changes", "0", "--max-changes"},
      {"--points-per-list", "0", "--points-per-list"},
      {"--threads", "0", "--threads"},
      {"--faces", "2", "--faces"},
      {"--faces", "0", "--faces"},
      {"--faces", "3-1", "--faces"},
      {"--faces", "roof", "roof"},
      {"--faces", "1,,1", "--faces"},
      {"--faces", "", "--faces"},
  };
  for (const auto& [option, value, word] : cases) {
    // Written with "=", so that values that begin with a dash are values.
    expectRefused(fair({option + "=" + value}), 2, word);
  }
  expectRefused(fair({"--tolerance", "-1"}), 2, "tolerance");
}

TEST_F(BadInput, OptionsAndCommands) {
  expectRefused({}, 2, "subcommand");
  expectRefused({"smooth", path("in.g2")}, 2, "--help");
  expectRefused({"fair"}, 2, "IN");
  expectRefused({"fair", path("in.g2")}, 2, "--output");
  expectRefused(fair({"--no-such-option"}), 2, "--no-such-option");
  expectRefused(fair({"surplus"}), 2, "surplus");
  expectRefused(fair({"--tolerance"}), 2, "--tolerance");
  expectRefused({"info"}, 2, "FILE");
  expectRefused({"compare", path("in.g2")}, 2, "B");
}

TEST_F(BadInput, FilesThatAreNotThere) {
  for (const char* command : {"info", "fair", "convert", "render"}) {
    std::vector<std::string> arguments{command, path("missing.g2")};
    if (std::string(command) != "info") arguments.insert(arguments.end(), {"-o", path("out.svg")});
    if (arguments.size() == 4 && std::string(command) != "render") arguments[3] = path("out.g2");
    expectRefused(arguments, 2, "missing.g2");
  }
  expectRefused({"compare", path("in.g2"), path("missing.g2")}, 2, "missing.g2");
  expectRefused({"info", path(".")}, 2, "folder");
}

TEST_F(BadInput, OutputsThatCannotBe) {
  expectRefused({"fair", path("in.g2"), "-o", path("nowhere/out.g2")}, 1, "nowhere");
  expectRefused({"convert", path("in.g2"), "-o", path("nowhere/out.g2")}, 1, "nowhere");
  expectRefused({"render", path("in.g2"), "-o", path("nowhere/out.svg")}, 1, "nowhere");
  expectRefused(fair({"--report", path("nowhere/report.html")}), 1, "nowhere");
  expectRefused({"fair", path("in.g2"), "-o", path("out.doc")}, 2, "out.doc");
  expectRefused({"convert", path("in.g2"), "-o", path("out")}, 2, "out");
  expectRefused({"render", path("in.g2"), "-o", path("out.png")}, 2, ".svg");
  expectRefused(fair({"--report", path("in.g2")}), 2, "--report");
  expectRefused(fair({"--report", path("out.g2")}), 2, "--report");
  std::filesystem::create_directory(file("folder.g2"));
  expectRefused({"fair", path("in.g2"), "-o", path("folder.g2")}, 1, "folder");
}

TEST_F(BadInput, RenderOptions) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"--kind", "wireframe"}, {"--kind", "deviation"}, {"--view", "0,0,0"}, {"--view", "1,2"},  {"--light", "x,y,z"},
      {"--lines", "0"},        {"--size", "900"},       {"--size", "0x700"}, {"--size", "-1x2"}, {"--faces", "7"}};
  for (const auto& [option, value] : cases) {
    expectRefused({"render", path("in.g2"), "-o", path("out.svg"), option + "=" + value}, 2, "");
  }
}

TEST_F(BadInput, FilesThatAreNoSplines) {
  const std::string good = g2(wavySurface(3, 6, 6));
  std::string rubbish(4096, '\0');
  std::mt19937_64 source(1);
  for (char& c : rubbish) c = static_cast<char>(source());
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  const std::vector<std::pair<std::string, std::string>> cases{
      {"empty.g2", ""},
      {"blank.g2", " \n \n"},
      {"rubbish.g2", rubbish},
      {"rubbish.step", rubbish},
      {"rubbish.igs", rubbish},
      {"half.g2", good.substr(0, good.size() / 2)},
      {"word.g2", replaced("3 0", "3 zero")},
      {"nan.g2", replaced("0.33333333333333331", "nan")},
      {"inf.g2", replaced("0.33333333333333331", "inf")},
      {"decreasing.g2", replaced("0.33333333333333331", "7")},
      {"many.g2", replaced("6 4", "600000000000000 4")},
      {"few.g2", replaced("6 4", "2 4")},
      {"negative.g2", replaced("6 4", "-6 4")},
      {"order.g2", replaced("6 4", "6 0")},
      {"broken.json", "{\"strak\": 1, \"objects\": [{"},
      {"other.json", "[1, 2, 3]"},
      {"header.step", "ISO-10303-21;\nHEADER;\n"},
      {"text.txt", "a letter"},
  };
  for (const auto& [name, content] : cases) {
    write(name, content);
    expectRefused({"info", path(name)}, 2, "");
    expectRefused({"fair", path(name), "-o", path("out.g2"), "--tolerance", "0.1"}, 2, "");
  }
}

TEST_F(BadInput, MutatedBytesNeverCrash) {
  const std::string good = g2(wavySurface(2, 5, 4)) + g2(wavyCurve(2, 6));
  std::mt19937_64 source(2);
  for (int k = 0; k < 60; ++k) {
    std::string text = good;
    for (int changes = 1 + static_cast<int>(source() % 3); changes > 0; --changes) {
      const std::size_t place = source() % text.size();
      switch (source() % 3) {
        case 0:
          text[place] = static_cast<char>(source());
          break;
        case 1:
          text.erase(place, 1 + source() % 20);
          break;
        default:
          text.insert(place, std::string(1, "0123456789.-e \n"[source() % 15]));
          break;
      }
    }
    write("mutant.g2", text);
    const Outcome outcome =
        strak({"fair", path("mutant.g2"), "-o", path("out.g2"), "--tolerance", "0.1", "--hold", "1", "--json"});
    EXPECT_TRUE(outcome.code == 0 || outcome.code == 1 || outcome.code == 2) << outcome.code << "\n"
                                                                             << outcome.err << text;
    EXPECT_EQ(outcome.code == 0, std::filesystem::exists(file("out.g2"))) << outcome.err;
    EXPECT_EQ(outcome.code == 0, nlohmann::json::accept(outcome.out)) << outcome.out;
    std::filesystem::remove(file("out.g2"));
  }
}

TEST_F(BadInput, SingularProblemsSayWhatToHold) {
  // Nothing held and no tolerance: every plane has no energy at all.
  expectRefused(fair({"--hold", "0"}), 2, "hold");
}

TEST_F(BadInput, ASingularObjectAmongOthersIsListed) {
  write("two.g2", g2(wavySurface(3, 12, 12)) + g2(wavyCurve(3, 20)));
  const Outcome outcome = strak({"fair", path("two.g2"), "-o", path("out.g2"), "--tolerance", "0.1", "--energy", "q3"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;  // the energy q3 exists for surfaces only
  EXPECT_NE(outcome.out.find("B-spline curve"), std::string::npos) << outcome.out;
}

TEST_F(BadInput, AFullDiskLeavesTheOldFile) {
  write("big.g2", g2(wavySurface(3, 60, 60)));
  write("out.g2", "the old file");
  const rlimit small{4096, RLIM_INFINITY};
  rlimit old{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old), 0);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);  // the child inherits it
  const pid_t child = start({"fair", path("big.g2"), "-o", path("out.g2"), "--tolerance", "0.1"});
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &old), 0);
  const Outcome outcome = finish(child);
  EXPECT_EQ(outcome.code, 1) << outcome.err;
  EXPECT_TRUE(outcome.err.starts_with("strak: ")) << outcome.err;
  EXPECT_EQ(text("out.g2"), "the old file");
  EXPECT_EQ(files(), (std::vector<std::string>{"big.g2", "in.g2", "out.g2"}));
}

}  // namespace
}  // namespace strak::test
