#include "apps/cli/values.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>

#include "strak/base/error.h"

namespace strak::cli {

namespace {

template <class Number>
std::optional<Number> parsed(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::vector<std::string> splitAtCommas(const std::string& text) {
  std::vector<std::string> parts(1);
  for (char c : text) {
    if (c == ',') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

}  // namespace

double positiveNumber(const std::string& option, const std::string& text, bool zeroToo) {
  const auto value = parsed<double>(text);
  if (!value || !std::isfinite(*value) || *value < 0 || (*value == 0 && !zeroToo)) {
    throw InvalidInput(
        fmt::format("{} is '{}': give a finite number {} zero", option, text, zeroToo ? "not below" : "above"));
  }
  return *value;
}

Index wholeNumber(const std::string& option, const std::string& text, Index least, Index most) {
  const auto value = parsed<Index>(text);
  if (!value || *value < least || *value > most) {
    const std::string range = most == std::numeric_limits<Index>::max() ? fmt::format("of at least {}", least)
                                                                        : fmt::format("from {} to {}", least, most);
    throw InvalidInput(fmt::format("{} is '{}': give a whole number {}", option, text, range));
  }
  return *value;
}

std::vector<double> numberList(const std::string& option, const std::string& text, std::size_t count) {
  std::vector<double> numbers;
  for (const auto& part : splitAtCommas(text)) {
    const auto value = parsed<double>(part);
    if (value && std::isfinite(*value)) numbers.push_back(*value);
  }
  if (numbers.size() != count || splitAtCommas(text).size() != count) {
    throw InvalidInput(fmt::format("{} is '{}': give {} numbers with commas between them", option, text, count));
  }
  return numbers;
}

std::vector<Index> wholeNumbers(const std::string& option, const std::string& text, char separator, Index least,
                                Index most, std::size_t count) {
  std::string commas = text;
  std::replace(commas.begin(), commas.end(), separator, ',');
  std::vector<Index> numbers;
  for (const auto& part : splitAtCommas(commas)) numbers.push_back(wholeNumber(option, part, least, most));
  if (numbers.size() == 1) numbers.resize(count, numbers.front());
  if (numbers.size() != count) {
    throw InvalidInput(fmt::format("{} is '{}': give one whole number or {}", option, text, count));
  }
  return numbers;
}

Eigen::Vector3d direction(const std::string& option, const std::string& text) {
  const auto parts = splitAtCommas(text);
  Eigen::Vector3d result = Eigen::Vector3d::Zero();
  bool good = parts.size() == 3;
  for (std::size_t c = 0; good && c < 3; ++c) {
    const auto value = parsed<double>(parts[c]);
    good = value && std::isfinite(*value);
    if (good) result[static_cast<Index>(c)] = *value;
  }
  if (!good || result.isZero(0)) {
    throw InvalidInput(fmt::format("{} is '{}': give a direction X,Y,Z, like 0,1,1", option, text));
  }
  return result;
}

double lengthOf(const std::string& option, const std::string& text, double modelSize) {
  constexpr std::string_view kSize = "size";
  const bool relative = text.ends_with(kSize);
  const auto value = parsed<double>(std::string_view(text).substr(0, text.size() - (relative ? kSize.size() : 0)));
  if (!value || !std::isfinite(*value) || *value <= 0) {
    throw InvalidInput(
        fmt::format("{} is '{}': give a length above zero in the file's unit (0.5) or as a part of the model's "
                    "size (0.0001size), or leave the option out for no limit",
                    option, text));
  }
  const double length = relative ? *value * modelSize : *value;
  if (!(length > 0)) {
    throw InvalidInput(
        fmt::format("{} '{}' is zero because the model has no size: give a length in the file's unit", option, text));
  }
  return length;
}

std::vector<Index> holdRows(const std::string& text) {
  constexpr std::string_view kContinuities[] = {"g0", "g1", "g2"};
  const auto continuity = std::find(std::begin(kContinuities), std::end(kContinuities), text);
  if (continuity != std::end(kContinuities)) return {continuity - std::begin(kContinuities) + 1};
  std::vector<Index> rows;
  for (const auto& part : splitAtCommas(text)) {
    const auto value = parsed<Index>(part);
    if (!value || *value < 0) {
      rows.clear();
      break;
    }
    rows.push_back(*value);
  }
  if (rows.size() != 1 && rows.size() != 2 && rows.size() != 4 && rows.size() != 6) {
    throw InvalidInput(
        fmt::format("--hold is '{}': give g0, g1, g2, one number of rows, or one number an end "
                    "(UMIN,UMAX,VMIN,VMAX)",
                    text));
  }
  return rows;
}

template <int D>
std::array<Index, 2 * static_cast<std::size_t>(D)> rowsAtEnds(const std::vector<Index>& rows) {
  std::array<Index, 2 * static_cast<std::size_t>(D)> result{};
  if (rows.size() == 1) {
    result.fill(rows.front());
    return result;
  }
  if (rows.size() != result.size()) {
    throw InvalidInput(fmt::format("--hold gives {} numbers, but a {} has {} ends: give one number, or one an end",
                                   rows.size(),
                                   D == 1   ? "curve"
                                   : D == 2 ? "surface"
                                            : "volume",
                                   result.size()));
  }
  std::copy(rows.begin(), rows.end(), result.begin());
  return result;
}

template std::array<Index, 2> rowsAtEnds<1>(const std::vector<Index>&);
template std::array<Index, 4> rowsAtEnds<2>(const std::vector<Index>&);
template std::array<Index, 6> rowsAtEnds<3>(const std::vector<Index>&);

std::vector<Index> selectedObjects(const std::string& text, const std::vector<Object>& objects, const char* option) {
  const auto count = static_cast<Index>(objects.size());
  std::set<Index> selected;
  if (text.empty()) {
    for (Index i = 0; i < count; ++i) selected.insert(i);
  }
  for (const auto& part : text.empty() ? std::vector<std::string>{} : splitAtCommas(text)) {
    bool named = false;
    for (Index i = 0; i < count; ++i) {
      if (!part.empty() && objects[static_cast<std::size_t>(i)].name == part) {
        selected.insert(i);
        named = true;
      }
    }
    if (named) continue;
    const auto dash = part.find('-');
    const auto first = parsed<Index>(std::string_view(part).substr(0, dash));
    const auto last = dash == std::string::npos ? first : parsed<Index>(std::string_view(part).substr(dash + 1));
    if (!first || !last || *first > *last) {
      throw InvalidInput(
          fmt::format("{} names '{}', which is neither a number, nor a range like 3-5, nor the name of an "
                      "object in the file: see strak info",
                      option, part));
    }
    if (*first < 1 || *last > count) {
      throw InvalidInput(fmt::format("{} names object {}, but the file has {} (numbered from 1): see strak info",
                                     option, *first < 1 ? *first : *last, count));
    }
    for (Index i = *first; i <= *last; ++i) selected.insert(i - 1);
  }
  return {selected.begin(), selected.end()};
}

void requireWritable(const std::filesystem::path& path) {
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) {
    throw Failure(fmt::format("there is no folder '{}' to write '{}' into: create it first", folder.string(),
                              path.filename().string()));
  }
  if (::access(folder.c_str(), W_OK) != 0) {
    throw Failure(fmt::format("the folder '{}' may not be written to: choose another for '{}'", folder.string(),
                              path.filename().string()));
  }
}

}  // namespace strak::cli
