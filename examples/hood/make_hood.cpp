// Makes the sample part hood.step: a car hood of 1000 x 600 mm in three faces, sewn, with a round hole in the middle
// one.
//
//   make_hood OUT.step
//
// The three faces are cut from one bicubic B-spline surface. Its edges, its joins and the rim of the hole are as they
// should be, with curvature; in between the surface has a ripple and noise of some tenths of a millimetre, as scanning
// and modelling by hand leave them. The file is the same to the byte every time.

#include <APIHeaderSection_MakeHeader.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepLib.hxx>
#include <Geom2d_Circle.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Precision.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Controller.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <Standard_Failure.hxx>
#include <StepData_Protocol.hxx>
#include <StepData_StepModel.hxx>
#include <StepData_StepWriter.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Wire.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_WorkSession.hxx>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <random>

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kDegree = 3;
constexpr double kHalfWidth = 500, kHalfDepth = 300;  // mm; x and y are the parameters u and v themselves
constexpr int kSpansU = 38, kSpansV = 23;
constexpr std::array kCuts{0, 12, 26, 38};  // spans in u where the faces begin and end
constexpr double kHoleX = 0, kHoleY = 40, kHoleRadius = 60;
constexpr double kRipple = 0.25, kNoise = 0.2;  // mm

double knot(double half, int spans, int i) { return -half + 2 * half * std::clamp(i, 0, spans) / spans; }

// The mean of the three knots that belong to a control point: with these as x and y the surface is a graph over (u, v).
double greville(double half, int spans, int i) {
  return (knot(half, spans, i - 2) + knot(half, spans, i - 1) + knot(half, spans, i)) / 3;
}

double crown(double x, double y) {
  const double a = x / kHalfWidth, b = y / kHalfDepth;
  return 95 - 70 * a * a - 12 * a * a * a * a - 35 * b - 30 * b * b + 14 * a * a * b;
}

// Whether a control point stays as it should be: those that decide on position, slope and curvature at the border, at a
// cut, or anywhere in a span that the rim of the hole touches.
bool isSound(int i, int j) {
  if (j < 3 || j >= kSpansV) return true;
  for (int cut : kCuts) {
    if (i >= cut && i < cut + kDegree) return true;
  }
  // The control point reaches over the spans i - 3 .. i and j - 3 .. j.
  const double x = std::clamp(kHoleX, knot(kHalfWidth, kSpansU, i - 3), knot(kHalfWidth, kSpansU, i + 1));
  const double y = std::clamp(kHoleY, knot(kHalfDepth, kSpansV, j - 3), knot(kHalfDepth, kSpansV, j + 1));
  return std::hypot(x - kHoleX, y - kHoleY) <= kHoleRadius;
}

Handle(Geom_BSplineSurface) wavySurface() {
  std::mt19937_64 random(20030114);
  TColgp_Array2OfPnt poles(1, kSpansU + kDegree, 1, kSpansV + kDegree);
  for (int i = 0; i < kSpansU + kDegree; ++i) {
    for (int j = 0; j < kSpansV + kDegree; ++j) {
      const double x = greville(kHalfWidth, kSpansU, i);
      const double y = greville(kHalfDepth, kSpansV, j);
      const double noise = kNoise * (static_cast<double>(random() >> 11) * 0x1p-52 - 1);
      const double ripple = kRipple * std::sin(2 * kPi * (x + 0.4 * y) / 110) * std::cos(2 * kPi * y / 190);
      const double z = crown(x, y) + (isSound(i, j) ? 0 : noise + ripple);
      poles(i + 1, j + 1).SetCoord(x, y, std::round(z * 1e6) / 1e6);  // alike whatever the sine's last digits
    }
  }
  const auto knots = [](double half, int spans) {
    TColStd_Array1OfReal values(1, spans + 1);
    for (int i = 0; i <= spans; ++i) values(i + 1) = knot(half, spans, i);
    return values;
  };
  const auto multiplicities = [](int spans) {
    TColStd_Array1OfInteger values(1, spans + 1);
    values.Init(1);
    values(1) = values(spans + 1) = kDegree + 1;
    return values;
  };
  return new Geom_BSplineSurface(poles, knots(kHalfWidth, kSpansU), knots(kHalfDepth, kSpansV), multiplicities(kSpansU),
                                 multiplicities(kSpansV), kDegree, kDegree);
}

// The part of the surface between two cuts; the middle one with the hole.
TopoDS_Face makeFace(const Handle(Geom_BSplineSurface) & whole, int part) {
  const Handle(Geom_BSplineSurface) surface = Handle(Geom_BSplineSurface)::DownCast(whole->Copy());
  const auto cut = static_cast<std::size_t>(part);
  surface->Segment(knot(kHalfWidth, kSpansU, kCuts[cut]), knot(kHalfWidth, kSpansU, kCuts[cut + 1]), -kHalfDepth,
                   kHalfDepth);
  BRepBuilderAPI_MakeFace face(surface, Precision::Confusion());
  if (part != 1) return face.Face();
  const Handle(Geom2d_Circle) rim = new Geom2d_Circle(gp_Ax2d(gp_Pnt2d(kHoleX, kHoleY), gp_Dir2d(1, 0)), kHoleRadius);
  TopoDS_Wire hole = BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(rim, surface)).Wire();
  BRepLib::BuildCurves3d(hole, 1e-6);
  BRepBuilderAPI_MakeFace cutFace(face.Face(), TopoDS::Wire(hole.Reversed()));
  TopoDS_Face result = cutFace.Face();
  BRepLib::SameParameter(result, 1e-6);
  return result;
}

bool writeHood(const char* path) {
  const Handle(Geom_BSplineSurface) whole = wavySurface();
  std::array<TopoDS_Face, 3> faces;
  BRepBuilderAPI_Sewing sewing(1e-5);
  for (int part = 0; part < 3; ++part) {
    faces[static_cast<std::size_t>(part)] = makeFace(whole, part);
    sewing.Add(faces[static_cast<std::size_t>(part)]);
  }
  sewing.Perform();

  Handle(TDocStd_Document) document;
  XCAFApp_Application::GetApplication()->NewDocument("BinXCAF", document);
  const Handle(XCAFDoc_ShapeTool) shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  const Handle(XCAFDoc_ColorTool) colours = XCAFDoc_DocumentTool::ColorTool(document->Main());
  const TDF_Label hood = shapes->AddShape(sewing.SewedShape(), false);
  TDataStd_Name::Set(hood, "hood");
  colours->SetColor(hood, Quantity_Color(0.55, 0.05, 0.08, Quantity_TOC_RGB), XCAFDoc_ColorSurf);
  const std::array names{"hood left", "hood middle", "hood right"};
  for (std::size_t part = 0; part < 3; ++part) {
    const TDF_Label label = shapes->AddSubShape(hood, sewing.Modified(faces[part]));
    if (!label.IsNull()) TDataStd_Name::Set(label, names[part]);
  }

  STEPCAFControl_Controller::Init();
  Interface_Static::SetCVal("write.step.schema", "AP214IS");
  Interface_Static::SetCVal("write.step.unit", "MM");
  Interface_Static::SetIVal("write.stepcaf.subshapes.name", 1);
  STEPCAFControl_Writer writer;
  if (!writer.Transfer(document, STEPControl_AsIs)) return false;
  APIHeaderSection_MakeHeader header(Handle(StepData_StepModel)::DownCast(writer.Writer().WS()->Model()));
  header.SetName(new TCollection_HAsciiString("hood.step"));
  header.SetTimeStamp(new TCollection_HAsciiString("2000-01-01T00:00:00"));
  header.SetAuthorValue(1, new TCollection_HAsciiString("Strak"));
  header.SetOrganizationValue(1, new TCollection_HAsciiString("examples/hood"));
  StepData_StepWriter text(Handle(StepData_StepModel)::DownCast(writer.Writer().WS()->Model()));
  text.FloatWriter().SetFormat("%.16E");  // 17 digits: read back to the bit
  text.SendModel(Handle(StepData_Protocol)::DownCast(writer.Writer().WS()->Protocol()));
  std::ofstream out(path, std::ios::binary);
  text.Print(out);
  out.close();
  return out.good();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_hood OUT.step\n");
    return 2;
  }
  Message::DefaultMessenger()->ChangePrinters().Clear();
  try {
    if (writeHood(argv[1])) return 0;
    std::fprintf(stderr, "cannot write '%s'\n", argv[1]);
  } catch (const Standard_Failure& failure) {
    std::fprintf(stderr, "Open CASCADE gives up: %s\n", failure.GetMessageString());
  }
  return 1;
}
