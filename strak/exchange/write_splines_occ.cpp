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

#include <functional>
#include <mutex>
#include <utility>

#include "strak/base/error.h"
#include "strak/exchange/cad_file_occ.h"
#include "strak/exchange/cad_geometry_occ.h"
#include "strak/exchange/trimmed_surface_occ.h"

namespace strak::cad {
namespace {

TopoDS_Shape shapeOf(const AnySpline& spline, double unitLength) {
  if (const auto* surface = std::get_if<Surface>(&spline)) {
    return BRepBuilderAPI_MakeFace(fromSpline(*surface, unitLength), Precision::Confusion());
  }
  if (const auto* curve = std::get_if<Curve>(&spline)) return BRepBuilderAPI_MakeEdge(fromSpline(*curve, unitLength));
  throw InvalidInput("CAD files hold curves and surfaces, no volumes: write .g2 or .json");
}

// Writes what `shapesOf` makes, in lengths of `unitLength`, with names.
using NamedShapes = std::vector<std::pair<TopoDS_Shape, std::string>>;
void writeShapes(const std::filesystem::path& path, FileKind kind, const std::string& unit,
                 const std::function<NamedShapes(double unitLength)>& shapesOf) {
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
    for (const auto& [shape, name] : shapesOf(file.unit.millimetres)) {
      builder.Add(file.shape, shape);
      const TDF_Label label = tool->AddShape(shape, false);
      if (!name.empty()) TDataStd_Name::Set(label, TCollection_ExtendedString(name.c_str(), true));
    }
  } catch (const Standard_Failure& failure) {
    throw InvalidInput(
        fmt::format("'{}': Open CASCADE cannot hold these splines ({})", path.string(), failure.GetMessageString()));
  }
  writeCadFile(file, path, kind);
}

}  // namespace

void writeCadSplines(const std::filesystem::path& path, FileKind kind, const std::vector<PlainObject>& objects,
                     const std::string& unit) {
  writeShapes(path, kind, unit, [&](double unitLength) {
    NamedShapes shapes;
    for (const PlainObject& object : objects) {
      if (object.spline) shapes.emplace_back(shapeOf(*object.spline, unitLength), object.name);
    }
    return shapes;
  });
}

void writeCadTrimmed(const std::filesystem::path& path, FileKind kind, const Surface& surface,
                     const std::vector<TrimmedPart>& parts, const std::string& name, const std::string& unit) {
  writeShapes(path, kind, unit, [&](double unitLength) {
    NamedShapes shapes;
    for (const TopoDS_Face& face : trimmedFaces(surface, parts, unitLength)) {
      shapes.emplace_back(face, shapes.empty() ? name : fmt::format("{} {}", name, shapes.size() + 1));
    }
    return shapes;
  });
}

}  // namespace strak::cad
