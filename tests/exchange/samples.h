#pragma once
//
// What the tests of this room share: splines with seeded numbers, a folder of their own, the real files.

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "strak/base/error.h"
#include "strak/base/file.h"
#include "strak/exchange/model.h"

namespace strak::test {

// A folder that lives as long as the test.
class Folder {
 public:
  Folder() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::temp_directory_path() /
            (std::string("strak-") + info->test_suite_name() + "-" + info->name() + "-" + std::to_string(::getpid()));
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }

 private:
  std::filesystem::path path_;
};

// A real file, or an empty path where the data are not at hand.
inline std::filesystem::path dataFile(const std::string& name) {
  const char* folder = std::getenv("STRAK_DATA");
  const std::filesystem::path path = std::filesystem::path(folder ? folder : STRAK_SOURCE_DIR "/../shared/data") / name;
  return std::filesystem::exists(path) ? path : std::filesystem::path();
}

// What a change of a model must not do: make faces invalid, open edges, loosen their tolerances.
inline void expectNothingWorse(const Audit& before, const Audit& after, double size) {
  EXPECT_LE(after.invalidFaces, before.invalidFaces);
  EXPECT_EQ(after.valid, before.valid);
  ASSERT_EQ(after.edges.size(), before.edges.size());
  for (std::size_t e = 0; e < after.edges.size(); ++e) {
    EXPECT_LT(after.edges[e].gap - before.edges[e].gap, 1e-9 * size) << after.edges[e].name;
    EXPECT_LE(after.edges[e].tolerance, before.edges[e].tolerance);
  }
}

// Clamped, with random steps and inner knots of multiplicity up to the degree.
inline KnotVector randomKnots(std::mt19937& random, int degree, Index size) {
  std::uniform_real_distribution<double> step(0.1, 1.0);
  double at = step(random) - 3;
  std::vector<double> knots(static_cast<std::size_t>(degree) + 1, at);
  int multiplicity = degree;  // the first inner knot is a new one
  for (Index i = 0; i < size - degree - 1; ++i) {
    multiplicity = multiplicity < degree && random() % 4 == 0 ? multiplicity + 1 : 1;
    if (multiplicity == 1) at += step(random);
    knots.push_back(at);
  }
  knots.insert(knots.end(), static_cast<std::size_t>(degree) + 1, at + step(random));
  return KnotVector(degree, std::move(knots));
}

// Random degrees 1..5, knots with repetitions, points of the given dimension.
template <int D>
Spline<D> randomSpline(std::mt19937& random, int dimension = 3, bool rational = false) {
  std::array<KnotVector, D> knots;
  Index points = 1;
  for (auto& k : knots) {
    const int degree = 1 + static_cast<int>(random() % 5);
    k = randomKnots(random, degree, degree + 1 + static_cast<Index>(random() % 6));
    points *= k.size();
  }
  std::uniform_real_distribution<double> number(-100, 100);
  Net net(points, dimension + (rational ? 1 : 0));
  for (Index r = 0; r < points; ++r) {
    for (Index c = 0; c < net.cols(); ++c) net(r, c) = number(random) / 3;
    if (rational) net(r, dimension) = 1 + std::abs(net(r, dimension));
  }
  return Spline<D>(std::move(knots), std::move(net), rational);
}

// Random changes of a text: cut off, bytes, digits, pieces taken out or doubled.
inline std::string mutated(const std::string& text, std::mt19937& random) {
  std::string result = text;
  const auto place = [&] { return random() % result.size(); };
  switch (random() % 5) {
    case 0:
      result.resize(place());
      break;
    case 1:
      for (auto k = 1 + random() % 8; k > 0; --k) result[place()] = static_cast<char>(random() % 256);
      break;
    case 2:
      for (auto k = 1 + random() % 6; k > 0; --k) {
        const std::size_t at = result.find_first_of("0123456789", place());
        if (at != result.npos) result[at] = static_cast<char>('0' + random() % 10);
      }
      break;
    case 3:
      result.erase(place(), random() % 200);
      break;
    default: {
      const std::size_t at = place();
      result.insert(at, text.substr(random() % text.size(), 1 + random() % 200));
    }
  }
  return result;
}

// The message of the InvalidInput that `call` must throw.
template <typename Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const InvalidInput& error) {
    return error.what();
  } catch (const std::exception& error) {
    ADD_FAILURE() << "another exception: " << error.what();
    return "";
  }
  ADD_FAILURE() << "no exception";
  return "";
}

}  // namespace strak::test
