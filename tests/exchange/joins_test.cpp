// Whole parts: borders that move together, and the edges that follow them.
#ifdef STRAK_HAS_CAD

#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepTools.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TopoDS_Face.hxx>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "strak/exchange/cad.h"
#include "strak/exchange/cad_geometry_occ.h"
#include "strak/fairing/joints.h"
#include "strak/spline/knot_insertion.h"
#include "tests/exchange/patches.h"
#include "tests/exchange/samples.h"

namespace strak {
namespace {

using namespace test;
using Eigen::Vector3d;

// The patches as faces of one shell, sewn.
std::filesystem::path sewn(const Folder& folder, const std::string& name, const std::vector<Surface>& patches) {
  BRepBuilderAPI_Sewing sewing(1e-6);
  for (const Surface& patch : patches) sewing.Add(BRepBuilderAPI_MakeFace(cad::fromSpline(patch, 1), 1e-7).Face());
  sewing.Perform();
  auto path = folder / name;
  BRepTools::Write(sewing.SewedShape(), path.c_str());
  return path;
}

// What undo must bring back: all points of all edges' curves and all corners, as numbers.
std::vector<double> skeleton(const Model& model, const Folder& folder) {
  model.write(folder / "skeleton.brep");
  const std::string text = readFile(folder / "skeleton.brep");
  std::vector<double> numbers;
  const char* at = text.c_str();
  while (*at != 0) {
    char* end = nullptr;
    const double number = std::strtod(at, &end);
    if (end != at) {
      numbers.push_back(number);
      at = end;
    } else {
      ++at;
    }
  }
  return numbers;
}

// All points with the same smooth displacement field of space: common borders move alike, to rounding of their gaps.
Surface displaced(const Surface& surface, double by, double size) {
  Surface moved = surface;
  for (Index r = 0; r < moved.net().rows(); ++r) {
    const double w = surface.isRational() ? surface.net()(r, 3) : 1;
    const Vector3d p = surface.net().row(r).head(3).transpose() / w * (2 * M_PI / size);
    const Vector3d step = by * Vector3d(std::sin(p.y() + 1), std::sin(p.z() + 2), std::sin(p.x() + 3));
    moved.net().row(r).head(3) += w * step.transpose();
  }
  return moved;
}

struct Together {
  std::vector<std::pair<Index, AnySpline>> before, after;
};

// Moves all faces and their common borders. Borders that do not fit control point by control point stay, and with them
// the corners of their neighbours.
Together displacedFaces(const Model& model, double by) {
  const double near = 5e-5 * model.size();
  std::vector<Surface> surfaces;
  std::vector<Index> numbers(model.objects().size(), -1);
  Together result;
  for (std::size_t i = 0; i < model.objects().size(); ++i) {
    const Object& object = model.objects()[i];
    if (!object.spline || object.spline->index() != 1) continue;
    numbers[i] = static_cast<Index>(surfaces.size());
    surfaces.push_back(std::get<Surface>(*object.spline));
  }
  const auto number = [&](Index object) { return numbers[static_cast<std::size_t>(object)]; };
  const auto edges = model.sharedEdges();
  std::vector<SidePair> pairs;
  for (const auto& edge : edges) {
    if (!edge.sideA || !edge.sideB || !edge.notJoinable.empty()) continue;
    pairs.push_back({number(edge.faceA), number(edge.faceB), *edge.sideA, *edge.sideB});
  }
  Index points = 0;
  for (const Surface& surface : surfaces) points += surface.net().rows();
  if (points < 20'000) surfaces = makeCompatible(surfaces, pairs);
  std::vector<Vector3d> still;
  std::vector<bool> frozen(surfaces.size(), false);
  const auto hold = [&](Index face, const std::optional<int>& along) {
    const auto& surface = surfaces[static_cast<std::size_t>(number(face))];
    if (!along) frozen[static_cast<std::size_t>(number(face))] = true;
    for (int side = 0; side < 4; ++side) {
      if (along && side != *along) continue;
      for (const Index row : borderRow(surface, side)) still.push_back(surface.net().row(row).head(3).transpose());
    }
  };
  for (const auto& edge : edges) {
    if (edge.sideA && edge.sideB && edge.notJoinable.empty() &&
        fitBorders(surfaces[static_cast<std::size_t>(number(edge.faceA))], *edge.sideA,
                   surfaces[static_cast<std::size_t>(number(edge.faceB))], *edge.sideB, near)
            .compatible) {
      continue;
    }
    hold(edge.faceA, edge.alongA);
    if (number(edge.faceB) >= 0) hold(edge.faceB, edge.alongB);
  }
  for (std::size_t i = 0; i < model.objects().size(); ++i) {
    const Object& object = model.objects()[i];
    if (numbers[i] < 0 || !object.leftAlone.empty() || !object.sharedWith.empty()) continue;
    const Surface& surface = surfaces[static_cast<std::size_t>(numbers[i])];
    if (frozen[static_cast<std::size_t>(numbers[i])]) continue;
    Surface moved = displaced(surface, by, model.size());
    for (int side = 0; side < 4; ++side) {
      for (const Index row : borderRow(surface, side)) {
        const Vector3d point = surface.net().row(row).head(3).transpose();
        const bool held =
            std::any_of(still.begin(), still.end(), [&](const Vector3d& p) { return (p - point).norm() < near; });
        if (held) moved.net().row(row) = surface.net().row(row);
      }
    }
    result.before.emplace_back(static_cast<Index>(i), *object.spline);
    result.after.emplace_back(static_cast<Index>(i), moved);
  }
  return result;
}

void expectNoWorse(const Audit& before, const Audit& after, double slack) {
  EXPECT_EQ(after.valid, before.valid);
  EXPECT_LE(after.invalidFaces, before.invalidFaces);
  ASSERT_EQ(after.edges.size(), before.edges.size());
  for (std::size_t e = 0; e < after.edges.size(); ++e) {
    EXPECT_LE(after.edges[e].gap, before.edges[e].gap + slack) << after.edges[e].name;
    EXPECT_LE(after.edges[e].tolerance, std::max(before.edges[e].tolerance, after.edges[e].gap)) << after.edges[e].name;
  }
}

TEST(SewnShell, KnowsItsEdges) {
  enableCad();
  const Folder folder;
  const auto model = readModel(sewn(folder, "four.brep", fourPatches()));
  ASSERT_EQ(model->objects().size(), 4U);
  const auto edges = model->sharedEdges();
  ASSERT_EQ(edges.size(), 4U);
  const Audit audit = model->audit();
  for (const SharedEdge& edge : edges) {
    EXPECT_TRUE(edge.sewn);
    EXPECT_TRUE(edge.notJoinable.empty()) << edge.notJoinable;
    ASSERT_TRUE(edge.sideA && edge.sideB);
    EXPECT_EQ(edge.lineA.size(), 2U);
    EXPECT_LT(apart(*model, edge), 1e-9);
    EXPECT_TRUE(
        std::any_of(audit.edges.begin(), audit.edges.end(), [&](const auto& e) { return e.name == edge.name; }));
  }
}

TEST(SewnShell, BordersMoveTogetherAndBackToTheBit) {
  enableCad();
  const Folder folder;
  const auto model = readModel(sewn(folder, "four.brep", fourPatches()));
  const Audit before = model->audit();
  ASSERT_TRUE(before.valid);
  const auto asRead = skeleton(*model, folder);
  const Together moves = displacedFaces(*model, 0.3);
  ASSERT_EQ(moves.after.size(), 4U);
  model->replaceTogether(moves.after);
  const Audit after = model->audit();
  expectNoWorse(before, after, 1e-12 * model->size());
  EXPECT_NE(skeleton(*model, folder), asRead);
  for (const SharedEdge& edge : model->sharedEdges()) EXPECT_LT(apart(*model, edge), 1e-9);
  const auto moved = readModel(folder / "four.brep");  // the writers add to the shapes they write
  moved->replaceTogether(displacedFaces(*moved, 0.3).after);
  for (const char* name : {"out.step", "out.igs", "out.brep"}) {
    moved->write(folder / name);
    const auto back = readModel(folder / name);
    EXPECT_EQ(back->objects().size(), 4U) << name;
    EXPECT_TRUE(back->audit().valid) << name;
    EXPECT_LT(back->audit().largestGap, 1e-9 * model->size()) << name;
    EXPECT_EQ(back->sharedEdges().size(), 4U) << name;
  }
  // Another move and back to the first one: the same bits, whatever was there in between.
  const auto first = skeleton(*model, folder);
  model->replaceTogether(displacedFaces(*model, 0.1).after);
  model->replaceTogether(moves.after);
  EXPECT_EQ(skeleton(*model, folder), first);
  model->replaceTogether(moves.before);
  EXPECT_EQ(skeleton(*model, folder), asRead);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(*model->objects()[i].spline, moves.before[i].second);
}

TEST(SewnShell, KnotsMayComeInWhenBordersMove) {
  enableCad();
  const Folder folder;
  const auto model = readModel(sewn(folder, "four.brep", fourPatches()));
  const auto asRead = skeleton(*model, folder);
  const Audit before = model->audit();
  Together moves = displacedFaces(*model, 0);
  for (auto& [index, spline] : moves.after) {
    Surface surface = std::get<Surface>(spline);
    for (int k = 0; k < 2; ++k) {
      const KnotVector& knots = surface.knots(k);
      surface = insertKnots(surface, k, {knots.from() + 0.5 * knots.length() + (k == 0 ? 0.125 : 0.25)});
    }
    spline = displaced(surface, 0.3, model->size());
  }
  // The displaced control points of different knots are no common border: they would tear the edges.
  EXPECT_NE(refusal([&] { model->replaceTogether(moves.after); }).find("torn"), std::string::npos);
  EXPECT_EQ(skeleton(*model, folder), asRead);
  // A linear displacement keeps common borders whatever the knots.
  for (auto& [index, spline] : moves.after) {
    auto& surface = std::get<Surface>(spline);
    const AnySpline old = moves.before[static_cast<std::size_t>(index)].second;
    surface = refine(std::get<Surface>(old), surface.knots());
    for (Index r = 0; r < surface.net().rows(); ++r) surface.net()(r, 2) += 1e-3 * surface.net()(r, 0) + 0.2;
  }
  model->replaceTogether(moves.after);
  expectNoWorse(before, model->audit(), 1e-12 * model->size());
  model->replaceTogether(moves.before);
  EXPECT_EQ(skeleton(*model, folder), asRead);
}

TEST(SewnShell, RefusesToTearEdgesAndCorners) {
  enableCad();
  const Folder folder;
  const auto patches = fourPatches();
  const auto model = readModel(sewn(folder, "four.brep", patches));
  const auto asRead = skeleton(*model, folder);
  const auto edges = model->sharedEdges();
  const auto shared =
      std::find_if(edges.begin(), edges.end(), [](const auto& e) { return e.faceA == 0 && e.faceB == 1; });
  ASSERT_NE(shared, edges.end());
  // The middle of the border of one face only.
  Surface a = std::get<Surface>(*model->objects()[0].spline), b = std::get<Surface>(*model->objects()[1].spline);
  const auto rowA = borderRow(a, *shared->sideA), rowB = borderRow(b, *shared->sideB);
  a.net()(rowA[3], 2) += 0.1;
  const std::string alone = refusal([&] { model->replaceTogether({{0, a}}); });
  EXPECT_NE(alone.find(shared->name), std::string::npos) << alone;
  EXPECT_NE(alone.find("torn"), std::string::npos) << alone;
  EXPECT_EQ(skeleton(*model, folder), asRead);
  EXPECT_EQ(*model->objects()[0].spline, AnySpline(patches[0]));
  // Both: fine.
  const std::size_t partner = shared->reversed ? rowB.size() - 4 : 3;
  b.net()(rowB[partner], 2) += 0.1;
  model->replaceTogether({{0, a}, {1, b}});
  EXPECT_TRUE(model->audit().valid);
  EXPECT_LT(model->audit().largestGap, 1e-9);
  // An interior move of a neighbour afterwards keeps the moved edge.
  const auto moved = skeleton(*model, folder);
  Surface c = std::get<Surface>(*model->objects()[2].spline);
  c.net()(c.row({2, 2}), 2) += 0.1;
  model->replaceTogether({{2, c}});
  EXPECT_TRUE(model->audit().valid);
  model->replaceTogether({{2, patches[2]}});
  EXPECT_EQ(skeleton(*model, folder), moved);
  // The corner where four faces meet, by two of them.
  const auto& endsA = rowA;
  const bool atEnd = std::hypot(a.net()(endsA.back(), 0) - 100, a.net()(endsA.back(), 1) - 80) < 1;
  const std::size_t corner = atEnd ? rowA.size() - 1 : 0;
  a.net()(rowA[corner], 2) += 0.1;
  b.net()(rowB[shared->reversed ? rowB.size() - 1 - corner : corner], 2) += 0.1;
  const std::string torn = refusal([&] { model->replaceTogether({{0, a}, {1, b}}); });
  EXPECT_NE(torn.find("torn"), std::string::npos) << torn;
  EXPECT_EQ(skeleton(*model, folder), moved);
}

TEST(SewnShell, BezierPatchesToo) {
  enableCad();
  const Folder folder;
  const auto model = readModel(
      sewn(folder, "two.brep", {graph(0, 100, 0, 80, 1, 1, hill), transposed(graph(100, 200, 0, 80, 1, 1, hill))}));
  const Audit before = model->audit();
  const Together moves = displacedFaces(*model, 0.2);
  model->replaceTogether(moves.after);
  expectNoWorse(before, model->audit(), 1e-12 * model->size());
}

struct Part {
  const char* name;
  std::size_t edges, wholeSides, changed;
};

class WholeParts : public testing::TestWithParam<Part> {};

TEST_P(WholeParts, AllFacesMoveAndTheirEdgesFollow) {
  const Part& expected = GetParam();
  enableCad();
  const auto path = dataFile(expected.name);
  if (path.empty()) GTEST_SKIP() << "a real file is not here: set STRAK_DATA";
  const Folder folder;
  const auto model = readModel(path);
  const auto edges = model->sharedEdges();
  EXPECT_EQ(edges.size(), expected.edges);
  EXPECT_EQ(std::count_if(edges.begin(), edges.end(), [](const auto& e) { return e.sideA && e.sideB; }),
            static_cast<std::ptrdiff_t>(expected.wholeSides));
  const Audit before = model->audit();
  const double tolerance = std::max(before.largestTolerance, 1e-6 * model->size());
  for (const SharedEdge& edge : edges) {
    if (!edge.sewn || edge.lineB.empty()) continue;
    EXPECT_LT(apart(*model, edge), 4 * tolerance) << edge.name;
  }
  const Together moves = displacedFaces(*model, 1e-4 * model->size());
  EXPECT_EQ(moves.after.size(), expected.changed);
  // Bezier surfaces become B-splines at the first change.
  if (model->format() == "BREP") model->replaceTogether(moves.before);
  const auto asRead = skeleton(*model, folder);
  model->replaceTogether(moves.after);
  expectNoWorse(before, model->audit(), 1e-9 * model->size());
  EXPECT_EQ(model->sharedEdges().size(), expected.edges);
  model->replaceTogether(moves.before);
  EXPECT_EQ(skeleton(*model, folder), asRead);
  model->replaceTogether(moves.after);
  const auto out = folder / (model->format() == "BREP" ? "out.brep" : "out.step");
  model->write(out);
  const auto back = readModel(out);
  EXPECT_EQ(back->objects().size(), model->objects().size());
  const Audit written = back->audit();
  EXPECT_LE(written.invalidFaces, before.invalidFaces);
  EXPECT_LT(written.largestGap, before.largestGap + 1e-9 * model->size());
}

INSTANTIATE_TEST_SUITE_P(Data, WholeParts,
                         testing::Values(Part{"cad/car_hood_capot.step", 29, 13, 14},
                                         Part{"cad/car_hood_capot.brep", 29, 13, 14},
                                         Part{"cad/sunglasses_lens.igs", 15, 15, 9},
                                         Part{"cad/joinsurf_01.stp", 0, 0, 2}, Part{"cad/joinsurf_04.stp", 1, 1, 2},
                                         Part{"cad/D150_fuselage.igs", 476, 468, 236}),
                         [](const auto& file) {
                           std::string name = file.param.name;
                           std::replace_if(
                               name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
                           return name;
                         });

// Three patches that meet one side of a fourth follow it.
TEST(WholePartsWithTJunctions, NeighboursFollowThePartOfTheSide) {
  enableCad();
  const auto path = dataFile("cad/car_hood_capot.step");
  if (path.empty()) GTEST_SKIP() << "a real file is not here: set STRAK_DATA";
  const Folder folder;
  const auto model = readModel(path);
  const Audit before = model->audit();
  const auto asRead = skeleton(*model, folder);
  const Index wide = 1;
  const auto surfaceOf = [&](Index i) {
    return std::get<Surface>(*model->objects()[static_cast<std::size_t>(i)].spline);
  };
  Surface lifted = surfaceOf(wide);
  const auto row = borderRow(lifted, 1);
  for (const std::size_t k : {2U, 3U}) lifted.net()(row[k], 2) += 1e-4 * model->size();
  Together moves{{{wide, surfaceOf(wide)}}, {{wide, lifted}}};
  for (const SharedEdge& edge : model->sharedEdges()) {
    if (edge.faceA != wide || edge.alongA != 1 || !edge.sideB) continue;
    EXPECT_FALSE(edge.sideA);
    const double start = edge.lineA.front()[1], end = edge.lineA.back()[1];
    const Surface old = surfaceOf(edge.faceB);
    const BorderFit fit = fitBorders(surfaceOf(wide), 1, old, *edge.sideB, 1e-5 * model->size(),
                                     SidePart{std::min(start, end), std::max(start, end)});
    ASSERT_TRUE(fit.compatible) << edge.name << ": " << fit.obstacle;
    EXPECT_EQ(fit.reversed, edge.reversed);
    Eigen::VectorXd lift = Eigen::VectorXd::Zero(static_cast<Index>(row.size()));
    lift[2] = lift[3] = 1e-4 * model->size();
    const Eigen::VectorXd follow = fit.fromA * lift;
    Surface next = old;
    const auto rowB = borderRow(next, *edge.sideB);
    for (std::size_t k = 0; k < rowB.size(); ++k) next.net()(rowB[k], 2) += follow[static_cast<Index>(k)];
    moves.before.emplace_back(edge.faceB, old);
    moves.after.emplace_back(edge.faceB, next);
  }
  ASSERT_EQ(moves.after.size(), 4U);
  EXPECT_FALSE(refusal([&] { model->replaceTogether({moves.after.front()}); }).empty());
  model->replaceTogether(moves.after);
  expectNoWorse(before, model->audit(), 1e-9 * model->size());
  EXPECT_NE(skeleton(*model, folder), asRead);
  model->replaceTogether(moves.before);
  EXPECT_EQ(skeleton(*model, folder), asRead);
}

TEST(WholePartsWithGaps, AreJoinedWithinTheLengthAskedFor) {
  enableCad();
  const auto path = dataFile("cad/joinsurf_01.stp");
  if (path.empty()) GTEST_SKIP() << "a real file is not here: set STRAK_DATA";
  const auto model = readModel(path);  // two faces 0.011 apart, size 385
  EXPECT_TRUE(model->sharedEdges().empty());
  const auto edges = model->sharedEdges(0.02);
  ASSERT_EQ(edges.size(), 1U);
  EXPECT_EQ(edges[0].sideA, 1);
  EXPECT_EQ(edges[0].sideB, 1);
  EXPECT_TRUE(edges[0].reversed == edges[0].sameNormals);
}

}  // namespace
}  // namespace strak

#endif
