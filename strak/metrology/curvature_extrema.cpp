#include "strak/metrology/curvature_extrema.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "strak/base/error.h"
#include "strak/metrology/piece.h"
#include "strak/metrology/plane_of_points.h"

namespace strak {

namespace {

struct Samples {
  std::vector<CurvatureTurn> turns;
  double length = 0;
  bool closed = false;
};

// The curvatures of all spans from their own sides, ends included.
Samples sample(const Curve& curve, Index perSpan) {
  Samples samples;
  std::optional<Eigen::Vector3d> normal;
  if (curve.pointDimension() == 2) {
    normal = Eigen::Vector3d::UnitZ();
  } else if (const auto plane = planeOfPoints(curve.euclideanNet())) {
    normal = plane->normal();
  }
  CurveJet first, last, jet;
  bool any = false;
  Eigen::Vector3d before;
  for (const Index span : curve.knots(0).spans()) {
    const CurvePiece piece(curve, span);
    for (Index i = 0; i <= perSpan; ++i) {
      const double u = std::lerp(piece.from(), piece.to(), static_cast<double>(i) / static_cast<double>(perSpan));
      piece.at(u, 2, jet);
      if (!any) first = jet;
      if (any) samples.length += (jet[0] - before).norm();
      before = jet[0];
      any = true;
      const double speed = jet[1].norm();
      const Eigen::Vector3d bend = jet[1].cross(jet[2]);
      const double curvature = (normal ? bend.dot(*normal) : bend.norm()) / (speed * speed * speed);
      if (std::isfinite(curvature)) samples.turns.push_back({u, curvature});
    }
  }
  last = jet;
  // Ends that meet with one direction: the curve runs on.
  constexpr double kMeet = 1e-9, kParallel = 1e-6;
  samples.closed = (last[0] - first[0]).norm() <= kMeet * samples.length &&
                   (last[1].normalized() - first[1].normalized()).norm() <= kParallel;
  return samples;
}

double relativeSwing(double a, double b, double length) {
  return std::abs(a - b) / std::max({std::abs(a), std::abs(b), 1 / length});
}

// The zigzag of a sequence: a turn counts once the value has swung back from it by more than the threshold.
std::vector<CurvatureTurn> zigzag(const std::vector<CurvatureTurn>& values, double length, double threshold) {
  std::vector<CurvatureTurn> turns;
  if (values.empty()) return turns;
  CurvatureTurn low = values.front(), high = values.front();
  int rising = 0;
  for (const CurvatureTurn& value : values) {
    if (value.curvature > high.curvature) high = value;
    if (value.curvature < low.curvature) low = value;
    const bool rose =
        value.curvature > low.curvature && relativeSwing(value.curvature, low.curvature, length) > threshold;
    const bool fell =
        value.curvature < high.curvature && relativeSwing(value.curvature, high.curvature, length) > threshold;
    if (rising >= 0 && fell) {
      if (rising > 0) turns.push_back(high);
      rising = -1;
      low = value;
    } else if (rising <= 0 && rose) {
      if (rising < 0) turns.push_back(low);
      rising = 1;
      high = value;
    }
  }
  return turns;
}

// Closed curves are read from their sharpest place, which is a turn whatever else there is.
std::vector<CurvatureTurn> cyclicZigzag(std::vector<CurvatureTurn> values, double length, double threshold) {
  const auto sharpest = std::max_element(values.begin(), values.end(), [](const auto& a, const auto& b) {
    return std::abs(a.curvature) < std::abs(b.curvature);
  });
  const CurvatureTurn start = *sharpest;
  std::rotate(values.begin(), sharpest, values.end());
  values.push_back(start);
  auto turns = zigzag(values, length, threshold);
  if (turns.empty()) return turns;
  turns.push_back(start);
  std::sort(turns.begin(), turns.end(), [](const auto& a, const auto& b) { return a.parameter < b.parameter; });
  return turns;
}

}  // namespace

CurvatureProfile curvatureProfile(const Curve& curve, const CurvatureExtremaOptions& options) {
  if (!(options.threshold > 0) || options.samplesPerSpan < 2) {
    throw InvalidInput("curvature extrema need a threshold above zero and at least 2 samples a span");
  }
  const Samples samples = sample(curve, options.samplesPerSpan);
  CurvatureProfile profile;
  profile.length = samples.length;
  profile.closed = samples.closed;
  if (samples.turns.empty() || !(samples.length > 0)) return profile;
  profile.begin = samples.turns.front();
  profile.end = samples.turns.back();
  profile.turns = profile.closed ? cyclicZigzag(samples.turns, samples.length, options.threshold)
                                 : zigzag(samples.turns, samples.length, options.threshold);
  return profile;
}

Index countCurvatureExtrema(const Curve& curve, const CurvatureExtremaOptions& options) {
  return curvatureProfile(curve, options).extrema();
}

CurvatureProfile mostSignificant(CurvatureProfile profile, Index count) {
  auto& turns = profile.turns;
  // Logarithmic away from zero: a nose does not outweigh everything, a change of sign counts on both sides.
  const auto bent = [&](const CurvatureTurn& turn) { return std::asinh(turn.curvature * profile.length); };
  const auto swing = [&](const CurvatureTurn& a, const CurvatureTurn& b) { return std::abs(bent(a) - bent(b)); };
  while (profile.extrema() > std::max<Index>(count, 0)) {
    const std::size_t n = turns.size();
    double least = std::numeric_limits<double>::infinity();
    std::size_t place = 0;  // between turns place - 1 and place; 0 and n: the ends
    for (std::size_t i = 0; i <= n; ++i) {
      if (profile.closed && i == n) break;
      const CurvatureTurn& a = i > 0 ? turns[i - 1] : (profile.closed ? turns[n - 1] : profile.begin);
      const CurvatureTurn& b = i < n ? turns[i] : profile.end;
      if (swing(a, b) < least) {
        least = swing(a, b);
        place = i;
      }
    }
    const auto at = [&](std::size_t i) { return turns.begin() + static_cast<std::ptrdiff_t>(i); };
    if (place > 0 && place < n) {
      turns.erase(at(place - 1), at(place + 1));
    } else if (profile.closed) {
      turns.erase(at(n - 1));
      turns.erase(turns.begin());
    } else if (place == 0) {
      profile.begin.curvature = turns.front().curvature;
      turns.erase(turns.begin());
    } else {
      profile.end.curvature = turns.back().curvature;
      turns.pop_back();
    }
  }
  return profile;
}

int direction(const CurvatureProfile& profile, double parameter) {
  const auto& turns = profile.turns;
  const auto sign = [](double from, double to) { return to > from ? 1 : to < from ? -1 : 0; };
  if (turns.empty()) return profile.closed ? 0 : sign(profile.begin.curvature, profile.end.curvature);
  const auto next = std::upper_bound(turns.begin(), turns.end(), parameter,
                                     [](double u, const CurvatureTurn& turn) { return u < turn.parameter; });
  const CurvatureTurn& from = next != turns.begin() ? *(next - 1) : (profile.closed ? turns.back() : profile.begin);
  const CurvatureTurn& to = next != turns.end() ? *next : (profile.closed ? turns.front() : profile.end);
  return sign(from.curvature, to.curvature);
}

}  // namespace strak
