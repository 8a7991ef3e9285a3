#include <BRepTools.hxx>
#include <IGESCAFControl_Writer.hxx>
#include <IGESControl_Controller.hxx>
#include <Interface_Static.hxx>
#include <STEPCAFControl_Controller.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <Standard_Failure.hxx>
#include <TDF_LabelSequence.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>

#include <fmt/format.h>

#include "strak/base/error.h"
#include "strak/base/file.h"
#include "strak/exchange/cad_file_occ.h"

namespace strak::cad {
namespace {

bool writeStep(const CadFile& file, const std::filesystem::path& path) {
  STEPCAFControl_Controller::Init();
  Interface_Static::SetIVal("write.step.unit", file.unit.flag);
  Interface_Static::SetCVal("write.step.schema", file.stepSchema.c_str());
  Interface_Static::SetIVal("write.stepcaf.subshapes.name", 1);
  STEPCAFControl_Writer writer;
  return writer.Transfer(file.document, STEPControl_AsIs) && writer.Write(path.c_str()) == IFSelect_RetDone;
}

bool writeIges(const CadFile& file, const std::filesystem::path& path) {
  IGESControl_Controller::Init();
  Interface_Static::SetIVal("write.iges.unit", file.unit.flag);
  Interface_Static::SetIVal("write.iges.brep.mode", file.igesSolids ? 1 : 0);
  IGESCAFControl_Writer writer;
  return writer.Transfer(file.document) && writer.Write(path.c_str());
}

}  // namespace

void writeCadFile(const CadFile& file, const std::filesystem::path& path, FileKind kind) {
  const std::lock_guard lock(readerMutex());
  writeBeside(path, [&](const std::filesystem::path& temporary) {
    bool written = false;
    std::string reason = "check that the folder may be written to and the disk has space";
    try {
      switch (kind) {
        case FileKind::step:
          written = writeStep(file, temporary);
          break;
        case FileKind::iges:
          written = writeIges(file, temporary);
          break;
        default:
          written = BRepTools::Write(file.shape, temporary.c_str());
          break;
      }
    } catch (const Standard_Failure& failure) {
      reason = fmt::format("Open CASCADE gives up ({})", failure.GetMessageString());
    }
    if (!written) {
      throw Failure(fmt::format("cannot write '{}' as {}: {}", path.string(), fileKindName(kind), reason));
    }
  });
}

}  // namespace strak::cad
