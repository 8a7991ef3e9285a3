#include "strak/report/curve_diagrams.h"

#include <fmt/format.h>

#include <algorithm>

#include "strak/report/curve_plot.h"
#include "strak/report/page.h"
#include "strak/report/svg.h"

namespace strak {

std::string curveDiagrams(const FairReport& report) {
  constexpr std::size_t kMost = 12;
  std::vector<std::size_t> curves;
  for (std::size_t i = 0; i < report.objects.size(); ++i) {
    const FairedObject& object = report.objects[i];
    if (object.curve && object.faired() && object.before) curves.push_back(i);
  }
  if (curves.empty()) return {};
  const std::size_t count = curves.size();
  std::stable_sort(curves.begin(), curves.end(), [&](std::size_t a, std::size_t b) {
    return report.objects[a].curve->extremaBefore > report.objects[b].curve->extremaBefore;
  });
  curves.resize(std::min(curves.size(), kMost));
  std::string out = "<h2>Curvature of the curves</h2>\n";
  if (count > kMost) {
    out += fmt::format("<p class=\"note\">The {} of {} curves with the most curvature extrema.</p>\n", kMost, count);
  }
  out += "<div class=\"pair\">\n";
  CurvePlotOptions options;
  options.width = 640;
  options.height = 320;
  if (report.tolerance < kUnlimited) options.tolerance = report.tolerance;
  for (const std::size_t i : curves) {
    const FairedObject& object = report.objects[i];
    const Curve &before = std::get<Curve>(*object.before), &after = std::get<Curve>(*object.after);
    out += htmlFigure(curvaturePlotSvg(after, &before, options),
                      fmt::format("<b>{}</b> \u2013 curvature, {} extrema before, {} after", escaped(object.name),
                                  object.curve->extremaBefore, object.curve->extremaAfter));
    out += htmlFigure(tolerancePlotSvg(after, before, options),
                      fmt::format("<b>{}</b> \u2013 moved, within the tolerance", escaped(object.name)));
  }
  return out + "</div>\n";
}

}  // namespace strak
