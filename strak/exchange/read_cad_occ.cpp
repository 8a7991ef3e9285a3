#include <APIHeaderSection_MakeHeader.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <IGESCAFControl_Reader.hxx>
#include <IGESData_IGESEntity.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_Check.hxx>
#include <Interface_InterfaceModel.hxx>
#include <Interface_ReportEntity.hxx>
#include <Interface_Static.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <StepBasic_MeasureValueMember.hxx>
#include <StepBasic_UncertaintyMeasureWithUnit.hxx>
#include <StepData_StepModel.hxx>
#include <StepGeom_BSplineCurveWithKnotsAndRationalBSplineCurve.hxx>
#include <StepGeom_BSplineSurfaceWithKnotsAndRationalBSplineSurface.hxx>
#include <StepGeom_CartesianPoint.hxx>
#include <TColStd_HArray1OfReal.hxx>
#include <TColStd_HArray2OfReal.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDF_LabelSequence.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS_Iterator.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_WorkSession.hxx>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <iostream>
#include <limits>
#include <sstream>
#include <utility>

#include "strak/base/error.h"
#include "strak/base/file.h"
#include "strak/exchange/cad_file_occ.h"
#include "strak/exchange/signal_guard_occ.h"

namespace strak::cad {
namespace {

constexpr double kFarthest = 1e15;  // coordinates beyond are no geometry: the kernel would search it for ever

struct KnownUnit {
  int flag;
  double millimetres;
  const char* name;
  std::array<const char*, 4> otherNames;
};

constexpr std::array<KnownUnit, 10> kUnits{{{1, 25.4, "inch", {"in", "inches", "", ""}},
                                            {2, 1, "mm", {"millimetre", "millimeter", "", ""}},
                                            {4, 304.8, "ft", {"foot", "feet", "", ""}},
                                            {5, 1609344, "mi", {"mile", "miles", "", ""}},
                                            {6, 1000, "m", {"metre", "meter", "", ""}},
                                            {7, 1e6, "km", {"kilometre", "kilometer", "", ""}},
                                            {8, 0.0254, "mil", {"milliinch", "thousandth inch", "mils", ""}},
                                            {9, 1e-3, "um", {"micrometre", "micrometer", "micron", "microns"}},
                                            {10, 10, "cm", {"centimetre", "centimeter", "", ""}},
                                            {11, 2.54e-5, "uin", {"microinch", "", "", ""}}}};

LengthUnit toUnit(const KnownUnit& known) { return {known.name, known.flag, known.millimetres}; }

[[noreturn]] void broken(const std::filesystem::path& path, FileKind kind, const std::string& why) {
  throw InvalidInput(fmt::format("'{}' cannot be read as {}: {}", path.string(), fileKindName(kind), why));
}

// Which of the writer's schemas is nearest to the one in the file's header.
std::string schemaOf(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string head(20000, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  std::transform(head.begin(), head.end(), head.begin(), [](unsigned char c) { return std::toupper(c); });
  const std::size_t at = head.find("FILE_SCHEMA");
  const std::string schema = at == head.npos ? "" : head.substr(at, head.find(';', at) - at);
  if (schema.find("CONFIG_CONTROL_DESIGN") != schema.npos) return "AP203";
  if (schema.find("AP242") != schema.npos) return "AP242DIS";
  return "AP214IS";
}

// Geometry and topology, in contrast to dates, annotations, properties and the like.
bool isShape(const Standard_Transient& entity) {
  if (const auto* iges = dynamic_cast<const IGESData_IGESEntity*>(&entity)) {
    return (iges->TypeNumber() >= 100 && iges->TypeNumber() < 200) || iges->TypeNumber() / 100 == 5;
  }
  const std::string type = entity.DynamicType()->Name();
  return type.starts_with("StepGeom_") || type.starts_with("StepShape_") || type.starts_with("StepRepr_");
}

// Open CASCADE loads what it can and follows references that lead nowhere: a file with broken geometry is refused
// before it does. Errors elsewhere (in a date, a unit of solid angles) are common and harm nothing.
void requireSound(const std::filesystem::path& path, FileKind kind, const Interface_InterfaceModel& model) {
  for (int i = 1; i <= model.NbEntities(); ++i) {
    if (const auto* point = dynamic_cast<const StepGeom_CartesianPoint*>(model.Value(i).get())) {
      for (int c = 1; c <= point->NbCoordinates(); ++c) {
        if (std::abs(point->CoordinatesValue(c)) <= kFarthest) continue;
        broken(path, kind,
               fmt::format("entity {} is damaged (a coordinate is {})", model.StringLabel(model.Value(i))->ToCString(),
                           point->CoordinatesValue(c)));
      }
    }
    if (!model.IsErrorEntity(i) || !isShape(*model.Value(i))) continue;
    const Handle(Interface_Check) check = model.ReportEntity(i)->Check();
    broken(path, kind,
           fmt::format("entity {} is damaged ({})", model.StringLabel(model.Value(i))->ToCString(),
                       check->NbFails() > 0 ? check->CFail(1) : "no reason given"));
  }
}

// The largest length uncertainty that the file states, in its unit.
double statedUncertainty(const Interface_InterfaceModel& model) {
  double largest = 0;
  for (int i = 1; i <= model.NbEntities(); ++i) {
    const auto* stated = dynamic_cast<const StepBasic_UncertaintyMeasureWithUnit*>(model.Value(i).get());
    if (stated == nullptr || stated->ValueComponentMember().IsNull()) continue;
    if (stated->ValueComponentMember()->Matches("LENGTH_MEASURE"))
      largest = std::max(largest, stated->ValueComponent());
  }
  return largest;
}

// The kernel projects edges onto surfaces while it reads; where weights leave the surface no digits, it never ends.
void requireWeights(const std::filesystem::path& path, const StepData_StepModel& model) {
  constexpr double kMostDecades = 1e100;
  for (int i = 1; i <= model.NbEntities(); ++i) {
    double least = std::numeric_limits<double>::infinity(), most = 0;
    const auto note = [&](double weight) {
      least = std::min(least, std::abs(weight));
      most = std::max(most, std::abs(weight));
    };
    const Handle(Standard_Transient) entity = model.Entity(i);
    if (const auto* s = dynamic_cast<const StepGeom_BSplineSurfaceWithKnotsAndRationalBSplineSurface*>(entity.get())) {
      const Handle(TColStd_HArray2OfReal) weights = s->WeightsData();
      if (weights.IsNull()) continue;
      for (int r = weights->LowerRow(); r <= weights->UpperRow(); ++r) {
        for (int c = weights->LowerCol(); c <= weights->UpperCol(); ++c) note(weights->Value(r, c));
      }
    } else if (const auto* k =
                   dynamic_cast<const StepGeom_BSplineCurveWithKnotsAndRationalBSplineCurve*>(entity.get())) {
      const Handle(TColStd_HArray1OfReal) weights = k->WeightsData();
      if (weights.IsNull()) continue;
      for (int r = weights->Lower(); r <= weights->Upper(); ++r) note(weights->Value(r));
    }
    if (most > kMostDecades * least) {
      broken(path, FileKind::step, fmt::format("the weights of a spline lie between {} and {}", least, most));
    }
  }
}

void readStep(const std::filesystem::path& path, CadFile& file) {
  STEPCAFControl_Reader reader;
  Interface_Static::SetIVal("read.stepcaf.subshapes.name", 1);
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone) broken(path, file.kind, "it is cut off or no STEP file");
  const Handle(StepData_StepModel) model = Handle(StepData_StepModel)::DownCast(reader.Reader().WS()->Model());
  requireSound(path, file.kind, *model);
  requireWeights(path, *model);
  TColStd_SequenceOfAsciiString lengths, angles, solidAngles;
  reader.ChangeReader().FileUnits(lengths, angles, solidAngles);
  file.unit = unitNamed(lengths.IsEmpty() ? "mm" : lengths.First().ToCString());
  file.uncertainty = statedUncertainty(*model) * file.unit.millimetres;
  file.stepSchema = schemaOf(path);
  file.stepHeader = APIHeaderSection_MakeHeader(model).FnValue();
  if (!reader.Transfer(file.document)) broken(path, file.kind, "it holds no shape");
}

void readIges(const std::filesystem::path& path, CadFile& file) {
  IGESCAFControl_Reader reader;
  // Splines are taken as they are: the reader's default would cut or approximate those that are only C0.
  Interface_Static::SetIVal("read.iges.bspline.continuity", 0);
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone) broken(path, file.kind, "it is cut off or no IGES file");
  const Handle(IGESData_IGESModel) model = reader.IGESModel();
  requireSound(path, file.kind, *model);
  file.unit = unitOfFlag(model->GlobalSection().UnitFlag());
  if (model->GlobalSection().UnitFlag() == 3 && !model->GlobalSection().UnitName().IsNull()) {
    file.unit = unitNamed(model->GlobalSection().UnitName()->ToCString());
  }
  for (int i = 1; i <= model->NbEntities(); ++i) {
    const int type = model->Entity(i)->TypeNumber();
    if (type == 186 || type == 514) file.igesSolids = true;
  }
  if (!reader.Transfer(file.document)) broken(path, file.kind, "it holds no shape");
}

// The kernel's BREP reader tells std::cout what it misses; nobody asked it to.
class QuietOutput {
 public:
  QuietOutput() : kept_(std::cout.rdbuf(nullptr)) {}
  ~QuietOutput() { std::cout.rdbuf(kept_); }
  QuietOutput(const QuietOutput&) = delete;
  QuietOutput& operator=(const QuietOutput&) = delete;

 private:
  std::streambuf* kept_;
};

void readBrep(const std::filesystem::path& path, CadFile& file) {
  std::istringstream in(readFile(path));
  in.exceptions(std::ios::failbit | std::ios::badbit);  // it would read on and on behind the end
  TopoDS_Shape shape;
  try {
    const QuietOutput quiet;
    BRepTools::Read(shape, in, BRep_Builder());
  } catch (const std::ios_base::failure&) {
    broken(path, file.kind, "it is cut off or damaged");
  }
  if (shape.IsNull()) broken(path, file.kind, "it is cut off or no BREP file");
  file.unit = {};
  XCAFDoc_DocumentTool::ShapeTool(file.document->Main())->AddShape(shape, false);
}

}  // namespace

std::recursive_mutex& readerMutex() {
  static std::recursive_mutex mutex;
  return mutex;
}

LengthUnit unitOfFlag(int flag) {
  const auto known = std::find_if(kUnits.begin(), kUnits.end(), [&](const KnownUnit& u) { return u.flag == flag; });
  return toUnit(known == kUnits.end() ? kUnits[1] : *known);
}

LengthUnit unitNamed(const std::string& name) {
  std::string lower = name;
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  const auto known = std::find_if(kUnits.begin(), kUnits.end(), [&](const KnownUnit& unit) {
    const auto& others = unit.otherNames;
    return lower == unit.name || (!lower.empty() && std::find(others.begin(), others.end(), lower) != others.end());
  });
  return toUnit(known == kUnits.end() ? kUnits[1] : *known);
}

CadFile::~CadFile() {
  if (document.IsNull()) return;
  const std::lock_guard lock(readerMutex());
  XCAFApp_Application::GetApplication()->Close(document);
}

std::vector<TopoDS_Shape> partsOf(const TopoDS_Shape& shape, TopAbs_ShapeEnum type) {
  TopTools_IndexedMapOfShape map;
  TopExp::MapShapes(shape, type, map);
  std::vector<TopoDS_Shape> parts;
  for (int i = 1; i <= map.Extent(); ++i) parts.push_back(map(i));
  return parts;
}

Handle(TDocStd_Document) newDocument() {
  Handle(TDocStd_Document) document;
  XCAFApp_Application::GetApplication()->NewDocument("BinXCAF", document);
  return document;
}

CadFile readCadFile(const std::filesystem::path& path, FileKind kind) {
  CadFile file;
  file.kind = kind;
  const std::lock_guard lock(readerMutex());
  file.document = newDocument();
  try {
    // Whole files are read at about a megabyte a second.
    constexpr double kSeconds = 15, kSecondsPerByte = 2e-5;
    const double most = kSeconds + kSecondsPerByte * static_cast<double>(std::filesystem::file_size(path));
    const bool survived = survives(
        [&] {
          switch (kind) {
            case FileKind::step:
              return readStep(path, file);
            case FileKind::iges:
              return readIges(path, file);
            default:
              return readBrep(path, file);
          }
        },
        most);
    if (!survived) {
      file.document->IncrementRefCounter();  // half-built: never to be touched again, not even to destroy it
      file.document.Nullify();
      broken(path, kind, "it is damaged, its references lead nowhere or in circles");
    }
  } catch (const Standard_Failure& failure) {
    const char* message = failure.GetMessageString();
    broken(path, kind, fmt::format("Open CASCADE gives up ({})", message && *message ? message : "no reason given"));
  }
  BRep_Builder builder;
  builder.MakeCompound(file.shape);
  TDF_LabelSequence labels;
  XCAFDoc_DocumentTool::ShapeTool(file.document->Main())->GetFreeShapes(labels);
  for (const TDF_Label& label : labels) {
    const TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(label);
    if (!shape.IsNull()) builder.Add(file.shape, shape);
  }
  if (!TopoDS_Iterator(file.shape).More()) broken(path, kind, "it holds no shape");
  return file;
}

}  // namespace strak::cad
