#pragma once
//
// CAD files written from nothing but splines. Only for the *_occ.cpp files.

#include "strak/exchange/file_kind.h"

namespace strak::cad {

// As CadFormats asks.
void writeCadSplines(const std::filesystem::path& path, FileKind kind, const std::vector<PlainObject>& objects,
                     const std::string& unit);
void writeCadTrimmed(const std::filesystem::path& path, FileKind kind, const Surface& surface,
                     const std::vector<TrimmedPart>& parts, const std::string& name, const std::string& unit);

}  // namespace strak::cad
