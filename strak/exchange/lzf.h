#pragma once
//
// The LZF compression, as point clouds of the kind PCD binary_compressed have it.

#include <cstddef>
#include <string>
#include <string_view>

namespace strak {

// The `size` bytes that were compressed. A byte below 32 begins a run of that many literal bytes and one more; any
// other one a copy of bytes that are already there: length in its upper three bits (7: plus the next byte) plus 2,
// distance in the lower five and another byte, plus 1. Throws InvalidInput, without the file's name, if the data end
// early, refer to bytes before the beginning or do not give `size` bytes.
std::string lzfDecompressed(std::string_view data, std::size_t size);

}  // namespace strak
