#include "strak/exchange/packed_file.h"

#include <fmt/format.h>
#include <unistd.h>
#include <zlib.h>

#include <fstream>
#include <string>
#include <vector>

#include "strak/base/error.h"

namespace strak {

bool isPacked(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return in.get() == 0x1f && in.get() == 0x8b;
}

std::shared_ptr<const std::filesystem::path> unpacked(const std::filesystem::path& packed) {
  constexpr unsigned kBlock = 1U << 20;
  const std::string ending = packed.stem().extension().string();
  std::string name = (std::filesystem::temp_directory_path() / ("strak-XXXXXX" + ending)).string();
  const int descriptor = ::mkstemps(name.data(), static_cast<int>(ending.size()));
  if (descriptor < 0) {
    throw Failure(fmt::format("'{}' cannot be unpacked: no file can be made in '{}'", packed.string(),
                              std::filesystem::temp_directory_path().string()));
  }
  ::close(descriptor);
  const std::shared_ptr<const std::filesystem::path> result(new std::filesystem::path(name),
                                                            [](const std::filesystem::path* path) {
                                                              std::error_code ignored;
                                                              std::filesystem::remove(*path, ignored);
                                                              delete path;
                                                            });
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> in(gzopen(packed.c_str(), "rb"), gzclose);
  if (!in) throw InvalidInput(fmt::format("cannot read '{}': check the name and the permissions", packed.string()));
  std::ofstream out(name, std::ios::binary);
  std::vector<char> block(kBlock);
  int count = 0;
  while ((count = gzread(in.get(), block.data(), kBlock)) > 0) out.write(block.data(), count);
  int state = Z_OK;
  gzerror(in.get(), &state);
  // A file cut off in the middle gives what there is, and then says so.
  if (count < 0 || state != Z_OK) {
    throw InvalidInput(fmt::format("'{}' cannot be unpacked: it is damaged or cut off", packed.string()));
  }
  out.close();
  if (!out) throw Failure(fmt::format("'{}' cannot be unpacked: the disk is full", packed.string()));
  return result;
}

}  // namespace strak
