#include "strak/exchange/write_splines_occ.h"

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRep_Builder.hxx>
#include <Precision.hxx>
#include <Standard_Failure.hxx>
#include <TCollection_ExtendedString.hxx>
#include <TDataStd_Name.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>

#include <fmt/format.h>

#include <mutex>

#include "strak/base/error.h"
#include "strak/exchange/cad_file_occ.h"
#include "strak/exchange/cad_geometry_occ.h"

namespace strak::cad {
namespace {

TopoDS_Shape shapeOf(const AnySpline& spline, double unitLength) {
  if (const auto* surface = std::get_if<Surface>(&spline)) {
    return BRepBuilderAPI_MakeFace(fromSpline(*surface, unitLength), Precision::Confusion());
  }
  if (const auto* curve = std::get_if<Curve>(&spline)) return BRepBuilderAPI_MakeEdge(fromSpline(*curve, unitLength));
  throw InvalidInput("CAD files hold curves and surfaces, no volumes: write .g2 or .json");
}

}  // namespace

void writeCadSplines(const std::filesystem::path& path, FileKind kind, const std::vector<PlainObject>& objects,
                     const std::string& unit) {
  CadFile file;
  file.kind = kind;
  file.unit = unitNamed(unit);
  try {
    {
      const std::lock_guard lock(readerMutex());
      file.document = newDocument();
    }
    BRep_Builder builder;
    builder.MakeCompound(file.shape);
    const Handle(XCAFDoc_ShapeTool) tool = XCAFDoc_DocumentTool::ShapeTool(file.document->Main());
    for (const PlainObject& object : objects) {
      if (!object.spline) continue;
      const TopoDS_Shape shape = shapeOf(*object.spline, file.unit.millimetres);
      builder.Add(file.shape, shape);
      const TDF_Label label = tool->AddShape(shape, false);
      if (!object.name.empty()) {
        TDataStd_Name::Set(label, TCollection_ExtendedString(object.name.c_str(), true));
      }
    }
  } catch (const Standard_Failure& failure) {
    throw InvalidInput(
        fmt::format("'{}': Open CASCADE cannot hold these splines ({})", path.string(), failure.GetMessageString()));
  }
  writeCadFile(file, path, kind);
}

}  // namespace strak::cad
