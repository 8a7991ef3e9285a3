#pragma once
//
// The knot cells of a curve or a surface with boxes around their points and their tangents: what a proof that images
// lie apart is made of.

#include <Eigen/Core>
#include <array>
#include <limits>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

using HomogeneousPoints = Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>;  // (x, y, z, 1) without weights

struct PointBox {
  using Vector = Eigen::Array3d;
  Vector low = Vector::Constant(std::numeric_limits<double>::infinity()), high = -low;

  void add(const Vector& p) {
    low = low.min(p);
    high = high.max(p);
  }
  void add(const PointBox& other) {
    low = low.min(other.low);
    high = high.max(other.high);
  }
  void grow(const Vector& by) {
    low -= by;
    high += by;
  }
  Vector middle() const { return (low + high) / 2; }
  Vector half() const { return (high - low) / 2; }
  double diameter() const { return (high - low).matrix().norm(); }
  bool meets(const PointBox& other) const { return (low <= other.high).all() && (other.low <= high).all(); }
};

// Boxes around the derivatives S_u, S_v of a piece; of a rational one around w S_u, w S_v.
template <int D>
using TangentBoxes = std::array<PointBox, D>;

// All numbers are of the spline moved to the origin. Curves of the plane have z = 0.
template <int D>
class BezierCells {
 public:
  using Cell = std::array<Index, D>;
  using Parameters = std::array<double, D>;

  // Cost O(points of the Bezier form). Multi-threaded.
  explicit BezierCells(const Spline<D>& spline);

  const Spline<D>& form() const { return form_; }  // the Bezier form
  Index count(std::size_t k) const { return static_cast<Index>(breaks_[k].size()) - 1; }
  double from(std::size_t k) const { return breaks_[k].front(); }
  double to(std::size_t k) const { return breaks_[k].back(); }
  double period(std::size_t k) const { return to(k) - from(k); }
  double at(std::size_t k, Index i) const { return breaks_[k][static_cast<std::size_t>(i)]; }
  std::size_t number(const Cell& cell) const;

  // Whether the two sides of a direction are one, to 1e-9 of the size; whether a side is one point; whether the spline
  // jumps at the beginning of a cell.
  bool isClosed(std::size_t k) const { return closed_[k]; }
  bool isPole(std::size_t k, bool high) const { return pole_[k][high]; }
  bool jumpsAt(std::size_t k, Index cell) const { return torn_[k][static_cast<std::size_t>(cell)] != 0; }

  double size() const { return size_; }          // of the net
  double rounding() const { return rounding_; }  // of a control point, in space

  const HomogeneousPoints& points(std::size_t number) const { return points_[number]; }
  const PointBox& box(std::size_t number) const { return boxes_[number]; }
  const TangentBoxes<D>& tangents(std::size_t number) const { return tangents_[number]; }

  // The same for Bezier points of a part of a cell; its lengths in parameters.
  PointBox boxOf(const HomogeneousPoints& points) const;
  TangentBoxes<D> tangentsOf(const HomogeneousPoints& points, const Parameters& lengths) const;
  // The Bezier points of the stretch from .. to (of 0 .. 1) in a direction, by de Casteljau.
  HomogeneousPoints part(HomogeneousPoints points, std::size_t k, double from, double to) const;

 private:
  void findSides();

  Spline<D> form_;
  std::array<std::vector<double>, D> breaks_;
  std::array<bool, D> closed_{};
  std::array<std::array<bool, 2>, D> pole_{};
  std::array<std::vector<std::uint8_t>, D> torn_;  // by breaks
  double size_ = 0, rounding_ = 0;
  std::vector<HomogeneousPoints> points_;
  std::vector<PointBox> boxes_;
  std::vector<TangentBoxes<D>> tangents_;
};

extern template class BezierCells<1>;
extern template class BezierCells<2>;

}  // namespace strak
