#include "strak/exchange/point_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "strak/base/error.h"

namespace strak {
namespace {

class PointFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("strak-points-") + testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& text) const {
    const auto path = folder_ / "points.txt";
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }
  Net read(const std::string& text) const { return readPoints(PointFile(write(text))); }
  std::string problem(const std::string& text) const {
    try {
      read(text);
    } catch (const InvalidInput& error) {
      const std::string sentence = error.what();
      return sentence.substr(sentence.find("points.txt'") + 11);
    }
    return "";
  }

 private:
  std::filesystem::path folder_;
};

TEST_F(PointFiles, ReadsTheUsualTables) {
  Net expected(2, 3);
  expected << 1.5, -2, 3e-2, 4, 5.25, 6;
  EXPECT_EQ(read("1.5 -2 3e-2\n4 5.25 6\n"), expected);
  EXPECT_EQ(read("1.5,-2,3e-2\r\n4,5.25,6"), expected);
  EXPECT_EQ(read("# a comment\nx,y,z\n1.5, -2 ,\t0.03\n\n% more\n 4,5.25 , +6\n"), expected);
  EXPECT_EQ(read("X [mm];Y [mm];Z [mm]\n1,5;-2;0,03\n4;5,25;6\n"), expected);
  EXPECT_EQ(read("1,5 -2 0,03\n4 5,25 6,0\n"), expected);
  EXPECT_EQ(read("2\nmade by a scanner\n1.5\t-2\t3e-2\n4\t5.25\t6\n"), expected);
}

TEST_F(PointFiles, KnowTheirColumnsByName) {
  const PointFile file(write("# \"Y (m)\" , X_, weight,Z\n1,2,3,4\n"));
  EXPECT_EQ(file.columns(), 4);
  EXPECT_EQ(file.columnNamed("x"), 1);
  EXPECT_EQ(file.columnNamed("y"), 0);
  EXPECT_EQ(file.columnNamed("weight"), 2);
  EXPECT_EQ(file.columnNamed("u"), -1);
}

TEST_F(PointFiles, SayWhichLineIsWrong) {
  EXPECT_EQ(problem("1 2 3\n4 5 six\n"), ", line 2: 'six' is not a number: correct or remove it");
  EXPECT_EQ(problem("x y z\n1 2 3\n4 nan 6\n"), ", line 3: 'nan' is not a number: correct or remove it");
  EXPECT_EQ(problem("1,2,3\n4,,6\n"), ", line 2: '' is not a number: correct or remove it");
  EXPECT_EQ(problem("1 2 3\n\n4 5\n"), ", line 3: 2 numbers, where the first row has 3: correct or remove it");
  EXPECT_EQ(problem(" \n"), " is empty: give a file with a row of numbers a point");
  EXPECT_EQ(problem("hello\nworld\n"), " holds no row of two or more numbers: give a point a line");
  EXPECT_EQ(problem(std::string("1 2 3\n\0\n", 8)), " is not a text file: convert the points to text");
  EXPECT_THROW(PointFile("/nowhere/points.txt"), InvalidInput);
  EXPECT_THROW(PointFile("/"), InvalidInput);
}

TEST_F(PointFiles, ReadGridsWithMissingValues) {
  const std::string head = "ncols 3\nnrows 2\nxllcorner 10\nyllcorner 20\ncellsize 2\nNODATA_value -9999\n";
  Net expected(5, 3);
  expected << 11, 23, 1, 13, 23, 2, 11, 21, 4, 13, 21, 5, 15, 21, 6;
  EXPECT_EQ(read(head + "1 2 -9999\n4 5 6\n"), expected);
  EXPECT_EQ(problem(head + "1 2 3\n4 5\n"),
            " does not hold the 2 x 3 heights that its head announces: it may be damaged");
  EXPECT_EQ(problem(head + "1 2 3\n4 5 6 7\n"),
            " does not hold the 2 x 3 heights that its head announces: it may be damaged");
  EXPECT_EQ(problem("ncols three\n"), ", line 1: 'ncols' needs a number");
}

TEST_F(PointFiles, LongFilesComeWholeAndInOrder) {
  std::string text;
  constexpr Index kRows = 700000;
  for (Index r = 0; r < kRows; ++r) text += std::to_string(r) + " " + std::to_string(r % 7) + ".5\n";
  const PointFile file(write(text));
  Index next = 0, blocks = 0;
  bool inOrder = true;
  file.forEachBlock([&](const Net& block) {
    ++blocks;
    for (Index r = 0; r < block.rows(); ++r, ++next) {
      inOrder =
          inOrder && block(r, 0) == static_cast<double>(next) && block(r, 1) == static_cast<double>(next % 7) + 0.5;
    }
  });
  EXPECT_TRUE(inOrder);
  EXPECT_EQ(next, kRows);
  EXPECT_GT(blocks, 0);
  EXPECT_EQ(problem(text + "1 x\n"), ", line 700001: 'x' is not a number: correct or remove it");
}

}  // namespace
}  // namespace strak
