#include "strak/exchange/model.h"

#include "strak/exchange/file_kind.h"
#include "strak/spline/knot_insertion.h"
#include "tests/exchange/samples.h"

namespace strak {
namespace {

using namespace test;

TEST(Model, PlainFilesKeepTheirSplinesAndNames) {
  const Folder folder;
  std::mt19937 random(21);
  const Surface surface = randomSpline<2>(random);
  const Curve curve = randomSpline<1>(random, 2);
  const auto made = modelOf({surface, curve}, {"wing"}, "m");
  EXPECT_EQ(made->objects()[0].name, "wing");
  EXPECT_EQ(made->objects()[1].name, "curve 2");
  EXPECT_EQ(made->objects()[1].kind, "B-spline curve");
  for (const char* name : {"out.g2", "out.json"}) {
    made->write(folder / name);
    const auto back = readModel(folder / name);
    ASSERT_EQ(back->objects().size(), 2U);
    EXPECT_EQ(*back->objects()[0].spline, AnySpline(surface));
    EXPECT_EQ(*back->objects()[1].spline, AnySpline(curve));
    EXPECT_TRUE(back->audit().edges.empty());
  }
  EXPECT_EQ(readModel(folder / "out.json")->unit(), "m");
  EXPECT_EQ(readModel(folder / "out.json")->objects()[0].name, "wing");
}

TEST(Model, ContentDecidesBeforeTheEnding) {
  const Folder folder;
  std::mt19937 random(22);
  modelOf({randomSpline<2>(random)})->write(folder / "a.g2");
  std::filesystem::rename(folder / "a.g2", folder / "a.step");
  EXPECT_EQ(readModel(folder / "a.step")->format(), "g2");
  EXPECT_EQ(fileKindOfContent("\n  ISO-10303-21;\nHEADER;"), FileKind::step);
  EXPECT_EQ(fileKindOfContent(std::string(72, ' ') + "S      1\n"), FileKind::iges);
  EXPECT_EQ(fileKindOfContent("\nCASCADE Topology V1, (c) Matra-Datavision\n"), FileKind::brep);
  EXPECT_EQ(fileKindOfContent("DBRep_DrawableShape\n"), FileKind::brep);
  EXPECT_EQ(fileKindOfContent("solid cube\n"), std::nullopt);
}

TEST(Model, RefusesWhatItCannotReadOrWrite) {
  const Folder folder;
  std::mt19937 random(23);
  const auto model = modelOf({randomSpline<2>(random)});
  EXPECT_NE(refusal([&] { model->write(folder / "a.xyz"); }).find(".g2"), std::string::npos);
  EXPECT_NE(refusal([&] { readModel(folder.write("empty.g2", "")); }).find("is empty"), std::string::npos);
  EXPECT_NE(refusal([&] { readModel(folder.write("a.xyz", "hello")); }).find("ending"), std::string::npos);
  EXPECT_NE(refusal([&] { readModel(folder / "none.g2"); }).find("cannot open"), std::string::npos);
  EXPECT_NE(refusal([&] { readModel(folder.write("cut.g2", "200 1 0 0\n3 0\n4 4\n")); }).find("cut.g2': line 3"),
            std::string::npos);
  EXPECT_THROW(model->write(folder / "none/a.g2"), Failure);
}

TEST(Model, ReplaceTakesOtherKnotsOnTheSameDomainOnly) {
  std::mt19937 random(24);
  const Surface surface = randomSpline<2>(random);
  const auto model = modelOf({surface, randomSpline<2>(random, 3, true)});
  const double middle = (surface.knots(0).from() + surface.knots(0).to()) / 2;
  Surface finer = insertKnots(surface, 0, {middle});
  finer.net()(3, 1) += 1;
  model->replace(0, finer);
  EXPECT_EQ(*model->objects()[0].spline, AnySpline(finer));
  const Surface bare({KnotVector::uniformClamped(surface.degree(0), 1, surface.knots(0).from(), surface.knots(0).to()),
                      KnotVector::uniformClamped(surface.degree(1), 1, surface.knots(1).from(), surface.knots(1).to())},
                     Net::Random((surface.degree(0) + 1) * (surface.degree(1) + 1), 3));
  model->replace(0, bare);
  EXPECT_EQ(*model->objects()[0].spline, AnySpline(bare));
  model->replace(0, surface);  // the original always fits
  EXPECT_EQ(*model->objects()[0].spline, AnySpline(surface));

  const auto refused = [&](const AnySpline& next) { return refusal([&] { model->replace(0, next); }); };
  EXPECT_NE(refused(randomSpline<2>(random)).find("direction"), std::string::npos);
  EXPECT_NE(refused(randomSpline<1>(random)).find("only be replaced by"), std::string::npos);
  const Surface flat(surface.knots(), surface.net().leftCols(2));
  EXPECT_NE(refused(flat).find("3 coordinates"), std::string::npos);
  EXPECT_NE(refusal([&] { model->replace(1, surface); }).find("same kind"), std::string::npos);
  EXPECT_NE(refusal([&] { model->replace(2, surface); }).find("the file has 2"), std::string::npos);
  EXPECT_NE(refusal([&] { model->replace(-1, surface); }).find("no object 0"), std::string::npos);
}

TEST(Model, SizeIsTheDiagonalOfTheBox) {
  const Curve curve({KnotVector(1, {0, 0, 1, 1})}, (Net(2, 3) << 1, 1, 1, 3, 4, 7).finished());
  EXPECT_DOUBLE_EQ(modelOf({curve})->size(), 7);
  EXPECT_EQ(modelOf({})->size(), 0);
}

}  // namespace
}  // namespace strak
