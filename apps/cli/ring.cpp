#include "apps/cli/ring.h"

#include <fmt/format.h>

#include <numbers>

#include "apps/cli/console.h"
#include "apps/cli/values.h"
#include "strak/base/error.h"

namespace strak::cli {

namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

double dioptres(double curvature, double index) { return (index - 1) * 1000 * std::abs(curvature); }

}  // namespace

RingOptions ringNamed(const std::string& text) {
  const auto numbers = numberList("--ring", text, 3);
  if (!(numbers[2] > 0)) throw InvalidInput(fmt::format("--ring is '{}': the radius must be above zero", text));
  RingOptions options;
  options.centre = {numbers[0], numbers[1]};
  options.radius = numbers[2];
  return options;
}

Json jsonOf(const RingCurvature& ring, double index) {
  Json json{{"mean", ring.mean},
            {"flat", {{"curvature", ring.flat}, {"degrees", ring.flatAngle * kDegrees}}},
            {"steep", {{"curvature", ring.steep}, {"degrees", ring.steepAngle * kDegrees}}},
            {"irregular", ring.irregular},
            {"flattest", {{"curvature", ring.flattest}, {"degrees", ring.flattestAngle * kDegrees}}},
            {"steepest", {{"curvature", ring.steepest}, {"degrees", ring.steepestAngle * kDegrees}}},
            {"axial", ring.axial}};
  if (index != 1) {
    json["power"] = {{"mean", dioptres(ring.mean, index)},         {"flat", dioptres(ring.flat, index)},
                     {"steep", dioptres(ring.steep, index)},       {"irregular", dioptres(ring.irregular, index)},
                     {"flattest", dioptres(ring.flattest, index)}, {"steepest", dioptres(ring.steepest, index)}};
  }
  return json;
}

std::string ringText(const RingCurvature& ring, double index) {
  const auto line = [&](const char* name, const auto& figure) {
    return fmt::format(
        "{}: mean {}; regular part {} at {:.0f} and {} at {:.0f} degrees, irregular {}; meridians from {} at {:.0f} to "
        "{} at {:.0f} degrees\n",
        name, figure(ring.mean), figure(ring.flat), ring.flatAngle * kDegrees, figure(ring.steep),
        ring.steepAngle * kDegrees, figure(ring.irregular), figure(ring.flattest), ring.flattestAngle * kDegrees,
        figure(ring.steepest), ring.steepestAngle * kDegrees);
  };
  std::string text = line("axial curvature on the ring", [](double curvature) { return number(curvature); });
  if (index != 1) {
    text += line("  power in dioptres",
                 [&](double curvature) { return fmt::format("{:.2f}", dioptres(curvature, index)); });
  }
  return text;
}

}  // namespace strak::cli
