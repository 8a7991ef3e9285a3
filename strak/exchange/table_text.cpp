#include "strak/exchange/table_text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>

namespace strak {

namespace {

constexpr int kSampleLines = 50;

bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

// The line without a comment behind its numbers.
std::string_view withoutComment(std::string_view line) {
  const std::size_t mark = std::min({line.find_first_of("#%!"), line.find("//"), line.size()});
  return trimmed(line.substr(0, mark));
}

bool parsePlainNumber(std::string_view word, double& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc{} && end == word.data() + word.size();
}

bool parseRow(std::string_view line, const TableDialect& dialect, std::vector<double>& numbers,
              std::string_view& offending, bool missingToo) {
  double value = 0;
  while (const auto word = nextWord(line, dialect.separator)) {
    if (!parseNumber(*word, dialect.decimalComma, value, missingToo)) {
      offending = *word;
      return false;
    }
    numbers.push_back(value);
  }
  return true;
}

}  // namespace

std::string_view trimmed(std::string_view line) {
  while (!line.empty() && isBlank(line.front())) line.remove_prefix(1);
  while (!line.empty() && isBlank(line.back())) line.remove_suffix(1);
  return line;
}

std::string lowered(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](unsigned char c) { return std::tolower(c); });
  return result;
}

bool isComment(std::string_view line) {
  return line.empty() || line[0] == '#' || line[0] == '%' || line[0] == '!' || line.starts_with("//");
}

std::string_view nextLine(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

std::optional<std::string_view> nextWord(std::string_view& line, char separator) {
  while (!line.empty() && isBlank(line.front())) line.remove_prefix(1);
  if (line.empty()) return std::nullopt;
  std::size_t end = 0;
  while (end < line.size() && (separator == ' ' ? !isBlank(line[end]) : line[end] != separator)) ++end;
  const std::string_view word = trimmed(line.substr(0, end));
  line.remove_prefix(std::min(end + (separator == ' ' ? 0 : 1), line.size()));
  return word;
}

bool parseNumber(std::string_view word, bool decimalComma, double& value, bool missingToo) {
  std::array<char, 64> copy{}, again{};
  if (decimalComma && word.size() < copy.size()) {
    std::replace_copy(word.begin(), word.end(), copy.begin(), ',', '.');
    word = {copy.data(), word.size()};
  }
  bool number = parsePlainNumber(word, value);
  // What is rare is looked for only where the plain way fails: tables are read by the gigabyte.
  if (!number && word.size() >= 2 && (word.front() == '"' || word.front() == '\'') && word.back() == word.front()) {
    return parseNumber(trimmed(word.substr(1, word.size() - 2)), false, value, missingToo);
  }
  const std::size_t exponent = number ? word.npos : word.find_first_of("dD");
  if (exponent != word.npos && word.size() < again.size()) {
    std::copy(word.begin(), word.end(), again.begin());
    again.at(exponent) = 'e';
    number = parsePlainNumber({again.data(), word.size()}, value);
  }
  return number && (missingToo || std::isfinite(value));
}

bool parseLine(std::string_view line, const TableDialect& dialect, std::vector<double>& numbers,
               std::string_view& offending, bool missingToo) {
  const std::size_t before = numbers.size();
  if (parseRow(line, dialect, numbers, offending, missingToo)) return true;
  const std::string_view row = withoutComment(line);
  if (row.size() == line.size()) return false;
  numbers.resize(before);
  return parseRow(row, dialect, numbers, offending, missingToo);
}

TableDialect dialectOf(std::string_view text) {
  constexpr std::array<TableDialect, 5> kDialects{{{' ', false}, {',', false}, {';', false}, {';', true}, {' ', true}}};
  std::array<int, kDialects.size()> understood{};
  for (int i = 0; i < kSampleLines && !text.empty();) {
    const std::string_view line = trimmed(nextLine(text));
    if (isComment(line)) continue;
    ++i;
    for (std::size_t k = 0; k < kDialects.size(); ++k) {
      std::vector<double> numbers;
      std::string_view offending;
      if (parseLine(line, kDialects.at(k), numbers, offending) && numbers.size() >= 2) ++understood.at(k);
    }
  }
  const auto best = std::max_element(understood.begin(), understood.end());
  return kDialects.at(static_cast<std::size_t>(best - understood.begin()));
}

std::string plainName(std::string_view word) {
  std::string name;
  for (char c : lowered(word)) {
    if (c == '[' || c == '(') break;
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_') name += c;
  }
  while (!name.empty() && name.back() == '_') name.pop_back();
  return name;
}

std::vector<std::string> namesOf(std::string_view line, char separator) {
  while (!line.empty() && (line.front() == '#' || line.front() == '%' || line.front() == '/')) line.remove_prefix(1);
  std::vector<std::string> names;
  while (const auto word = nextWord(line, separator)) {
    std::string name = plainName(*word);
    if (!name.empty()) names.push_back(std::move(name));
  }
  return names;
}

}  // namespace strak
