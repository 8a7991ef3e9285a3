#include "strak/metrology/orthotomic.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "strak/base/error.h"
#include "strak/metrology/piece.h"
#include "strak/spline/evaluate.h"

namespace strak {

namespace {

void requirePlane(const Curve& curve) {
  if (curve.pointDimension() != 2)
    throw InvalidInput("k-orthotomics are drawn of curves in the plane (two coordinates)");
}

}  // namespace

Orthotomic orthotomic(const Curve& curve, const Eigen::Vector2d& pole, double k, Index samplesPerSpan) {
  requirePlane(curve);
  if (!std::isfinite(k) || k == 0 || !pole.allFinite() || samplesPerSpan < 1) {
    throw InvalidInput("a k-orthotomic needs a finite pole, a factor k that is not zero, and samples on every span");
  }
  Orthotomic result{pole, k, {}, {}, {}, {}};
  CurveJet jet;
  double before = 0;
  for (const Index span : curve.knots(0).spans()) {
    const CurvePiece piece(curve, span);
    for (Index i = 0; i <= samplesPerSpan; ++i) {
      const double u =
          std::lerp(piece.from(), piece.to(), static_cast<double>(i) / static_cast<double>(samplesPerSpan));
      piece.at(u, 2, jet);
      const Eigen::Vector2d tangent = jet[1].head<2>(), x = jet[0].head<2>();
      const double speed = tangent.norm();
      if (!(speed > 0)) continue;
      const Eigen::Vector2d normal(-tangent.y() / speed, tangent.x() / speed);
      const double bend = tangent.x() * jet[2].y() - tangent.y() * jet[2].x();
      if (bend * before < 0) result.cusps.push_back(u);
      if (bend != 0) before = bend;
      result.parameters.push_back(u);
      result.curve.push_back(x);
      result.points.emplace_back(pole + k * (x - pole).dot(normal) * normal);
    }
  }
  return result;
}

Eigen::Vector2d suggestedPole(const Curve& curve) {
  requirePlane(curve);
  const Net net = curve.euclideanNet();
  const Eigen::Vector2d low = net.colwise().minCoeff().transpose(), size = net.colwise().maxCoeff().transpose() - low;
  constexpr int kPlaces = 200, kGrid = 12;
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> tangents;  // point and unit normal
  for (int i = 0; i <= kPlaces; ++i) {
    const Net d =
        derivatives<1>(curve, {std::lerp(curve.knots(0).from(), curve.knots(0).to(), i / double{kPlaces})}, 1);
    const Eigen::Vector2d tangent = d.row(1).transpose();
    if (tangent.norm() > 0) {
      tangents.emplace_back(d.row(0).transpose(), Eigen::Vector2d(-tangent.y(), tangent.x()).normalized());
    }
  }
  Eigen::Vector2d best = low + size / 2;
  double farthest = -1;
  const double margin = std::max(size.x(), size.y());
  for (int i = 0; i <= kGrid; ++i) {
    for (int j = 0; j <= kGrid; ++j) {
      const Eigen::Vector2d part(i / double{kGrid}, j / double{kGrid});
      const Eigen::Vector2d pole =
          low - Eigen::Vector2d::Constant(margin / 2) + part.cwiseProduct(size + Eigen::Vector2d::Constant(margin));
      double least = std::numeric_limits<double>::infinity();
      for (const auto& [x, normal] : tangents) least = std::min(least, std::abs((x - pole).dot(normal)));
      if (least > farthest) {
        farthest = least;
        best = pole;
      }
    }
  }
  return best;
}

}  // namespace strak
