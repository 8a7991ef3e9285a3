#pragma once
//
// One polynomial (or rational) piece of a curve or a surface, evaluated from its own side also on its end knots.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

// Derivatives of a surface in space in the order of strak::derivatives: X, X_u, X_v, X_uu, X_uv, X_vv, X_uuu, ...
using SurfaceJet = std::array<Eigen::Vector3d, 10>;

// X, X', X'', X''' of a curve; a curve of the plane has z = 0.
using CurveJet = std::array<Eigen::Vector3d, 4>;

// The piece of a surface in space on a knot span in u and one in v (KnotVector::spans). Keeps a copy of the control
// points it needs and refers to the surface's knots: the surface must outlive it.
class SurfacePiece {
 public:
  // Throws InvalidInput unless the surface lies in space.
  SurfacePiece(const Surface& surface, Index spanU, Index spanV);

  double from(int direction) const { return knots(direction)[spans_[index(direction)]]; }
  double to(int direction) const { return knots(direction)[spans_[index(direction)] + 1]; }

  // Derivatives up to total order `order` <= 3 at any (u, v), also outside the piece, where it is continued; those
  // above are left as they are.
  void at(double u, double v, int order, SurfaceJet& jet) const;

  // The same at all combinations of the parameters; jets[i * vs.size() + j] belongs to (us[i], vs[j]).
  void grid(const std::vector<double>& us, const std::vector<double>& vs, int order,
            std::vector<SurfaceJet>& jets) const;

 private:
  static std::size_t index(int direction) { return static_cast<std::size_t>(direction); }
  const KnotVector& knots(int direction) const { return surface_->knots(direction); }
  void evaluate(const double* us, Index countU, const double* vs, Index countV, int order, SurfaceJet* jets) const;

  const Surface* surface_;
  std::array<Index, 2> spans_;
  Eigen::Vector3d origin_;
  Eigen::Matrix<double, 4, Eigen::Dynamic> points_;  // homogeneous, v fastest; the weight is 1 on polynomial pieces
};

// The piece of a curve of the plane or of space on a knot span.
class CurvePiece {
 public:
  // Throws InvalidInput unless the curve has 2 or 3 coordinates.
  CurvePiece(const Curve& curve, Index span);

  double from() const { return curve_->knots(0)[span_]; }
  double to() const { return curve_->knots(0)[span_ + 1]; }
  void at(double u, int order, CurveJet& jet) const;

 private:
  const Curve* curve_;
  Index span_;
  Eigen::Vector3d origin_;
  Eigen::Matrix<double, 4, Eigen::Dynamic> points_;
};

}  // namespace strak
