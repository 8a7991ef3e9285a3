// Shapes that no program of ours writes: instances of one face, pieces of Bezier form, scaled placements.
#ifdef STRAK_HAS_CAD

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierCurve.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Face.hxx>

#include "strak/exchange/cad.h"
#include "strak/spline/knot_insertion.h"
#include "tests/exchange/samples.h"

namespace strak {
namespace {

using namespace test;

Handle(Geom_BezierSurface) bezier() {
  TColgp_Array2OfPnt poles(1, 4, 1, 5);
  for (int i = 1; i <= 4; ++i) {
    for (int j = 1; j <= 5; ++j) poles(i, j).SetCoord(10 * i, 7 * j, (i * j) % 4);
  }
  return new Geom_BezierSurface(poles);
}

TopoDS_Compound compound(const std::vector<TopoDS_Shape>& shapes) {
  TopoDS_Compound result;
  BRep_Builder builder;
  builder.MakeCompound(result);
  for (const TopoDS_Shape& shape : shapes) builder.Add(result, shape);
  return result;
}

std::filesystem::path save(const Folder& folder, const std::string& name, const TopoDS_Shape& shape) {
  auto path = folder / name;
  BRepTools::Write(shape, path.c_str());
  return path;
}

gp_Trsf moved(double x, double scale = 1) {
  gp_Trsf placement;
  if (scale != 1) placement.SetScale(gp_Pnt(0, 0, 0), scale);
  gp_Trsf shift;
  shift.SetTranslation(gp_Vec(x, 0, 0));
  return shift * placement;
}

TEST(Instances, ChangeTogetherAndSaySo) {
  enableCad();
  const Folder folder;
  const Handle(Geom_BSplineSurface) surface = [] {
    const std::vector<double> values{0, 0, 0, 0, 1, 2, 2, 2, 2};
    TColgp_Array2OfPnt poles(1, 5, 1, 5);
    for (int i = 1; i <= 5; ++i) {
      for (int j = 1; j <= 5; ++j) poles(i, j).SetCoord(i, j, (i * j) % 3);
    }
    TColStd_Array1OfReal knots(1, 3);
    TColStd_Array1OfInteger multiplicities(1, 3);
    for (int i = 1; i <= 3; ++i) {
      knots(i) = i - 1;
      multiplicities(i) = i == 2 ? 1 : 4;
    }
    return Handle(Geom_BSplineSurface)(
        new Geom_BSplineSurface(poles, knots, knots, multiplicities, multiplicities, 3, 3));
  }();
  const TopoDS_Face face = BRepBuilderAPI_MakeFace(surface, 1e-7);
  const auto model = readModel(save(folder, "two.brep", compound({face, face.Moved(TopLoc_Location(moved(100)))})));
  ASSERT_EQ(model->objects().size(), 2U);
  EXPECT_EQ(model->objects()[0].sharedWith, std::vector<Index>{1});
  EXPECT_EQ(model->objects()[1].sharedWith, std::vector<Index>{0});
  EXPECT_EQ(*model->objects()[0].spline, *model->objects()[1].spline);  // in their own coordinates
  Surface next = insertKnots(std::get<Surface>(*model->objects()[1].spline), 0, {0.5});
  next.net()(next.row({3, 2}), 2) += 0.25;
  model->replace(1, next);
  EXPECT_EQ(*model->objects()[0].spline, AnySpline(next));
  EXPECT_TRUE(model->audit().valid);
  EXPECT_EQ(model->audit().edges.size(), 4U);  // once for both
  model->write(folder / "out.brep");
  EXPECT_EQ(*readModel(folder / "out.brep")->objects()[0].spline, AnySpline(next));
  // In a plain format each stands in its place.
  model->write(folder / "out.g2");
  const auto plain = readModel(folder / "out.g2");
  const Net apart =
      std::get<Surface>(*plain->objects()[1].spline).net() - std::get<Surface>(*plain->objects()[0].spline).net();
  EXPECT_LT((apart.rowwise() - Eigen::RowVector3d(100, 0, 0)).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(BezierPieces, BecomeBSplinesWhenChanged) {
  enableCad();
  const Folder folder;
  // Two faces on one Bezier surface: the left and the right half.
  const Handle(Geom_BezierSurface) surface = bezier();
  const TopoDS_Face left = BRepBuilderAPI_MakeFace(surface, 0, 0.5, 0, 1, 1e-7);
  const TopoDS_Face right = BRepBuilderAPI_MakeFace(surface, 0.5, 1, 0, 1, 1e-7);
  const auto model = readModel(save(folder, "bezier.brep", compound({left, right})));
  ASSERT_EQ(model->objects().size(), 2U);
  EXPECT_EQ(model->objects()[0].kind, "Bezier surface");
  EXPECT_EQ(model->objects()[0].sharedWith, std::vector<Index>{1});
  EXPECT_EQ(model->objects()[0].naturalSide, (std::array{true, false, false, false}));
  EXPECT_EQ(model->objects()[0].trims.size(), 4U);
  const Surface original = std::get<Surface>(*model->objects()[0].spline);
  EXPECT_EQ(original.sizes(), (Surface::Sizes{4, 5}));
  const Audit before = model->audit();
  const Surface finer = insertKnots(insertKnots(original, 0, {0.25, 0.75}), 1, {0.5});
  model->replace(0, finer);
  const Audit same = model->audit();
  EXPECT_TRUE(same.valid);
  EXPECT_EQ(same.edges.size(), before.edges.size());
  EXPECT_LT(same.largestGap, 1e-12);
  model->write(folder / "out.step");
  const auto back = readModel(folder / "out.step");
  EXPECT_EQ(back->objects()[1].kind, "B-spline surface");
  EXPECT_EQ(*back->objects()[1].spline, AnySpline(finer));
  EXPECT_TRUE(back->audit().valid);
  model->replace(1, original);
  EXPECT_LT(model->audit().largestGap, 1e-12);
  EXPECT_EQ(*model->objects()[0].spline, AnySpline(original));
}

TEST(BezierPieces, CurvesToo) {
  enableCad();
  const Folder folder;
  TColgp_Array1OfPnt poles(1, 4);
  for (int i = 1; i <= 4; ++i) poles(i).SetCoord(i, i * i, 0);
  const Handle(Geom_BezierCurve) curve = new Geom_BezierCurve(poles);
  const auto model = readModel(
      save(folder, "curve.brep", compound({BRepBuilderAPI_MakeEdge(curve), BRepBuilderAPI_MakeEdge(curve, 0.2, 0.8)})));
  ASSERT_EQ(model->objects().size(), 2U);
  EXPECT_EQ(model->objects()[0].kind, "Bezier curve");
  EXPECT_EQ(model->objects()[1].leftAlone, "its edge is a part of a longer curve");
}

TEST(Faces, RectangularTrimmingIsSeenThrough) {
  enableCad();
  const Folder folder;
  const Handle(Geom_Surface) trimmed = new Geom_RectangularTrimmedSurface(bezier(), 0.25, 1.0, 0.0, 1.0);
  const auto model = readModel(save(folder, "trimmed.brep", BRepBuilderAPI_MakeFace(trimmed, 1e-7).Face()));
  const Object& object = model->objects()[0];
  EXPECT_EQ(object.kind, "Bezier surface");
  EXPECT_EQ(std::get<Surface>(*object.spline).knots(0).from(), 0);
  EXPECT_EQ(object.naturalSide, (std::array{false, true, false, false}));
  model->replace(0, insertKnots(std::get<Surface>(*object.spline), 1, {0.5}));
  EXPECT_TRUE(model->audit().valid);
  EXPECT_LT(model->audit().largestGap, 1e-12);
}

}  // namespace
}  // namespace strak

#endif
