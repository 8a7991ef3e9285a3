#include "strak/exchange/file_kind.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cctype>

#include "strak/base/error.h"
#include "strak/base/file.h"
#include "strak/exchange/g2.h"
#include "strak/exchange/json.h"

namespace strak {
namespace {

std::atomic<const CadFormats*> cadFormats = nullptr;

bool isDigit(char c) { return c >= '0' && c <= '9'; }

// An IGES line has 80 columns: a letter for its section in column 73, its number after it.
bool looksLikeIges(std::string_view text) {
  return text.size() >= 80 && text[72] == 'S' && text.substr(0, 80).find('\n') == text.npos &&
         std::all_of(text.begin() + 73, text.begin() + 80, [](char c) { return c == ' ' || isDigit(c); });
}

const CadFormats& cad(const std::filesystem::path& path, FileKind kind) {
  const CadFormats* formats = cadFormats;
  if (formats == nullptr) {
    throw InvalidInput(fmt::format("'{}': this program was built without {} files; convert it to .g2 or .json first",
                                   path.string(), fileKindName(kind)));
  }
  return *formats;
}

}  // namespace

const char* fileKindName(FileKind kind) {
  switch (kind) {
    case FileKind::step:
      return "STEP";
    case FileKind::iges:
      return "IGES";
    case FileKind::brep:
      return "BREP";
    case FileKind::g2:
      return "g2";
    case FileKind::json:
      return "JSON";
    case FileKind::points:
      return "points";
  }
  return "unknown";
}

std::optional<FileKind> fileKindOfContent(std::string_view text) {
  if (looksLikeIges(text)) return FileKind::iges;
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == text.npos) return std::nullopt;
  const std::string_view head = text.substr(begin, 200);
  if (head.starts_with("ISO-10303-21")) return FileKind::step;
  if (head.starts_with("DBRep_DrawableShape") || head.starts_with("CASCADE Topology")) return FileKind::brep;
  if (head[0] == '{') return FileKind::json;
  // A class of three digits, then the version.
  if (head.size() > 3 && isDigit(head[0]) && isDigit(head[1]) && isDigit(head[2]) &&
      (head[3] == ' ' || head[3] == '\t' || head[3] == '\n' || head[3] == '\r')) {
    return FileKind::g2;
  }
  return std::nullopt;
}

FileKind fileKindOfEnding(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  if (ending == ".stp" || ending == ".step") return FileKind::step;
  if (ending == ".igs" || ending == ".iges") return FileKind::iges;
  if (ending == ".brep" || ending == ".brp") return FileKind::brep;
  if (ending == ".g2") return FileKind::g2;
  if (ending == ".json") return FileKind::json;
  if (ending == ".dat" || ending == ".csv" || ending == ".txt" || ending == ".pcd") return FileKind::points;
  throw InvalidInput(
      fmt::format("'{}' has an ending this program does not know: use .stp, .step, .igs, .iges, .brep, "
                  ".g2 or .json, or .dat, .csv, .txt, .pcd for digitised curves",
                  path.string()));
}

void setCadFormats(const CadFormats& formats) {
  static const CadFormats kept = formats;
  cadFormats = &kept;
}

void writePlain(const std::filesystem::path& path, const std::vector<PlainObject>& objects, const std::string& unit) {
  const FileKind kind = fileKindOfEnding(path);
  if (kind != FileKind::g2 && std::none_of(objects.begin(), objects.end(),
                                           [](const PlainObject& object) { return object.spline.has_value(); })) {
    throw InvalidInput(
        fmt::format("'{}': there is no spline that a {} file could hold", path.string(), fileKindName(kind)));
  }
  switch (kind) {
    case FileKind::g2:
      return writeFile(path, formatG2(objects));
    case FileKind::json:
      return writeFile(path, formatJson({objects, unit}));
    case FileKind::points:
      throw InvalidInput(
          fmt::format("'{}': only a curve that was read from such a file can be written as its points: use .g2, .json, "
                      ".step or .igs",
                      path.string()));
    default:
      return cad(path, kind).write(path, kind, objects, unit);
  }
}

bool holdsTrimming(const std::filesystem::path& path) {
  const FileKind kind = fileKindOfEnding(path);
  return kind == FileKind::step || kind == FileKind::iges || kind == FileKind::brep;
}

void writeTrimmed(const std::filesystem::path& path, const Surface& surface, const std::vector<TrimmedPart>& parts,
                  const std::string& name, const std::string& unit) {
  const FileKind kind = fileKindOfEnding(path);
  if (!holdsTrimming(path)) {
    throw InvalidInput(
        fmt::format("'{}': {} files hold no trimming: use .step, .igs or .brep", path.string(), fileKindName(kind)));
  }
  cad(path, kind).writeTrimmed(path, kind, surface, parts, name, unit);
}

std::unique_ptr<Model> readCad(const std::filesystem::path& path, FileKind kind) {
  return cad(path, kind).read(path, kind);
}

}  // namespace strak
