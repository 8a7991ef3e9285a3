#pragma once
//
// The exact fairness functionals of a curve of the plane or of space, linearised for Gauss-Newton steps: bending
// int k^2 ds, curvature variation int |D_s K|^2 ds, and two helpers: how uneven the parameter speed became, and how far
// the curvature runs the wrong way where its direction is prescribed.
//
// K = k N is the curvature vector and D_s its normal derivative: |D_s K|^2 = (dk/ds)^2 + k^2 torsion^2, in the plane
// (dk/ds)^2 (Moreton and Sequin's minimum variation curve); in space it is smooth where k passes through zero, which
// dk/ds is not, and bounds it. Where the curvature may jump at a knot the squared jump over the mean length of the
// neighbouring spans is added, or curves of degree 2 and Hermite cubics would have kinks of curvature for free.

#include <utility>
#include <vector>

#include "strak/solve/block_matrix.h"
#include "strak/spline/spline.h"

namespace strak {

// Displacements of control points as combinations of fewer unknown points: row i lists (unknown, coefficient) of
// control point i; an empty row is a held point.
struct PointMap {
  Index unknowns = 0;
  std::vector<std::vector<std::pair<Index, double>>> rows;

  // `y`: three numbers an unknown; a row of three a control point.
  Net apply(const Eigen::VectorXd& y) const;
};

struct CurveEnergyValues {
  double bending = 0;    // int |K|^2 ds; 1 / length
  double variation = 0;  // int |D_s K|^2 ds plus jumps; 1 / length^3
  double sliding = 0;    // int (d eta / ds)^2 ds, eta the speed along the reference over its own; 1 / length
  double wrongWay = 0;   // int (max(0, -sign dk/ds) / (k0^2 + 1 / L^2))^2 ds, k0 and L of the reference; length
};

class CurveEnergy {
 public:
  // Functionals of curves that differ from `reference` in the places of their control points (weights stay), in the
  // unknowns of `map`. Throws InvalidInput unless the curve lies in the plane or in space and has a degree of at
  // least 2. `closed`: the ends meet, and a jump of curvature there counts too. Displacements `y` have three numbers an
  // unknown; a curve of the plane takes no notice of the third.
  CurveEnergy(const Curve& reference, const PointMap& map, bool closed);

  // The unknowns that each element couples, for patternOfCliques.
  std::vector<std::vector<int>> cliques() const;
  int dimension() const { return dimension_; }
  double length() const { return length_; }                              // of the reference
  const std::vector<double>& parameters() const { return parameters_; }  // of the quadrature, ascending

  // The wanted sign of dk/ds (-1, 0: free, 1) at every one of parameters(). Curvature is signed in the plane.
  void prescribe(std::vector<int> signs) { signs_ = std::move(signs); }

  // Of the reference displaced by `y`; infinite where the curve stands still.
  CurveEnergyValues values(const Eigen::VectorXd& y) const;

  // H = 2 J'J and the gradient of sum of weight * functional at `y`. In the plane the third coordinates are on their
  // own, each as stiff as its point's other two in the mean, with gradient zero.
  void linearize(const Eigen::VectorXd& y, const CurveEnergyValues& weights, BlockMatrix& h,
                 Eigen::VectorXd& gradient) const;

 private:
  struct Place {
    double weight = 0;      // of the quadrature, in the parameter
    Eigen::MatrixXd basis;  // three rows: first to third derivative (of a jump: first, second left, second right)
    Eigen::Matrix3d jet =
        Eigen::Matrix3d::Zero();  // the same of the reference, a row each (the third column zero in the plane)
    // d eta / ds = slide . X'' + slideChange . X'
    Eigen::Vector3d slide = Eigen::Vector3d::Zero(), slideChange = Eigen::Vector3d::Zero();
    double speed = 0, scale = 0;  // |X'| and k0^2 + 1 / L^2 of the reference
  };
  struct Element {
    std::vector<int> points;  // ascending
    std::vector<Place> places;
    std::size_t first = 0;  // number of its first place among all
    bool jump = false;
  };

  template <int Dim>
  CurveEnergyValues valuesIn(const Eigen::VectorXd& y) const;
  template <int Dim>
  void linearizeIn(const Eigen::VectorXd& y, const CurveEnergyValues& weights, BlockMatrix& h,
                   Eigen::VectorXd& gradient) const;
  static Eigen::Matrix3d jetAt(const Element& element, const Place& place, const Eigen::VectorXd& y);
  void addJump(const Curve& reference, const PointMap& map, Index left, Index right);

  int dimension_ = 2;
  double length_ = 0;
  std::vector<Element> elements_;
  std::vector<double> parameters_;
  std::vector<int> signs_;
};

}  // namespace strak
