#pragma once
//
// Bezier patches of one, two or three directions and what bounds them: the pieces that certificates are made of.
// Only convex combinations are formed, so rounding errors stay a known multiple of the largest control point.

#include <Eigen/Core>
#include <array>

#include "strak/spline/spline.h"

namespace strak {

// Control points (rows; the last direction fastest) of a Bezier patch on a box. A rational patch is homogeneous, its
// last column the weight.
template <int D>
struct BezierPatch {
  std::array<int, D> degrees{};
  bool rational = false;
  Net points;
  std::array<double, D> from{}, to{};

  // max |P_i| / w_i over the control points: no point of the patch has a larger norm.
  double bound() const;

  // The largest norm at a corner of the box, where a control point lies on the patch.
  struct Corner {
    double norm = 0;
    std::array<double, D> place{};
  };
  Corner farthestCorner() const;

  // Corner number 0 .. 2^D - 1; bit k is set at the high end of direction k.
  Corner corner(unsigned number) const;

  // The direction in which the patch is farthest from being linear; -1 if it is linear in each one.
  int mostBent() const;

  // The two halves along a direction (de Casteljau).
  std::array<BezierPatch, 2> halves(int direction) const;
};

// The matrix that takes the p + 1 control points of a knot span to the Bezier points of the same polynomial on [from,
// to], a part of the span: (p + 1) x (p + 1), entries >= 0. Row j is the blossom at (from, ..., from, to, ..., to), j
// times to.
Eigen::MatrixXd spanToBezier(const KnotVector& knots, Index span, double from, double to);

// The matrix that raises the degree of Bezier points.
Eigen::MatrixXd bezierElevation(int degree, int raised);

// The tensor product of the maps applied to a block of control points (sizes: the columns of the maps).
template <int D>
Net applyMaps(const std::array<const Eigen::MatrixXd*, D>& maps, const Net& block);

// The control points of the product of two scalar- or vector-valued Bezier nets of the given degrees (columns times the
// single column of `factor`).
template <int D>
Net bezierProduct(const Net& points, const std::array<int, D>& degrees, const Net& factor,
                  const std::array<int, D>& factorDegrees);

}  // namespace strak
