#pragma once
//
// Numbers in binary files.

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string_view>

namespace strak {

// The number at `at`; sizeof(Number) bytes must be there. Files of little-endian machines are read on such machines.
template <class Number>
Number binaryNumber(std::string_view bytes, std::size_t at, bool bigEndian = false) {
  std::array<char, sizeof(Number)> copy{};
  std::memcpy(copy.data(), bytes.data() + at, copy.size());
  if (bigEndian) std::reverse(copy.begin(), copy.end());
  return std::bit_cast<Number>(copy);
}

}  // namespace strak
