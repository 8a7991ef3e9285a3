#pragma once
//
// Rows of numbers in a text, as people and programs write them: separated by blanks, commas or semicolons, with decimal
// points or commas, Fortran's exponents (1.5D-3), quotes, comments on lines of their own or behind the numbers.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace strak {

struct TableDialect {
  char separator = ' ';  // ' ' (blanks and tabs), ',' or ';'
  bool decimalComma = false;
};

// Without blanks, tabs and carriage returns at both ends.
std::string_view trimmed(std::string_view line);
std::string lowered(std::string_view text);

// Whether nothing but a comment (#, %, ! or //) stands on a trimmed line.
bool isComment(std::string_view line);

// Takes the first line off the text.
std::string_view nextLine(std::string_view& text);

// Takes the first word off the line, up to the separator. Two separators in a row leave a word empty, which is no
// number.
std::optional<std::string_view> nextWord(std::string_view& line, char separator);

// Infinity and NaN are numbers only where missing ones may be said so.
bool parseNumber(std::string_view word, bool decimalComma, double& value, bool missingToo = false);

// Appends the numbers of a line; false with the offending word if one is none.
bool parseLine(std::string_view line, const TableDialect& dialect, std::vector<double>& numbers,
               std::string_view& offending, bool missingToo = false);

// Which of the ways to read numbers makes sense of the most of the first lines; in doubt the first.
TableDialect dialectOf(std::string_view text);

// A name without quotes, units and marks: "X [mm]" is x.
std::string plainName(std::string_view word);

// The names on a line, which may be a comment.
std::vector<std::string> namesOf(std::string_view line, char separator);

}  // namespace strak
