#include <APIHeaderSection_MakeHeader.hxx>
#include <BRepTools.hxx>
#include <IGESCAFControl_Writer.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESData_IGESModel.hxx>
#include <IGESData_IGESWriter.hxx>
#include <IGESData_Protocol.hxx>
#include <IGESSelect_WorkLibrary.hxx>
#include <Interface_Static.hxx>
#include <STEPCAFControl_Controller.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <Standard_Failure.hxx>
#include <StepData_Protocol.hxx>
#include <StepData_StepModel.hxx>
#include <StepData_StepWriter.hxx>
#include <TDF_LabelSequence.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_WorkSession.hxx>

#include <fmt/format.h>

#include <sstream>

#include "strak/base/error.h"
#include "strak/base/file.h"
#include "strak/exchange/cad_file_occ.h"
#include "strak/exchange/signal_guard_occ.h"

namespace strak::cad {
namespace {

// 17 digits, so that what is written is read back to the bit; the writers' own formats keep 13.
constexpr const char* kNumberFormat = "%.16E";

// Who made the file stays in its header; when it was written is new.
void keepHeader(const CadFile& file, const Handle(StepData_StepModel) & model) {
  const Handle(HeaderSection_FileName)& had = file.stepHeader;
  if (had.IsNull()) return;
  APIHeaderSection_MakeHeader header(model);
  if (!had->Name().IsNull()) header.SetName(had->Name());
  if (!had->Author().IsNull()) header.SetAuthor(had->Author());
  if (!had->Organization().IsNull()) header.SetOrganization(had->Organization());
  if (!had->OriginatingSystem().IsNull()) header.SetOriginatingSystem(had->OriginatingSystem());
  if (!had->Authorisation().IsNull()) header.SetAuthorisation(had->Authorisation());
}

bool writeStep(const CadFile& file, std::ostream& out) {
  STEPCAFControl_Controller::Init();
  Interface_Static::SetIVal("write.step.unit", file.unit.flag);
  Interface_Static::SetCVal("write.step.schema", file.stepSchema.c_str());
  Interface_Static::SetIVal("write.stepcaf.subshapes.name", 1);
  Interface_Static::SetIVal("write.precision.mode", file.uncertainty > 0 ? 2 : 1);  // as given; the largest
  Interface_Static::SetRVal("write.precision.val", file.uncertainty);
  STEPCAFControl_Writer writer;
  if (!writer.Transfer(file.document, STEPControl_AsIs)) return false;
  const Handle(XSControl_WorkSession) session = writer.Writer().WS();
  const Handle(StepData_StepModel) model = Handle(StepData_StepModel)::DownCast(session->Model());
  keepHeader(file, model);
  StepData_StepWriter text(model);
  text.FloatWriter().SetFormat(kNumberFormat);
  text.SendModel(Handle(StepData_Protocol)::DownCast(session->Protocol()));
  return text.Print(out);
}

bool writeIges(const CadFile& file, std::ostream& out) {
  IGESControl_Controller::Init();
  Interface_Static::SetIVal("write.iges.unit", file.unit.flag);
  Interface_Static::SetIVal("write.iges.brep.mode", file.igesSolids ? 1 : 0);
  IGESCAFControl_Writer writer;
  if (!writer.Transfer(file.document)) return false;
  writer.ComputeModel();
  IGESData_IGESWriter text(writer.Model());
  text.FloatWriter().SetFormat(kNumberFormat);
  text.SendModel(IGESSelect_WorkLibrary::DefineProtocol());
  return text.Print(out);
}

}  // namespace

void writeCadFile(const CadFile& file, const std::filesystem::path& path, FileKind kind) {
  const auto fail = [&](const std::string& why) {
    throw Failure(fmt::format("cannot write '{}' as {}: {}", path.string(), fileKindName(kind), why));
  };
  // Into memory first: the kernel does not notice a full disk.
  std::ostringstream text;
  try {
    const std::lock_guard lock(readerMutex());
    bool made = true;
    const bool survived = survives([&] {
      switch (kind) {
        case FileKind::step:
          made = writeStep(file, text);
          break;
        case FileKind::iges:
          made = writeIges(file, text);
          break;
        default:
          BRepTools::Write(file.shape, text);
          break;
      }
    });
    if (!survived || !made) fail("Open CASCADE cannot express it");
  } catch (const Standard_Failure& failure) {
    fail(fmt::format("Open CASCADE gives up ({})", failure.GetMessageString()));
  }
  writeFile(path, text.view());
}

}  // namespace strak::cad
