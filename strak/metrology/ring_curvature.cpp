#include "strak/metrology/ring_curvature.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "strak/base/error.h"
#include "strak/metrology/closest_point.h"
#include "strak/metrology/curvature.h"
#include "strak/spline/evaluate.h"

namespace strak {

namespace {

constexpr double kOnSurface = 1e-9;  // of the radius: how near the ring must come to the surface seen from above
constexpr double kSteep = 1e-6;      // cosine to the axis

double angleOf(double angle) {
  const double turned = std::fmod(angle, std::numbers::pi);
  return turned < 0 ? turned + std::numbers::pi : turned;
}

}  // namespace

RingCurvature ringCurvature(const Surface& surface, const RingOptions& options) {
  if (surface.pointDimension() != 3) throw InvalidInput("a ring can be measured on a surface in space only");
  if (!(options.radius > 0) || !std::isfinite(options.radius) || options.meridians < 8 || options.meridians % 2 != 0 ||
      !std::isfinite(options.centre[0]) || !std::isfinite(options.centre[1])) {
    throw InvalidInput(
        "a ring needs a finite centre, a radius above zero and an even number of at least 8 half meridians");
  }
  // Seen from above: a map of the plane onto itself, on which the ring's points are looked for.
  Net seen(surface.net().rows(), surface.isRational() ? 3 : 2);
  seen.leftCols(2) = surface.net().leftCols(2);
  if (surface.isRational()) seen.col(2) = surface.net().col(3);
  const Surface shadow(surface.knots(), std::move(seen), surface.isRational());
  const auto angle = [&](Index k) {
    return 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(options.meridians);
  };
  const ClosestPointFinder<2> finder(shadow);
  const double near = kOnSurface * (options.radius + std::hypot(options.centre[0], options.centre[1]));
  ClosestPoint<2> at;
  RingCurvature result;
  double cosine = 0, sine = 0;
  for (Index k = 0; k < options.meridians; ++k) {
    const double phi = angle(k);
    Point place(2);
    place << options.centre[0] + options.radius * std::cos(phi), options.centre[1] + options.radius * std::sin(phi);
    // Usually the next place is one Newton step away.
    if (k > 0) at = finder.findFrom(place, at.parameters);
    if (k == 0 || at.distance > near) at = finder.find(place);
    const Net d = derivatives<2>(surface, at.parameters, 1);
    const auto normal = unitNormal(d.row(1).transpose(), d.row(2).transpose());
    if (at.distance > near || !normal || std::abs(normal->z()) < kSteep) {
      throw InvalidInput(
          fmt::format("the ring of radius {:g} around ({:g}, {:g}) leaves the surface, or it is as steep as the axis "
                      "there, at {:.0f} "
                      "degrees: give a smaller ring, or another centre",
                      options.radius, options.centre[0], options.centre[1], phi * 180 / std::numbers::pi));
    }
    const double outwards = normal->x() * std::cos(phi) + normal->y() * std::sin(phi);
    const double up = normal->z();
    result.axial.push_back(std::copysign(1.0, up) * outwards / std::hypot(outwards, up) / options.radius);
    result.mean += result.axial.back();
    cosine += result.axial.back() * std::cos(2 * phi);
    sine += result.axial.back() * std::sin(2 * phi);
  }
  const auto n = static_cast<double>(options.meridians);
  result.mean /= n;
  cosine *= 2 / n;
  sine *= 2 / n;
  const double part = std::hypot(cosine, sine), most = std::atan2(sine, cosine) / 2;
  const bool bowl = result.mean < 0;
  result.steep = result.mean + (bowl ? -part : part);
  result.flat = result.mean + (bowl ? part : -part);
  result.steepAngle = angleOf(bowl ? most + std::numbers::pi / 2 : most);
  result.flatAngle = angleOf(result.steepAngle + std::numbers::pi / 2);
  for (Index k = 0; k < options.meridians; ++k) {
    const double regular = result.mean + cosine * std::cos(2 * angle(k)) + sine * std::sin(2 * angle(k));
    result.irregular += std::pow(result.axial[static_cast<std::size_t>(k)] - regular, 2) / n;
  }
  result.irregular = std::sqrt(result.irregular);
  const auto half = static_cast<std::size_t>(options.meridians / 2);
  for (std::size_t k = 0; k < half; ++k) {
    const double both = (result.axial[k] + result.axial[k + half]) / 2;
    if (k == 0 || std::abs(both) < std::abs(result.flattest)) {
      result.flattest = both;
      result.flattestAngle = angle(static_cast<Index>(k));
    }
    if (k == 0 || std::abs(both) > std::abs(result.steepest)) {
      result.steepest = both;
      result.steepestAngle = angle(static_cast<Index>(k));
    }
  }
  return result;
}

}  // namespace strak
