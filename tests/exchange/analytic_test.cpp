// Analytic faces made into B-splines: the same points at the same parameters, edges as they were.
#ifdef STRAK_HAS_CAD

#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <GeomAPI_PointsToBSpline.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_Circle.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Ellipse.hxx>
#include <Geom_Hyperbola.hxx>
#include <Geom_Line.hxx>
#include <Geom_OffsetSurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_SurfaceOfLinearExtrusion.hxx>
#include <Geom_SurfaceOfRevolution.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Vertex.hxx>
#include <gp_Ax3.hxx>

#include <cmath>
#include <numbers>

#include "strak/exchange/cad.h"
#include "strak/fairing/plan_face.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/periodic.h"
#include "tests/exchange/samples.h"

namespace strak {
namespace {

using namespace test;
using std::numbers::pi;

struct Sample {
  std::string name;
  Handle(Geom_Surface) surface;
  double u0, u1, v0, v1;
};

Handle(Geom_Curve) freeform() {
  TColgp_Array1OfPnt points(1, 6);
  for (int i = 1; i <= 6; ++i) points(i) = gp_Pnt(20 + 3 * std::sin(i), 1, 5 * i);
  const Handle(Geom_BSplineCurve) curve = GeomAPI_PointsToBSpline(points).Curve();
  return Handle(Geom_Curve)(curve);
}

std::vector<Sample> samples() {
  const gp_Ax3 axes(gp_Pnt(3, -2, 5), gp_Dir(1, 2, 3), gp_Dir(1, -1, 0.3));
  gp_Ax3 left = axes;
  left.YReverse();
  const gp_Ax1 axis(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1));
  const Handle(Geom_Curve) spline = freeform();
  const double a = spline->FirstParameter(), b = spline->LastParameter();
  const Handle(Geom_Curve) circle = new Geom_Circle(gp_Ax2(gp_Pnt(30, 0, 0), gp_Dir(0, 1, 0)), 7);
  const Handle(Geom_Curve) oval = new Geom_Ellipse(gp_Ax2(gp_Pnt(1, 2, 3), gp_Dir(0, 1, 1)), 9, 4);
  const Handle(Geom_Curve) straight = new Geom_Line(gp_Pnt(12, 3, 0), gp_Dir(0.2, 0, 1));
  return {{"plane", new Geom_Plane(axes), -3, 20, 1, 9},
          {"cylinder", new Geom_CylindricalSurface(axes, 12), 0.4, 2.9, -4, 30},
          {"whole cylinder", new Geom_CylindricalSurface(axes, 12), 0, 2 * pi, -4, 30},
          {"left-handed cylinder", new Geom_CylindricalSurface(left, 12), 1, 3, -4, 30},
          {"cone", new Geom_ConicalSurface(axes, 0.3, 10), 0, 2 * pi, -5, 25},
          {"cone to its tip", new Geom_ConicalSurface(axes, 0.3, 10), 0, 2 * pi, -10 / std::sin(0.3), 25},
          {"sphere", new Geom_SphericalSurface(axes, 15), 0, 2 * pi, -pi / 2, pi / 2},
          {"piece of a sphere", new Geom_SphericalSurface(left, 15), 1, 1.5, -0.2, 0.9},
          {"torus", new Geom_ToroidalSurface(axes, 20, 6), 0, 2 * pi, 0, 2 * pi},
          {"piece of a torus", new Geom_ToroidalSurface(axes, 20, 6), 5, 7, 1, 3},
          {"turned spline", new Geom_SurfaceOfRevolution(spline, axis), 0, 2 * pi, a, b},
          {"turned line", new Geom_SurfaceOfRevolution(straight, axis), 0.1, 2, -3, 8},
          {"turned circle", new Geom_SurfaceOfRevolution(circle, axis), 0.1, 2, 0.2, 1.7},
          {"extruded spline", new Geom_SurfaceOfLinearExtrusion(spline, gp_Dir(1, 1, 0)), a, b, 0, 14},
          {"extruded ellipse", new Geom_SurfaceOfLinearExtrusion(oval, gp_Dir(1, 1, 2)), 0, 2 * pi, -3, 14}};
}

TopoDS_Face faceOf(const Sample& sample) {
  return BRepBuilderAPI_MakeFace(sample.surface, sample.u0, sample.u1, sample.v0, sample.v1, 1e-7);
}

class Analytic : public testing::Test {
 protected:
  void SetUp() override { enableCad(); }

  std::unique_ptr<Model> modelWith(const std::vector<TopoDS_Face>& faces) const {
    BRep_Builder builder;
    TopoDS_Compound all;
    builder.MakeCompound(all);
    for (const TopoDS_Face& face : faces) builder.Add(all, face);
    BRepTools::Write(all, (folder_ / "in.brep").c_str());
    return readModel(folder_ / "in.brep");
  }

  Folder folder_;
};

TEST_F(Analytic, TheSamePointsAtTheSameParameters) {
  for (const Sample& sample : samples()) {
    SCOPED_TRACE(sample.name);
    const auto model = modelWith({faceOf(sample)});
    ASSERT_EQ(model->objects().size(), 1U);
    ASSERT_FALSE(model->objects()[0].spline);
    const Audit before = model->audit();
    ASSERT_TRUE(before.valid);
    model->convertAnalytic({0});
    const Object& object = model->objects()[0];
    ASSERT_EQ(object.leftAlone, "");
    EXPECT_EQ(object.kind, "B-spline surface");
    const auto& spline = std::get<Surface>(*object.spline);
    EXPECT_EQ(object.naturalSide, (std::array{true, true, true, true}));
    EXPECT_TRUE(object.trims.empty());
    for (int i = 0; i <= 37; ++i) {
      for (int j = 0; j <= 23; ++j) {
        const double u = std::lerp(sample.u0, sample.u1, i / 37.0), v = std::lerp(sample.v0, sample.v1, j / 23.0);
        const gp_Pnt was = sample.surface->Value(u, v);
        const Point is = evaluate<2>(spline, {u, v});
        ASSERT_LT(std::hypot(is[0] - was.X(), is[1] - was.Y(), is[2] - was.Z()), 2e-9) << u << " " << v;
      }
    }
    const Audit after = model->audit();
    EXPECT_TRUE(after.valid);
    EXPECT_LT(after.largestGap, before.largestGap + 2e-9);
    EXPECT_LE(after.largestTolerance, before.largestTolerance);
    model->write(folder_ / "out.step");
    const auto back = readModel(folder_ / "out.step");
    EXPECT_TRUE(back->audit().valid);
    ASSERT_EQ(back->objects().size(), 1U);
    EXPECT_TRUE(back->objects()[0].spline);
  }
}

TEST_F(Analytic, WholeTurnsCloseAsSmoothlyAsTheDegreeAllows) {
  for (const Sample& sample : samples()) {
    if (sample.u1 - sample.u0 < 2 * pi || sample.name == "plane") continue;
    const auto model = modelWith({faceOf(sample)});
    model->convertAnalytic({0});
    EXPECT_EQ(seamSmoothness(std::get<Surface>(*model->objects()[0].spline), 0), 6) << sample.name;
  }
}

TEST_F(Analytic, TheOthersStayAndAConvertedFaceCanBeChanged) {
  const auto all = samples();
  const auto model = modelWith({faceOf(all[1]), faceOf(all[0]), faceOf(all[6])});
  model->convertAnalytic({0});
  EXPECT_TRUE(model->objects()[0].spline);
  EXPECT_FALSE(model->objects()[1].spline);
  EXPECT_EQ(model->objects()[2].leftAlone, "a sphere is not a B-spline");
  const auto original = std::get<Surface>(*model->objects()[0].spline);
  const FacePlan plan = planFace(original, {model->objects()[0].trims, model->objects()[0].naturalSide});
  ASSERT_EQ(plan.leftAlone, "");
  Surface moved = plan.spline;
  for (Index r = 0; r < moved.net().rows(); ++r) {
    if (!plan.held[static_cast<std::size_t>(r)]) moved.net()(r, 2) += 0.01;
  }
  model->replace(0, moved);
  EXPECT_TRUE(model->audit().valid);
  model->write(folder_ / "out.brep");
  const auto back = readModel(folder_ / "out.brep");
  EXPECT_EQ(std::get<Surface>(*back->objects()[0].spline).knots(), moved.knots());
  EXPECT_EQ(back->objects()[2].kind, "sphere");
  model->replace(0, original);
  EXPECT_EQ(std::get<Surface>(*model->objects()[0].spline), original);
}

TEST_F(Analytic, TwoHalvesOfOneCylinderGoTogether) {
  const Sample whole = samples()[2];
  Sample first = whole, second = whole;
  first.u1 = second.u0 = pi;
  const auto model = modelWith({faceOf(first), faceOf(second)});
  model->convertAnalytic({1});
  EXPECT_TRUE(model->objects()[0].spline);
  EXPECT_EQ(model->objects()[0].sharedWith, (std::vector<Index>{1}));
  EXPECT_EQ(model->objects()[1].sharedWith, (std::vector<Index>{0}));
  EXPECT_TRUE(model->audit().valid);
}

TEST_F(Analytic, WhatCannotBeDoneIsSaid) {
  const Handle(Geom_Curve) hyperbola = new Geom_Hyperbola(gp_Ax2(gp_Pnt(5, 0, 0), gp_Dir(0, 1, 0)), 3, 2);
  const Sample drawn{"", new Geom_SurfaceOfLinearExtrusion(hyperbola, gp_Dir(0, 1, 0)), -1, 1, 0, 4};
  const Sample offset{"", new Geom_OffsetSurface(samples()[11].surface, 2), 0.1, 2, -3, 8};
  const auto model = modelWith({faceOf(drawn), faceOf(offset)});
  model->convertAnalytic({0, 1});
  EXPECT_NE(model->objects()[0].leftAlone.find("profile"), std::string::npos) << model->objects()[0].leftAlone;
  EXPECT_NE(model->objects()[1].leftAlone.find("cannot be made one"), std::string::npos);
  EXPECT_THROW(model->convertAnalytic({2}), InvalidInput);
}

// A face whose edge is off by a hundredth, more than what is changed: the gap stays what it is, whatever moves inside.
TEST_F(Analytic, AGapLargerThanTheChangeDoesNotGrow) {
  const Sample sample = samples()[1];
  const TopoDS_Face face = faceOf(sample);
  TopoDS_Edge edge;
  for (TopExp_Explorer edges(face, TopAbs_EDGE); edges.More(); edges.Next()) edge = TopoDS::Edge(edges.Current());
  TopLoc_Location place;
  double from = 0, to = 0;
  const Handle(Geom_Curve) off = Handle(Geom_Curve)::DownCast(BRep_Tool::Curve(edge, place, from, to)->Copy());
  off->Translate(gp_Vec(0.006, 0, 0.008));
  const BRep_Builder builder;
  builder.UpdateEdge(edge, off, 0.011);
  for (TopExp_Explorer ends(edge, TopAbs_VERTEX); ends.More(); ends.Next()) {
    builder.UpdateVertex(TopoDS::Vertex(ends.Current()), 0.011);
  }
  const auto model = modelWith({face});
  const Audit before = model->audit();
  EXPECT_TRUE(before.valid);
  EXPECT_NEAR(before.largestGap, 0.01, 1e-6);
  model->convertAnalytic({0});
  ASSERT_EQ(model->objects()[0].leftAlone, "");
  EXPECT_NEAR(model->audit().largestGap, before.largestGap, 1e-9);
  const auto original = std::get<Surface>(*model->objects()[0].spline);
  const FacePlan plan = planFace(original, {model->objects()[0].trims, model->objects()[0].naturalSide});
  Surface moved = plan.spline;
  for (Index r = 0; r < moved.net().rows(); ++r) {
    if (!plan.held[static_cast<std::size_t>(r)]) moved.net()(r, 0) += 1e-3;
  }
  model->replace(0, moved);
  EXPECT_TRUE(model->audit().valid);
  EXPECT_LE(model->audit().largestGap, before.largestGap + 1e-9);
  EXPECT_EQ(model->audit().largestTolerance, before.largestTolerance);
}

// All analytic faces of a real part, one after the other.
TEST_F(Analytic, RealParts) {
  for (const char* name : {"cad/linkrods.step", "cad/as1-oc-214.stp"}) {
    const auto path = dataFile(name);
    if (path.empty()) GTEST_SKIP() << "a real file is not here: set STRAK_DATA";
    const auto model = readModel(path);
    const Audit before = model->audit();
    std::vector<Index> all;
    Index analytic = 0, left = 0;
    for (std::size_t i = 0; i < model->objects().size(); ++i) {
      all.push_back(static_cast<Index>(i));
      analytic += model->objects()[i].spline ? 0 : 1;
    }
    model->convertAnalytic(all);
    for (const Object& object : model->objects()) left += object.spline ? 0 : 1;
    EXPECT_GT(analytic, 0);
    EXPECT_EQ(left, 0) << name;
    const Audit after = model->audit();
    EXPECT_EQ(after.valid, before.valid);
    EXPECT_LE(after.invalidFaces, before.invalidFaces);
    EXPECT_LE(after.largestTolerance, before.largestTolerance);
    EXPECT_LE(after.largestGap, std::max(before.largestGap + 1e-9 * model->size(), before.largestTolerance));
    model->write(folder_ / "out.step");
    const auto back = readModel(folder_ / "out.step");
    EXPECT_EQ(back->objects().size(), model->objects().size());
    EXPECT_LE(back->audit().invalidFaces, before.invalidFaces);
  }
}

}  // namespace
}  // namespace strak

#endif
