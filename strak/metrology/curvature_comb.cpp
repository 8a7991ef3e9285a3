#include "strak/metrology/curvature_comb.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "strak/base/error.h"
#include "strak/metrology/curvature.h"
#include "strak/metrology/piece.h"

namespace strak {

namespace {

// Calls tooth(span, u) along the spans: both ends of each span only where the curvature may jump (multiplicity above
// degree - 2), else the end of one span is left to the next.
template <class Tooth>
void alongSpans(const KnotVector& knots, Index samplesPerSpan, const Tooth& tooth) {
  if (samplesPerSpan < 1) {
    throw InvalidInput(fmt::format("{} samples a span are too few for a comb: give at least 1", samplesPerSpan));
  }
  const auto spans = knots.spans();
  for (std::size_t s = 0; s < spans.size(); ++s) {
    const double from = knots[spans[s]], to = knots[spans[s] + 1];
    const bool jumps = s + 1 == spans.size() || spans[s + 1] - spans[s] > knots.degree() - 2;
    for (Index i = 0; i < samplesPerSpan + (jumps ? 1 : 0); ++i) {
      tooth(spans[s], std::lerp(from, to, static_cast<double>(i) / static_cast<double>(samplesPerSpan)));
    }
  }
}

void append(CurvatureComb& comb, double u, const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double k) {
  comb.parameters.push_back(u);
  comb.points.push_back(point);
  comb.normals.push_back(normal);
  comb.curvature.push_back(k);
}

}  // namespace

CurvatureComb curvatureComb(const Curve& curve, Index samplesPerSpan) {
  const bool plane = curve.pointDimension() == 2;
  CurvatureComb comb;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();  // the normal of the tooth before
  CurveJet jet;
  alongSpans(curve.knots(0), samplesPerSpan, [&](Index span, double u) {
    CurvePiece(curve, span).at(u, 2, jet);
    const double speed = jet[1].norm();
    if (!(speed > 0)) return;
    const Eigen::Vector3d tangent = jet[1] / speed;
    const Eigen::Vector3d bend = (jet[2] - jet[2].dot(tangent) * tangent) / (speed * speed);
    if (plane) {
      const Eigen::Vector3d normal(-tangent[1], tangent[0], 0);
      append(comb, u, jet[0], normal, bend.dot(normal));
      return;
    }
    const double k = bend.norm();
    if (k > 0) {
      last = bend / k;
    } else {
      last -= last.dot(tangent) * tangent;
      last = last.squaredNorm() > 0 ? last.normalized() : tangent.unitOrthogonal();
    }
    append(comb, u, jet[0], last, k);
  });
  return comb;
}

CurvatureComb curvatureComb(const Surface& surface, int direction, double value, Index samplesPerSpan) {
  if (direction != 0 && direction != 1) {
    throw InvalidInput(fmt::format("there is no direction {}: give 0 (u) or 1 (v)", direction));
  }
  const KnotVector& fixed = surface.knots(direction);
  if (!(value >= fixed.from() && value <= fixed.to())) {
    throw InvalidInput(fmt::format("the isoline {} = {} lies outside the domain [{}, {}]: move it inside",
                                   directionName(direction), value, fixed.from(), fixed.to()));
  }
  const Index fixedSpan = fixed.findSpan(value);
  CurvatureComb comb;
  SurfaceJet jet;
  alongSpans(surface.knots(1 - direction), samplesPerSpan, [&](Index span, double t) {
    const bool alongV = direction == 0;
    const SurfacePiece piece(surface, alongV ? fixedSpan : span, alongV ? span : fixedSpan);
    piece.at(alongV ? value : t, alongV ? t : value, 2, jet);
    const Eigen::Vector3d& tangent = alongV ? jet[2] : jet[1];
    const Eigen::Vector3d& second = alongV ? jet[5] : jet[3];
    if (const auto normal = unitNormal(jet[1], jet[2]))
      append(comb, t, jet[0], *normal, second.dot(*normal) / tangent.squaredNorm());
  });
  return comb;
}

double combScale(const std::vector<CurvatureComb>& combs, double longestTooth) {
  double largest = 0;
  for (const CurvatureComb& comb : combs) {
    for (const double k : comb.curvature) largest = std::max(largest, std::abs(k));
  }
  return largest > 0 ? longestTooth / largest : 0;
}

}  // namespace strak
