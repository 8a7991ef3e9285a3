#include "strak/exchange/lzf.h"

#include "strak/base/error.h"

namespace strak {

namespace {

constexpr unsigned kLiterals = 32;
constexpr unsigned kLongLength = 7;
constexpr std::size_t kMostRatio = 100;  // 3 bytes give at most 264

[[noreturn]] void damaged() {
  throw InvalidInput("the compressed points are damaged: write the file again, best without compression");
}

}  // namespace

std::string lzfDecompressed(std::string_view data, std::size_t size) {
  // A header that lies about the size is not worth its memory.
  if (size / kMostRatio > data.size()) damaged();
  std::string out;
  out.reserve(size);
  std::size_t at = 0;
  const auto next = [&] {
    if (at >= data.size()) damaged();
    return static_cast<unsigned>(static_cast<unsigned char>(data[at++]));
  };
  while (at < data.size()) {
    const unsigned control = next();
    if (control < kLiterals) {
      const std::size_t count = control + 1;
      if (count > data.size() - at || count > size - out.size()) damaged();
      out.append(data.substr(at, count));
      at += count;
      continue;
    }
    std::size_t length = control >> 5U;
    if (length == kLongLength) length += next();
    length += 2;
    const std::size_t distance = ((control & 0x1fU) << 8U) + next() + 1;
    if (distance > out.size() || length > size - out.size()) damaged();
    // Byte by byte: what is copied may run into what is written.
    for (std::size_t from = out.size() - distance; length > 0; --length) out.push_back(out[from++]);
  }
  if (out.size() != size) damaged();
  return out;
}

}  // namespace strak
