#include "strak/exchange/point_file.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string_view>

#include "strak/base/error.h"
#include "strak/exchange/packed_file.h"
#include "strak/exchange/point_import.h"
#include "strak/exchange/table_text.h"

namespace strak {

namespace {

constexpr std::size_t kHead = std::size_t{1} << 16;         // bytes looked at to find out what the file is
constexpr std::size_t kBlock = std::size_t{1} << 23;        // bytes parsed at once
constexpr std::size_t kRecordBlock = std::size_t{1} << 21;  // ... of records, that all stays in the cache
constexpr Index kRows = 4096;                               // of records, by one task
constexpr std::size_t kChunk = std::size_t{1} << 18;        // ... by one task
constexpr Index kKeptRows = 100000;                         // handed out at once
constexpr std::size_t kShown = 40;                          // characters of a line that a message shows

// Without the rows that hold a number that is not finite.
Net finiteRows(const Net& block) {
  if (block.allFinite()) return block;
  Net rows(block.rows(), block.cols());
  Index count = 0;
  for (Index r = 0; r < block.rows(); ++r) {
    if (block.row(r).allFinite()) rows.row(count++) = block.row(r);
  }
  rows.conservativeResize(count, Eigen::NoChange);
  return rows;
}

std::string tooShort(const std::string& name, Index has, Index announced) {
  return fmt::format("'{}' holds {} of the {} points that its header announces: it may be damaged", name, has,
                     announced);
}

}  // namespace

PointFile::PointFile(std::filesystem::path path) : path_(std::move(path)), name_(path_.string()) {
  if (isPacked(path_)) {
    unpacked_ = unpacked(path_);
    path_ = *unpacked_;
  }
  readHead();
}

void PointFile::readHead() {
  std::error_code error;
  if (std::filesystem::is_directory(path_, error)) {
    throw InvalidInput(fmt::format("'{}' is a folder: give a file of points", name_));
  }
  std::ifstream in(path_, std::ios::binary);
  if (!in) throw InvalidInput(fmt::format("cannot read '{}': check the name and the permissions", name_));
  bytes_ = std::filesystem::file_size(path_, error);
  std::string head(kHead, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  if (head.find_first_not_of(" \t\r\n") == head.npos) {
    throw InvalidInput(fmt::format("'{}' is empty: give a file with a row of numbers a point", name_));
  }
  try {
    if (auto whole = importPoints(path_, head)) {
      columns_ = whole->points.cols();
      for (const auto& name : whole->names) names_.push_back(plainName(name));
      kept_ = std::move(whole->points);
      return;
    }
    cloud_ = cloudLayout(head);
  } catch (const InvalidInput& problem) {
    throw InvalidInput(fmt::format("'{}': {}", name_, problem.what()));
  }
  if (cloud_) {
    columns_ = static_cast<Index>(cloud_->fields.size());
    headLines_ = cloud_->headLines;
    headBytes_ = cloud_->headBytes;
    for (const auto& field : cloud_->fields) names_.push_back(plainName(field.name));
    return;
  }
  if (head.find('\0') != head.npos) {
    throw InvalidInput(fmt::format("'{}' is not a text file: convert the points to text", name_));
  }
  if (lowered(trimmed(head).substr(0, 5)) == "ncols") return readGridHead(head);

  // The mark of UTF-8 that some editors write is no part of the first number.
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  std::string_view text = head, before;
  if (text.starts_with(kMark)) text.remove_prefix(kMark.size());
  dialect_ = dialectOf(text);
  Index line = 0;
  std::string nearly;  // why the first line that begins with a number is no row
  while (!text.empty()) {
    const auto at = static_cast<std::uintmax_t>(text.data() - head.data());
    const std::string_view content = trimmed(nextLine(text));
    ++line;
    std::vector<double> numbers;
    std::string_view offending;
    const bool row = !isComment(content) && parseLine(content, dialect_, numbers, offending) && numbers.size() >= 2;
    if (!row) {
      // Column names may stand in a comment; the last line before the numbers counts.
      if (!content.empty()) before = content;
      if (nearly.empty() && !numbers.empty() && !offending.empty()) {
        nearly = fmt::format(" (line {}: '{}' is not a number)", line, offending.substr(0, kShown));
      }
      continue;
    }
    columns_ = static_cast<Index>(numbers.size());
    headLines_ = line - 1;
    headBytes_ = at;
    names_ = namesOf(before, dialect_.separator);
    if (static_cast<Index>(names_.size()) != columns_) names_.clear();
    return;
  }
  throw InvalidInput(fmt::format("'{}' holds no row of two or more numbers{}: give a point a line", name_, nearly));
}

void PointFile::readGridHead(const std::string& head) {
  grid_ = true;
  columns_ = 3;
  std::string_view text = head;
  bool corner = true;
  while (!text.empty()) {
    const auto at = static_cast<std::uintmax_t>(text.data() - head.data());
    std::string_view line = trimmed(nextLine(text));
    const auto word = nextWord(line, ' ');
    double value = 0;
    if (!word || std::isalpha(static_cast<unsigned char>(word->front())) == 0) {
      headBytes_ = at;
      break;
    }
    ++headLines_;
    const std::string name = lowered(*word);
    const auto number = nextWord(line, ' ');
    if (!number || !parseNumber(*number, false, value, name == "nodata_value")) {
      throw InvalidInput(fmt::format("'{}', line {}: '{}' needs a number", name_, headLines_, name));
    }
    if (name == "ncols") gridColumns_ = static_cast<Index>(value);
    if (name == "nrows") gridRows_ = static_cast<Index>(value);
    if (name == "xllcorner" || name == "xllcenter") left_ = value;
    if (name == "yllcorner" || name == "yllcenter") bottom_ = value;
    if (name == "xllcenter") corner = false;
    if (name == "cellsize") cell_ = {value, value};
    if (name == "dx") cell_[0] = value;
    if (name == "dy") cell_[1] = value;
    if (name == "nodata_value") missing_ = value;
  }
  if (gridColumns_ < 1 || gridRows_ < 1 || !(cell_[0] > 0 && cell_[1] > 0)) {
    throw InvalidInput(fmt::format("'{}': a grid needs ncols, nrows and cellsize (or dx and dy) above zero", name_));
  }
  if (corner) {
    left_ += cell_[0] / 2;
    bottom_ += cell_[1] / 2;
  }
}

Index PointFile::columnNamed(const std::string& name) const {
  const auto place = std::find(names_.begin(), names_.end(), name);
  return place == names_.end() ? -1 : place - names_.begin();
}

void PointFile::choose(const std::vector<Index>& columns) {
  if (columns.empty()) throw InvalidInput("no column is chosen: give at least one");
  std::vector<std::string> names;
  std::vector<Index> chosen;
  for (const Index column : columns) {
    if (column < 0 || column >= this->columns()) {
      throw InvalidInput(
          fmt::format("'{}' has {} columns: column {} cannot be chosen", path_.string(), this->columns(), column + 1));
    }
    const auto k = static_cast<std::size_t>(column);
    chosen.push_back(chosen_.empty() ? column : chosen_[k]);
    if (!names_.empty()) names.push_back(names_[k]);
  }
  chosen_ = std::move(chosen);
  names_ = std::move(names);
}

void PointFile::forEachBlock(const std::function<void(const Net&)>& visit) const {
  if (chosen_.empty()) return forEachRawBlock(visit);
  forEachRawBlock([&](const Net& block) {
    Net kept(block.rows(), columns());
    for (Index c = 0; c < kept.cols(); ++c) kept.col(c) = block.col(chosen_[static_cast<std::size_t>(c)]);
    visit(kept);
  });
}

void PointFile::forEachRawBlock(const std::function<void(const Net&)>& visit) const {
  if (kept_) {
    for (Index begin = 0; begin < kept_->rows(); begin += kKeptRows) {
      visit(kept_->middleRows(begin, std::min(kKeptRows, kept_->rows() - begin)));
    }
    return;
  }
  if (cloud_ && cloud_->binary) return forEachBinaryBlock(visit);
  if (!cloud_) return forEachTextBlock(visit);
  // The rows behind the points (faces) are not looked at.
  Index seen = 0;
  forEachTextBlock([&](const Net& block) {
    seen += block.rows();
    const Net points = finiteRows(block);
    if (points.rows() > 0) visit(points);
  });
  if (seen < cloud_->count) throw InvalidInput(tooShort(name_, seen, cloud_->count));
}

void PointFile::forEachBinaryBlock(const std::function<void(const Net&)>& visit) const {
  std::ifstream in(path_, std::ios::binary);
  if (!in) throw InvalidInput(fmt::format("cannot read '{}': check the name and the permissions", name_));
  in.seekg(static_cast<std::streamoff>(headBytes_));
  const auto perBlock = static_cast<Index>(std::max<std::size_t>(kRecordBlock / cloud_->record, 1));
  std::vector<char> buffer(static_cast<std::size_t>(perBlock) * cloud_->record);
  for (Index begin = 0; begin < cloud_->count;) {
    const Index count = std::min(perBlock, cloud_->count - begin);
    const auto bytes = static_cast<std::streamsize>(static_cast<std::size_t>(count) * cloud_->record);
    in.read(buffer.data(), bytes);
    if (in.gcount() != bytes) {
      throw InvalidInput(
          tooShort(name_, begin + static_cast<Index>(in.gcount()) / static_cast<Index>(cloud_->record), cloud_->count));
    }
    Net block(count, columns_);
    std::atomic<bool> finite = true;
    tbb::parallel_for(tbb::blocked_range<Index>(0, count, kRows), [&](const tbb::blocked_range<Index>& part) {
      cloudNumbers(*cloud_, buffer.data() + static_cast<std::size_t>(part.begin()) * cloud_->record,
                   static_cast<Index>(part.size()), &block(part.begin(), 0));
      if (!block.middleRows(part.begin(), static_cast<Index>(part.size())).allFinite()) finite = false;
    });
    if (finite) {
      visit(block);
    } else if (const Net points = finiteRows(block); points.rows() > 0) {
      visit(points);
    }
    begin += count;
  }
}

void PointFile::forEachTextBlock(const std::function<void(const Net&)>& visit) const {
  std::ifstream in(path_, std::ios::binary);
  if (!in) throw InvalidInput(fmt::format("cannot read '{}': check the name and the permissions", name_));
  in.seekg(static_cast<std::streamoff>(headBytes_));
  Index linesBefore = headLines_;
  Index gridPlace = 0, rowsBefore = 0;
  std::string buffer;
  struct Chunk {
    std::string_view text;
    std::vector<double> numbers;
    Index lines = 0, badLine = -1;
    std::string problem;
  };
  bool more = true;
  while (more) {
    const std::size_t kept = buffer.size();
    buffer.resize(kept + kBlock);
    in.read(buffer.data() + kept, static_cast<std::streamsize>(kBlock));
    const auto got = static_cast<std::size_t>(in.gcount());
    buffer.resize(kept + got);
    more = got == kBlock;
    // Whole lines only; the rest waits for the next block.
    const std::size_t end = more ? buffer.rfind('\n') + 1 : buffer.size();
    if (end == 0 && more) continue;
    std::vector<Chunk> chunks;
    for (std::size_t begin = 0; begin < end;) {
      std::size_t stop = std::min(begin + kChunk, end);
      if (stop < end) stop = std::min(buffer.find('\n', stop) + 1, end);
      chunks.push_back({std::string_view(buffer).substr(begin, stop - begin), {}, 0, -1, {}});
      begin = stop;
    }
    tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t k) {
      Chunk& chunk = chunks[k];
      std::string_view text = chunk.text;
      while (!text.empty()) {
        const std::string_view line = trimmed(nextLine(text));
        ++chunk.lines;
        if (isComment(line)) continue;
        const std::size_t before = chunk.numbers.size();
        std::string_view offending;
        if (!parseLine(line, dialect_, chunk.numbers, offending, grid_ || cloud_)) {
          chunk.problem = fmt::format("'{}' is not a number", offending.substr(0, kShown));
        } else if (!grid_ && static_cast<Index>(chunk.numbers.size() - before) != columns_) {
          chunk.problem =
              fmt::format("{} numbers, where the first row has {}", chunk.numbers.size() - before, columns_);
        } else {
          continue;
        }
        chunk.numbers.resize(before);
        chunk.badLine = chunk.lines;
        return;
      }
    });
    std::size_t total = 0;
    const auto most = cloud_ ? static_cast<std::size_t>((cloud_->count - rowsBefore) * columns_) : SIZE_MAX;
    for (const Chunk& chunk : chunks) {
      if (chunk.badLine >= 0 && total + chunk.numbers.size() < most) {
        throw InvalidInput(
            fmt::format("'{}', line {}: {}: correct or remove it", name_, linesBefore + chunk.badLine, chunk.problem));
      }
      linesBefore += chunk.lines;
      total += chunk.numbers.size();
      if (total >= most) break;
    }
    total = std::min(total, most);
    if (!grid_) {
      Net rows(static_cast<Index>(total) / columns_, columns_);
      double* to = rows.data();
      for (const Chunk& chunk : chunks) {
        const auto room = rows.data() + rows.size() - to;
        to = std::copy_n(chunk.numbers.begin(), std::min(room, static_cast<std::ptrdiff_t>(chunk.numbers.size())), to);
      }
      rowsBefore += rows.rows();
      if (rows.rows() > 0) visit(rows);
      if (cloud_ && rowsBefore >= cloud_->count) return;
    } else {
      Net rows(static_cast<Index>(total), 3);
      Index count = 0;
      for (const Chunk& chunk : chunks) {
        for (const double height : chunk.numbers) {
          const Index i = gridPlace % gridColumns_, j = gridRows_ - 1 - gridPlace / gridColumns_;
          ++gridPlace;
          if (height == missing_ || !std::isfinite(height)) continue;
          rows.row(count++) << left_ + cell_[0] * static_cast<double>(i), bottom_ + cell_[1] * static_cast<double>(j),
              height;
        }
      }
      rows.conservativeResize(count, Eigen::NoChange);
      if (gridPlace > gridRows_ * gridColumns_) break;
      if (count > 0) visit(rows);
    }
    buffer.erase(0, end);
  }
  if (grid_ && gridPlace != gridRows_ * gridColumns_) {
    throw InvalidInput(fmt::format("'{}' does not hold the {} x {} heights that its head announces: it may be damaged",
                                   name_, gridRows_, gridColumns_));
  }
}

Net readPoints(const PointFile& file) {
  std::vector<Net> blocks;
  Index rows = 0;
  file.forEachBlock([&](const Net& block) {
    blocks.push_back(block);
    rows += block.rows();
  });
  Net all(rows, file.columns());
  rows = 0;
  for (Net& block : blocks) {
    all.middleRows(rows, block.rows()) = block;
    rows += block.rows();
    block.resize(0, 0);
  }
  return all;
}

}  // namespace strak
