#include "strak/exchange/las_layout.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "strak/base/error.h"
#include "strak/exchange/binary_number.h"

namespace strak {

namespace {

// Where the head keeps what, in bytes from the beginning.
constexpr std::size_t kMinor = 25, kPointsBegin = 96, kFormat = 104, kRecord = 105, kCount = 107, kFactors = 131,
                      kOffsets = 155, kHead = 227, kLongCount = 247, kLongHead = 375;
constexpr std::uint8_t kLaz = 0x80;       // in the format's byte: the points are compressed
constexpr std::uint8_t kLongSince = 4;    // minor version: from then on the number of points has eight bytes
constexpr std::size_t kLeastRecord = 20;  // bytes of a point, format 0

}  // namespace

std::optional<CloudLayout> lasLayout(std::string_view head) {
  if (!head.starts_with("LASF")) return std::nullopt;
  const bool isLong = head.size() > kMinor && binaryNumber<std::uint8_t>(head, kMinor) >= kLongSince;
  if (head.size() < (isLong ? kLongHead : kHead)) {
    throw InvalidInput("the LAS file ends within its header: it may be damaged");
  }
  if ((binaryNumber<std::uint8_t>(head, kFormat) & kLaz) != 0) {
    throw InvalidInput("the points are compressed (LAZ), which is not read: convert the file to LAS, PLY or .xyz");
  }
  CloudLayout layout;
  layout.binary = true;
  layout.headBytes = binaryNumber<std::uint32_t>(head, kPointsBegin);
  layout.record = binaryNumber<std::uint16_t>(head, kRecord);
  const std::uint64_t count =
      isLong ? binaryNumber<std::uint64_t>(head, kLongCount) : binaryNumber<std::uint32_t>(head, kCount);
  if (layout.headBytes < kHead || layout.record < kLeastRecord || count > std::uint64_t{1} << 48U) {
    throw InvalidInput("the LAS file's header makes no sense: it may be damaged");
  }
  layout.count = static_cast<Index>(count);
  constexpr std::array<const char*, 3> kNames{"x", "y", "z"};
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    CloudField field;
    field.name = kNames[k];
    field.type = CloudField::Type::signedInteger;
    field.offset = field.group = 4 * k;
    field.factor = binaryNumber<double>(head, kFactors + 8 * k);
    field.shift = binaryNumber<double>(head, kOffsets + 8 * k);
    if (!(field.factor > 0) || !std::isfinite(field.factor) || !std::isfinite(field.shift)) {
      throw InvalidInput(
          fmt::format("the LAS file's factor or offset of {} is no number above zero: it may be damaged", kNames[k]));
    }
    layout.fields.push_back(field);
  }
  return layout;
}

}  // namespace strak
