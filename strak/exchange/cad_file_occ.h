#pragma once
//
// A CAD file in memory: a document of Open CASCADE with everything the file says. Only for the *_occ.cpp files.
//
// Open CASCADE keeps all lengths in millimetres; `unitLength` goes back to the file's own unit.

#include <HeaderSection_FileName.hxx>
#include <Standard_Handle.hxx>
#include <TDocStd_Document.hxx>
#include <TopoDS_Compound.hxx>
#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include "strak/exchange/file_kind.h"

namespace strak::cad {

// Open CASCADE's readers and writers share parameters that are global: one of them at a time.
std::recursive_mutex& readerMutex();

struct LengthUnit {
  std::string name;        // "mm", "inch", ...; "" where the format knows none (BREP)
  int flag = 2;            // the number IGES and Open CASCADE give it
  double millimetres = 1;  // one unit in Open CASCADE's lengths
};

// The unit with that flag or name ("millimetre", "INCH", "M", ...); millimetres for an unknown one.
LengthUnit unitOfFlag(int flag);
LengthUnit unitNamed(const std::string& name);

struct CadFile {
  Handle(TDocStd_Document) document;
  TopoDS_Compound shape;  // all that stands free in the document
  FileKind kind = FileKind::step;
  LengthUnit unit;
  std::string stepSchema = "AP214IS";  // "AP203", "AP214IS", "AP242DIS": as the file has it
  // How exact a STEP file says it is, in millimetres; readers judge trimming curves by it. 0 where the file says
  // nothing: then the largest tolerance of an edge is written.
  double uncertainty = 0;
  Handle(HeaderSection_FileName) stepHeader;  // name, authors, organization, originating system; may be null
  bool igesSolids = false;                    // the IGES file has shells or solids, not single faces

  CadFile() = default;
  CadFile(const CadFile&) = delete;
  CadFile& operator=(const CadFile&) = delete;
  CadFile(CadFile&&) = default;
  CadFile& operator=(CadFile&&) = delete;
  ~CadFile();
};

// All faces, edges, ... of a shape in their order, each once in every place that an assembly puts it.
std::vector<TopoDS_Shape> partsOf(const TopoDS_Shape& shape, TopAbs_ShapeEnum type);

// An empty document. The caller holds readerMutex().
Handle(TDocStd_Document) newDocument();

// Throws InvalidInput if the file cannot be understood.
CadFile readCadFile(const std::filesystem::path& path, FileKind kind);

// Writes in the file's own unit and schema, beside and then renamed. Throws Failure if it cannot.
void writeCadFile(const CadFile& file, const std::filesystem::path& path, FileKind kind);

}  // namespace strak::cad
