#pragma once
//
// A convex quadratic problem with the refined points of a spline kept in balls: the inner problem of exact fairing.

#include <Eigen/SparseCholesky>
#include <vector>

#include "strak/solve/point_matrix.h"

namespace strak {

// A row of points: a matrix with a row a point.
using Points = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// One point of the refined difference: sum of coefficient * displacement of the point.
struct TubeRow {
  std::vector<Eigen::Index> points;
  std::vector<double> coefficients;

  // The refined point of the displacements `y`.
  Eigen::RowVectorXd apply(const Points& y) const;
};

// The largest |row| of the displacements `y`; zero without rows.
double largestRow(const std::vector<TubeRow>& rows, const Points& y);

// Minimises q(y) = (y - y0) . H (y - y0) / 2 + g . (y - y0) over displacements y (a row a point) subject to
// |row(y)| <= radius for every row.
//
// Method: augmented Lagrangian; each inner problem is convex with a continuous gradient, solved by Newton's method with
// the generalised Hessian (exact sparse Cholesky) and a line search. Multipliers are kept from solve to solve: a
// sequence of similar problems takes few factorisations each. Source: Rockafellar, "Augmented Lagrangians and
// applications of the proximal point algorithm" (1976); Qi, Sun, "A nonsmooth version of Newton's method" (1993).
class TubeMinimizer {
 public:
  // The pattern of H must hold each row's points as a clique. An infinite radius means no constraint.
  TubeMinimizer(std::vector<TubeRow> rows, double radius, const PointMatrix& pattern);

  struct Result {
    Points y;           // feasible: |row(y)| <= radius up to rounding
    double excess = 0;  // by how many parts of the radius the rows overstepped before they were scaled back
    int factorizations = 0;
    bool solved = true;  // false: H is not positive definite; y = y0
  };

  // y0 must be feasible. Stops once the rows overstep by less than `accuracy` of the radius.
  Result minimize(const PointMatrix& h, const Points& g, const Points& y0, double accuracy = 1e-4);

  const std::vector<TubeRow>& rows() const { return rows_; }
  double radius() const { return radius_; }

 private:
  struct State;
  bool newton(const PointMatrix& h, const Points& g, const Points& y0, State& state);
  double lagrangian(const PointMatrix& h, const Points& g, const Points& y0, const Points& y, Points* gradient) const;
  void addCurvature(const Points& y, PointMatrix& matrix) const;

  std::vector<TubeRow> rows_;
  double radius_;
  Points multipliers_;
  Eigen::VectorXd stiffness_;  // of each row's penalty
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower> factor_;
};

}  // namespace strak
