#pragma once
//
// Which kind of file it is, and who reads and writes CAD files.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "strak/exchange/plain_object.h"
#include "strak/exchange/trimmed_surface.h"

namespace strak {

enum class FileKind { step, iges, brep, g2, json, points };

// "STEP", "IGES", "BREP", "g2", "JSON", "points" (digitised curves: .dat, .csv, .txt, .pcd).
const char* fileKindName(FileKind kind);

// By how a file begins; nothing if it looks like none of them.
std::optional<FileKind> fileKindOfContent(std::string_view text);

// By its ending in any case. Throws InvalidInput with the list of endings for another one.
FileKind fileKindOfEnding(const std::filesystem::path& path);

// The CAD library, as the rest of this room sees it.
struct CadFormats {
  std::unique_ptr<Model> (*read)(const std::filesystem::path& path, FileKind kind);
  void (*write)(const std::filesystem::path& path, FileKind kind, const std::vector<PlainObject>& objects,
                const std::string& unit);
  void (*writeTrimmed)(const std::filesystem::path& path, FileKind kind, const Surface& surface,
                       const std::vector<TrimmedPart>& parts, const std::string& name, const std::string& unit);
};

// Called by enableCad().
void setCadFormats(const CadFormats& formats);

// Opens a STEP, IGES or BREP file. Throws InvalidInput if it is broken or CAD files are not enabled.
std::unique_ptr<Model> readCad(const std::filesystem::path& path, FileKind kind);

// Writes splines to a file of any kind, beside and then renamed. Throws InvalidInput if there is nothing the format can
// hold, or CAD files are not enabled.
void writePlain(const std::filesystem::path& path, const std::vector<PlainObject>& objects, const std::string& unit);

}  // namespace strak
