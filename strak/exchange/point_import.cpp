#include "strak/exchange/point_import.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <unordered_set>

#include "strak/base/error.h"
#include "strak/base/file.h"
#include "strak/exchange/binary_number.h"
#include "strak/exchange/cloud_layout.h"
#include "strak/exchange/g2.h"
#include "strak/exchange/interferogram.h"
#include "strak/exchange/lzf.h"
#include "strak/exchange/ply_elements.h"
#include "strak/exchange/table_text.h"

namespace strak {

namespace {

using Points = std::vector<std::array<double, 3>>;

constexpr std::size_t kLargestAirfoil = 60000;  // bytes

ImportedPoints asNet(const Points& points) {
  ImportedPoints result{Net(static_cast<Index>(points.size()), 3), {"x", "y", "z"}};
  Index count = 0;
  for (const auto& p : points) {
    if (std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2])) {
      result.points.row(count++) << p[0], p[1], p[2];
    }
  }
  result.points.conservativeResize(count, Eigen::NoChange);
  return result;
}

// The first of points that are the same to the bit.
Points withoutRepetition(const Points& points) {
  struct Hash {
    std::size_t operator()(const std::array<double, 3>& p) const {
      std::size_t h = 0;
      for (const double c : p) h = (h ^ std::bit_cast<std::uint64_t>(c)) * 0x9e3779b97f4a7c15U;
      return h ^ (h >> 32U);
    }
  };
  std::unordered_set<std::array<double, 3>, Hash> seen;
  Points result;
  for (const auto& p : points) {
    if (seen.insert(p).second) result.push_back(p);
  }
  return result;
}

// Words of a text one after another, and where the line ends.
class Words {
 public:
  explicit Words(std::string_view text) : text_(text) {}

  bool nextLine() {
    if (end_ >= text_.size() && line_ > 0) return false;
    at_ = line_ == 0 ? 0 : end_ + 1;
    if (at_ >= text_.size()) return false;
    end_ = std::min(text_.find('\n', at_), text_.size());
    ++line_;
    return true;
  }
  // Empty at the end of the line, or of what is no comment.
  std::string_view next() {
    while (at_ < end_ && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\r')) ++at_;
    const std::size_t begin = at_;
    while (at_ < end_ && text_[at_] != ' ' && text_[at_] != '\t' && text_[at_] != '\r') ++at_;
    const std::string_view word = text_.substr(begin, at_ - begin);
    return word.starts_with('#') ? std::string_view() : word;
  }
  template <class Number>
  Number number() {
    std::string_view word = next();
    if (word.starts_with('+')) word.remove_prefix(1);
    Number value{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty() || error != std::errc{} || end != word.data() + word.size()) {
      throw InvalidInput(fmt::format("line {}: '{}' where a number is expected", line_, word.substr(0, 40)));
    }
    return value;
  }
  std::array<double, 3> point() {
    std::array<double, 3> p{};
    for (double& c : p) c = number<double>();
    return p;
  }

 private:
  std::string_view text_;
  std::size_t at_ = 0, end_ = 0;
  Index line_ = 0;
};

// Whether it is `name`, in small letters, in any case.
bool isWord(std::string_view word, std::string_view name) {
  return std::equal(word.begin(), word.end(), name.begin(), name.end(),
                    [](unsigned char a, char b) { return std::tolower(a) == b; });
}

// The vertices of lines that begin with `word`, and a line with `last` behind them unless that is empty.
Points verticesNamed(std::string_view text, std::string_view word, std::string_view last = {}) {
  Points points;
  bool complete = last.empty();
  for (Words words(text); words.nextLine();) {
    const std::string_view first = words.next();
    if (isWord(first, word)) {
      points.push_back(words.point());
      complete = last.empty();
    }
    complete = complete || isWord(first, last);
  }
  if (points.empty()) throw InvalidInput(fmt::format("there is no vertex in the file (no line '{} x y z')", word));
  if (!complete) throw InvalidInput(fmt::format("the file ends without '{}': it may be damaged", last));
  return points;
}

Points stlVertices(std::string_view bytes) {
  constexpr std::size_t kHead = 84, kTriangle = 50, kNormal = 12, kVertex = 12;
  const std::size_t count = bytes.size() >= kHead ? binaryNumber<std::uint32_t>(bytes, kHead - 4) : 0;
  constexpr std::string_view kTextual = "solid";
  const bool textual = isWord(bytes.substr(0, kTextual.size()), kTextual);
  if (bytes.size() < kHead || (bytes.size() - kHead) / kTriangle < count ||
      (textual && bytes.size() != kHead + count * kTriangle)) {
    if (!textual) throw InvalidInput("the STL file is shorter than it says: it may be damaged");
    return withoutRepetition(verticesNamed(bytes, "vertex", "endsolid"));
  }
  Points points;
  for (std::size_t t = 0; t < count; ++t) {
    for (std::size_t v = 0; v < 3; ++v) {
      const std::size_t at = kHead + t * kTriangle + kNormal + v * kVertex;
      points.push_back(
          {binaryNumber<float>(bytes, at), binaryNumber<float>(bytes, at + 4), binaryNumber<float>(bytes, at + 8)});
    }
  }
  return withoutRepetition(points);
}

Points offVertices(std::string_view text) {
  Words words(text);
  std::string_view word;
  while (words.nextLine() && (word = words.next()).empty()) continue;
  if (!word.ends_with("OFF") || word.find('n') != word.npos) {
    throw InvalidInput("a file with the ending .off begins with the word OFF");
  }
  // The counts stand on the same line or on the next one that is no comment.
  std::string_view first = words.next();
  while (first.empty()) {
    if (!words.nextLine()) throw InvalidInput("the OFF file ends before its counts");
    first = words.next();
  }
  std::size_t count = 0;
  const auto [end, error] = std::from_chars(first.data(), first.data() + first.size(), count);
  if (error != std::errc{} || end != first.data() + first.size()) {
    throw InvalidInput(fmt::format("the OFF file says '{}' where the number of vertices is expected", first));
  }
  Points points;
  while (points.size() < count && words.nextLine()) {
    Words copy = words;
    if (copy.next().empty()) continue;
    points.push_back(words.point());
  }
  if (points.size() < count) {
    throw InvalidInput(fmt::format("the OFF file holds {} of the {} vertices that it announces: it may be damaged",
                                   points.size(), count));
  }
  return points;
}

// Point clouds that were compressed field by field.
ImportedPoints compressedCloud(const CloudLayout& layout, std::string_view bytes) {
  const auto count = static_cast<std::size_t>(layout.count);
  if (bytes.size() < layout.headBytes + 8)
    throw InvalidInput("the compressed points are missing: the file may be damaged");
  const std::size_t packed = binaryNumber<std::uint32_t>(bytes, layout.headBytes);
  const std::size_t size = binaryNumber<std::uint32_t>(bytes, layout.headBytes + 4);
  if (packed > bytes.size() - layout.headBytes - 8 || size % layout.record != 0 || size / layout.record != count) {
    throw InvalidInput("the compressed points have another size than the header announces: the file may be damaged");
  }
  const std::string fields = lzfDecompressed(bytes.substr(layout.headBytes + 8, packed), size);
  ImportedPoints result{Net(layout.count, static_cast<Index>(layout.fields.size())), {}};
  for (std::size_t f = 0; f < layout.fields.size(); ++f) {
    const CloudField& field = layout.fields[f];
    for (std::size_t r = 0; r < count; ++r) {
      // The elements of a field with several stand together, point by point.
      const std::size_t at = field.group * count + r * field.groupBytes + (field.offset - field.group);
      CloudField here = field;
      here.offset = 0;
      result.points(static_cast<Index>(r), static_cast<Index>(f)) = cloudNumber(here, fields.data() + at, false);
    }
    result.names.push_back(field.name);
  }
  Index kept = 0;
  for (Index r = 0; r < result.points.rows(); ++r) {
    if (result.points.row(r).allFinite()) result.points.row(kept++) = result.points.row(r);
  }
  result.points.conservativeResize(kept, Eigen::NoChange);
  return result;
}

// Big-endian: latitude and longitude of the south-west corner, their steps, rows and columns, then heights from the
// south, float.
Points gtxHeights(std::string_view bytes) {
  constexpr std::size_t kHead = 40;
  constexpr float kMissing = -88.8888F;
  if (bytes.size() < kHead) throw InvalidInput("the .gtx grid ends within its header: it may be damaged");
  std::array<double, 4> head{};
  for (std::size_t k = 0; k < 4; ++k) head[k] = binaryNumber<double>(bytes, 8 * k, true);
  const std::int64_t rows = binaryNumber<std::int32_t>(bytes, 32, true),
                     columns = binaryNumber<std::int32_t>(bytes, 36, true);
  if (rows < 1 || columns < 1 || bytes.size() != kHead + 4 * static_cast<std::size_t>(rows * columns)) {
    throw InvalidInput(
        fmt::format("the .gtx grid does not hold the {} x {} heights that its header announces: it may "
                    "be damaged",
                    rows, columns));
  }
  Points points;
  points.reserve(static_cast<std::size_t>(rows * columns));
  for (std::int64_t i = 0; i < rows; ++i) {
    for (std::int64_t j = 0; j < columns; ++j) {
      const auto height = binaryNumber<float>(bytes, kHead + 4 * static_cast<std::size_t>(i * columns + j), true);
      if (height == kMissing) continue;
      points.push_back(
          {head[1] + head[3] * static_cast<double>(j), head[0] + head[2] * static_cast<double>(i), height});
    }
  }
  return points;
}

constexpr std::size_t kDemRecord = 1024;

// A number in columns of a USGS DEM, Fortran's way; nothing if there is none.
std::optional<double> demNumber(std::string_view record, std::size_t from, std::size_t width) {
  if (from + width > record.size()) return std::nullopt;
  std::string text(record.substr(from, width));
  text.erase(0, std::min(text.find_first_not_of(" +"), text.size()));
  text.erase(text.find_last_not_of(' ') + 1);
  std::replace(text.begin(), text.end(), 'D', 'E');
  std::replace(text.begin(), text.end(), 'd', 'E');
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Columns of record A: the steps x, y, z stand at 816, rows and columns of profiles at 852.
bool isDem(std::string_view head) {
  if (head.size() < 2 * kDemRecord || head.substr(0, kDemRecord).find_first_of("\n\r") != head.npos) return false;
  const auto columns = demNumber(head, 858, 6), first = demNumber(head, kDemRecord, 6);
  return demNumber(head, 144, 6) && demNumber(head, 816, 12) && columns && *columns >= 1 && first && *first == 1;
}

// Profiles from south to north, each in blocks of 1024 characters: 146 heights in the first, 170 in the others.
Points demHeights(std::string_view bytes) {
  constexpr double kMissing = -32767;
  const auto need = [](std::optional<double> value) {
    if (!value) throw InvalidInput("the USGS DEM has a number that cannot be read: it may be damaged");
    return *value;
  };
  const double stepX = need(demNumber(bytes, 816, 12)), stepY = need(demNumber(bytes, 828, 12)),
               stepZ = need(demNumber(bytes, 840, 12)), profiles = need(demNumber(bytes, 858, 6));
  Points points;
  std::size_t at = kDemRecord;
  for (double profile = 0; profile < profiles; ++profile) {
    const std::string_view head = bytes.substr(std::min(at, bytes.size()));
    if (head.size() < 144) {
      throw InvalidInput(fmt::format(
          "the USGS DEM holds {:g} of the {:g} profiles that it announces: it may be damaged", profile, profiles));
    }
    const double rows = need(demNumber(head, 12, 6)), columns = need(demNumber(head, 18, 6)),
                 x = need(demNumber(head, 24, 24)), y = need(demNumber(head, 48, 24)),
                 datum = need(demNumber(head, 72, 24));
    if (!(rows >= 1) || columns != 1)
      throw InvalidInput("the USGS DEM has a profile without heights: it may be damaged");
    std::size_t place = 144, block = 0;
    for (double i = 0; i < rows; ++i, place += 6) {
      if (place + 6 > (block + 1) * kDemRecord - 4) place = ++block * kDemRecord;
      const double height = need(demNumber(head, place, 6));
      if (height != kMissing) points.push_back({x, y + stepY * i, datum + stepZ * height});
    }
    at += (block + 1) * kDemRecord;
  }
  if (!(stepX > 0) || points.empty()) throw InvalidInput("the USGS DEM holds no heights");
  return points;
}

// The export of a corneal topographer: a head that names the number of rings ("Anelli") and of half meridians
// ("Semimeridiani"), then a number with a decimal comma a line, the radii of all samples ring by ring and then their
// elevations (below the apex: negative). A negative radius or the elevation -1000 says that the sample is missing.
bool isTopography(std::string_view head) {
  return head.find("Anelli :") != head.npos && head.find("Semimeridiani :") != head.npos;
}

Points topographyPoints(const std::string& text) {
  const auto headed = [&](std::string_view name) {
    const std::size_t at = text.find(name);
    const double value = std::strtod(text.c_str() + at + name.size(), nullptr);
    if (!(value >= 1 && value <= 1e6)) {
      throw InvalidInput(fmt::format("the topography needs a number of rings and meridians after '{}'", name));
    }
    return static_cast<std::size_t>(value);
  };
  const std::size_t rings = headed("Anelli :"), meridians = headed("Semimeridiani :");
  std::vector<double> numbers;
  std::size_t at = text.find('\n', text.find("Semimeridiani :"));
  while (at < text.size()) {
    const std::size_t end = std::min(text.find('\n', at + 1), text.size());
    std::string line = text.substr(at + 1, end - at - 1);
    at = end;
    std::replace(line.begin(), line.end(), ',', '.');
    double value = 0;
    const auto result = std::from_chars(line.data(), line.data() + line.size(), value);
    if (result.ec == std::errc{}) numbers.push_back(value);
  }
  const std::size_t samples = rings * meridians;
  if (numbers.size() != 2 * samples) {
    throw InvalidInput(
        fmt::format("the topography holds {} numbers, not the radii and elevations of {} rings on {} "
                    "half meridians: it may be damaged",
                    numbers.size(), rings, meridians));
  }
  constexpr double kNoHeight = -1000;
  Points points;
  for (std::size_t k = 0; k < samples; ++k) {
    const double radius = numbers[k], height = numbers[samples + k];
    if (!(radius >= 0) || height == kNoHeight) continue;
    const double angle = 2 * std::numbers::pi * static_cast<double>(k % meridians) / static_cast<double>(meridians);
    points.push_back({radius * std::cos(angle), radius * std::sin(angle), height});
  }
  return points;
}

// Airfoils in Lednicer's order: a line with the two numbers of points, then the upper and the lower side, each from the
// leading edge. Returned in Selig's, from the trailing edge around the nose, which comes once; nothing for other
// tables.
std::optional<ImportedPoints> airfoilPoints(std::string_view text) {
  std::vector<std::array<double, 2>> rows;
  while (!text.empty()) {
    const std::string_view line = trimmed(nextLine(text));
    if (isComment(line)) continue;
    std::vector<double> numbers;
    std::string_view offending;
    if (parseLine(line, TableDialect(), numbers, offending) && numbers.size() == 2) {
      rows.push_back({numbers[0], numbers[1]});
    } else if (!rows.empty()) {
      return std::nullopt;
    }
  }
  if (rows.size() < 5) return std::nullopt;
  const auto [upper, lower] = rows[0];
  rows.erase(rows.begin());
  if (!(upper >= 2 && lower >= 2 && upper == std::floor(upper) && upper + lower == static_cast<double>(rows.size()))) {
    return std::nullopt;
  }
  const auto nose = rows.begin() + static_cast<std::ptrdiff_t>(upper);
  const bool twice = rows.front() == *nose;
  std::reverse(rows.begin(), nose);
  if (twice) rows.erase(nose);
  ImportedPoints result{Net(static_cast<Index>(rows.size()), 2), {"x", "y"}};
  for (std::size_t r = 0; r < rows.size(); ++r) result.points.row(static_cast<Index>(r)) << rows[r][0], rows[r][1];
  return result;
}

}  // namespace

std::optional<ImportedPoints> importPoints(const std::filesystem::path& path, std::string_view head) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  if (ending == ".obj") return asNet(verticesNamed(readFile(path), "v"));
  if (ending == ".stl") return asNet(stlVertices(readFile(path)));
  if (ending == ".off") return asNet(offVertices(readFile(path)));
  if (ending == ".gtx") return asNet(gtxHeights(readFile(path)));
  if (ending == ".g2" || beginsWithG2Cloud(head)) return ImportedPoints{parseG2Clouds(readFile(path)), {"x", "y", "z"}};
  if (isInterferogram(head)) return ImportedPoints{interferogramHeights(readFile(path)), {"x", "y", "z"}};
  if (isTopography(head)) return asNet(topographyPoints(readFile(path)));
  if (isDem(head)) return asNet(demHeights(readFile(path)));
  if (isIrregularPly(head)) {
    PlyVertices vertices = irregularPlyVertices(readFile(path));
    return ImportedPoints{std::move(vertices.points), std::move(vertices.names)};
  }
  if (const auto layout = cloudLayout(head); layout && layout->compressed) {
    return compressedCloud(*layout, readFile(path));
  }
  // Airfoils are small: a longer table is none.
  if (ending == ".dat" && head.size() < kLargestAirfoil) return airfoilPoints(head);
  return std::nullopt;
}

}  // namespace strak
