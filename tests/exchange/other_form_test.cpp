// Splines of another form under the faces and edges of files: edges fit, and the checker agrees.
#ifdef STRAK_HAS_CAD
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepTools.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TopoDS_Face.hxx>

#include "strak/exchange/cad_geometry_occ.h"
#endif

#include <cmath>

#include "strak/exchange/cad.h"
#include "strak/fairing/conversion.h"
#include "strak/spline/degree_elevation.h"
#include "tests/exchange/patches.h"
#include "tests/exchange/samples.h"

namespace strak {
namespace {

using namespace test;

// Every spline that may be changed as a cubic on uniform knots within `tolerance`; how many were taken.
Index makeCubic(Model& model, double tolerance) {
  std::vector<std::pair<Index, AnySpline>> changes;
  for (std::size_t i = 0; i < model.objects().size(); ++i) {
    const Object& object = model.objects()[i];
    if (!object.leftAlone.empty() || !object.spline) continue;
    if (!object.sharedWith.empty() && object.sharedWith.front() < static_cast<Index>(i)) continue;
    ConversionOptions options;
    options.tolerance = tolerance;
    std::visit(
        [&]<int D>(const Spline<D>& spline) {
          auto made = convertSpline<D>(spline, options);
          EXPECT_TRUE(made.reached) << object.name;
          changes.emplace_back(static_cast<Index>(i), std::move(made.spline));
        },
        *object.spline);
  }
  Index taken = 0;
  for (const std::string& refused : model.replaceForms(changes)) taken += refused.empty() ? 1 : 0;
  return taken;
}

void expectCubic(const Model& model) {
  for (const Object& object : model.objects()) {
    if (!object.leftAlone.empty() || !object.spline) continue;
    std::visit(
        [&]<int D>(const Spline<D>& spline) {
          EXPECT_FALSE(spline.isRational()) << object.name;
          for (int k = 0; k < D; ++k) EXPECT_EQ(spline.degree(k), 3) << object.name;
        },
        *object.spline);
  }
}

TEST(OtherForm, PlainSplinesTakeAnyFormOnTheirDomain) {
  std::mt19937 random(51);
  const KnotVector knots = randomKnots(random, 5, 9);
  Net net(9, 3);
  for (Index r = 0; r < 9; ++r) net.row(r) << static_cast<double>(r), std::sin(static_cast<double>(r)), 0;
  const Curve curve({knots}, net);
  const auto model = modelOf({curve});
  EXPECT_EQ(makeCubic(*model, 1e-3), 1);
  expectCubic(*model);
  // From then on that is the spline as it was read.
  const AnySpline now = *model->objects()[0].spline;
  model->replace(0, now);
  EXPECT_THROW(model->replace(0, curve), InvalidInput);
  EXPECT_THROW(model->replaceForms({{1, now}}), InvalidInput);
  const KnotVector other = knots.rescaled(knots.from(), knots.to() + 1);
  EXPECT_THROW(model->replaceForms({{0, Curve({other}, net)}}), InvalidInput);
}

#ifdef STRAK_HAS_CAD

// A common side that stays common takes its edge along, exactly; so does a free side.
TEST(OtherForm, EdgesOfCommonSidesFollow) {
  enableCad();
  std::vector<Surface> patches;
  for (Surface patch : fourPatches()) {
    patch = elevateDegree(elevateDegree(patch, 0, 1), 1, 1);
    Net net = patch.net();
    for (Index r = 0; r < net.rows(); ++r) net(r, 2) += 2 * std::sin(0.1 * net(r, 0)) * std::sin(0.08 * net(r, 1) + 1);
    patches.emplace_back(patch.knots(), std::move(net));
  }
  BRepBuilderAPI_Sewing sewing(1e-6);
  for (const Surface& patch : patches) sewing.Add(BRepBuilderAPI_MakeFace(cad::fromSpline(patch, 1), 1e-7).Face());
  sewing.Perform();
  const Folder folder;
  BRepTools::Write(sewing.SewedShape(), (folder / "in.brep").c_str());
  const auto model = readModel(folder / "in.brep");
  const Audit before = model->audit();
  ASSERT_TRUE(before.valid);
  const auto lineOf = [&] { return evaluate<2>(std::get<Surface>(*model->objects()[0].spline), {0.4, 1.0}); };
  const Point had = lineOf();
  EXPECT_EQ(makeCubic(*model, std::numeric_limits<double>::infinity()), 4);
  EXPECT_GT((lineOf() - had).norm(), 1e-3);
  const auto check = [&](const Audit& after) {
    EXPECT_TRUE(after.valid);
    ASSERT_EQ(after.edges.size(), before.edges.size());
    for (const EdgeFit& edge : after.edges) {
      EXPECT_LT(edge.gap, 1e-9) << edge.name;
      EXPECT_LT(edge.faceGap, 1e-9) << edge.name;
      EXPECT_LT(edge.tolerance, 2e-6) << edge.name;
    }
  };
  check(model->audit());
  for (const char* name : {"out.step", "out.brep"}) {
    model->write(folder / name);
    check(readModel(folder / name)->audit());
  }
}

struct RealFile {
  const char* name;
  double tolerance;  // of the size
  Index taken;
};

class OtherFormOfFiles : public testing::TestWithParam<RealFile> {};

TEST_P(OtherFormOfFiles, FacesStayValid) {
  const RealFile& expected = GetParam();
  enableCad();
  const auto path = dataFile(expected.name);
  if (path.empty()) GTEST_SKIP() << "a real file is not here: set STRAK_DATA";
  const auto model = readModel(path);
  const Audit before = model->audit();
  const double tolerance = expected.tolerance * model->size();
  EXPECT_EQ(makeCubic(*model, tolerance), expected.taken);
  expectCubic(*model);
  const auto check = [&](const Audit& after) {
    EXPECT_EQ(after.valid, before.valid);
    EXPECT_LE(after.invalidFaces, before.invalidFaces);
    EXPECT_LE(after.largestGap, 1.01 * (before.largestGap + tolerance));
  };
  check(model->audit());
  for (const EdgeFit& edge : model->audit().edges) EXPECT_LE(edge.gap, edge.tolerance * (1 + 1e-9)) << edge.name;
  const Folder folder;
  const auto written = folder / ("out" + path.extension().string());
  model->write(written);
  const auto again = readModel(written);
  EXPECT_EQ(again->objects().size(), model->objects().size());
  expectCubic(*again);
  check(again->audit());
}

INSTANTIATE_TEST_SUITE_P(Real, OtherFormOfFiles,
                         testing::Values(RealFile{"cad/car_hood_capot.step", 1e-4, 18},
                                         RealFile{"cad/joinsurf_02.stp", 1e-4, 2},
                                         RealFile{"cad/propeller_blade_upper.iges", 1e-4, 1}),
                         [](const auto& file) { return std::string(1, static_cast<char>('a' + file.index)); });

#endif

}  // namespace
}  // namespace strak
