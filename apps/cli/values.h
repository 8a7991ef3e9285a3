#pragma once
//
// Option values that are more than a number, read from their text. All functions throw InvalidInput with the option's
// name, what was given and what is possible.

#include <array>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "strak/exchange/model.h"

namespace strak::cli {

// A finite number above zero (or not below, if `zeroToo`).
double positiveNumber(const std::string& option, const std::string& text, bool zeroToo = false);

// A whole number from `least` to `most`.
Index wholeNumber(const std::string& option, const std::string& text, Index least,
                  Index most = std::numeric_limits<Index>::max());

// `count` finite numbers, separated by commas.
std::vector<double> numberList(const std::string& option, const std::string& text, std::size_t count);

// `count` whole numbers from `least` to `most`, separated by commas or by `separator`; a single one stands for all.
std::vector<Index> wholeNumbers(const std::string& option, const std::string& text, char separator, Index least,
                                Index most, std::size_t count);

// "X,Y,Z", not all zero.
Eigen::Vector3d direction(const std::string& option, const std::string& text);

// A length in model units: "0.5", or a part of the model's size: "0.0001size".
double lengthOf(const std::string& option, const std::string& text, double modelSize);

// Rows held at the ends of each direction: "g0", "g1", "g2" (1, 2, 3 rows), "N", or one number an end
// "UMIN,UMAX,VMIN,VMAX" (two numbers for curves, six for volumes). One number stands for all ends.
std::vector<Index> holdRows(const std::string& text);

// Those rows, one number an end of a curve, surface or volume.
template <int D>
std::array<Index, 2 * static_cast<std::size_t>(D)> rowsAtEnds(const std::vector<Index>& rows);

// The numbers (from 0) of the objects named by "1,3-5,hood": numbers count from 1, a name takes every object of that
// name. Ascending, each once; the empty text takes all.
std::vector<Index> selectedObjects(const std::string& text, const std::vector<Object>& objects,
                                   const char* option = "--faces");

// Throws Failure unless the folder of `path` exists and may be written to: before hours of work, not after them.
void requireWritable(const std::filesystem::path& path);

}  // namespace strak::cli
