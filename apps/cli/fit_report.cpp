#include "apps/cli/fit_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/cli/console.h"
#include "apps/cli/fit_energy.h"
#include "apps/cli/fit_normals.h"
#include "apps/cli/fit_trim.h"
#include "apps/cli/values.h"

namespace strak::cli {

namespace {

constexpr std::size_t kShownCells = 5;  // with points outside, the worst ones; --json lists more

}  // namespace

template <int D>
void takeOver(const AdaptiveFit<D>& fit, FitReport& report) {
  report.reached = fit.reached;
  report.rounds += fit.rounds;
  report.inserted += fit.inserted;
  report.removed += fit.removed;
  report.outside = Json::array();
  for (const auto& cell : fit.outside) {
    report.outside.push_back(
        {{"from", cell.from}, {"to", cell.to}, {"points", cell.count}, {"outside", cell.outside}, {"max", cell.max}});
  }
}

template <int D>
void takeOver(const RobustFit<D>& fit, const std::string& name, FitReport& report) {
  report.loss = {{"name", name},         {"scale", fit.scale},         {"outliers", fit.outliers},
                 {"rounds", fit.rounds}, {"converged", fit.converged}, {"gap", fit.gap}};
}

template <int D>
void takeOver(const MinimaxFit<D>& fit, FitReport& report) {
  report.loss = {{"name", "linf"}, {"rounds", fit.rounds}, {"converged", fit.converged}, {"gap", fit.gap}};
}

template void takeOver<1>(const AdaptiveFit<1>&, FitReport&);
template void takeOver<1>(const RobustFit<1>&, const std::string&, FitReport&);
template void takeOver<1>(const MinimaxFit<1>&, FitReport&);
template void takeOver<2>(const AdaptiveFit<2>&, FitReport&);
template void takeOver<2>(const RobustFit<2>&, const std::string&, FitReport&);
template void takeOver<2>(const MinimaxFit<2>&, FitReport&);

Json jsonOf(const FitReport& report) {
  const FitSummary& s = report.summary;
  Json json{{"kind", report.kind},
            {"measured", s.points},
            {"outside_domain", s.outsideDomain},
            {"degree", report.degree},
            {"points", report.size},
            {"energy", {{"name", s.energyName}, {"value", s.energy}, {"parameter_scale", report.scale}}},
            {"smoothing", {{"lambda", s.lambda}, {"freedom", s.freedom}, {"cross_validation", s.crossValidation}}},
            {"rms", s.rms},
            {"max", s.max},
            {"worst", {{"point", s.worstPoint + 1}, {"at", s.worstPlace}}}};
  if (report.adaptive) {
    json["tolerance"] = {{"value", report.tolerance},       {"share", report.share},
                         {"inside", s.insideShare()},       {"reached", report.reached},
                         {"rounds", report.rounds},         {"knots_inserted", report.inserted},
                         {"knots_removed", report.removed}, {"outside", report.outside}};
  }
  if (!report.loss.is_null()) json["loss"] = report.loss;
  if (!report.drawing.is_null()) json["drawing"] = report.drawing;
  if (!report.correction.is_null()) json["correction"] = report.correction;
  if (!report.conditions.is_null()) json["conditions"] = report.conditions;
  if (!report.following.is_null()) json["following"] = report.following;
  if (!report.normals.is_null()) json["normals"] = report.normals;
  if (!report.trimming.is_null()) json["trimming"] = report.trimming;
  json["streamed"] = report.streamed;
  json["warnings"] = s.warnings;
  return json;
}

void print(const FitReport& report, const std::string& output, double seconds) {
  const FitSummary& s = report.summary;
  fmt::print("{} of degree {} with {} control points near {} points\n", report.kind, times(report.degree),
             times(report.size), s.points);
  fmt::print("smoothing   {} ({}{}), {} degrees of freedom\n", number(s.lambda), s.energyName,
             report.scale == "unit" ? " in a square domain" : "", number(s.freedom));
  fmt::print("errors      rms {}, largest {} at point {} ({})\n", number(s.rms), number(s.max), s.worstPoint + 1,
             fmt::join(s.worstPlace, ", "));
  if (!report.loss.is_null() && !report.loss.contains("scale")) {
    fmt::print("loss        {}: gap {} after {} rounds\n", report.loss["name"].get<std::string>(),
               number(report.loss["gap"].get<double>()), report.loss["rounds"].dump());
  } else if (!report.loss.is_null()) {
    fmt::print("loss        {}: scale of the noise {}, {} outliers, gap {} after {} rounds\n",
               report.loss["name"].get<std::string>(), number(report.loss["scale"].get<double>()),
               report.loss["outliers"].dump(), number(report.loss["gap"].get<double>()), report.loss["rounds"].dump());
  }
  if (!report.drawing.is_null()) {
    const Json& drawing = report.drawing;
    fmt::print("drawn       in {} steps, rms {} to {}", drawing["steps"].dump(),
               number(drawing["rms"].front().get<double>()), number(drawing["rms"].back().get<double>()));
    if (drawing.contains("stretch")) {
      fmt::print(", the domain {} times as large", number(drawing["stretch"].get<double>()));
    }
    fmt::print("\n");
  }
  if (!report.correction.is_null()) {
    fmt::print("parameters  corrected in {} rounds, rms {} before\n", report.correction["rounds"].dump(),
               number(report.correction["rms"][0].get<double>()));
  }
  if (!report.conditions.is_null()) {
    fmt::print("conditions  {}, up to {} away before, now {}\n", report.conditions["count"].dump(),
               number(report.conditions["largest_before"].get<double>()),
               number(report.conditions["largest"].get<double>()));
  }
  if (!report.following.is_null()) fmt::print("{}", describeFollowing(report.following));
  if (!report.normals.is_null()) fmt::print("{}", describeNormals(report.normals));
  if (report.adaptive) {
    fmt::print("tolerance   {:.6g} % of the points within {} ({} knots inserted in {} rounds, {} removed)\n",
               100 * s.insideShare(), number(report.tolerance), report.inserted, report.rounds, report.removed);
    for (std::size_t i = 0; i < std::min(kShownCells, report.outside.size()); ++i) {
      const Json& cell = report.outside[i];
      fmt::print("  outside   {} of {} points in {} to {}, up to {}\n", cell["outside"].dump(), cell["points"].dump(),
                 cell["from"].dump(), cell["to"].dump(), number(cell["max"].get<double>()));
    }
  }
  if (!report.trimming.is_null()) printTrimming(report.trimming);
  fmt::print("wrote {} in {}\n", output, duration(seconds));
}

}  // namespace strak::cli
