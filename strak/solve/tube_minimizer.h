#pragma once
//
// A convex quadratic problem with the refined points of a spline kept in balls: the inner problem of exact fairing.

#include <Eigen/SparseCholesky>
#include <vector>

#include "strak/solve/point_matrix.h"

namespace strak {

// A row a point, at most three columns.
using Points = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// One of them; no heap.
using TubePoint = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, 3>;

// One point of the refined difference: sum of coefficient * displacement of the point.
struct TubeRow {
  std::vector<Eigen::Index> points;
  std::vector<double> coefficients;

  // The refined point of the displacements `y`.
  TubePoint apply(const Points& y) const;
};

// The largest |row| of the displacements `y`; zero without rows.
double largestRow(const std::vector<TubeRow>& rows, const Points& y);

// Minimises q(y) = (y - y0) . H (y - y0) / 2 + g . (y - y0) over displacements y (a row a point) subject to
// |row(y)| <= radius for every row. H must be positive definite.
//
// Method: primal-dual interior point with Mehrotra's predictor and corrector on the constraints radius^2 - |row(y)|^2
// >= 0; one sparse Cholesky factor an iteration, 10 to 25 iterations whatever the number of rows that are active.
// Source: Mehrotra, "On the implementation of a primal-dual interior point method" (1992); Nocedal, Wright, "Numerical
// Optimization", chapter 19.
class TubeMinimizer {
 public:
  // The pattern of H must hold each row's points as a clique. An infinite radius means no constraint.
  TubeMinimizer(std::vector<TubeRow> rows, double radius, const PointMatrix& pattern);

  struct Result {
    Points y;        // feasible: |row(y)| <= radius up to rounding
    double gap = 0;  // of q, estimated by the complementarity
    int factorizations = 0;
    bool solved = true;  // false: H is not positive definite; y = y0
  };

  // y0 must be feasible. Stops once the gap is below `accuracy`, in units of q, and below 1e-4 of what q fell
  // (or a hundredth of `accuracy`).
  Result minimize(const PointMatrix& h, const Points& g, const Points& y0, double accuracy);

  const std::vector<TubeRow>& rows() const { return rows_; }
  double radius() const { return radius_; }

 private:
  Result minimizeFreely(const PointMatrix& h, const Points& g, const Points& y0);

  std::vector<TubeRow> rows_;
  double radius_;
  PointMatrix matrix_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower> factor_;
};

}  // namespace strak
