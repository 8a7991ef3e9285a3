#pragma once
//
// Runs the program `strak` as a person or a script would, on files made by the test.

#include <gtest/gtest.h>
#include <sys/types.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "strak/exchange/model.h"

namespace strak::test {

struct Outcome {
  int code = -1;  // exit code, or 128 + signal
  std::string out, err;
};

// A fresh folder for each test, removed afterwards, and the program to run in it.
class Program : public testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  std::filesystem::path file(const std::string& name) const { return folder_ / name; }
  std::string path(const std::string& name) const { return file(name).string(); }

  // Writes `text` to a new file and returns its path.
  std::string write(const std::string& name, const std::string& text) const;
  std::string text(const std::string& name) const;

  // Starts the program with standard output and error going to files; finish() waits for it.
  pid_t start(const std::vector<std::string>& arguments) const;
  Outcome finish(pid_t process) const;
  Outcome strak(const std::vector<std::string>& arguments) const { return finish(start(arguments)); }

  // The JSON of a run that must succeed.
  nlohmann::json json(std::vector<std::string> arguments) const;

  // The one sentence of a run that must fail with 2 and leave nothing behind.
  std::string refusal(const std::vector<std::string>& arguments) const;

  // The names of all files in the folder, hidden ones too, without the captured output.
  std::vector<std::string> files() const;

 private:
  std::filesystem::path folder_;
};

// A .g2 text of one surface; 17 digits, so that a reader gets every bit.
std::string g2(const Surface& surface);
std::string g2(const Curve& curve);

// A gently curved surface with repeatable noise on its inner control points: nu x nv points, uniform clamped knots on
// [0, 1] x [0, 2], about 10 x 8 units large.
Surface wavySurface(int degree, Index nu, Index nv, double noise = 0.02);
Curve wavyCurve(int degree, Index n, double noise = 0.05);

// The first spline of a file.
Surface readSurface(const std::filesystem::path& path);

}  // namespace strak::test
