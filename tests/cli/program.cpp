#include "tests/cli/program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <random>
#include <stdexcept>

extern char** environ;

namespace strak::test {

namespace {

constexpr const char* kOut = ".captured-out";
constexpr const char* kErr = ".captured-err";

std::string knotsText(const KnotVector& knots) {
  std::string text = fmt::format("{} {}\n", knots.size(), knots.degree() + 1);
  for (double u : knots.knots()) text += fmt::format("{:.17g} ", u);
  return text + "\n";
}

std::string rowText(const Net& net, Index row) {
  std::string text;
  for (Index c = 0; c < net.cols(); ++c) text += fmt::format("{:.17g} ", net(row, c));
  return text + "\n";
}

double noiseOf(std::mt19937_64& source, double noise) {
  return noise * (2 * static_cast<double>(source() >> 11) * 0x1p-53 - 1);
}

}  // namespace

void Program::SetUp() {
  std::string pattern = (std::filesystem::temp_directory_path() / "strak-cli-XXXXXX").string();
  ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
  folder_ = pattern;
}

void Program::TearDown() {
  std::error_code ignored;
  std::filesystem::permissions(folder_, std::filesystem::perms::owner_all, ignored);
  std::filesystem::remove_all(folder_, ignored);
}

std::string Program::write(const std::string& name, const std::string& content) const {
  std::ofstream(file(name), std::ios::binary) << content;
  return path(name);
}

std::string Program::text(const std::string& name) const {
  std::ifstream in(file(name), std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

pid_t Program::start(const std::vector<std::string>& arguments) const {
  std::vector<std::string> words{STRAK_PROGRAM};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (auto& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, path(kOut).c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, path(kErr).c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  pid_t process = -1;
  const int error = ::posix_spawn(&process, STRAK_PROGRAM, &actions, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::runtime_error(std::string("cannot start ") + STRAK_PROGRAM);
  return process;
}

Outcome Program::finish(pid_t process) const {
  int status = 0;
  EXPECT_EQ(::waitpid(process, &status, 0), process);
  Outcome outcome;
  outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  outcome.out = text(kOut);
  outcome.err = text(kErr);
  return outcome;
}

nlohmann::json Program::json(std::vector<std::string> arguments) const {
  arguments.emplace_back("--json");
  const Outcome outcome = strak(arguments);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(nlohmann::json::accept(outcome.out)) << outcome.out;
  return nlohmann::json::parse(outcome.out, nullptr, false);
}

std::string Program::refusal(const std::vector<std::string>& arguments) const {
  const auto before = files();
  const Outcome outcome = strak(arguments);
  EXPECT_EQ(outcome.code, 2) << outcome.err;
  EXPECT_EQ(files(), before);
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  return outcome.err;
}

std::vector<std::string> Program::files() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
    const std::string name = entry.path().filename().string();
    if (name != kOut && name != kErr) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string g2(const Surface& surface) {
  std::string text = fmt::format("200 1 0 0\n{} {}\n", surface.pointDimension(), surface.isRational() ? 1 : 0);
  text += knotsText(surface.knots(0)) + knotsText(surface.knots(1));
  for (Index j = 0; j < surface.size(1); ++j) {
    for (Index i = 0; i < surface.size(0); ++i) text += rowText(surface.net(), surface.row({i, j}));
  }
  return text;
}

std::string g2(const Curve& curve) {
  std::string text = fmt::format("100 1 0 0\n{} {}\n", curve.pointDimension(), curve.isRational() ? 1 : 0);
  text += knotsText(curve.knots(0));
  for (Index i = 0; i < curve.size(0); ++i) text += rowText(curve.net(), i);
  return text;
}

Surface wavySurface(int degree, Index nu, Index nv, double noise) {
  std::mt19937_64 source(42);
  Net net(nu * nv, 3);
  for (Index i = 0; i < nu; ++i) {
    for (Index j = 0; j < nv; ++j) {
      const double x = 10 * static_cast<double>(i) / static_cast<double>(nu - 1);
      const double y = 8 * static_cast<double>(j) / static_cast<double>(nv - 1);
      net.row(i * nv + j) << x, y, 0.05 * (x - 5) * (x - 5) + 0.04 * (y - 4) * (y - 4);
      const bool inner = i > 1 && j > 1 && i < nu - 2 && j < nv - 2;
      for (Index c = 0; c < 3; ++c) net(i * nv + j, c) += inner ? noiseOf(source, noise) : 0;
    }
  }
  return Surface(
      {KnotVector::uniformClamped(degree, nu - degree), KnotVector::uniformClamped(degree, nv - degree, 0, 2)}, net);
}

Curve wavyCurve(int degree, Index n, double noise) {
  std::mt19937_64 source(7);
  Net net(n, 3);
  for (Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(n - 1);
    net.row(i) << 10 * t, 3 * std::sin(3 * t), t * t;
    for (Index c = 0; c < 3; ++c) net(i, c) += noiseOf(source, noise);
  }
  return Curve({KnotVector::uniformClamped(degree, n - degree)}, net);
}

Surface readSurface(const std::filesystem::path& path) {
  return std::get<Surface>(readModel(path)->objects().at(0).spline.value());
}

}  // namespace strak::test
