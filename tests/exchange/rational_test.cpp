// Rational splines in and out of files: points move, weights stay.
#include "strak/spline/rational.h"

#include <algorithm>
#include <cmath>

#include "strak/fairing/plan_face.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/knot_insertion.h"
#include "tests/exchange/samples.h"

#ifdef STRAK_HAS_CAD
#include "strak/exchange/cad.h"
#endif

namespace strak {
namespace {

using namespace test;

class Rational : public testing::Test {
 protected:
#ifdef STRAK_HAS_CAD
  void SetUp() override { enableCad(); }
  const std::vector<std::string> endings_{"step", "igs", "brep", "g2", "json"};
#else
  const std::vector<std::string> endings_{"g2", "json"};
#endif
};

// A graph over a rectangle, weights between 1 and `most`.
Surface wavy(double most = 2, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(0, 1);
  const KnotVector u(3, {0, 0, 0, 0, 1, 2.1, 3, 3, 3, 3}), v(2, {-1, -1, -1, 0.5, 0.5, 2, 3, 3, 3});
  const auto x = u.greville(), y = v.greville();
  Net net(u.size() * v.size(), 4);
  for (Index i = 0; i < u.size(); ++i) {
    for (Index j = 0; j < v.size(); ++j) {
      const double a = x[static_cast<std::size_t>(i)], b = y[static_cast<std::size_t>(j)];
      const double w = std::pow(most, number(random));
      net.row(i * v.size() + j) << w * 10 * a, w * 7 * b, w * (std::sin(a + 0.5 * b) + 0.1 * number(random)), w;
    }
  }
  return Surface({u, v}, std::move(net), true);
}

Curve arcs(unsigned seed = 1) {
  const Surface surface = wavy(2, seed);
  Net net(surface.size(0), 4);
  for (Index i = 0; i < surface.size(0); ++i) net.row(i) = surface.net().row(surface.row({i, 2}));
  return Curve({surface.knots(0)}, net, true);
}

// The same spline with the points of space that are free moved, their weights not.
template <int D>
Spline<D> moved(const FairingPlan<D>& plan, double by, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> move(-by, by);
  Spline<D> result = plan.spline;
  const Index dimension = result.pointDimension();
  for (Index r = 0; r < result.net().rows(); ++r) {
    if (plan.held[static_cast<std::size_t>(r)]) continue;
    const double weight = result.isRational() ? result.net()(r, dimension) : 1.0;
    for (Index c = 0; c < dimension; ++c) result.net()(r, c) += weight * move(random);
  }
  return result;
}

template <int D>
FairingPlan<D> planWith(const Spline<D>& spline) {
  FairingPlanOptions<D> options;
  options.rational = true;
  return planFairing(spline, options);
}

template <int D>
void expectSame(const AnySpline& any, const Spline<D>& wanted, double relative, const std::string& where) {
  const auto& is = std::get<Spline<D>>(any);
  ASSERT_TRUE(is.isRational()) << where;
  EXPECT_EQ(is.knots(), wanted.knots()) << where;
  ASSERT_EQ(is.net().rows(), wanted.net().rows()) << where;
  const Eigen::VectorXd had = weights(wanted);
  EXPECT_LE((weights(is) - had).cwiseQuotient(had).cwiseAbs().maxCoeff(), relative) << where;
  EXPECT_LE((is.euclideanNet() - wanted.euclideanNet()).cwiseAbs().maxCoeff(),
            4 * relative * wanted.euclideanNet().cwiseAbs().maxCoeff())
      << where;
}

TEST_F(Rational, PointsMoveAndWeightsStayInEveryFormat) {
  const Folder folder;
  for (const auto& ending : endings_) {
    const auto in = folder / ("in." + ending), out = folder / ("out." + ending);
    modelOf({wavy()}, {}, "mm")->write(in);
    const auto model = readModel(in);
    ASSERT_EQ(model->objects().size(), 1U);
    EXPECT_EQ(model->objects()[0].kind, "rational B-spline surface") << ending;
    EXPECT_EQ(model->objects()[0].leftAlone, "") << ending;
    const auto original = std::get<Surface>(*model->objects()[0].spline);
    expectSame(original, wavy(), 2e-15, ending);
    const FacePlan plan = planWith<2>(original);
    ASSERT_EQ(plan.leftAlone, "");
    EXPECT_GT(plan.knotsInserted, 0);
    const Surface next = moved<2>(plan, 0.05, 5);
    EXPECT_EQ(weights(next), weights(plan.spline));
    model->replace(0, next);
    EXPECT_TRUE(model->audit().valid);
    model->write(out);
    expectSame(*readModel(out)->objects()[0].spline, next, 4e-15, ending);
  }
}

TEST_F(Rational, CurvesToo) {
  const Folder folder;
  for (const auto& ending : endings_) {
    const auto in = folder / ("in." + ending), out = folder / ("out." + ending);
    modelOf({arcs()}, {}, "mm")->write(in);
    const auto model = readModel(in);
    ASSERT_EQ(model->objects().size(), 1U);
    EXPECT_EQ(model->objects()[0].leftAlone, "") << ending;
    const auto original = std::get<Curve>(*model->objects()[0].spline);
    const FairingPlan<1> plan = planWith<1>(original);
    ASSERT_EQ(plan.leftAlone, "");
    const Curve next = moved<1>(plan, 0.05, 6);
    model->replace(0, next);
    model->write(out);
    expectSame(*readModel(out)->objects()[0].spline, next, 4e-15, ending);
  }
}

TEST_F(Rational, WhatWasReadIsPutBackToTheBit) {
  const Folder folder;
  for (const auto& ending : endings_) {
    for (const AnySpline& spline : {AnySpline(wavy(50, 3)), AnySpline(arcs(3))}) {
      const auto in = folder / ("in." + ending);
      modelOf({spline}, {}, "inch")->write(in);
      const auto model = readModel(in);
      const AnySpline original = *model->objects()[0].spline;
      model->write(folder / ("untouched." + ending));
      std::visit([&]<int D>(const Spline<D>& s) { model->replace(0, moved<D>(planWith<D>(s), 0.2, 7)); }, original);
      EXPECT_NE(*model->objects()[0].spline, original);
      model->replace(0, original);
      model->write(folder / ("back." + ending));
      EXPECT_EQ(*readModel(folder / ("back." + ending))->objects()[0].spline,
                *readModel(folder / ("untouched." + ending))->objects()[0].spline)
          << ending;
    }
  }
}

TEST_F(Rational, TheUnitScalesPointsAndNotWeights) {
  const Folder folder;
  for (const auto& ending : endings_) {
    if (ending == "brep" || ending == "g2") continue;  // these know no unit
    for (const char* unit : {"m", "inch"}) {
      const auto in = folder / ("in." + ending);
      modelOf({wavy()}, {}, unit)->write(in);
      const auto model = readModel(in);
      EXPECT_EQ(model->unit(), unit);
      expectSame(*model->objects()[0].spline, wavy(), 4e-15, ending);
    }
  }
}

TEST_F(Rational, ManyDecadesOfWeightsAreKept) {
  const Folder folder;
  const Surface steep = wavy(1e9, 9);
  for (const auto& ending : endings_) {
    const auto in = folder / ("in." + ending);
    modelOf({steep}, {}, "mm")->write(in);
    const auto model = readModel(in);
    const FacePlan plan = planWith<2>(std::get<Surface>(*model->objects()[0].spline));
    const Surface next = moved<2>(plan, 0.01, 8);
    model->replace(0, next);
    model->write(folder / ("out." + ending));
    expectSame(*readModel(folder / ("out." + ending))->objects()[0].spline, next, 4e-15, ending);
  }
}

TEST_F(Rational, TheOtherKindIsRefused) {
  const auto model = modelOf({wavy()});
  const Surface plain(wavy().knots(), wavy().euclideanNet());
  EXPECT_NE(refusal([&] { model->replace(0, plain); }).find("points of the same kind"), std::string::npos);
}

#ifdef STRAK_HAS_CAD

struct RealFile {
  const char* name;
  Index rational;  // surfaces
  Index changed;   // of them
};

class RationalFiles : public testing::TestWithParam<RealFile> {};

TEST_P(RationalFiles, SmallMovesOfFreePointsHarmNothing) {
  const RealFile& expected = GetParam();
  enableCad();
  const auto path = dataFile(expected.name);
  if (path.empty()) GTEST_SKIP() << "a real file is not here: set STRAK_DATA";
  const auto model = readModel(path);
  const Audit before = model->audit();
  Index rational = 0, changed = 0;
  std::vector<AnySpline> original;
  std::vector<std::size_t> which;
  for (std::size_t i = 0; i < model->objects().size(); ++i) {
    const Object object = model->objects()[i];
    if (!object.spline || !std::holds_alternative<Surface>(*object.spline)) continue;
    const auto& surface = std::get<Surface>(*object.spline);
    if (!surface.isRational()) continue;
    ++rational;
    if (!object.leftAlone.empty() || !object.sharedWith.empty()) continue;
    PlanOptions options;
    options.rational = true;
    const FacePlan plan = planFace(surface, {object.trims, object.naturalSide}, options);
    if (!plan.leftAlone.empty()) continue;
    original.push_back(surface);
    which.push_back(i);
    model->replace(static_cast<Index>(i), moved<2>(plan, 1e-4 * model->size(), 40));
    ++changed;
  }
  EXPECT_EQ(rational, expected.rational);
  EXPECT_EQ(changed, expected.changed);
  expectNothingWorse(before, model->audit(), model->size());

  const Folder folder;
  const auto out = folder / "out.step";
  model->write(out);
  const auto back = readModel(out);
  ASSERT_EQ(back->objects().size(), model->objects().size());
  for (std::size_t i : which) {
    const auto& was = std::get<Surface>(*model->objects()[i].spline);
    const auto& is = std::get<Surface>(*back->objects()[i].spline);
    ASSERT_EQ(is.knots(), was.knots()) << model->objects()[i].name;
    const Eigen::VectorXd had = weights(was);
    EXPECT_LE((weights(is) - had).cwiseQuotient(had).cwiseAbs().maxCoeff(), 4e-15) << model->objects()[i].name;
    EXPECT_LT((is.euclideanNet() - was.euclideanNet()).cwiseAbs().maxCoeff(), 1e-13 * model->size());
  }
  const Audit written = back->audit();
  EXPECT_LE(written.invalidFaces, before.invalidFaces);
  EXPECT_LT(written.largestGap - before.largestGap, 1e-9 * model->size());

  for (std::size_t k = 0; k < which.size(); ++k) model->replace(static_cast<Index>(which[k]), original[k]);
  EXPECT_EQ(model->audit().largestGap, before.largestGap);
}

INSTANTIATE_TEST_SUITE_P(Data, RationalFiles,
                         testing::Values(RealFile{"cad/impeller.igs", 212, 175},
                                         RealFile{"cad/NIST_MBE_PMI_2.stp", 434, 27},
                                         RealFile{"cad/airliner_A319.step", 39, 39},
                                         RealFile{"cad/linkrods.step", 16, 9}),
                         [](const auto& file) {
                           std::string name = file.param.name;
                           std::replace_if(
                               name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
                           return name;
                         });

#endif

}  // namespace
}  // namespace strak
