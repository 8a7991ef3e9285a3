#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "strak/report/curve_diagrams.h"
#include "strak/report/fair_report.h"
#include "strak/report/page.h"
#include "strak/report/picture.h"
#include "strak/report/svg.h"
#include "strak/report/viewer_data.h"

namespace strak {

namespace {

constexpr const char* kArrow = " \u2192 ";
constexpr std::size_t kSinglePictures = 6;  // faces that get drawings of their own
constexpr std::size_t kWorstEdges = 12;

std::string withUnit(double value, const std::string& unit, int digits = 4) {
  return unit.empty() ? figure(value, digits) : fmt::format("{}\u00A0{}", figure(value, digits), escaped(unit));
}

// "-12.3 %" in the colour of better (less) or worse.
std::string change(double before, double after) {
  if (!(before > 0) || !std::isfinite(before) || !std::isfinite(after)) return "\u2013";
  const double percent = 100 * (after - before) / before;
  // Enough decimals to tell a small change from none, and nearly all from all.
  const double telling = std::min(std::abs(percent), percent < 0 ? 100 + percent : 100.0);
  const int decimals = telling > 0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(telling))), 1, 4) : 1;
  const std::string text = shortNumber(std::abs(percent), decimals);
  if (text == "0") return "0\u00A0%";
  return fmt::format("<span class=\"{}\">{}{}\u00A0%</span>", percent < 0 ? "better" : "worse",
                     percent < 0 ? "\u2212" : "+", text);
}

std::string number(const std::string& html) { return fmt::format("<td class=\"n\">{}</td>", html); }
std::string number(double value, int digits = 5) { return number(figure(value, digits)); }

// Three cells: before, after, change.
std::string beforeAfter(double before, double after) {
  return number(before) + number(after) + number(change(before, after));
}

std::string joined(const auto& numbers, const char* separator) {
  std::string out;
  for (const auto& n : numbers) out += fmt::format("{}{}", out.empty() ? "" : separator, n);
  return out.empty() ? "\u2013" : out;
}

std::string nameCell(const FairedObject& object) {
  return fmt::format("<td>{}<br><small>{}</small></td>", escaped(object.name), escaped(object.kind));
}

std::string rowStart(std::size_t index) { return fmt::format("<tr data-object=\"{}\">", index); }

// What became of the file in a few figures.
std::string tiles(const FairReport& report) {
  std::size_t faired = 0;
  BeforeAfter energy, plate;
  double deviation = 0, moved = 0, gap = 0;
  bool certified = true;  // every optimum; those of exact energies are not
  for (const FairedObject& object : report.objects) {
    if (!object.faired()) continue;
    ++faired;
    energy.before += object.summary.energyBefore;
    energy.after += object.summary.energyAfter;
    plate.before += object.plate.before;
    plate.after += object.plate.after;
    deviation = std::max(deviation, object.deviationUpper);
    moved = std::max(moved, object.controlPointMove);
    certified = certified && std::isfinite(object.summary.gap);
    gap = std::max(gap, object.summary.gap);
  }
  const std::string& unit = report.unit;
  std::string out = "<dl class=\"tiles\">\n";
  const auto tile = [&](std::string_view term, const std::string& value, const std::string& more) {
    out += fmt::format("<div><dt>{}</dt><dd>{}<small>{}</small></dd></div>\n", term, value, more);
  };
  tile("Faired", fmt::format("{} of {}", faired, report.objects.size()),
       faired == report.objects.size() ? "nothing left alone"
                                       : fmt::format("{} left alone", report.objects.size() - faired));
  tile("Energy minimized", change(energy.before, energy.after), figure(energy.before) + kArrow + figure(energy.after));
  tile("Bending energy", change(plate.before, plate.after), figure(plate.before) + kArrow + figure(plate.after));
  tile("Moved at most (certified)", withUnit(deviation, unit),
       std::isfinite(report.tolerance)
           ? fmt::format("tolerance {} on {}", withUnit(report.tolerance, unit), escaped(report.toleranceKind))
           : fmt::format("no tolerance set; control points {}", withUnit(moved, unit)));
  if (certified && faired > 0) tile("Distance from the optimum", figure(gap, 2), "certified, relative, worst object");
  if (!report.joins.empty()) {
    const JoinSummary joins = summaryOf(report.joins);
    const std::string inverse = unit.empty() ? "" : fmt::format("\u00A01/{}", escaped(unit));
    tile("Largest angle at joins", figure(joins.angle.after, 3) + "\u00B0",
         fmt::format("before {}\u00B0; mean {}\u00B0{}{}\u00B0", figure(joins.angle.before, 3),
                     figure(joins.angleMean.before, 3), kArrow, figure(joins.angleMean.after, 3)));
    tile("Largest curvature jump", figure(joins.curvature.after, 3) + inverse,
         fmt::format("before {}; mean {}{}{}", figure(joins.curvature.before, 3), figure(joins.curvatureMean.before, 3),
                     kArrow, figure(joins.curvatureMean.after, 3)));
  }
  if (!report.before.edges.empty() || !report.after.edges.empty())
    tile("Largest gap at edges", withUnit(report.after.largestGap, unit),
         "before " + withUnit(report.before.largestGap, unit));
  tile("Checked", report.after.valid ? "valid" : fmt::format("{} invalid", report.after.invalidFaces),
       report.before.valid ? "valid before" : fmt::format("{} invalid before", report.before.invalidFaces));
  tile("Time", fmt::format("{}\u00A0s", figure(report.seconds, 3)), "the whole run");
  return out + "</dl>\n";
}

std::string fairnessTable(const FairReport& report) {
  std::string rows;
  for (std::size_t i = 0; i < report.objects.size(); ++i) {
    const FairedObject& o = report.objects[i];
    if (!o.faired()) continue;
    rows += rowStart(i) + nameCell(o) +
            fmt::format("<td>{}</td>", escaped(o.energyName.empty() ? "\u2013" : o.energyName)) +
            beforeAfter(o.summary.energyBefore, o.summary.energyAfter) + beforeAfter(o.plate.before, o.plate.after);
    if (o.fairnessBefore && o.fairnessAfter) {
      const SurfaceFairness &a = *o.fairnessBefore, &b = *o.fairnessAfter;
      rows += beforeAfter(a.curvatureVariation, b.curvatureVariation) +
              beforeAfter(a.isophoteRoughness, b.isophoteRoughness);
    } else {
      for (int k = 0; k < 6; ++k) rows += number("\u2013");
    }
    rows += "</tr>\n";
  }
  if (rows.empty()) return {};
  std::string heads;
  for (int k = 0; k < 4; ++k)
    heads += "<th class=\"n\">before</th><th class=\"n\">after</th><th class=\"n\">change</th>";
  return "<h2>Fairness</h2>\n<div class=\"scroll\"><table>\n<thead><tr><th rowspan=\"2\">Object</th><th "
         "rowspan=\"2\">Energy</th><th colspan=\"3\">Energy minimized</th><th colspan=\"3\">Bending "
         "\u222B\u00A0k\u2081\u00B2\u2009+\u2009k\u2082\u00B2\u00A0dA</th><th colspan=\"3\">Curvature variation "
         "(MVS)</th><th colspan=\"3\">Isophote roughness, all lights</th></tr>\n<tr>" +
         heads + "</tr></thead>\n<tbody>\n" + rows + "</tbody></table></div>\n";
}

std::string proofTable(const FairReport& report) {
  std::string rows;
  for (std::size_t i = 0; i < report.objects.size(); ++i) {
    const FairedObject& o = report.objects[i];
    if (!o.faired()) continue;
    std::string notes;
    for (const std::string& note : o.notes) notes += fmt::format("{}{}", notes.empty() ? "" : "; ", escaped(note));
    rows +=
        rowStart(i) + nameCell(o) +
        fmt::format("<td>{}</td><td class=\"n\">{}</td>", joined(o.degree, " \u00D7 "), joined(o.points, " \u00D7 ")) +
        number(fmt::format("{}", o.summary.freePoints)) + number(fmt::format("{}", o.summary.activePoints)) +
        number(o.deviationLower) + number(o.deviationUpper) + number(o.controlPointMove) + number(o.heldMaxMove, 3) +
        number(o.summary.gap, 3) + number(fmt::format("{}", o.summary.steps)) +
        fmt::format("<td>{}</td>", escaped(stopReasonName(o.summary.stopReason))) + number(o.summary.seconds, 3) +
        fmt::format("<td>{}</td></tr>\n", notes);
  }
  if (rows.empty()) return {};
  const std::string unit = report.unit.empty() ? "" : fmt::format(" ({})", escaped(report.unit));
  return fmt::format(
      "<h2>What moved, and how well that is proven</h2>\n<div class=\"scroll\"><table>\n<thead><tr><th "
      "rowspan=\"2\">Object</th><th rowspan=\"2\">Degree</th><th rowspan=\"2\" class=\"n\">Control net</th><th "
      "colspan=\"2\">Points</th><th colspan=\"2\">Deviation{0}</th><th colspan=\"2\">Control points moved{0}</th><th "
      "rowspan=\"2\" class=\"n\">Gap to<br>optimum</th><th rowspan=\"2\" class=\"n\">Steps</th><th "
      "rowspan=\"2\">Stopped by</th><th rowspan=\"2\" class=\"n\">Seconds</th><th rowspan=\"2\">Notes</th></tr>\n<tr>"
      "<th class=\"n\">free</th><th class=\"n\">at limit</th><th class=\"n\">reached</th><th class=\"n\">certified</th>"
      "<th class=\"n\">free</th><th class=\"n\">held</th></tr></thead>\n<tbody>\n{1}</tbody></table></div>\n",
      unit, rows);
}

// Counts by kind, and the edges where faces join worst, features apart.
std::string joinsTable(const FairReport& report) {
  if (report.joins.empty()) return {};
  const JoinSummary summary = summaryOf(report.joins);
  std::string counts;
  for (const JointKind kind : {JointKind::g2, JointKind::g1, JointKind::g0, JointKind::feature}) {
    const auto k = static_cast<std::size_t>(kind);
    if (summary.before[k] == 0 && summary.after[k] == 0) continue;
    counts += fmt::format("{}{}: {}{}{}", counts.empty() ? "" : " \u00B7 ", jointKindName(kind), summary.before[k],
                          kArrow, summary.after[k]);
  }
  std::vector<std::pair<double, std::size_t>> worst;
  for (std::size_t i = 0; i < report.joins.size(); ++i) {
    const EdgeJoin& join = report.joins[i];
    if (join.kindBefore != JointKind::feature) worst.emplace_back(-std::max(join.angle.before, join.angle.after), i);
  }
  std::sort(worst.begin(), worst.end());
  if (worst.size() > kWorstEdges) worst.resize(kWorstEdges);
  std::string rows;
  for (const auto& [angle, i] : worst) {
    const EdgeJoin& join = report.joins[i];
    rows += fmt::format("<tr><td>{}</td><td>{}, {}</td>", escaped(join.name), join.faceA + 1, join.faceB + 1) +
            beforeAfter(join.gap.before, join.gap.after) + beforeAfter(join.angle.before, join.angle.after) +
            beforeAfter(join.curvature.before, join.curvature.after) + "</tr>\n";
  }
  std::string heads;
  for (int k = 0; k < 3; ++k)
    heads += "<th class=\"n\">before</th><th class=\"n\">after</th><th class=\"n\">change</th>";
  return fmt::format("<h2>Joins</h2>\n<p class=\"note\">{} edges between faces. {}</p>\n", report.joins.size(),
                     counts) +
         (rows.empty() ? ""
                       : "<div class=\"scroll\"><table>\n<thead><tr><th rowspan=\"2\">Edge</th><th "
                         "rowspan=\"2\">Faces</th><th colspan=\"3\">Gap</th><th colspan=\"3\">Angle (degrees)</th><th "
                         "colspan=\"3\">Curvature jump</th></tr>\n<tr>" +
                             heads + "</tr></thead>\n<tbody>\n" + rows + "</tbody></table></div>\n");
}

std::string auditTable(const FairReport& report) {
  const auto row = [](std::string_view name, const std::string& before, const std::string& after) {
    return fmt::format("<tr><td>{}</td>{}{}</tr>\n", name, number(before), number(after));
  };
  const Audit &a = report.before, &b = report.after;
  std::string out =
      "<h2>Audit of the whole model</h2>\n<div class=\"scroll single\"><table>\n<thead><tr><th></th><th "
      "class=\"n\">before</th><th class=\"n\">after</th></tr></thead>\n<tbody>\n";
  out += row("Passes the kernel\u2019s checker", a.valid ? "yes" : "no", b.valid ? "yes" : "no");
  out += row("Invalid faces", fmt::format("{}", a.invalidFaces), fmt::format("{}", b.invalidFaces));
  if (a.edges.empty() && b.edges.empty()) return out + "</tbody></table></div>\n";
  out += row("Edges measured", fmt::format("{}", a.edges.size()), fmt::format("{}", b.edges.size()));
  out += row("Largest gap between an edge and its faces", withUnit(a.largestGap, report.unit),
             withUnit(b.largestGap, report.unit));
  out += row("Largest tolerance in the file", withUnit(a.largestTolerance, report.unit),
             withUnit(b.largestTolerance, report.unit));
  // The edges whose gaps changed, most first.
  std::vector<std::pair<double, std::size_t>> changed;
  for (std::size_t i = 0; i < std::min(a.edges.size(), b.edges.size()); ++i)
    if (a.edges[i].gap != b.edges[i].gap) changed.emplace_back(a.edges[i].gap - b.edges[i].gap, i);
  std::sort(changed.begin(), changed.end());
  if (changed.size() > kWorstEdges) changed.resize(kWorstEdges);
  for (const auto& [difference, i] : changed)
    out += row(fmt::format("Gap at {}", escaped(b.edges[i].name)), withUnit(a.edges[i].gap, report.unit),
               withUnit(b.edges[i].gap, report.unit));
  return out + "</tbody></table></div>\n";
}

std::string leftAloneTable(const FairReport& report) {
  // Objects of one kind that were left alone for the same reason share a row, in the order of the first of each.
  struct Group {
    std::string kind, reason, names;
    std::size_t count = 0;
  };
  std::vector<Group> groups;
  for (std::size_t i = 0; i < report.objects.size(); ++i) {
    const FairedObject& o = report.objects[i];
    if (o.faired()) continue;
    const std::string reason = o.leftAlone.empty() ? "not chosen" : o.leftAlone;
    auto group = std::find_if(groups.begin(), groups.end(),
                              [&](const Group& g) { return g.kind == o.kind && g.reason == reason; });
    if (group == groups.end()) group = groups.insert(group, {o.kind, reason, {}, 0});
    group->names += fmt::format("{}{}", group->count++ ? ", " : "", escaped(o.name));
  }
  if (groups.empty()) return {};
  std::string out =
      "<h2>Left alone</h2>\n<div class=\"scroll\"><table>\n<thead><tr><th>Kind</th><th>Why</th><th "
      "class=\"n\">Number</th><th>Objects</th></tr></thead>\n<tbody>\n";
  for (const Group& g : groups)
    out += fmt::format("<tr><td>{}</td><td>{}</td>{}<td>{}</td></tr>\n", escaped(g.kind), escaped(g.reason),
                       number(fmt::format("{}", g.count)), g.names);
  return out + "</tbody></table></div>\n";
}

Object objectOf(const FairedObject& faired, bool after) {
  Object object;
  object.name = faired.name;
  object.trims = faired.trims;
  object.spline = after && faired.after ? faired.after : faired.before;
  return object;
}

// The kind of drawing that shows the fairness of what there is.
RenderKind tellingKind(const Scene& scene) {
  if (scene.surfaces.empty()) return RenderKind::combs;
  return scene.plane ? RenderKind::isolines : RenderKind::isophotes;
}

// A picture of the objects that is no higher than they need.
Picture fittedPicture(const std::vector<Object>& objects, RenderOptions& options) {
  const Picture first = preparePicture(objects, options);
  options.kind = tellingKind(first.scene);
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector3d& p : scenePoints(first.scene))
    box.extend(Eigen::Vector2d(first.camera.project(p).head<2>()));
  const double width = std::max(box.sizes().x(), 1.0);
  options.height = std::clamp(static_cast<int>(box.sizes().y() / width * 600 + 90), 260, 560);
  return preparePicture(objects, options);
}

// Before and after with the same camera and levels.
std::string picturePair(const Picture& before, const std::vector<Object>& after, const RenderOptions& options,
                        const std::string& what) {
  const auto range = pictureRange(before, options);
  const Picture second = preparePicture(after, options, &before.camera);
  return fmt::format("{}{}",
                     htmlFigure(drawPicture(before, options, range), fmt::format("<b>Before</b> \u2013 {}", what)),
                     htmlFigure(drawPicture(second, options, range), fmt::format("<b>After</b> \u2013 {}", what)));
}

// How far the faired objects moved, seen as in `whole`.
std::string deviationMap(const std::vector<Object>& before, const std::vector<Object>& after, const Picture& whole,
                         RenderOptions options) {
  options.kind = RenderKind::deviation;
  options.reference = before;
  options.view = whole.camera.view();
  options.up = whole.camera.up();
  return htmlFigure(renderSvg(after, options), "<b>Deviation</b> \u2013 moved along the normal, the whole part");
}

std::string drawings(const FairReport& report, const std::vector<Object>& before, const std::vector<Object>& after,
                     const Picture& whole, const RenderOptions& options) {
  std::vector<std::pair<double, std::size_t>> faired;
  for (std::size_t i = 0; i < report.objects.size(); ++i)
    if (report.objects[i].faired()) faired.emplace_back(-report.objects[i].deviationLower, i);
  std::sort(faired.begin(), faired.end());

  std::string out = "<h2>Drawings</h2>\n<div class=\"pair\">\n" + picturePair(whole, after, options, "the whole part");
  if (!faired.empty() && !whole.scene.surfaces.empty()) out += deviationMap(before, after, whole, options);
  out += "</div>\n";
  const auto hidden =
      std::count_if(report.objects.begin(), report.objects.end(), [](const FairedObject& o) { return !o.before; });
  if (hidden > 0)
    out += fmt::format("<p class=\"note\">Only splines are drawn; {} of other kinds {} not.</p>\n",
                       hidden == 1 ? "one object" : fmt::format("{} objects", hidden), hidden == 1 ? "is" : "are");
  if (report.objects.size() == 1 || faired.empty()) return out;
  if (faired.size() > kSinglePictures) {
    faired.resize(kSinglePictures);
    out += fmt::format("<p class=\"note\">The {} objects that moved most; the view above shows the others.</p>\n",
                       kSinglePictures);
  }
  out += "<div class=\"pair small\">\n";
  for (const auto& [move, i] : faired) {
    RenderOptions own = options;
    own.caption = false;
    const Picture picture = fittedPicture({before[i]}, own);
    out += picturePair(picture, {after[i]}, own, escaped(report.objects[i].name));
  }
  return out + "</div>\n";
}

std::string header(const FairReport& report) {
  const std::string more =
      report.size > 0 ? fmt::format(" \u00B7 size {}", withUnit(report.size, report.unit)) : std::string();
  return fmt::format("<h1>Fairing report</h1>\n<p class=\"sub\">{}{}{}{}</p>\n", escaped(report.inputName), kArrow,
                     escaped(report.outputName), more);
}

std::string origin(const FairReport& report) {
  return fmt::format("<h2>How this was made</h2>\n<pre><code>{}</code></pre>\n<p class=\"note\">strak {}</p>\n",
                     escaped(report.command), escaped(report.version));
}

}  // namespace

std::string fairReportHtml(const FairReport& report) {
  std::vector<Object> before, after;
  ViewerModel model;
  model.unit = report.unit;
  model.joins = report.joins;
  bool drawable = false;
  for (const FairedObject& object : report.objects) {
    before.push_back(objectOf(object, false));
    after.push_back(objectOf(object, true));
    model.after.push_back(after.back());
    if (!object.faired()) model.after.back().spline.reset();
    drawable = drawable || object.before;
  }
  std::string body = header(report) + tiles(report), data = "null";
  if (drawable) {
    RenderOptions options;
    options.width = 640;
    options.height = 560;
    const Picture whole = fittedPicture(before, options);
    model.before = before;
    model.start = options;
    data = viewerData(model, whole);
    body += viewerMarkup();
    body += drawings(report, before, after, whole, options) + curveDiagrams(report);
  }
  body += fairnessTable(report) + proofTable(report) + joinsTable(report) + leftAloneTable(report) +
          auditTable(report) + origin(report);
  return htmlPage(fmt::format("{} \u2013 fairing report", report.inputName), body, data);
}

}  // namespace strak
