#include "apps/cli/fit_trim.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "apps/cli/console.h"
#include "apps/cli/values.h"
#include "strak/base/error.h"
#include "strak/exchange/model.h"
#include "strak/exchange/trimmed_surface.h"
#include "strak/fitting/border_curves.h"
#include "strak/spline/evaluate.h"

namespace strak::cli {

namespace {

constexpr int kTightenings = 3;
constexpr double kTightened = 0.9;
constexpr double kFewLeftOut = 0.01;  // of the points: not worth a word

double lengthOrAuto(const char* option, const std::string& text) {
  return text.empty() || text == "auto" ? 0 : positiveNumber(option, text);
}

// How long a unit of u and of v is: the median at some of the points. Where there are none a surface may do anything.
std::array<double, 2> lengthsOfUnits(const Surface& surface, const Eigen::Ref<const Net>& parameters) {
  constexpr Index kSome = 5000;
  const Index step = (parameters.rows() + kSome - 1) / kSome, count = (parameters.rows() + step - 1) / step;
  Net some(count, 2);
  for (Index i = 0; i < count; ++i) {
    for (int k = 0; k < 2; ++k) {
      some(i, k) = std::clamp(parameters(i * step, k), surface.knots(k).from(), surface.knots(k).to());
    }
  }
  const Net derivatives = derivativesAt<2>(surface, some, 1);
  const Index dimension = surface.pointDimension();
  std::array<double, 2> lengths{1, 1};
  for (Index k = 0; k < 2; ++k) {
    Eigen::VectorXd norms = derivatives.middleCols((k + 1) * dimension, dimension).rowwise().norm();
    std::nth_element(norms.begin(), norms.begin() + count / 2, norms.end());
    if (norms[count / 2] > 0) lengths[static_cast<std::size_t>(k)] = norms[count / 2];
  }
  return lengths;
}

// How far the border points of a loop are in space from the nearest places of its curves in the plane.
double deviationInSpace(const Surface& surface, const Net& places, const BorderLoop& border, const FairLoop& loop,
                        const std::array<double, 2>& lengths) {
  double largest = 0;
  const auto at = [&](const auto& place) {
    return evaluate<2>(surface, {place[0] / lengths[0], place[1] / lengths[1]});
  };
  for (Index i = 0; i < loop.points; ++i) {
    const auto point = places.row(border.points[static_cast<std::size_t>(i)]);
    largest = std::max(largest, (at(point) - at(loop.feet.row(i))).norm());
  }
  return largest;
}

double deviationInSpace(const Surface& surface, const Net& places, const Borders& borders,
                        const std::vector<FairPart>& fair, const std::array<double, 2>& lengths) {
  double largest = 0;
  for (std::size_t p = 0; p < fair.size(); ++p) {
    const BorderPart& part = borders.parts[p];
    largest = std::max(largest, deviationInSpace(surface, places, part.outer, fair[p].outer, lengths));
    for (std::size_t h = 0; h < part.holes.size(); ++h) {
      largest = std::max(largest, deviationInSpace(surface, places, part.holes[h], fair[p].holes[h], lengths));
    }
  }
  return largest;
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

// Writes the faces beside the output and looks at that file as other programs read it; only what can be read takes the
// output's name.
Audit writeAudited(const std::filesystem::path& output, const Surface& surface, const std::vector<TrimmedPart>& parts,
                   const std::string& name) {
  std::filesystem::path beside = output;
  beside.replace_filename(fmt::format(".{}.unread{}", output.stem().string(), output.extension().string()));
  try {
    writeTrimmed(beside, surface, parts, name);
    Audit audit = readModel(beside)->audit();
    std::filesystem::rename(beside, output);
    return audit;
  } catch (const InvalidInput&) {
    std::filesystem::remove(beside);
    throw Failure(
        fmt::format("the trimmed face cannot be read back: points very far from the origin leave too few digits for "
                    "'{}', move them there or write .brep",
                    output.string()));
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove(beside, ignored);
    throw;
  }
}

Json jsonOf(const FairLoop& loop) {
  return {{"points", loop.points},       {"corners", loop.corners}, {"length", loop.length},
          {"area", loop.area},           {"rms", loop.rms},         {"deviation", loop.deviation},
          {"tolerance", loop.tolerance}, {"pinned", loop.pinned}};
}

}  // namespace

void addTrimOptions(CLI::App& command, TrimArguments& arguments) {
  command
      .add_option(
          "--trim", arguments.gap,
          "Trim the surface along the border of the points and around their holes (STEP, IGES, BREP); a length: "
          "how wide a gap is to count as a hole")
      ->expected(0, 1)
      ->default_str("auto")
      ->option_text("[L]");
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

Json writeTrimmedFit(const TrimArguments& arguments, const std::string& output, const Surface& surface,
                     const Eigen::Ref<const Net>& parameters, bool function, const std::string& name,
                     std::vector<std::string>& warnings) {
  const std::array<double, 2> lengths = function ? std::array<double, 2>{1, 1} : lengthsOfUnits(surface, parameters);
  const Net places = placesInside(surface, parameters, lengths);
  BorderOptions gaps;
  gaps.gap = lengthOrAuto("--trim", arguments.gap);
  const Borders borders = findBorders(places, gaps);
  BorderCurveOptions options;
  options.tolerance = lengthOrAuto("--trim-tolerance", arguments.tolerance);
  const KnotVector &u = surface.knots(0), &v = surface.knots(1);
  options.domain = {Eigen::Vector2d(u.from() * lengths[0], v.from() * lengths[1]),
                    Eigen::Vector2d(u.to() * lengths[0], v.to() * lengths[1])};
  std::vector<FairPart> fair = fairBorders(places, borders, options);
  const double tolerance = options.tolerance;
  double inSpace = function ? 0 : deviationInSpace(surface, places, borders, fair, lengths);
  // Lengths in the plane are those of the middle: where the surface is longer the tolerance is tighter.
  for (int round = 0; round < kTightenings && tolerance > 0 && inSpace > tolerance; ++round) {
    options.tolerance *= kTightened * tolerance / inSpace;
    fair = fairBorders(places, borders, options);
    inSpace = deviationInSpace(surface, places, borders, fair, lengths);
  }

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
  const Audit audit = writeAudited(output, surface, parts, name);
  if (parts.size() > 1) {
    warnings.push_back(
        fmt::format("the points lie in {} separate parts: the file has a trimmed face for each", parts.size()));
  }
  if (!function) largest = inSpace;
  if (tolerance > 0 && largest > tolerance) {
    warnings.push_back(fmt::format(
        "a border point is {} away from its trimming curve, farther than --trim-tolerance: the border there is "
        "too rough to be followed more closely",
        number(largest)));
  }
  const Index leftOut = borders.leftOut + parameters.rows() - places.rows();
  if (static_cast<double>(leftOut) > kFewLeftOut * static_cast<double>(parameters.rows())) {
    warnings.push_back(
        fmt::format("{} of {} points lie beyond the trimmed faces: alone, in parts too small for a face, "
                    "or beside the surface",
                    leftOut, parameters.rows()));
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
          {"deviation", largest},
          {"left_out", leftOut},
          {"area", area},
          {"area_of_triangles", triangles},
          {"area_share", area / options.domain.volume()},
          {"valid", audit.valid},
          {"largest_gap", audit.largestGap}};
}

void printTrimming(const Json& trimming) {
  const Json& loops = trimming["loops"];
  std::size_t holes = 0;
  for (const Json& loop : loops) {
    holes += loop["hole"].get<bool>() ? 1 : 0;
  }
  fmt::print("trimmed     {} face{} with {} hole{} wider than {}: {:.1f} % of the domain, {} points left out\n",
             trimming["faces"].dump(), trimming["faces"] == 1 ? "" : "s", holes, holes == 1 ? "" : "s",
             number(trimming["gap"].get<double>()), 100 * trimming["area_share"].get<double>(),
             trimming["left_out"].dump());
  fmt::print("            curves within {} of the border points; {}, edges within {} of the surface\n",
             number(trimming["deviation"].get<double>()), trimming["valid"].get<bool>() ? "valid" : "not valid",
             number(trimming["largest_gap"].get<double>()));
}

}  // namespace strak::cli
