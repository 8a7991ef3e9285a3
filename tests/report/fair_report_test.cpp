#include "strak/report/fair_report.h"

#include <gtest/gtest.h>

#include <rapidcheck.h>
#include <rapidcheck/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/report/shapes.h"

namespace strak {
namespace {

using namespace test;
using nlohmann::json;

FairedObject faired(const AnySpline& before, const AnySpline& after, const std::string& name) {
  Object o = object(before, name);
  FairedObject out = describe(o);
  out.after = after;
  out.energyName = "thin-plate";
  out.summary.energyBefore = 3.5;
  out.summary.energyAfter = 0.1 + 0.2;
  out.summary.gap = 1.0 / 3;
  out.summary.steps = 41;
  out.summary.stopReason = StopReason::gap;
  out.summary.seconds = 0.015;
  out.plate = {7.0, 5.0};
  out.fairnessBefore = SurfaceFairness{1, 7, 3, 4, 1e-5};
  out.fairnessAfter = SurfaceFairness{1, 5, 1, 2, 1e-5};
  out.deviationLower = 0.0119;
  out.deviationUpper = 0.0120001;
  out.controlPointMove = 0.02;
  out.notes = {"2 knots inserted"};
  return out;
}

FairReport report() {
  FairReport r;
  r.version = "1.2.3";
  r.command = "strak fair 'a <b>.step' -o b.step";
  r.inputName = "a <b>.step";
  r.outputName = "b.step";
  r.unit = "mm";
  r.size = 100;
  r.tolerance = 0.02;
  r.toleranceKind = "points";
  r.before.edges = {{"edge 1", 1e-4, 1e-3, 2e-4}, {"edge 2", 3e-4, 1e-3, 2e-4}};
  r.after.edges = {{"edge 1", 1e-4, 1e-3, 2e-4}, {"edge 2", 2e-4, 1e-3, 2e-4}};
  r.before.largestGap = 3e-4;
  r.after.largestGap = 2e-4;
  r.seconds = 1.5;
  r.objects.push_back(faired(wavySheet(), wavySheet(0), "<script>alert(1)</script>"));
  Object plane;
  plane.name = "face 2";
  plane.kind = "plane";
  plane.leftAlone = "a plane is not a B-spline";
  r.objects.push_back(describe(plane));
  return r;
}

TEST(FairReportJson, HasTheKeysOfThePrograms) {
  const json j = json::parse(fairReportJson(report()));
  for (const char* key : {"version", "command", "inputs", "output", "objects", "audit", "seconds"})
    EXPECT_TRUE(j.contains(key)) << key;
  const json& o = j["objects"][0];
  for (const char* key : {"name", "degree", "points", "energy", "plate", "deviation", "held_max_move", "steps", "gap",
                          "stop_reason", "seconds", "left_alone", "notes"})
    EXPECT_TRUE(o.contains(key)) << key;
  EXPECT_EQ(o["name"], "<script>alert(1)</script>");
  EXPECT_EQ(o["degree"], json({3, 3}));
  EXPECT_EQ(o["points"], json({9, 9}));
  EXPECT_EQ(o["energy"]["name"], "thin-plate");
  EXPECT_EQ(o["energy"]["before"].get<double>(), 3.5);
  EXPECT_EQ(o["energy"]["after"].get<double>(), 0.1 + 0.2);
  EXPECT_EQ(o["plate"]["after"].get<double>(), 5);
  EXPECT_EQ(o["deviation"]["control_points"].get<double>(), 0.02);
  EXPECT_EQ(o["deviation"]["lower"].get<double>(), 0.0119);
  EXPECT_EQ(o["deviation"]["certified"].get<double>(), 0.0120001);
  EXPECT_EQ(o["gap"].get<double>(), 1.0 / 3);
  EXPECT_EQ(o["steps"], 41);
  EXPECT_EQ(o["stop_reason"], "gap");
  EXPECT_TRUE(o["left_alone"].is_null());
  EXPECT_EQ(j["objects"][1]["left_alone"], "a plane is not a B-spline");
  EXPECT_FALSE(j["objects"][1].contains("energy"));
  EXPECT_EQ(j["audit"]["before"]["largest_gap"].get<double>(), 3e-4);
  EXPECT_EQ(j["audit"]["after"]["valid"], true);
}

TEST(FairReportJson, InfinitiesAreNullAndBytesThatAreNoTextAreReplaced) {
  FairReport r = report();
  r.tolerance = kUnlimited;
  r.objects[0].summary.gap = std::nan("");
  r.objects[0].name = "bad \xFF name";
  const json j = json::parse(fairReportJson(r));
  EXPECT_TRUE(j["tolerance"].is_null());
  EXPECT_TRUE(j["objects"][0]["gap"].is_null());
  EXPECT_EQ(j["objects"][0]["name"], "bad \xEF\xBF\xBD name");
}

RC_GTEST_PROP(FairReportJson, EveryFiniteNumberReadsBackToTheBit, (std::uint64_t bits)) {
  double value = 0;
  std::memcpy(&value, &bits, sizeof value);
  RC_PRE(std::isfinite(value));
  FairReport r;
  r.seconds = value;
  RC_ASSERT(json::parse(fairReportJson(r))["seconds"].get<double>() == value);
}

TEST(FairReportHtml, HoldsDrawingsTablesReasonsAndTheCommand) {
  const std::string html = fairReportHtml(report());
  for (const char* part :
       {"<canvas", "class=\"isophotes\"", "<b>Before</b>", "<b>After</b>", "<h2>Fairness</h2>", "thin-plate",
        "<h2>Left alone</h2>", "a plane is not a B-spline", "2 knots inserted", "0.012", "Gap at edge 2",
        "strak fair &#39;a &lt;b&gt;.step&#39; -o b.step", "data-kind=\"deviation\"", "\"deviation\":{\"from\""})
    EXPECT_NE(html.find(part), std::string::npos) << part;
}

// Exact energies have no certificate: without one of every object there is nothing to say about the worst.
TEST(FairReportHtml, ClaimsNoDistanceFromAnOptimumWithoutACertificate) {
  FairReport r = report();
  EXPECT_NE(fairReportHtml(r).find("Distance from the optimum"), std::string::npos);
  r.objects.push_back(r.objects.front());
  r.objects.back().summary.gap = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(fairReportHtml(r).find("Distance from the optimum"), std::string::npos);
}

TEST(FairReportHtml, IsSelfContainedSafeAndRepeatable) {
  const std::string html = fairReportHtml(report());
  EXPECT_EQ(html, fairReportHtml(report()));
  EXPECT_EQ(html.find("<script>alert"), std::string::npos);
  std::size_t scripts = 0;
  for (std::size_t at = html.find("<script"); at != std::string::npos; at = html.find("<script", at + 1)) ++scripts;
  EXPECT_EQ(scripts, 2u);  // the data and the code
  for (const char* loads : {" src=", " href=", "url(", "@import", "fetch(", "XMLHttpRequest"})
    EXPECT_EQ(html.find(loads), std::string::npos) << loads;
}

TEST(FairReportHtml, WorksForCurvesVolumesAndFilesWithoutSplines) {
  FairReport r = report();
  r.objects = {faired(planeCurve(), planeCurve(), "curve"), faired(block(), block(), "block")};
  EXPECT_NE(fairReportHtml(r).find("<svg"), std::string::npos);
  r.objects = {report().objects[1]};
  const std::string html = fairReportHtml(r);
  EXPECT_EQ(html.find("<canvas"), std::string::npos);
  EXPECT_NE(html.find("a plane is not a B-spline"), std::string::npos);
}

TEST(FairReportHtml, ManyFacesMakeAPageOfSensibleSize) {
  FairReport r = report();
  r.objects.clear();
  for (int i = 0; i < 30; ++i) {
    const Surface a = sheet([=](double x, double y) { return i + 0.1 * std::sin(20 * x * y); }, 12);
    r.objects.push_back(faired(a, sheet([=](double, double) { return i; }, 12), "face " + std::to_string(i)));
  }
  EXPECT_LT(fairReportHtml(r).size(), 10u << 20);
}

// Draws the page in a real browser and counts pixels that are not background in its left and right half.
TEST(FairReportHtml, ABrowserDrawsBothStates) {
  const std::filesystem::path browser = "/usr/bin/chromium";
  if (!std::filesystem::exists(browser)) GTEST_SKIP() << "no " << browser;
  std::string folder = (std::filesystem::temp_directory_path() / "strak-report-XXXXXX").string();
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  std::string html = fairReportHtml(report());
  const std::string probe = R"(<script>
  const count = (v, from, to) => {
    const gl = v.gl, pixels = new Uint8Array(4 * gl.canvas.width * gl.canvas.height);
    v.draw();
    gl.readPixels(0, 0, gl.canvas.width, gl.canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    let n = 0;
    for (let i = 0; i < pixels.length; i += 4) {
      const x = (i / 4) % gl.canvas.width / gl.canvas.width;
      if (x >= from && x < to && pixels[i] < 128) ++n;
    }
    return n;
  };
  const v = window.strakViewer, result = [];
  for (const kind of ["isophotes", "zebra", "gaussian", "mean", "deviation", "shaded"]) {
    v.kind = kind;
    result.push(kind, count(v, 0, 0.5), count(v, 0.5, 1));
  }
  document.title = "pixels " + result.join(" ") + " error " + v.gl.getError();
  </script></body>)";
  html.replace(html.rfind("</body>"), 7, probe);
  std::ofstream(folder + "/page.html") << html;
  const std::string command =
      "timeout 60 " + browser.string() +
      " --headless --no-sandbox --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader --disable-quic "
      "--no-first-run --disable-background-networking --disable-component-update --disable-sync --user-data-dir=" +
      folder + "/profile --window-size=900,700 --virtual-time-budget=10000 --dump-dom file://" + folder +
      "/page.html 2>/dev/null";
  std::string dom;
  FILE* pipe = popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  char buffer[65536];
  for (std::size_t n; (n = fread(buffer, 1, sizeof buffer, pipe)) > 0;) dom.append(buffer, n);
  pclose(pipe);
  std::filesystem::remove_all(folder);
  if (dom.find("data-viewer=\"unavailable\"") != std::string::npos) GTEST_SKIP() << "the browser has no WebGL 2";
  const std::size_t at = dom.find("<title>pixels ");
  ASSERT_NE(at, std::string::npos) << "the page did not run to its end";
  std::istringstream title(dom.substr(at + 14, dom.find("</title>", at) - at - 14));
  for (const char* kind : {"isophotes", "zebra", "gaussian", "mean", "deviation", "shaded"}) {
    std::string name;
    long before = 0, after = 0;
    title >> name >> before >> after;
    EXPECT_EQ(name, kind);
    const long least =
        name == "shaded" ? 50 : 500;  // dark pixels: lines, stripes, strong colours; at least the borders
    EXPECT_GT(before, least) << kind;
    EXPECT_GT(after, name == "gaussian" || name == "mean" || name == "shaded" ? 50 : least) << kind;
  }
  std::string word;
  int error = -1;
  title >> word >> error;
  EXPECT_EQ(error, 0);
}

}  // namespace
}  // namespace strak
