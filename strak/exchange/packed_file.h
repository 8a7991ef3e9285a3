#pragma once
//
// Files packed by gzip, unpacked beside the work: what reads them needs not know.

#include <filesystem>
#include <memory>

namespace strak {

// Whether the file begins as gzip's do.
bool isPacked(const std::filesystem::path& path);

// A temporary file with the content of the packed one and the ending before ".gz"; it goes with the last pointer.
// Throws InvalidInput if the packed file is damaged, Failure if there is no room.
std::shared_ptr<const std::filesystem::path> unpacked(const std::filesystem::path& packed);

}  // namespace strak
