// Interferograms (MetroPro), made here after the format's description.

#include "strak/exchange/interferogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include "strak/base/error.h"
#include "strak/exchange/point_file.h"

namespace strak {
namespace {

constexpr std::int32_t kInvalid = 2147483640;

template <class Number>
void put(std::string& bytes, std::size_t at, Number number) {
  auto own = std::bit_cast<std::array<char, sizeof(Number)>>(number);
  std::reverse(own.begin(), own.end());
  std::copy(own.begin(), own.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
}

// 3 x 2 samples of 0.5 mm; a wave is 1 micrometre of light in 4096 steps, of surface half of it.
std::string sample(const std::array<std::int32_t, 6>& phases, std::int16_t resolution = 0, float lateral = 5e-4F) {
  std::string bytes(834, '\0');
  bytes.replace(0, 4, "\x88\x1b\x03\x6f");
  put<std::int32_t>(bytes, 6, 834);
  put<std::int32_t>(bytes, 60, 10);  // bytes of intensities
  put<std::uint16_t>(bytes, 68, 3);
  put<std::uint16_t>(bytes, 70, 2);
  put<std::int32_t>(bytes, 72, 24);
  put<float>(bytes, 164, 0.5F);
  put<float>(bytes, 168, 1e-6F);
  put<float>(bytes, 176, 1);
  put<float>(bytes, 184, lateral);
  put<std::int16_t>(bytes, 218, resolution);
  bytes += std::string(10 + 24, '\1');
  for (std::size_t k = 0; k < 6; ++k) put(bytes, 844 + 4 * k, phases[k]);
  return bytes;
}

TEST(Interferogram, HeightsAreMillimetresAndInvalidSamplesMissing) {
  const Net points = interferogramHeights(sample({4096, -2048, kInvalid, 0, kInvalid + 5, 1}));
  ASSERT_EQ(points.rows(), 4);
  Net expected(4, 3);
  expected << 0, 0.5, 5e-4, 0.5, 0.5, -2.5e-4, 0, 0, 0, 1, 0, 5e-4 / 4096;
  EXPECT_LT((points - expected).leftCols(2).cwiseAbs().maxCoeff(), 1e-7);  // floats in the header
  EXPECT_LT((points - expected).col(2).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_NEAR(interferogramHeights(sample({32768, 0, 0, 0, 0, 0}, 1))(0, 2), 5e-4, 1e-10);
  EXPECT_NEAR(interferogramHeights(sample({131072, 0, 0, 0, 0, 0}, 2))(0, 2), 5e-4, 1e-10);
  // Without a calibrated lateral resolution samples are counted.
  EXPECT_EQ(interferogramHeights(sample({0, 0, 0, 0, 0, 0}, 0, 0))(2, 0), 2);
}

TEST(Interferogram, DamagedFilesAreRefused) {
  const std::string good = sample({1, 2, 3, 4, 5, 6});
  for (std::size_t size = 0; size < good.size(); size += 37) {
    EXPECT_THROW(interferogramHeights(good.substr(0, size)), InvalidInput) << size;
  }
  EXPECT_THROW(interferogramHeights(sample({1, 2, 3, 4, 5, 6}, 7)), InvalidInput);
  EXPECT_THROW(interferogramHeights(sample({kInvalid, kInvalid, kInvalid, kInvalid, kInvalid, kInvalid})),
               InvalidInput);
  std::string noPhases = good;
  put<std::uint16_t>(noPhases, 68, 0);
  EXPECT_THROW(interferogramHeights(noPhases), InvalidInput);
  std::string hugeHeader = good;
  put<std::int32_t>(hugeHeader, 6, 2147483647);
  EXPECT_THROW(interferogramHeights(hugeHeader), InvalidInput);
  std::string noWave = good;
  put<float>(noWave, 168, 0);
  EXPECT_THROW(interferogramHeights(noWave), InvalidInput);
}

TEST(Interferogram, IsAPointFileWithColumnsToChoose) {
  const auto path = std::filesystem::temp_directory_path() / "strak-interferogram.dat";
  std::ofstream(path, std::ios::binary) << sample({4096, 0, 0, 0, 0, 0});
  PointFile file(path);
  EXPECT_EQ(file.columnNamed("z"), 2);
  EXPECT_EQ(readPoints(file).rows(), 6);
  file.choose({2, 0});
  EXPECT_EQ(file.columns(), 2);
  EXPECT_EQ(file.columnNamed("z"), 0);
  EXPECT_NEAR(readPoints(file)(0, 0), 5e-4, 1e-10);
  EXPECT_NEAR(readPoints(file)(2, 1), 1, 1e-7);
  file.choose({1});
  EXPECT_EQ(file.columnNamed("x"), 0);
  EXPECT_NEAR(readPoints(file)(2, 0), 1, 1e-7);
  EXPECT_THROW(file.choose({1}), InvalidInput);
  EXPECT_THROW(file.choose({}), InvalidInput);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace strak
