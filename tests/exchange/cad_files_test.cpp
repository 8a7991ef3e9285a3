// Real files: everything that may be changed is changed a little, and the rest must not notice.
#ifdef STRAK_HAS_CAD

#include <algorithm>
#include <cctype>
#include <map>
#include <utility>
#include <vector>

#include "strak/exchange/cad.h"
#include "strak/fairing/plan_face.h"
#include "tests/exchange/samples.h"

namespace strak {
namespace {

using namespace test;

#define STRAK_SKIP_WITHOUT(path) \
  if ((path).empty()) GTEST_SKIP() << "a real file is not here: set STRAK_DATA"

template <int D>
Spline<D> shaken(const FairingPlan<D>& plan, double by, std::mt19937& random) {
  std::uniform_real_distribution<double> move(-by, by);
  Spline<D> moved = plan.spline;
  for (Index r = 0; r < moved.net().rows(); ++r) {
    if (plan.held[static_cast<std::size_t>(r)]) continue;
    for (Index c = 0; c < moved.net().cols(); ++c) moved.net()(r, c) += move(random);
  }
  return moved;
}

// Moves every free point of the model by up to 1e-4 of its size; the number of objects changed.
Index shake(Model& model) {
  std::mt19937 random(40);
  Index changed = 0;
  for (std::size_t i = 0; i < model.objects().size(); ++i) {
    const Object object = model.objects()[i];
    if (!object.leftAlone.empty()) continue;
    if (!object.sharedWith.empty() && object.sharedWith.front() < static_cast<Index>(i)) continue;
    const double by = 1e-4 * model.size();
    if (const auto* surface = std::get_if<Surface>(&*object.spline)) {
      const FacePlan plan = planFace(*surface, {object.trims, object.naturalSide});
      if (!plan.leftAlone.empty()) continue;
      model.replace(static_cast<Index>(i), shaken(plan, by, random));
    } else {
      const FairingPlan<1> plan = planFairing<1>(std::get<Curve>(*object.spline));
      if (!plan.leftAlone.empty()) continue;
      model.replace(static_cast<Index>(i), shaken(plan, by, random));
    }
    ++changed;
  }
  return changed;
}

struct RealFile {
  const char* name;
  const char* unit;
  std::size_t objects;
  Index changed;
};

class CadFiles : public testing::TestWithParam<RealFile> {};

TEST_P(CadFiles, SmallMovesOfFreePointsHarmNothing) {
  const RealFile& expected = GetParam();
  enableCad();
  const auto path = dataFile(expected.name);
  STRAK_SKIP_WITHOUT(path);
  const auto model = readModel(path);
  EXPECT_EQ(model->unit(), expected.unit);
  EXPECT_EQ(model->objects().size(), expected.objects);
  const Audit before = model->audit();
  EXPECT_EQ(shake(*model), expected.changed);
  expectNothingWorse(before, model->audit(), model->size());

  const Folder folder;
  // IGES turns reversed faces round, so that its control points come in another order: STEP instead.
  const auto out = folder / (model->format() == "BREP" ? "out.brep" : "out.step");
  model->write(out);
  const auto back = readModel(out);
  EXPECT_EQ(back->unit(), expected.unit);
  ASSERT_EQ(back->objects().size(), model->objects().size());
  for (std::size_t i = 0; i < back->objects().size(); ++i) {
    const Object& was = model->objects()[i];
    const Object& is = back->objects()[i];
    EXPECT_EQ(is.name, was.name);
    ASSERT_EQ(is.spline.has_value(), was.spline.has_value()) << was.name;
    if (!was.spline) continue;
    std::visit(
        [&]<int D>(const Spline<D>& spline) {
          const auto& again = std::get<Spline<D>>(*is.spline);
          EXPECT_EQ(again.knots(), spline.knots()) << was.name;
          EXPECT_LT((again.net() - spline.net()).cwiseAbs().maxCoeff(), 1e-14 * model->size()) << was.name;
        },
        *was.spline);
  }
  const Audit written = back->audit();
  EXPECT_LE(written.invalidFaces, before.invalidFaces);
  EXPECT_LT(written.largestGap - before.largestGap, 1e-9 * model->size());
}

INSTANTIATE_TEST_SUITE_P(
    Data, CadFiles,
    testing::Values(RealFile{"cad/car_hood_capot.step", "mm", 18, 18}, RealFile{"cad/car_hood_capot.brep", "", 18, 18},
                    RealFile{"cad/joinsurf_01.stp", "mm", 2, 2}, RealFile{"cad/IEA_15MW_blade.stp", "mm", 27, 3},
                    RealFile{"cad/IEA_15MW_blade.igs", "m", 27, 3}, RealFile{"hull/hull_160m.igs", "m", 1, 1},
                    RealFile{"hull/hull_160m_sections.igs", "m", 31, 31}, RealFile{"hull/series60.step", "mm", 3, 2},
                    RealFile{"cad/sunglasses_lens.igs", "inch", 9, 9}, RealFile{"gotools/surface.igs", "mm", 1, 1},
                    RealFile{"cad/propeller_blade_upper.iges", "mm", 1, 1}, RealFile{"cad/linkrods.step", "mm", 37, 0},
                    RealFile{"cad/fuselage_profiles.brep", "", 10, 10}, RealFile{"cad/shell1_bicubic.brep", "", 99, 99},
                    RealFile{"cad/as1-oc-214.stp", "mm", 160, 0}, RealFile{"cad/D150_wing.igs", "mm", 8, 6}),
    [](const auto& file) {
      std::string name = file.param.name;
      std::replace_if(
          name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
      return name;
    });

TEST(CadUnits, TheTwoFilesOfOneBladeDifferByTheirUnitsOnly) {
  enableCad();
  const auto step = dataFile("cad/IEA_15MW_blade.stp");
  STRAK_SKIP_WITHOUT(step);
  enableCad();
  const auto iges = dataFile("cad/IEA_15MW_blade.igs");
  STRAK_SKIP_WITHOUT(iges);
  const auto a = readModel(step), b = readModel(iges);
  // 117 of its unit long in both; the one says millimetre, the other metre.
  EXPECT_NEAR(a->size(), b->size(), 1e-6 * a->size());
  EXPECT_NEAR(a->size(), std::hypot(6.83589, 6.59485, 117), 0.3);
  EXPECT_EQ(a->unit(), "mm");
  EXPECT_EQ(b->unit(), "m");
}

TEST(CadAssembly, InstancesKnowOneAnother) {
  enableCad();
  const auto path = dataFile("cad/as1-oc-214.stp");
  STRAK_SKIP_WITHOUT(path);
  const auto model = readModel(path);
  Index shared = 0;
  for (std::size_t i = 0; i < model->objects().size(); ++i) {
    for (Index other : model->objects()[i].sharedWith) {
      const auto& back = model->objects()[static_cast<std::size_t>(other)].sharedWith;
      EXPECT_NE(std::find(back.begin(), back.end(), static_cast<Index>(i)), back.end());
      ++shared;
    }
  }
  EXPECT_GT(shared, 0);
}

// The text of a STEP file without line breaks and blanks.
std::string dense(const std::filesystem::path& path) {
  std::string text = readFile(path);
  text.erase(std::remove_if(text.begin(), text.end(), [](unsigned char c) { return std::isspace(c); }), text.end());
  return text;
}

// How often `entity` stands in the text with each of its quoted words number `word` (0: none counts).
std::map<std::string, int> counts(const std::string& text, const std::string& entity, int word) {
  std::map<std::string, int> result;
  for (std::size_t at = text.find(entity); at != text.npos; at = text.find(entity, at + 1)) {
    std::size_t quote = at, end = at;
    for (int k = 0; k < word; ++k) {
      quote = text.find('\'', end) + 1;
      end = text.find('\'', quote) + 1;
    }
    ++result[word == 0 ? "" : text.substr(quote, end - 1 - quote)];
  }
  return result;
}

TEST(CadAssembly, NamesColoursAndLayersSurvive) {
  enableCad();
  const auto path = dataFile("cad/as1-oc-214.stp");
  STRAK_SKIP_WITHOUT(path);
  const Folder folder;
  readModel(path)->write(folder / "out.step");
  const std::string before = dense(path), after = dense(folder / "out.step");
  const std::vector<std::pair<std::string, int>> kinds{
      {"=PRODUCT(", 1},    {"=NEXT_ASSEMBLY_USAGE_OCCURRENCE(", 2}, {"STYLED_ITEM(", 0},
      {"=COLOUR_RGB(", 0}, {"=PRESENTATION_LAYER_ASSIGNMENT(", 1},  {"=MANIFOLD_SOLID_BREP(", 0}};
  for (const auto& [entity, word] : kinds) {
    EXPECT_EQ(counts(before, entity, word), counts(after, entity, word)) << entity;
    EXPECT_FALSE(counts(after, entity, word).empty()) << entity;
  }
  EXPECT_EQ(counts(after, "=PRODUCT(", 1).size(), 9U);
  EXPECT_NE(after.find("('CADProcessor'),('OPENCASCADES.A.S')"), after.npos);  // author and organization
  EXPECT_EQ(counts(after, "=NEXT_ASSEMBLY_USAGE_OCCURRENCE(", 2).size(), 13U);
}

}  // namespace
}  // namespace strak

#endif
