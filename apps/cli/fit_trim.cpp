#include "apps/cli/fit_trim.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/cli/console.h"
#include "apps/cli/values.h"
#include "strak/base/error.h"
#include "strak/energy/parameter_scale.h"
#include "strak/exchange/model.h"
#include "strak/exchange/trimmed_surface.h"
#include "strak/fitting/border_curves.h"

namespace strak::cli {

namespace {

double lengthOrAuto(const char* option, const std::string& text) {
  return text.empty() || text == "auto" ? 0 : positiveNumber(option, text);
}

// The rows inside the domain, in lengths.
Net placesInside(const Surface& surface, const Eigen::Ref<const Net>& parameters,
                 const std::array<double, 2>& lengths) {
  const KnotVector &u = surface.knots(0), &v = surface.knots(1);
  Net places(parameters.rows(), 2);
  Index count = 0;
  for (Index i = 0; i < parameters.rows(); ++i) {
    const double x = parameters(i, 0), y = parameters(i, 1);
    if (x < u.from() || x > u.to() || y < v.from() || y > v.to()) continue;
    places.row(count++) << x * lengths[0], y * lengths[1];
  }
  places.conservativeResize(count, 2);
  return places;
}

Json jsonOf(const FairLoop& loop) {
  return {{"points", loop.points},       {"corners", loop.corners}, {"length", loop.length},
          {"area", loop.area},           {"rms", loop.rms},         {"deviation", loop.deviation},
          {"tolerance", loop.tolerance}, {"pinned", loop.pinned}};
}

}  // namespace

void addTrimOptions(CLI::App& command, TrimArguments& arguments) {
  command.add_option("--trim", arguments.gap,
                     "Trim the surface along the border of the points and around their holes (STEP, IGES, BREP): auto, "
                     "or how wide a gap is to count as a hole");
  command.add_option("--trim-tolerance", arguments.tolerance,
                     "How far a trimming curve may be from the border points; default: auto, by their spacing");
}

void requireTrimmable(const TrimArguments& arguments, const std::string& output, int directions) {
  if (arguments.gap.empty()) {
    if (!arguments.tolerance.empty()) throw InvalidInput("--trim-tolerance says how to --trim: give that too");
    return;
  }
  lengthOrAuto("--trim", arguments.gap);
  lengthOrAuto("--trim-tolerance", arguments.tolerance);
  if (directions == 1) throw InvalidInput("--trim is for surfaces: a curve has no border");
  if (!holdsTrimming(output)) {
    throw InvalidInput(fmt::format("--trim: '{}' cannot hold trimmed faces, write .step, .igs or .brep", output));
  }
}

std::array<double, 2> lengthsOfUnits(const Surface& fit) {
  const auto scaled = scaledKnots<2>(fit, ParameterScale::lengths);
  return {scaled[0].length() / fit.knots(0).length(), scaled[1].length() / fit.knots(1).length()};
}

Json writeTrimmedFit(const TrimArguments& arguments, const std::string& output, const Surface& surface,
                     const Eigen::Ref<const Net>& parameters, const std::array<double, 2>& lengths,
                     const std::string& name, std::vector<std::string>& warnings) {
  const Net places = placesInside(surface, parameters, lengths);
  BorderOptions gaps;
  gaps.gap = lengthOrAuto("--trim", arguments.gap);
  const Borders borders = findBorders(places, gaps);
  BorderCurveOptions options;
  options.tolerance = lengthOrAuto("--trim-tolerance", arguments.tolerance);
  const KnotVector &u = surface.knots(0), &v = surface.knots(1);
  options.domain = {Eigen::Vector2d(u.from() * lengths[0], v.from() * lengths[1]),
                    Eigen::Vector2d(u.to() * lengths[0], v.to() * lengths[1])};
  const std::vector<FairPart> fair = fairBorders(places, borders, options);

  Json loops = Json::array();
  Index pinned = 0;
  double largest = 0;
  double area = 0, triangles = 0;
  const auto take = [&](const FairLoop& loop) {
    loops.push_back(jsonOf(loop));
    pinned += loop.pinned;
    largest = std::max(largest, loop.deviation);
    area += loop.area;
    TrimLoop curves = loop.pieces;
    for (Curve& curve : curves) {
      Eigen::Ref<Net> net = curve.net();
      for (Index k = 0; k < 2; ++k) {
        const KnotVector& knots = surface.knots(static_cast<int>(k));
        net.col(k) =
            (net.col(k) / lengths[static_cast<std::size_t>(k)]).cwiseMax(knots.from()).cwiseMin(knots.to()).eval();
      }
    }
    return curves;
  };
  std::vector<TrimmedPart> parts;
  for (std::size_t p = 0; p < fair.size(); ++p) {
    triangles += borders.parts[p].area;
    TrimmedPart& part = parts.emplace_back();
    part.outer = take(fair[p].outer);
    loops.back()["part"] = p + 1;
    loops.back()["hole"] = false;
    for (const FairLoop& hole : fair[p].holes) {
      part.holes.push_back(take(hole));
      loops.back()["part"] = p + 1;
      loops.back()["hole"] = true;
    }
  }
  writeTrimmed(output, surface, parts, name);
  const Audit audit = readModel(output)->audit();
  if (parts.size() > 1) {
    warnings.push_back(
        fmt::format("the points lie in {} separate parts: the file has a trimmed face for each", parts.size()));
  }
  if (options.tolerance > 0 && largest > options.tolerance) {
    warnings.push_back(fmt::format(
        "a border point is {} away from its trimming curve, farther than --trim-tolerance: the border there is "
        "too rough to be followed more closely",
        number(largest)));
  }
  if (pinned > 0) {
    warnings.push_back(fmt::format(
        "the trimming runs straight through {} border points, where no fair curve keeps clear of the others", pinned));
  }
  if (!audit.valid) {
    warnings.push_back("Open CASCADE's checker does not accept the trimmed face as it is read back from the file");
  }
  return {{"faces", parts.size()},
          {"loops", loops},
          {"gap", borders.gap},
          {"spacing", borders.spacing},
          {"left_out", borders.leftOut + parameters.rows() - places.rows()},
          {"area", area},
          {"area_of_triangles", triangles},
          {"area_share", area / options.domain.volume()},
          {"valid", audit.valid},
          {"largest_gap", audit.largestGap}};
}

void printTrimming(const Json& trimming) {
  const Json& loops = trimming["loops"];
  double largest = 0;
  std::size_t holes = 0;
  for (const Json& loop : loops) {
    largest = std::max(largest, loop["deviation"].get<double>());
    holes += loop["hole"].get<bool>() ? 1 : 0;
  }
  fmt::print("trimmed     {} face{} with {} hole{} wider than {}: {:.1f} % of the domain, {} points left out\n",
             trimming["faces"].dump(), trimming["faces"] == 1 ? "" : "s", holes, holes == 1 ? "" : "s",
             number(trimming["gap"].get<double>()), 100 * trimming["area_share"].get<double>(),
             trimming["left_out"].dump());
  fmt::print("            curves within {} of the border points; {}, edges within {} of the surface\n", number(largest),
             trimming["valid"].get<bool>() ? "valid" : "not valid", number(trimming["largest_gap"].get<double>()));
}

}  // namespace strak::cli
