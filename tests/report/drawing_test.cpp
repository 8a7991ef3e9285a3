#include "strak/report/drawing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "strak/base/error.h"
#include "strak/exchange/model.h"
#include "strak/spline/evaluate.h"
#include "tests/report/shapes.h"

namespace strak {
namespace {

using namespace test;

constexpr RenderKind kKinds[] = {RenderKind::isophotes, RenderKind::zebra,    RenderKind::isolines,
                                 RenderKind::combs,     RenderKind::gaussian, RenderKind::mean};

TEST(Drawing, EveryKindOfEverySplineIsWellFormedFiniteAndTheSameTwice) {
  const std::vector<Object> objects{object(planeCurve(), "a & b"), object(wavySheet(), "<sheet>"), object(block()),
                                    object(sphere({3, 0, 0}))};
  for (RenderKind kind : kKinds) {
    for (std::size_t n = 0; n <= objects.size(); ++n) {
      const std::vector<Object> shown = n < objects.size() ? std::vector<Object>{objects[n]} : objects;
      RenderOptions options;
      options.kind = kind;
      options.width = 300;
      options.height = 240;
      const std::string svg = renderSvg(shown, options);
      EXPECT_EQ(xmlFault(svg), "") << renderKindName(kind) << " of object " << n;
      EXPECT_EQ(svg.find("nan"), std::string::npos);
      EXPECT_EQ(svg.find("inf"), std::string::npos);
      EXPECT_EQ(svg, renderSvg(shown, options));
    }
  }
}

TEST(Drawing, NamesOfKindsReadBackAndOthersAreRefused) {
  for (RenderKind kind : kKinds) EXPECT_EQ(renderKind(renderKindName(kind)), kind);
  EXPECT_THROW(renderKind("isophote"), InvalidInput);
}

TEST(Drawing, BadOptionsAreRefusedWithASentence) {
  const std::vector<Object> objects{object(wavySheet())};
  const auto refused = [&](auto change) {
    RenderOptions options;
    change(options);
    EXPECT_THROW(renderSvg(objects, options), InvalidInput);
  };
  refused([](RenderOptions& o) { o.width = 10; });
  refused([](RenderOptions& o) { o.height = 1'000'000; });
  refused([](RenderOptions& o) { o.lines = -1; });
  refused([](RenderOptions& o) { o.view = Eigen::Vector3d::Zero(); });
  refused([](RenderOptions& o) { o.view = Eigen::Vector3d(0, 0, std::nan("")); });
  refused([](RenderOptions& o) { o.light = Eigen::Vector3d::Zero(); });
  refused([](RenderOptions& o) { o.up = Eigen::Vector3d::Zero(); });
  refused([](RenderOptions& o) { o.range = {2.0, 1.0}; });
  refused([](RenderOptions& o) { o.kind = RenderKind::deviation; });
  EXPECT_THROW(renderSvg({Object{}}), InvalidInput);
  EXPECT_THROW(renderSvg({}), InvalidInput);
}

TEST(Drawing, TheBackHalfOfASphereIsHidden) {
  RenderOptions options;
  options.kind = RenderKind::isolines;
  options.view = Eigen::Vector3d(1, -0.3, 0.5);
  options.lines = 8;
  const std::vector<Object> objects{object(sphere())};
  const double visible = pathSize(renderSvg(objects, options), "isolines").length;
  options.hideLines = false;
  const double all = pathSize(renderSvg(objects, options), "isolines").length;
  // The pictures of a sphere's front and back are mirror images. Lines reach up to a pixel past the silhouette, which
  // on a sphere of 300 pixels are five degrees.
  EXPECT_GT(visible / all, 0.499);
  EXPECT_LT(visible / all, 0.53);
}

TEST(Drawing, TheSilhouetteOfASphereIsACircle) {
  RenderOptions options;
  options.kind = RenderKind::gaussian;
  options.view = Eigen::Vector3d(0.3, -0.5, 0.2);
  options.width = options.height = 500;
  options.caption = false;
  const PathSize silhouette = pathSize(renderSvg({object(sphere())}, options), "silhouettes");
  const double radius = (500 - 2 * 18) / 2.0;
  EXPECT_NEAR(silhouette.length, 2 * M_PI * radius, 0.01 * 2 * M_PI * radius);
}

TEST(Drawing, ASheetHidesWhatIsBehindIt) {
  const Surface front = sheet([](double, double) { return 1.0; }), back = sheet([](double, double) { return 0.0; });
  RenderOptions options;
  options.kind = RenderKind::isolines;
  options.view = Eigen::Vector3d(0, 0, 1);
  options.lines = 5;
  const double one = pathSize(renderSvg({object(front)}, options), "isolines").length;
  const double both = pathSize(renderSvg({object(front), object(back)}, options), "isolines").length;
  EXPECT_NEAR(both, one, 0.01 * one);
  options.hideLines = false;
  EXPECT_NEAR(pathSize(renderSvg({object(front), object(back)}, options), "isolines").length, 2 * one, 0.01 * one);
}

TEST(Drawing, LinesAndBordersStopAtTheTrims) {
  Object hole = object(sheet([](double, double) { return 0.0; }));
  hole.trims = {circle(0.3, 200)};
  RenderOptions options;
  options.kind = RenderKind::isolines;
  options.view = Eigen::Vector3d(0, 0, 1);
  options.lines = 40;
  options.frame = Eigen::AlignedBox3d(Eigen::Vector3d::Zero(), Eigen::Vector3d(1, 1, 0));
  const std::string svg = renderSvg({hole}, options);
  const double pixels = 700 - 34 - 2 * 18;  // of the unit square
  // Chords of a disc: the area over the distance of the lines, for both directions.
  EXPECT_NEAR(pathSize(svg, "isolines").length, 2 * 40 * M_PI * 0.09 * pixels, 0.02 * 80 * M_PI * 0.09 * pixels);
  EXPECT_NEAR(pathSize(svg, "borders").length, 2 * M_PI * 0.3 * pixels, 0.01 * 2 * M_PI * 0.3 * pixels);
}

TEST(Drawing, TheSameFrameLaysPicturesOnTopOfEachOther) {
  const std::vector<Object> before{object(wavySheet(0.05))}, after{object(wavySheet(0.0))};
  RenderOptions options;
  options.kind = RenderKind::isolines;
  options.view = Eigen::Vector3d(0, 0, 1);
  options.frame = frameOf(before);
  const std::string a = renderSvg(before, options), b = renderSvg(after, options);
  const auto borders = [](const std::string& svg) { return pathSize(svg, "borders").length; };
  EXPECT_NEAR(borders(a), borders(b), 0.01);
}

TEST(Drawing, DeviationIsMeasuredAgainstTheReference) {
  const Surface before = sheet([](double, double) { return 0.0; });
  const Surface after = sheet([](double x, double) { return 0.02 * x; });
  RenderOptions options;
  options.kind = RenderKind::deviation;
  options.reference = {object(before)};
  options.view = Eigen::Vector3d(0, 0, 1);
  const auto [low, high] = rangeOf({object(after)}, options);
  EXPECT_NEAR(low, 0.0, 4e-4);
  EXPECT_NEAR(high, 0.02, 4e-4);
  options.reference = {object(planeCurve())};
  EXPECT_THROW(renderSvg({object(after)}, options), InvalidInput);
}

TEST(Drawing, AnUnfairSurfaceHasLongerIsophotes) {
  RenderOptions options;
  options.view = Eigen::Vector3d(0, 0, 1);
  options.light = Eigen::Vector3d(0.4, 0.2, 1);
  options.range = {0.5, 1.0};
  const double wavy = pathSize(renderSvg({object(wavySheet(0.04))}, options), "isophotes").length;
  const double calm = pathSize(renderSvg({object(wavySheet(0.0))}, options), "isophotes").length;
  EXPECT_GT(wavy, 1.5 * calm);
}

// However narrow the range of brightness that is shown.
TEST(Drawing, IsophotesAreSeenFromTheInnerSideToo) {
  RenderOptions options;
  options.light = Eigen::Vector3d(0.4, 0.2, 1);
  options.range = {0.85, 0.95};
  options.view = Eigen::Vector3d(0, 0, 1);
  const Surface outer = wavySheet(0.02);
  Net net(outer.net().rows(), 3);  // u and v exchanged: the normals turn round
  for (Index i = 0; i < outer.size(0); ++i) {
    for (Index j = 0; j < outer.size(1); ++j) net.row(j * outer.size(0) + i) = outer.net().row(i * outer.size(1) + j);
  }
  const Surface inner({outer.knots(1), outer.knots(0)}, net);
  const double seen = pathSize(renderSvg({object(outer)}, options), "isophotes").length;
  EXPECT_GT(seen, 100);
  EXPECT_NEAR(pathSize(renderSvg({object(inner)}, options), "isophotes").length, seen, 0.02 * seen);
}

TEST(Drawing, TheNoiseOfTheFirstExampleIsSeen) {
  const char* folder = std::getenv("STRAK_DATA");
  const std::filesystem::path data =
      std::filesystem::path(folder ? folder : STRAK_SOURCE_DIR "/../shared/data") / "hadenfeld1";
  if (!std::filesystem::exists(data / "perturbed.g2")) GTEST_SKIP() << "no " << data;
  const auto rough = readModel(data / "perturbed.g2"), clean = readModel(data / "unperturbed.g2");
  RenderOptions options;
  options.width = 500;
  options.height = 400;
  options.range = rangeOf(rough->objects(), options);
  options.view = Eigen::Vector3d(1, -0.3, 0.3);
  const PathSize a = pathSize(renderSvg(rough->objects(), options), "isophotes");
  const PathSize b = pathSize(renderSvg(clean->objects(), options), "isophotes");
  EXPECT_GT(a.length, 3 * b.length);
  EXPECT_LT(b.pieces, 60);
}

TEST(Drawing, ThePageHoldsTheViewerTheDrawingAndNothingFromElsewhere) {
  RenderOptions options;
  options.width = 300;
  options.height = 200;
  const std::string html = renderHtml({object(wavySheet(), "</script><b>")}, "<i>title</i>", options);
  EXPECT_NE(html.find("<canvas"), std::string::npos);
  EXPECT_NE(html.find("class=\"isophotes\""), std::string::npos);
  EXPECT_EQ(html.find("<i>"), std::string::npos);
  EXPECT_EQ(html.find("<b>"), std::string::npos);
  EXPECT_EQ(html.find("src="), std::string::npos);
  EXPECT_EQ(html.find("href="), std::string::npos);
  EXPECT_EQ(html, renderHtml({object(wavySheet(), "</script><b>")}, "<i>title</i>", options));
}

TEST(Drawing, MeasuredPointsHaveTheColoursOfTheirValues) {
  const std::vector<Object> objects{object(wavySheet())};
  const auto* sheet = std::get_if<Surface>(&*objects[0].spline);
  RenderOptions options;
  options.kind = RenderKind::points;
  options.points.resize(3, 3);
  for (Index k = 0; k < 3; ++k) {
    const double t = 0.3 + 0.2 * static_cast<double>(k);
    const auto at = [&](int d) { return sheet->knots(d).from() + t * sheet->knots(d).length(); };
    options.points.row(k) = evaluate<2>(*sheet, {at(0), at(1)});
  }
  options.values = Eigen::Vector3d(-1, std::nan(""), 1);
  options.view = Eigen::Vector3d::UnitZ();
  options.lines = 2;
  const std::string svg = renderSvg(objects, options);
  EXPECT_EQ(xmlFault(svg), "");
  const std::size_t group = svg.find("class=\"points\"");
  ASSERT_NE(group, std::string::npos);
  const std::string drawn = svg.substr(group, svg.find("</g>", group) - group);
  // One square in each colour; the point without a value is left out.
  EXPECT_EQ(std::count(drawn.begin(), drawn.end(), 'z'), 2);
  EXPECT_EQ(std::count(drawn.begin(), drawn.end(), 'M'), 2);
  EXPECT_EQ(rangeOf(objects, options), (std::pair{-1.0, 1.0}));
  // Points of one value at steps a little wider than the squares: no pattern, but rows of one run.
  constexpr Index kAcross = 50;
  RenderOptions even = options;
  even.points.resize(kAcross * kAcross, 3);
  even.values = Eigen::VectorXd::Constant(kAcross * kAcross, 0.5);
  for (Index i = 0; i < kAcross; ++i) {
    for (Index j = 0; j < kAcross; ++j) {
      even.points.row(kAcross * i + j) = evaluate<2>(
          *sheet, {0.1 + 0.8 * static_cast<double>(i) / kAcross, 0.1 + 0.8 * static_cast<double>(j) / kAcross});
    }
  }
  even.width = even.height = 600;
  const std::string whole = renderSvg(objects, even);
  const std::size_t from = whole.find("class=\"points\"");
  ASSERT_NE(from, std::string::npos);
  const std::string squares = whole.substr(from, whole.find("</g>", from) - from);
  EXPECT_GE(std::count(squares.begin(), squares.end(), 'M'), 1);
  EXPECT_LT(std::count(squares.begin(), squares.end(), 'M'), 3 * kAcross);
  EXPECT_THROW(renderHtml(objects, "t", options), InvalidInput);
  options.values.conservativeResize(2);
  EXPECT_THROW(renderSvg(objects, options), InvalidInput);
}

}  // namespace
}  // namespace strak
