#pragma once
//
// Measured points, read block by block: tables of numbers (.xyz, .csv, .txt, .dat, with or without header and comments,
// decimal points or commas), gridded heights (ESRI ASCII grids, USGS DEM, .gtx, interferograms; with missing values),
// point clouds (PLY and PCD, in text, binary or compressed form; LAS, .g2) and the vertices of meshes (OBJ, STL, OFF).
//
// Any of them may be packed by gzip. Tables, ESRI grids and clouds that are not compressed may be larger than memory;
// the others are kept.

#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "strak/exchange/cloud_layout.h"
#include "strak/exchange/table_text.h"
#include "strak/spline/spline.h"

namespace strak {

class PointFile {
 public:
  // Looks at the head of the file. Throws InvalidInput if it cannot be read, is empty or holds no row of numbers.
  explicit PointFile(std::filesystem::path path);

  // Keeps these of the columns() only, from 0, in this order. Throws InvalidInput if there is none or the file has
  // not so many.
  void choose(const std::vector<Index>& columns);

  // Numbers a row; of a grid 3: x, y and the height.
  Index columns() const { return chosen_.empty() ? columns_ : static_cast<Index>(chosen_.size()); }
  // The header's names, lower case, one a column; empty if there is none.
  const std::vector<std::string>& names() const { return names_; }
  // The column of that name, or -1.
  Index columnNamed(const std::string& name) const;
  std::uintmax_t bytes() const { return bytes_; }

  // Calls `visit` with all rows in the order of the file, some 10^4 to 10^6 at a time. Parsed by all threads; the same
  // blocks whenever it is called. Points of clouds that are not finite are missing ones and left out. Throws
  // InvalidInput with the number of the line that is not a row of `columns()` numbers, or if the file ends too early.
  void forEachBlock(const std::function<void(const Net&)>& visit) const;

 private:
  void readHead();
  void forEachRawBlock(const std::function<void(const Net&)>& visit) const;
  void readGridHead(const std::string& text);
  void forEachBinaryBlock(const std::function<void(const Net&)>& visit) const;
  void forEachTextBlock(const std::function<void(const Net&)>& visit) const;

  std::shared_ptr<const std::filesystem::path> unpacked_;  // of a packed file
  std::filesystem::path path_;                             // what is read
  std::string name_;                                       // what the user calls it
  std::uintmax_t bytes_ = 0;
  Index columns_ = 0;  // of the file
  std::vector<std::string> names_;
  std::vector<Index> chosen_;  // all columns if empty
  TableDialect dialect_;
  Index headLines_ = 0;  // before the first row
  std::uintmax_t headBytes_ = 0;

  std::optional<Net> kept_;  // of files that are read as a whole
  std::optional<CloudLayout> cloud_;
  bool grid_ = false;
  Index gridColumns_ = 0, gridRows_ = 0;
  double left_ = 0, bottom_ = 0, missing_ = -9999;
  std::array<double, 2> cell_{};
};

// All rows of the file.
Net readPoints(const PointFile& file);

}  // namespace strak
