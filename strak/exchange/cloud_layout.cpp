#include "strak/exchange/cloud_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>

#include "strak/base/error.h"
#include "strak/exchange/las_layout.h"

namespace strak {

namespace {

std::vector<std::string_view> wordsOf(std::string_view line) {
  std::vector<std::string_view> words;
  constexpr std::string_view kBlanks = " \t\r";
  for (std::size_t at = line.find_first_not_of(kBlanks); at != line.npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

// Lines of the head one after another; throws when it ends too early.
class Lines {
 public:
  explicit Lines(std::string_view head) : head_(head) {}
  std::vector<std::string_view> next() {
    const std::size_t end = head_.find('\n', at_);
    if (end == head_.npos) throw InvalidInput("the header of the point cloud has no end: the file may be damaged");
    const auto line = head_.substr(at_, end - at_);
    at_ = end + 1;
    ++count_;
    return wordsOf(line);
  }
  std::size_t bytes() const { return at_; }
  Index count() const { return count_; }

 private:
  std::string_view head_;
  std::size_t at_ = 0;
  Index count_ = 0;
};

Index countOf(std::string_view word) {
  Index value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size() || value < 0) {
    throw InvalidInput(fmt::format("the header of the point cloud says '{}' where a number is expected", word));
  }
  return value;
}

void append(CloudLayout& layout, std::string_view name, CloudField::Type type, int bytes) {
  if (bytes != 1 && bytes != 2 && bytes != 4 && bytes != 8) {
    throw InvalidInput(
        fmt::format("the point cloud's field '{}' has {} bytes: 1, 2, 4 or 8 are possible", name, bytes));
  }
  CloudField field;
  field.name = name;
  field.type = type;
  field.bytes = bytes;
  field.offset = field.group = layout.record;
  field.groupBytes = static_cast<std::size_t>(bytes);
  layout.fields.push_back(field);
  layout.record += static_cast<std::size_t>(bytes);
}

struct PlyType {
  std::string_view name;
  CloudField::Type type;
  int bytes;
};
using Type = CloudField::Type;
constexpr std::array<PlyType, 16> kPlyTypes{{{"char", Type::signedInteger, 1},
                                             {"int8", Type::signedInteger, 1},
                                             {"uchar", Type::unsignedInteger, 1},
                                             {"uint8", Type::unsignedInteger, 1},
                                             {"short", Type::signedInteger, 2},
                                             {"int16", Type::signedInteger, 2},
                                             {"ushort", Type::unsignedInteger, 2},
                                             {"uint16", Type::unsignedInteger, 2},
                                             {"int", Type::signedInteger, 4},
                                             {"int32", Type::signedInteger, 4},
                                             {"uint", Type::unsignedInteger, 4},
                                             {"uint32", Type::unsignedInteger, 4},
                                             {"float", Type::real, 4},
                                             {"float32", Type::real, 4},
                                             {"double", Type::real, 8},
                                             {"float64", Type::real, 8}}};

CloudLayout plyLayout(std::string_view head) {
  CloudLayout layout;
  Lines lines(head);
  lines.next();
  bool inVertices = false, seen = false;
  for (;;) {
    const auto words = lines.next();
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format" && words.size() >= 2) {
      layout.binary = words[1] != "ascii";
      layout.bigEndian = words[1] == "binary_big_endian";
      if (layout.binary && !layout.bigEndian && words[1] != "binary_little_endian") {
        throw InvalidInput(fmt::format("a PLY file of format '{}' is not understood", words[1]));
      }
    } else if (words[0] == "element" && words.size() >= 3) {
      inVertices = words[1] == "vertex";
      if (!seen && !inVertices) {
        throw InvalidInput("the PLY file does not begin with its vertices: write it again with them first");
      }
      seen = true;
      if (inVertices) layout.count = countOf(words[2]);
    } else if (words[0] == "property" && inVertices && words.size() >= 3) {
      CloudField field;
      if (!plyType(words[1], field)) {
        throw InvalidInput(
            fmt::format("the PLY file's vertices have a property of type '{}', which is not understood", words[1]));
      }
      append(layout, words[2], field.type, field.bytes);
    }
  }
  layout.headBytes = lines.bytes();
  layout.headLines = lines.count();
  return layout;
}

CloudLayout pcdLayout(std::string_view head) {
  CloudLayout layout;
  Lines lines(head);
  std::vector<std::string> names, types;
  std::vector<Index> sizes, counts;
  Index width = 0, height = 1, points = -1;
  for (;;) {
    const auto words = lines.next();
    if (words.size() < 2 || words[0].starts_with('#')) continue;
    const auto rest = [&](auto& list, const auto& convert) {
      for (std::size_t k = 1; k < words.size(); ++k) list.push_back(convert(words[k]));
    };
    if (words[0] == "FIELDS") rest(names, [](std::string_view w) { return std::string(w); });
    if (words[0] == "TYPE") rest(types, [](std::string_view w) { return std::string(w); });
    if (words[0] == "SIZE") rest(sizes, countOf);
    if (words[0] == "COUNT") rest(counts, countOf);
    if (words[0] == "WIDTH") width = countOf(words[1]);
    if (words[0] == "HEIGHT") height = countOf(words[1]);
    if (words[0] == "POINTS") points = countOf(words[1]);
    if (words[0] == "DATA") {
      layout.compressed = words[1] == "binary_compressed";
      if (words[1] != "ascii" && words[1] != "binary" && !layout.compressed) {
        throw InvalidInput(
            fmt::format("a PCD file with '{}' points is not understood: convert it to binary", words[1]));
      }
      layout.binary = words[1] != "ascii";
      break;
    }
  }
  if (counts.empty()) counts.assign(names.size(), 1);
  if (names.size() != sizes.size() || names.size() != types.size() || names.size() != counts.size()) {
    throw InvalidInput("the PCD file's header has not as many sizes, types and counts as fields: it may be damaged");
  }
  layout.count = points >= 0 ? points : width * height;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const Type type = types[k] == "F" ? Type::real : types[k] == "U" ? Type::unsignedInteger : Type::signedInteger;
    const std::size_t group = layout.record;
    for (Index c = 0; c < counts[k]; ++c) {
      append(layout, names[k], type, static_cast<int>(sizes[k]));
      layout.fields.back().group = group;
      layout.fields.back().groupBytes = static_cast<std::size_t>(counts[k] * sizes[k]);
    }
  }
  layout.headBytes = lines.bytes();
  layout.headLines = lines.count();
  return layout;
}

template <class Number>
double asNumber(const char* bytes) {
  Number value;
  std::memcpy(&value, bytes, sizeof(Number));
  return static_cast<double>(value);
}

// What stands in the record, before factor and shift.
double storedNumber(const CloudField& field, const char* record, bool bigEndian) {
  std::array<char, 8> bytes{};
  const auto size = static_cast<std::size_t>(field.bytes);
  std::memcpy(bytes.data(), record + field.offset, size);
  // The machine is little-endian.
  if (bigEndian) std::reverse(bytes.begin(), bytes.begin() + field.bytes);
  const char* b = bytes.data();
  switch (field.type) {
    case Type::real:
      return size == 4 ? asNumber<float>(b) : size == 8 ? asNumber<double>(b) : 0;
    case Type::signedInteger:
      return size == 1   ? asNumber<std::int8_t>(b)
             : size == 2 ? asNumber<std::int16_t>(b)
             : size == 4 ? asNumber<std::int32_t>(b)
                         : asNumber<std::int64_t>(b);
    case Type::unsignedInteger:
      return size == 1   ? asNumber<std::uint8_t>(b)
             : size == 2 ? asNumber<std::uint16_t>(b)
             : size == 4 ? asNumber<std::uint32_t>(b)
                         : asNumber<std::uint64_t>(b);
  }
  return 0;
}

}  // namespace

bool plyType(std::string_view name, CloudField& field) {
  const auto type = std::find_if(kPlyTypes.begin(), kPlyTypes.end(), [&](const auto& t) { return t.name == name; });
  if (type == kPlyTypes.end()) return false;
  field.type = type->type;
  field.bytes = type->bytes;
  return true;
}

std::optional<CloudLayout> cloudLayout(std::string_view head) {
  std::optional<CloudLayout> layout = lasLayout(head);
  if (head.starts_with("ply\n") || head.starts_with("ply\r\n")) layout = plyLayout(head);
  if (head.starts_with("# .PCD") || head.starts_with("VERSION") || head.starts_with("FIELDS "))
    layout = pcdLayout(head);
  if (layout && layout->fields.empty()) throw InvalidInput("the header of the point cloud names no coordinates");
  return layout;
}

double cloudNumber(const CloudField& field, const char* record, bool bigEndian) {
  return field.shift + field.factor * storedNumber(field, record, bigEndian);
}

void cloudNumbers(const CloudLayout& layout, const char* records, Index rows, double* numbers) {
  const auto columns = static_cast<Index>(layout.fields.size());
  const auto record = static_cast<Index>(layout.record);
  for (Index c = 0; c < columns; ++c) {
    const CloudField& field = layout.fields[static_cast<std::size_t>(c)];
    const bool plain = field.type == Type::real && !layout.bigEndian;
    const char* from = records + field.offset;
    for (Index r = 0; r < rows; ++r) {
      double& to = numbers[r * columns + c];
      if (plain && field.bytes == 4) {
        to = asNumber<float>(from + r * record);
      } else if (plain && field.bytes == 8) {
        to = asNumber<double>(from + r * record);
      } else {
        to = cloudNumber(field, records + r * record, layout.bigEndian);
      }
    }
  }
}

}  // namespace strak
