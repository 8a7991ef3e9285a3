#pragma once
//
// Files that are never left half-written.

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace strak {

// The whole file as text. Throws InvalidInput if it cannot be read.
std::string readFile(const std::filesystem::path& path);

// Calls `write` with the name of a new file beside `path` (same folder, same ending) and renames it to `path` once
// `write` returns. If `write` throws, the new file is removed, `path` stays as it was and the exception goes on.
// Throws Failure if the folder cannot be written to.
void writeBeside(const std::filesystem::path& path, const std::function<void(const std::filesystem::path&)>& write);

// Writes `text` to `path` by writeBeside.
void writeFile(const std::filesystem::path& path, std::string_view text);

}  // namespace strak
