#include "strak/exchange/ply_elements.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "strak/base/error.h"
#include "strak/exchange/cloud_layout.h"
#include "strak/exchange/table_text.h"

namespace strak {

namespace {

constexpr double kLongestList = 1e15;  // no file is so long

struct Property {
  std::string name;
  CloudField count, value;  // count.bytes is 0 for a plain number
};

struct Element {
  std::string name;
  Index count = 0;
  std::vector<Property> properties;
};

struct Header {
  bool binary = false, bigEndian = false;
  std::vector<Element> elements;
  std::size_t bytes = 0;
};

CloudField fieldOf(std::string_view type) {
  CloudField field;
  if (!plyType(type, field)) {
    throw InvalidInput(fmt::format("the PLY file has a property of type '{}', which is not understood", type));
  }
  return field;
}

Header headerOf(std::string_view text) {
  Header header;
  const std::size_t size = text.size();
  while (!text.empty()) {
    std::string_view line = trimmed(nextLine(text));
    std::vector<std::string> words;
    while (const auto word = nextWord(line, ' ')) words.emplace_back(*word);
    if (words.empty()) continue;
    if (words[0] == "end_header") {
      header.bytes = size - text.size();
      return header;
    }
    if (words[0] == "format" && words.size() > 1) {
      header.binary = words[1] != "ascii";
      header.bigEndian = words[1] == "binary_big_endian";
      if (header.binary && !header.bigEndian && words[1] != "binary_little_endian") {
        throw InvalidInput(fmt::format("a PLY file of format '{}' is not understood", words[1]));
      }
    } else if (words[0] == "element" && words.size() > 2) {
      Element element{words[1], 0, {}};
      const char* const last = words[2].data() + words[2].size();
      const auto [end, error] = std::from_chars(words[2].data(), last, element.count);
      if (error != std::errc{} || end != last || element.count < 0) {
        throw InvalidInput(
            fmt::format("the PLY file's header says '{}' where a number of {} is expected", words[2], words[1]));
      }
      header.elements.push_back(std::move(element));
    } else if (words[0] == "property" && !header.elements.empty() && words.size() > 2) {
      Property property{words.back(), {}, {}};
      property.count.bytes = 0;
      if (words[1] == "list") {
        if (words.size() < 5)
          throw InvalidInput("the PLY file's header has a list without its types: it may be damaged");
        property.count = fieldOf(words[2]);
        property.value = fieldOf(words[3]);
      } else {
        property.value = fieldOf(words[1]);
      }
      header.elements.back().properties.push_back(std::move(property));
    }
  }
  return {};
}

// Takes the numbers of a file one after another.
class Numbers {
 public:
  Numbers(std::string_view data, const Header& header) : data_(data), header_(header) {}

  double next(const CloudField& field) {
    if (header_.binary) {
      const auto bytes = static_cast<std::size_t>(field.bytes);
      if (data_.size() < bytes) fail();
      const double value = cloudNumber(field, data_.data(), header_.bigEndian);
      data_.remove_prefix(bytes);
      return value;
    }
    data_.remove_prefix(std::min(data_.find_first_not_of(" \t\r\n"), data_.size()));
    const std::string_view word = data_.substr(0, data_.find_first_of(" \t\r\n"));
    double value = 0;
    if (word.empty()) fail();
    if (!parseNumber(word, false, value, true)) {
      throw InvalidInput(fmt::format("the PLY file says '{}' where a number is expected", word.substr(0, 40)));
    }
    data_.remove_prefix(word.size());
    return value;
  }

 private:
  [[noreturn]] static void fail() { throw InvalidInput("the PLY file ends within its points: it may be damaged"); }
  std::string_view data_;
  const Header& header_;
};

bool isList(const Property& property) { return property.count.bytes != 0; }

}  // namespace

bool isIrregularPly(std::string_view head) {
  if (!head.starts_with("ply\n") && !head.starts_with("ply\r\n")) return false;
  bool first = true, irregular = false, inVertices = false;
  while (!head.empty()) {
    std::string_view line = trimmed(nextLine(head));
    const auto word = nextWord(line, ' '), second = nextWord(line, ' ');
    if (word == "end_header") return irregular;
    if (word == "element" && second) {
      inVertices = *second == "vertex";
      irregular = irregular || (inVertices && !first);
      first = false;
    }
    irregular = irregular || (word == "property" && inVertices && second == "list");
  }
  return false;
}

PlyVertices irregularPlyVertices(std::string_view bytes) {
  const Header header = headerOf(bytes);
  Numbers numbers(bytes.substr(header.bytes), header);
  for (const Element& element : header.elements) {
    const bool wanted = element.name == "vertex";
    PlyVertices vertices;
    for (const Property& property : element.properties) {
      if (!isList(property)) vertices.names.push_back(property.name);
    }
    if (wanted && vertices.names.empty()) throw InvalidInput("the header of the point cloud names no coordinates");
    if (element.properties.empty()) continue;
    std::vector<double> rows;
    for (Index r = 0; r < element.count; ++r) {
      for (const Property& property : element.properties) {
        if (!isList(property)) {
          const double value = numbers.next(property.value);
          if (wanted) rows.push_back(value);
          continue;
        }
        const double count = numbers.next(property.count);
        if (!(count >= 0)) throw InvalidInput("the PLY file has a list of a negative length: it may be damaged");
        const auto length = static_cast<Index>(std::min(count, kLongestList));
        for (Index k = 0; k < length; ++k) numbers.next(property.value);
      }
    }
    if (!wanted) continue;
    const auto columns = static_cast<Index>(vertices.names.size());
    vertices.points.resize(static_cast<Index>(rows.size()) / columns, columns);
    Index kept = 0;
    for (std::size_t at = 0; at < rows.size(); at += vertices.names.size()) {
      const Eigen::Map<const Eigen::RowVectorXd> row(rows.data() + at, columns);
      if (row.allFinite()) vertices.points.row(kept++) = row;
    }
    vertices.points.conservativeResize(kept, Eigen::NoChange);
    return vertices;
  }
  throw InvalidInput("the PLY file has no vertices");
}

}  // namespace strak
