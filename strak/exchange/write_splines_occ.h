#pragma once
//
// A CAD file made of splines alone. Only for the *_occ.cpp files.

#include <filesystem>
#include <string>
#include <vector>

#include "strak/exchange/file_kind.h"
#include "strak/exchange/plain_object.h"

namespace strak::cad {

// Surfaces become faces over their domains, curves free edges, under their names. Throws InvalidInput for volumes and
// what the kernel cannot hold, Failure if the file cannot be written.
void writeCadSplines(const std::filesystem::path& path, FileKind kind, const std::vector<PlainObject>& objects,
                     const std::string& unit);

}  // namespace strak::cad
