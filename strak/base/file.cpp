#include "strak/base/file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <system_error>

#include "strak/base/error.h"

namespace strak {

std::string readFile(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    throw InvalidInput(fmt::format("'{}' is a folder: name a file in it", path.string()));
  }
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InvalidInput(fmt::format("cannot open '{}': check the name and that you may read it", path.string()));
  std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (in.bad()) throw Failure(fmt::format("reading '{}' stopped half-way: check the disk", path.string()));
  return text;
}

void writeBeside(const std::filesystem::path& path, const std::function<void(const std::filesystem::path&)>& write) {
  std::error_code error;
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  if (!std::filesystem::is_directory(folder, error)) {
    throw Failure(fmt::format("there is no folder '{}' to write '{}' into: create it first", folder.string(),
                              path.filename().string()));
  }
  if (std::filesystem::is_directory(path, error)) {
    throw Failure(fmt::format("cannot write '{}': it is a folder, name a file in it", path.string()));
  }
  const auto temporary =
      folder / fmt::format(".{}.{}.part{}", path.stem().string(), ::getpid(), path.extension().string());
  try {
    write(temporary);
  } catch (...) {
    std::filesystem::remove(temporary, error);
    throw;
  }
  std::filesystem::rename(temporary, path, error);
  if (error) {
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);
    throw Failure(
        fmt::format("cannot write '{}' ({}): check that the folder may be written to", path.string(), error.message()));
  }
}

void writeFile(const std::filesystem::path& path, std::string_view text) {
  writeBeside(path, [&](const std::filesystem::path& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
    out.close();
    if (!out) {
      throw Failure(fmt::format("cannot write '{}': check that the folder may be written to and the disk has space",
                                path.string()));
    }
  });
}

}  // namespace strak
