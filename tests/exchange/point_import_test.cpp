// Files of points that are read as a whole.

#include "strak/exchange/point_import.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstdlib>
#include <fstream>
#include <functional>

#include "strak/base/error.h"
#include "strak/exchange/lzf.h"
#include "strak/exchange/point_file.h"

namespace strak {
namespace {

template <class Number>
std::string bytesOf(const std::vector<Number>& numbers, bool bigEndian = false) {
  std::string bytes;
  for (const Number number : numbers) {
    auto own = std::bit_cast<std::array<char, sizeof(Number)>>(number);
    if (bigEndian) std::reverse(own.begin(), own.end());
    bytes.append(own.data(), own.size());
  }
  return bytes;
}

class PointImport : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("strak-import-") + testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path file(const std::string& name, const std::string& text) const {
    const auto path = folder_ / name;
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }
  Net read(const std::string& name, const std::string& text) const {
    const PointFile points(file(name, text));
    EXPECT_EQ(points.columnNamed("z"), 2);
    return readPoints(points);
  }
  std::string problem(const std::string& name, const std::string& text) const {
    try {
      read(name, text);
    } catch (const InvalidInput& error) {
      const std::string sentence = error.what();
      return sentence.substr(sentence.find(name + "'") + name.size() + 1);
    }
    return "";
  }
  // Every beginning of the file is read or refused with a sentence.
  void expectNoHarm(const std::string& name, const std::string& text) const {
    for (std::size_t size = 1; size < text.size(); size += 1 + size / 16) {
      try {
        read(name, text.substr(0, size));
      } catch (const InvalidInput&) {
        continue;
      }
    }
  }

 private:
  std::filesystem::path folder_;
};

Net rows(std::initializer_list<std::array<double, 3>> points) {
  Net net(static_cast<Index>(points.size()), 3);
  Index r = 0;
  for (const auto& p : points) net.row(r++) << p[0], p[1], p[2];
  return net;
}

TEST_F(PointImport, TakesTheVerticesOfObjAndOff) {
  const Net expected = rows({{1.5, -2, 0.03}, {4, 5.25, 6}, {0, 0, 1}});
  EXPECT_EQ(read("a.obj", "# made\nmtllib a.mtl\nv 1.5 -2 3e-2\nvn 0 0 1\nv 4 5.25 +6 1.0\nf 1 2 3\r\n\tv 0 0 1\r\n"),
            expected);
  EXPECT_EQ(read("A.OFF", "OFF\n# a comment\n3 1 0\n1.5 -2 3e-2\n\n4 5.25 6\n0 0 1\n3 0 1 2\n"), expected);
  EXPECT_EQ(read("b.off", "OFF 3 1 0 # counts\n1.5 -2 3e-2\n4 5.25 6 255 0 0\n0 0 1"), expected);
  EXPECT_EQ(problem("a.obj", "v 1 2 x\n"), ": line 1: 'x' where a number is expected");
  EXPECT_EQ(problem("a.obj", "f 1 2 3\n"), ": there is no vertex in the file (no line 'v x y z')");
  EXPECT_EQ(problem("a.off", "OFF\n3 0 0\n1 2 3\n"),
            ": the OFF file holds 1 of the 3 vertices that it announces: it may be damaged");
  EXPECT_NE(problem("a.off", "nOFF\n4 1 0 0\n"), "");
}

// A LAS file with records of 28 bytes (format 1) and a block between head and points.
std::string lasFile(int minor, const std::vector<std::array<std::int32_t, 3>>& points, std::uint8_t format = 1) {
  constexpr std::size_t kRecord = 28, kBetween = 54;
  const std::size_t size = minor >= 4 ? 375 : minor == 3 ? 235 : 227;
  std::string head(size, '\0');
  const auto put = [&](std::size_t at, const std::string& bytes) { head.replace(at, bytes.size(), bytes); };
  put(0, "LASF");
  put(24, std::string{1, static_cast<char>(minor)});
  put(94, bytesOf<std::uint16_t>({static_cast<std::uint16_t>(size)}));
  put(96, bytesOf<std::uint32_t>({static_cast<std::uint32_t>(size + kBetween), 1}));
  put(104, std::string(1, static_cast<char>(format)));
  put(105, bytesOf<std::uint16_t>({kRecord}));
  if (minor < 4) put(107, bytesOf<std::uint32_t>({static_cast<std::uint32_t>(points.size())}));
  if (minor >= 4) put(247, bytesOf<std::uint64_t>({points.size()}));
  put(131, bytesOf<double>({0.25, 0.5, 0.125, 500000, 4000000, -100}));
  std::string file = head + std::string(kBetween, 'v');
  for (const auto& p : points) file += bytesOf<std::int32_t>({p[0], p[1], p[2]}) + std::string(kRecord - 12, 'i');
  return file;
}

TEST_F(PointImport, ReadsLaserScans) {
  const std::vector<std::array<std::int32_t, 3>> raw{{4, -2, 8}, {0, 0, 0}, {2147483647, 1, -2147483647 - 1}};
  const Net expected = rows({{500001, 3999999, -99}, {500000, 4000000, -100}, {537370911.75, 4000000.5, -268435556}});
  for (const int minor : {0, 2, 3, 4}) {
    EXPECT_EQ(read("scan.las", lasFile(minor, raw)), expected) << minor;
    expectNoHarm("scan.las", lasFile(minor, raw));
  }
  EXPECT_NE(problem("scan.laz", lasFile(2, raw, 0x81)).find("compressed (LAZ), which is not read"), std::string::npos);
  const std::string whole = lasFile(2, raw);
  EXPECT_EQ(problem("scan.las", whole.substr(0, whole.size() - 30)),
            " holds 1 of the 3 points that its header announces: it may be damaged");
  EXPECT_NE(problem("scan.las", whole.substr(0, 100)).find("ends within its header"), std::string::npos);
  std::string broken = whole;
  broken.replace(131, 8, 8, '\0');
  EXPECT_NE(problem("scan.las", broken).find("factor or offset of x"), std::string::npos);
}

TEST_F(PointImport, TakesTheVerticesOfStlOnce) {
  const Net expected = rows({{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5}, {1, 1, 2}});
  const std::string triangle = "facet normal 0 0 1\n outer loop\n";
  const std::string ascii = "solid part\n" + triangle +
                            "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0.5\nendloop\nendfacet\n" + triangle +
                            "vertex 1 0 0\n vertex 1 1 2\nvertex 0 1 5e-1\nendloop\nendfacet\nendsolid\n";
  EXPECT_EQ(read("a.stl", ascii), expected);
  std::string capitals = ascii;
  std::transform(capitals.begin(), capitals.end(), capitals.begin(), [](unsigned char c) { return std::toupper(c); });
  EXPECT_EQ(read("capitals.stl", capitals), expected);
  EXPECT_EQ(problem("c.stl", ascii.substr(0, ascii.rfind("endsolid"))),
            ": the file ends without 'endsolid': it may be damaged");
  const auto binaryTriangle = [](const std::vector<float>& vertices) {
    return bytesOf<float>({0, 0, 1}) + bytesOf<float>(vertices) + std::string(2, '\0');
  };
  // Some programs begin binary files with "solid", too.
  const std::string binary = std::string("solid") + std::string(75, ' ') + bytesOf<std::uint32_t>({2}) +
                             binaryTriangle({0, 0, 0, 1, 0, 0, 0, 1, 0.5F}) +
                             binaryTriangle({1, 0, 0, 1, 1, 2, 0, 1, 0.5F});
  EXPECT_EQ(read("b.stl", binary), expected);
  EXPECT_EQ(problem("c.stl", std::string(80, ' ') + binary.substr(80, 60)),
            ": the STL file is shorter than it says: it may be damaged");
  expectNoHarm("d.stl", binary);
  expectNoHarm("d.stl", ascii);
}

TEST_F(PointImport, TakesThePointsOfG2Clouds) {
  const Net expected = rows({{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5}, {1, 1, 2}});
  const std::string first = "400 1 0 0\n3\n0 0 0\n1 0 0\n0 1 0.5\n", second = "400 1 0 4 255 0 0 255\n1\n1 1 2\n";
  const std::string line = "100 1 0 0\n3 0\n2 2\n0 0 1 1\n0 0 0\n1 1 1\n";
  EXPECT_EQ(read("a.g2", first + second), expected);
  EXPECT_EQ(read("a.g2", line + "\n" + first + line + second), expected);
  EXPECT_EQ(read("a.txt", first + second), expected);  // by its content
  EXPECT_EQ(problem("a.g2", line), ": the .g2 file holds no point cloud (class 400): give measured points");
  EXPECT_EQ(problem("a.g2", first.substr(0, first.size() - 4)),
            ": line 5: the file ends where a coordinate should be: it is cut off");
  EXPECT_EQ(problem("a.g2", "400 1 0 0\n9999999\n1 2 3\n"),
            ": line 2: the file is too short for 9999999 points: it may be damaged");
  EXPECT_NE(problem("a.g2", "400 1 0 0\n1\n1 2 nan\n"), "");
  expectNoHarm("a.g2", line + first + second);
}

TEST_F(PointImport, PassesOverListsAndElementsOfPlyFiles) {
  const Net expected = rows({{1, 2, 3}, {4, 5, -6}, {7, 8, 9.5}});
  const std::string head =
      "element sensor 2\nproperty float a\nproperty list uchar short b\nelement vertex 3\nproperty double x\n"
      "property list uchar int marks\nproperty double y\nproperty double z\nend_header\n";
  const std::string ascii = "ply\nformat ascii 1.0\n" + head + "0.5 2 7 8\n1.5 0\n1 2 9 9 2 3\n4 0 5 -6\n7 1 3 8 9.5\n";
  EXPECT_EQ(read("a.ply", ascii), expected);
  for (const bool big : {false, true}) {
    const auto real = [&](double value) { return bytesOf<double>({value}, big); };
    const std::string bytes = std::string("ply\nformat ") + (big ? "binary_big_endian" : "binary_little_endian") +
                              " 1.0\n" + head + bytesOf<float>({0.5F}, big) + '\2' +
                              bytesOf<std::int16_t>({7, 8}, big) + bytesOf<float>({1.5F}, big) + '\0' + real(1) + '\2' +
                              bytesOf<std::int32_t>({9, 9}, big) + real(2) + real(3) + real(4) + '\0' + real(5) +
                              real(-6) + real(7) + '\1' + bytesOf<std::int32_t>({3}, big) + real(8) + real(9.5);
    EXPECT_EQ(read("b.ply", bytes), expected);
    EXPECT_EQ(problem("b.ply", bytes.substr(0, bytes.size() - 3)),
              ": the PLY file ends within its points: it may be damaged");
    expectNoHarm("b.ply", bytes);
  }
  EXPECT_EQ(problem("a.ply",
                    "ply\nformat ascii 1.0\nelement x 99999999999\nelement vertex 9\nproperty float x\nend_header\n"),
            ": the PLY file ends within its points: it may be damaged");
  EXPECT_EQ(problem("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar blob b\nend_header\n0\n"),
            ": the PLY file has a property of type 'blob', which is not understood");
  const std::string rest = "property list uchar int b\nproperty float x\nend_header\n1 2 3\n";
  EXPECT_EQ(problem("a.ply", "ply\nformat ascii 1.0\nelement vertex 3e5\n" + rest),
            ": the PLY file's header says '3e5' where a number of vertex is expected");
  EXPECT_EQ(problem("a.ply", "ply\nformat ascii 1.0\nelement vertex -1\n" + rest),
            ": the PLY file's header says '-1' where a number of vertex is expected");
  EXPECT_EQ(problem("a.ply", "ply\nformat binary 1.0\nelement vertex 1\n" + rest),
            ": a PLY file of format 'binary' is not understood");
}

TEST_F(PointImport, PutsAirfoilsInOneOrder) {
  const std::string upper = " 0.0 0.0\n 0.5 0.1\n 1.0 0.01\n", lower = " 0.0 0.0\n 0.4 -0.05\n 1.0 0.0\n";
  const auto pointsOf = [&](const std::string& name, const std::string& text) {
    const auto path = file(name, text);
    return readPoints(PointFile(path));
  };
  Net expected(5, 2);
  expected << 1, 0.01, 0.5, 0.1, 0, 0, 0.4, -0.05, 1, 0;
  EXPECT_EQ(pointsOf("lednicer.dat", "A WING\n  3.  3.\n\n" + upper + "\n" + lower), expected);
  EXPECT_EQ(pointsOf("selig.dat", "A WING\n 1.0 0.01\n 0.5 0.1\n" + lower), expected);
  // Numbers that do not count the rows are a point.
  EXPECT_EQ(pointsOf("points.dat", "3 4\n" + upper + lower).rows(), 7);
}

TEST_F(PointImport, ReadsCompressedClouds) {
  // Field by field: the first stands as literals, the second copies "nothing new" from 12 bytes before.
  const std::string x = bytesOf<float>({1, 2, 3}), z = bytesOf<float>({7, 8, 9});
  const std::string packed = std::string(1, static_cast<char>(11)) + x +                     // 12 literals
                             std::string{static_cast<char>(7U << 5U), 12 - 7 - 2, 12 - 1} +  // 12 bytes from 12 before
                             std::string(1, static_cast<char>(11)) + z;
  const auto file = [](const std::string& data, std::uint32_t size) {
    return "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\nPOINTS 3\n"
           "DATA binary_compressed\n" +
           bytesOf<std::uint32_t>({static_cast<std::uint32_t>(data.size()), size}) + data;
  };
  EXPECT_EQ(read("a.pcd", file(packed, 36)), rows({{1, 1, 7}, {2, 2, 8}, {3, 3, 9}}));
  EXPECT_NE(problem("a.pcd", file(packed, 37)).find("another size"), std::string::npos);
  EXPECT_NE(problem("a.pcd", file(packed.substr(0, 20), 36)).find("compressed points are damaged"), std::string::npos);
  expectNoHarm("b.pcd", file(packed, 36));
}

TEST(Lzf, GivesBackWhatWasCompressedAndRefusesTheRest) {
  EXPECT_EQ(lzfDecompressed("", 0), "");
  EXPECT_EQ(lzfDecompressed(std::string("\x02") + "abc", 3), "abc");
  // A copy that runs into itself: 1 literal, then 8 bytes from 1 before.
  EXPECT_EQ(lzfDecompressed(std::string{'\0', 'a', static_cast<char>(6U << 5U), '\0'}, 9), "aaaaaaaaa");
  // ... and a long one: 7 + 200 + 2 bytes from 2 before.
  const std::string longOne =
      lzfDecompressed(std::string{'\1', 'a', 'b', static_cast<char>(7U << 5U), static_cast<char>(200), '\1'}, 211);
  EXPECT_EQ(longOne.substr(0, 6), "ababab");
  EXPECT_EQ(longOne.size(), 211);
  for (const std::string& bad : {std::string("\x05") + "abc", std::string(1, static_cast<char>(0x20)),
                                 std::string{static_cast<char>(0x20), '\0'}, std::string{'\0', 'a'}}) {
    EXPECT_THROW(lzfDecompressed(bad, 3), InvalidInput);
  }
  EXPECT_THROW(lzfDecompressed("abc", std::size_t{1} << 40U), InvalidInput);
}

TEST_F(PointImport, ReadsGridsOfHeights) {
  const std::string gtx = bytesOf<double>({10, 20, 0.5, 0.25}, true) + bytesOf<std::int32_t>({2, 3}, true) +
                          bytesOf<float>({1, 2, -88.8888F, 4, 5, 6}, true);
  EXPECT_EQ(read("a.gtx", gtx), rows({{20, 10, 1}, {20.25, 10, 2}, {20, 10.5, 4}, {20.25, 10.5, 5}, {20.5, 10.5, 6}}));
  EXPECT_NE(problem("a.gtx", gtx.substr(0, 50)).find("2 x 3 heights"), std::string::npos);
  expectNoHarm("a.gtx", gtx);

  // Two profiles: one of 200 heights goes over two blocks, one begins farther north and has a hole.
  std::string a(1024, ' ');
  a.replace(0, 8, "A SMALL ");
  a.replace(144, 6, "     1");
  a.replace(816, 36, "0.300000E+020.100000E+020.500000E+00");
  a.replace(852, 12, "     1     2");
  const auto profile = [](int number, double x, double y, const std::vector<int>& heights) {
    std::string text =
        fmt::format("{:6}{:6}{:6}{:6}{:24.15E}{:24.15E}{:24.15E}", 1, number, heights.size(), 1, x, y, 100.0);
    std::replace(text.begin(), text.end(), 'E', 'D');
    text.resize(144, ' ');
    for (const int height : heights) {
      if (text.size() % 1024 + 6 > 1020) text.resize((text.size() / 1024 + 1) * 1024, ' ');
      text += fmt::format("{:6}", height);
    }
    text.resize((text.size() + 1023) / 1024 * 1024, ' ');
    return text;
  };
  std::vector<int> first(200);
  for (int i = 0; i < 200; ++i) first[static_cast<std::size_t>(i)] = 3 * i;
  const std::string dem = a + profile(1, 1000, 2000, first) + profile(2, 1030, 2050, {8, -32767, 10});
  const Net points = read("a.dem", dem);
  ASSERT_EQ(points.rows(), 202);
  for (Index i = 0; i < 200; ++i) {
    EXPECT_EQ(points.row(i),
              Eigen::RowVector3d(1000, 2000 + 10.0 * static_cast<double>(i), 100 + 1.5 * static_cast<double>(i)));
  }
  EXPECT_EQ(points.row(200), Eigen::RowVector3d(1030, 2050, 104));
  EXPECT_EQ(points.row(201), Eigen::RowVector3d(1030, 2070, 105));
  EXPECT_NE(problem("a.dem", dem.substr(0, 3 * 1024)).find("1 of the 2 profiles"), std::string::npos);
  expectNoHarm("a.dem", dem);
}

TEST_F(PointImport, ReadsCornealTopographies) {
  const std::string head = "SIM-k : \r\nK1 = 41,46 D\r\nN\xb0 Anelli : 2\r\nN\xb0 Semimeridiani : 4\r\n-----\r\n";
  const std::string body =
      "0,5\r\n0,5\r\n0,5\r\n-1\r\n1\r\n1,5\r\n1\r\n1\r\n"
      "-0,1\r\n-0,2\r\n-1000\r\n-1\r\n0,5\r\n0,6\r\n0,7\r\n0,8\r\n";
  const Net points = read("eye.txt", head + body);
  const Net expected = rows({{0.5, 0, -0.1}, {0, 0.5, -0.2}, {1, 0, 0.5}, {0, 1.5, 0.6}, {-1, 0, 0.7}, {0, -1, 0.8}});
  ASSERT_EQ(points.rows(), expected.rows());
  EXPECT_LT((points - expected).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_NE(problem("eye.txt", head + body.substr(5)).find("15 numbers"), std::string::npos);
  expectNoHarm("eye.txt", head + body);
}

TEST(PointImportOfRealFiles, IsWhatOtherProgramsRead) {
  const char* named = std::getenv("STRAK_DATA");
  const std::filesystem::path folder = named != nullptr ? named : STRAK_SOURCE_DIR "/../shared/data";
  if (!std::filesystem::exists(folder / "grid")) GTEST_SKIP() << "real files are not here: set STRAK_DATA";
  struct Known {
    std::string name;
    Index points;
    std::array<double, 3> box;  // extents; 0: not known
  };
  for (const Known& known :
       {Known{"scan/car6.pcd", 10031, {6.219, 6.68, 1.56}}, Known{"scan/blade.off", 8231, {9.9982, 129.19, 0.64824}},
        Known{"scan/ALSTOM_TEST4.off", 1138, {862.52, 188.4, 269.87}},
        Known{"grid/egm96_15.gtx", 1038240, {359.75, 180, 192.38}}, Known{"lens/cornea_N01.txt", 5384, {0, 0, 1.992}},
        Known{"grid/SainteHelens.dem", 148885, {0, 0, 1861}}}) {
    const Net points = readPoints(PointFile(folder / known.name));
    EXPECT_EQ(points.rows(), known.points) << known.name;
    const Point box = points.colwise().maxCoeff() - points.colwise().minCoeff();
    for (Index c = 0; c < 3; ++c) {
      const double extent = known.box[static_cast<std::size_t>(c)];
      if (extent > 0) {
        EXPECT_NEAR(box[c], extent, 2e-3 * extent) << known.name;
      }
    }
  }
}

}  // namespace
}  // namespace strak
