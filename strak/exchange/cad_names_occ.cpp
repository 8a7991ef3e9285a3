#include "strak/exchange/cad_names_occ.h"

#include <TCollection_AsciiString.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDataStd_Name.hxx>
#include <TopoDS_Shape.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>

#include <set>
#include <vector>

namespace strak::cad {
namespace {

// A name from the file, empty for one that Open CASCADE made up.
std::string nameOf(const TDF_Label& label) {
  Handle(TDataStd_Name) name;
  if (!label.FindAttribute(TDataStd_Name::GetID(), name)) return "";
  const std::string text = TCollection_AsciiString(name->Get()).ToCString();
  static const std::set<std::string> madeUp{"FACE", "EDGE", "WIRE", "SHELL", "SOLID", "COMPSOLID", "COMPOUND"};
  return madeUp.count(text) != 0 || text.starts_with("Open CASCADE") ? "" : text;
}

}  // namespace

std::map<const TopoDS_TShape*, std::string> namesOf(const CadFile& file) {
  std::map<const TopoDS_TShape*, std::string> names, partNames;
  const auto note = [&](const TDF_Label& label) {
    const std::string name = nameOf(label);
    const TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(label);
    if (shape.IsNull() || name.empty()) return;
    if (shape.ShapeType() == TopAbs_FACE || shape.ShapeType() == TopAbs_EDGE) {
      names[shape.TShape().get()] = name;
      return;
    }
    std::vector<TopoDS_Shape> parts = partsOf(shape, TopAbs_FACE);
    if (parts.empty()) parts = partsOf(shape, TopAbs_EDGE);
    if (parts.size() == 1) partNames[parts.front().TShape().get()] = name;
  };
  const Handle(XCAFDoc_ShapeTool) tool = XCAFDoc_DocumentTool::ShapeTool(file.document->Main());
  TDF_LabelSequence labels;
  tool->GetShapes(labels);
  for (const TDF_Label& label : labels) {
    note(label);
    TDF_LabelSequence parts;
    XCAFDoc_ShapeTool::GetSubShapes(label, parts);
    for (const TDF_Label& part : parts) note(part);
  }
  names.merge(partNames);
  return names;
}

}  // namespace strak::cad
