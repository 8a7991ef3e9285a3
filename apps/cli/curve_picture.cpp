#include "apps/cli/curve_picture.h"

#include <fmt/format.h>

#include "apps/cli/values.h"
#include "strak/base/error.h"

namespace strak::cli {

namespace {

const Curve* firstCurve(const std::vector<Object>& objects) {
  for (const Object& object : objects) {
    if (!object.spline) continue;
    if (const auto* curve = std::get_if<Curve>(&*object.spline)) return curve;
  }
  return nullptr;
}

double coordinate(const std::string& option, const std::string& text) {
  const bool negative = !text.empty() && text[0] == '-';
  const double size = positiveNumber(option, negative ? text.substr(1) : text, true);
  return negative ? -size : size;
}

}  // namespace

bool isCurvePicture(const std::string& kind) {
  return kind == "curvature-plot" || kind == "tolerance-band" || kind == "k-orthotomic";
}

std::string curvePicture(const std::string& kind, const std::vector<Object>& objects,
                         const std::vector<Object>& reference, const CurvePlotOptions& options) {
  const Curve* curve = firstCurve(objects);
  const Curve* before = firstCurve(reference);
  if (curve == nullptr) throw InvalidInput(fmt::format("--kind {} draws curves, and there is none", kind));
  if (kind == "k-orthotomic") return orthotomicSvg(*curve, options);
  if (kind == "curvature-plot") return curvaturePlotSvg(*curve, before, options);
  if (before == nullptr)
    throw InvalidInput("--kind tolerance-band compares with another file: name it with --reference");
  return tolerancePlotSvg(*curve, *before, options);
}

Eigen::Vector2d planePoint(const std::string& option, const std::string& text) {
  const auto comma = text.find(',');
  if (comma == std::string::npos) {
    throw InvalidInput(fmt::format("{} is '{}': give a point of the plane, X,Y", option, text));
  }
  return {coordinate(option, text.substr(0, comma)), coordinate(option, text.substr(comma + 1))};
}

}  // namespace strak::cli
