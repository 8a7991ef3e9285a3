#pragma once
//
// B-spline curves (D = 1), surfaces (2) and volumes (3) as plain values.

#include <array>
#include <vector>

#include "strak/spline/knot_vector.h"

namespace strak {

// A control net: a row a control point, any number of columns. Row-major over (i, j, k), the last index fastest.
using Net = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Point = Eigen::RowVectorXd;

// X(u) = sum over (i, j, k) of N_i(u) N_j(v) N_k(w) d_ijk. A rational spline keeps homogeneous points: its last column
// is the weight w > 0 and the others are w times the point.
template <int D>
class Spline {
  static_assert(D >= 1 && D <= 3);

 public:
  static constexpr int kDirections = D;
  using Sizes = std::array<Index, D>;
  using Parameter = std::array<double, D>;
  using Knots = std::array<KnotVector, D>;
  using Directions = std::array<int, D>;
  using Grid = std::array<std::vector<double>, D>;  // parameters per direction

  Spline() = default;

  // Throws InvalidInput if the net's rows do not match the knots, a number is not finite, or a weight is not positive.
  Spline(std::array<KnotVector, D> knots, Net net, bool rational = false);

  const KnotVector& knots(int direction) const { return knots_[static_cast<std::size_t>(direction)]; }
  const std::array<KnotVector, D>& knots() const { return knots_; }
  int degree(int direction) const { return knots(direction).degree(); }
  Index size(int direction) const { return knots(direction).size(); }
  Sizes sizes() const;
  bool isRational() const { return rational_; }
  Index pointDimension() const { return net_.cols() - (rational_ ? 1 : 0); }  // of the points in space

  const Net& net() const { return net_; }
  Eigen::Ref<Net> net() { return net_; }  // the values may change, the shape may not

  // Row of control point (i, j, k) in the net.
  Index row(const Sizes& index) const;

  // Control points as points of space: the net itself, or divided by the weights.
  Net euclideanNet() const;

  bool operator==(const Spline& other) const {
    return knots_ == other.knots_ && rational_ == other.rational_ && net_.rows() == other.net_.rows() &&
           net_.cols() == other.net_.cols() && net_ == other.net_;
  }

 private:
  std::array<KnotVector, D> knots_;
  Net net_ = Net::Zero(1, 0);
  bool rational_ = false;
};

using Curve = Spline<1>;
using Surface = Spline<2>;
using Volume = Spline<3>;

extern template class Spline<1>;
extern template class Spline<2>;
extern template class Spline<3>;

// "u", "v", "w".
const char* directionName(int direction);

}  // namespace strak
