#include "apps/cli/fit_sheet.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "strak/base/error.h"
#include "strak/spline/evaluate.h"

namespace strak::cli {

namespace {

constexpr double kWorthAWord = 0.05;  // share of points in layers
constexpr double kAstray = 0.01;

std::string placeOn(const Surface& surface, const std::array<double, 2>& at) {
  const Point point = evaluate<2>(surface, at);
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", point[0], point[1], point[2]);
}

}  // namespace

DrawnCloud drawOrRefuse(const FitPoints<2>& points, const std::array<KnotVector, 2>& sizes, bool robust,
                        const Progress& progress) {
  DeepDrawingOptions options;
  for (std::size_t k = 0; k < 2; ++k) {
    options.degree[k] = sizes[k].degree();
    options.size[k] = sizes[k].size();
  }
  options.robust = robust;
  options.progress = progress;
  DrawnCloud drawn = drawCloud(points.values, points.weights, options);
  const DrawnSheet& sheet = drawn.sheet;
  if (sheet.check.doubt() > kNotOneSheet && !sheet.fit.summary.stopped) {
    const bool layers = sheet.check.layered > sheet.check.astrayShare();
    const Point place = layers ? evaluate<2>(sheet.fit.spline, sheet.check.layeredAt) : sheet.check.astrayPoint;
    throw InvalidInput(fmt::format(
        "the cloud is not one sheet: {:.0f} % of its points lie in layers or nearer to other parts of the surface than "
        "to their own, for instance around ({:.6g}, {:.6g}, {:.6g}): cut it into sheets and fit each of them, or give "
        "the points parameters u, v",
        100 * std::min(sheet.check.doubt(), 1.0), place[0], place[1], place[2]));
  }
  return drawn;
}

Json jsonOf(const DrawnCloud& drawn) {
  const DrawnSheet& sheet = drawn.sheet;
  return {{"plane", drawn.plane},
          {"steps", sheet.rms.size()},
          {"rms", sheet.rms},
          {"smoothing", sheet.fit.summary.lambda},
          {"stretch", sheet.stretch},
          {"stopped_before_a_fold", sheet.folded},
          {"held_points", sheet.held.size()}};
}

std::vector<std::string> sheetWarnings(const SheetCheck& check, const Surface& surface) {
  std::vector<std::string> warnings;
  if (check.layered > kWorthAWord) {
    warnings.push_back(fmt::format("{:.0f} % of the points lie in two layers, for instance around {}",
                                   100 * check.layered, placeOn(surface, check.layeredAt)));
  }
  if (check.parts > 1) {
    warnings.push_back(fmt::format(
        "the points lie in {} parts with nothing between them, the second one around {}: what joins them is a guess",
        check.parts, placeOn(surface, check.partAt)));
  }
  if (check.thickness > kThick) {
    warnings.push_back(
        fmt::format("half of the points lie farther from the surface than {:.2g} of its size: a cloud that thick is no "
                    "sheet over one plane; cut it into sheets, or give the points parameters u, v",
                    check.thickness));
  }
  if (check.folded > 0) {
    warnings.push_back(
        fmt::format("the surface folds in {} of {} knot cells, for instance around {}: use fewer "
                    "control points",
                    check.folded, check.cells, placeOn(surface, check.foldedAt)));
  }
  if (check.astrayShare() > kAstray) {
    warnings.push_back(
        fmt::format("of {} points looked at {} are nearer to another part of the surface than to their own, for "
                    "instance ({:.6g}, {:.6g}, {:.6g}): the cloud may not be one sheet there",
                    check.looked, check.astray, check.astrayPoint[0], check.astrayPoint[1], check.astrayPoint[2]));
  }
  return warnings;
}

}  // namespace strak::cli
