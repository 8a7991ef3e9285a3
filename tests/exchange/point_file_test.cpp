#include "strak/exchange/point_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>

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

TEST_F(PointFiles, ReadWhatOtherProgramsWrite) {
  Net expected(2, 3);
  expected << 1.5, -2, 3e-2, 4, 5.25, 6;
  // The mark of UTF-8 before the first number, Fortran's exponents, quotes, comments behind the numbers.
  EXPECT_EQ(read("\xEF\xBB\xBF"
                 "1.5,-2,3e-2\n4,5.25,6\n"),
            expected);
  EXPECT_EQ(read("\xEF\xBB\xBFx,y,z\n1.5,-2,3e-2\n4,5.25,6\n"), expected);
  EXPECT_EQ(read("1.5D0 -2.0D+00 3.0d-02\n0.4D1 5.25 6\n"), expected);
  EXPECT_EQ(read("\"1.5\",\"-2\",\"3e-2\"\n'4', \"5.25\" ,6\n"), expected);
  EXPECT_EQ(read("1.5 -2 3e-2 # first\n4 5.25 6 // last\n"), expected);
  EXPECT_EQ(read("1,5;-2;0,03 % first\n4;5,25;6\n"), expected);
  EXPECT_EQ(problem("1 2 3\n4 5 6E\n"), ", line 2: '6E' is not a number: correct or remove it");
  EXPECT_EQ(problem("1 2 3\n4 5D 6\n"), ", line 2: '5D' is not a number: correct or remove it");
  EXPECT_EQ(problem("1 2 3\n4 5 # 6\n"), ", line 2: 2 numbers, where the first row has 3: correct or remove it");
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
  EXPECT_EQ(problem("1 2 nan\n2 3 nan\n"),
            " holds no row of two or more numbers (line 1: 'nan' is not a number): give a point a line");
  EXPECT_EQ(problem(std::string("1 2 3\n\0\n", 8)), " is not a text file: convert the points to text");
  EXPECT_THROW(PointFile("/nowhere/points.txt"), InvalidInput);
  EXPECT_THROW(PointFile("/"), InvalidInput);
}

TEST_F(PointFiles, ReadGridsWithMissingValues) {
  const std::string head = "ncols 3\nnrows 2\nxllcorner 10\nyllcorner 20\ncellsize 2\nNODATA_value -9999\n";
  Net expected(5, 3);
  expected << 11, 23, 1, 13, 23, 2, 11, 21, 4, 13, 21, 5, 15, 21, 6;
  EXPECT_EQ(read(head + "1 2 -9999\n4 5 6\n"), expected);
  EXPECT_EQ(read("ncols 3\nnrows 2\nxllcenter 11\nyllcenter 21\ncellsize 2\nNODATA_value nan\n1 2 nan\n4 5 6\n"),
            expected);
  // Cells need not be squares; without their size there is no grid.
  expected.col(0) << 10.5, 11.5, 10.5, 11.5, 12.5;
  EXPECT_EQ(read("ncols 3\nnrows 2\nxllcorner 10\nyllcorner 20\ndx 1\ndy 2\n1 2 -9999\n4 5 6\n"), expected);
  EXPECT_EQ(problem("ncols 3\nnrows 2\n1 2 -9999\n4 5 6\n"),
            ": a grid needs ncols, nrows and cellsize (or dx and dy) above zero");
  EXPECT_EQ(problem(head + "1 2 3\n4 5\n"),
            " does not hold the 2 x 3 heights that its head announces: it may be damaged");
  EXPECT_EQ(problem(head + "1 2 3\n4 5 6 7\n"),
            " does not hold the 2 x 3 heights that its head announces: it may be damaged");
  EXPECT_EQ(problem("ncols three\n"), ", line 1: 'ncols' needs a number");
}

template <class Number>
std::string bytesOf(std::initializer_list<Number> numbers, bool reversed = false) {
  std::string bytes;
  for (const Number number : numbers) {
    std::string one(sizeof(Number), '\0');
    std::memcpy(one.data(), &number, sizeof(Number));
    if (reversed) std::reverse(one.begin(), one.end());
    bytes += one;
  }
  return bytes;
}

TEST_F(PointFiles, ReadPly) {
  Net expected(2, 3);
  expected << 1.5, -2, 3, 4, 5.25, 6;
  const std::string points = "element vertex 2\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  EXPECT_EQ(read("ply\nformat ascii 1.0\ncomment by a test\n" + points + faces + "1.5 -2 3\n4 5.25 6\n3 0 1 1\n"),
            expected);
  for (const bool big : {false, true}) {
    const std::string format = big ? "binary_big_endian" : "binary_little_endian";
    const std::string body = bytesOf<float>({1.5F, -2, 3, 4, 5.25F, 6}, big);
    const std::string text = "ply\nformat " + format + " 1.0\n" + points + faces + body;
    EXPECT_EQ(read(text + "rest"), expected);
    EXPECT_EQ(problem(text.substr(0, text.size() - 4)),
              " holds 1 of the 2 points that its header announces: it may be damaged");
  }
  const PointFile mixed(
      write("ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty double x\n"
            "property uchar red\nproperty short y\nend_header\n" +
            bytesOf<double>({0.1}) + bytesOf<unsigned char>({200}) + bytesOf<short>({-7})));
  EXPECT_EQ(readPoints(mixed), Net(Eigen::RowVector3d(0.1, 200, -7)));
  EXPECT_EQ(mixed.columnNamed("red"), 1);
  EXPECT_EQ(problem("ply\nformat ascii 1.0\nelement face 1\n"),
            ": the PLY file does not begin with its vertices: write it again with them first");
  EXPECT_EQ(problem("ply\nformat ascii 1.0\n"), ": the header of the point cloud has no end: the file may be damaged");
}

TEST_F(PointFiles, ReadPcdWithMissingPoints) {
  const std::string head =
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\nPOINTS 3\n";
  Net expected(2, 3);
  expected << 1.5, -2, 3, 4, 5.25, 6;
  EXPECT_EQ(read(head + "DATA ascii\n1.5 -2 3\nnan nan nan\n4 5.25 6\n"), expected);
  const float none = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(read(head + "DATA binary\n" + bytesOf<float>({1.5F, -2, 3, none, none, none, 4, 5.25F, 6})), expected);
  EXPECT_EQ(problem(head + "DATA ascii\n1 2 3\n"),
            " holds 1 of the 3 points that its header announces: it may be damaged");
  EXPECT_EQ(problem(head + "DATA folded\n"),
            ": a PCD file with 'folded' points is not understood: convert it to binary");
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
