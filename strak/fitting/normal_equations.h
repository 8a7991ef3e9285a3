#pragma once
//
// Normal equations of least squares with B-splines, in one pass over the points and in the net's sparsity.
//
// In a knot cell the products of two basis functions are polynomials of twice the degree: it is enough to sum the
// cell's moments w T_i(s) T_j(t), 49 numbers for bicubic cells instead of the 136 of the local matrix, and to make the
// matrix of them once, at the end. Memory grows with the net, not with the points, which may come block by block.
// Source: (2.6) and (5.11) of Hoschek and Juettler; the moments are ours.

#include "strak/fitting/cell_points.h"
#include "strak/solve/net_matrix.h"

namespace strak {

// Curves are nets of 1 x n in a NetMatrix.
template <int D>
std::array<Index, 2> netSizes(const std::array<KnotVector, D>& knots);
template <int D>
std::array<int, 2> netReach(const std::array<KnotVector, D>& knots);

template <int D>
class NormalEquations {
 public:
  // For splines on `knots` with `columns` coordinates. Throws InvalidInput for degrees above 31.
  NormalEquations(const std::array<KnotVector, D>& knots, Index columns);

  // Adds points; those outside the domain are counted and left out. The sums do not depend on the number of threads nor
  // on how the points are divided into blocks. Some tens of nanoseconds a point on one thread. Throws InvalidInput as
  // CellSweep::sweep does.
  void add(const FitPoints<D>& points);

  Index count() const { return count_; }      // of the points inside the domain
  Index measured() const;                     // those of them whose weight is not zero
  Index outside() const { return outside_; }  // ... and outside

  // sum w, sum w |z|^2, and with B(u) the basis functions at the points: sum w B B^T, sum w B z^T (a row a control
  // point).
  struct Sums {
    double weight = 0, squares = 0;
    NetMatrix matrix;
    Net right;
  };
  // Cost O(cells (p + 1)^2 (q + 1)^3).
  Sums sums() const;

 private:
  CellSweep sweep_;
  std::array<Index, 2> sizes_;
  std::array<int, 2> reach_;
  std::vector<double> cells_, squares_;  // squares by strips
  std::vector<Index> measured_;          // by strips
  Index count_ = 0, outside_ = 0;
};

// How far points are from a spline at their parameters, in one pass.
template <int D>
class FitErrors {
 public:
  // Errors up to `tolerance` count as inside.
  FitErrors(const Spline<D>& spline, double tolerance);

  // As NormalEquations::add.
  void add(const FitPoints<D>& points);

  struct Cell {
    Index count = 0, outside = 0;  // points, and those with a larger error than the tolerance
    double max = 0;
    // Sums of the 1st to 4th powers of the errors of functions (z - f, without weights).
    std::array<double, 4> powers{};
    // Sarle's coefficient (skewness^2 + 1) / kurtosis: 1 / 3 for normal errors, 5 / 9 for evenly spread ones, 1 if they
    // have only two values. 0 if there are fewer than 12 points, no errors,
    // or so skew errors that of two groups one would have less than 20 % of the points: outliers are not a group.
    double bimodality() const;
  };
  Index count() const;
  Index outsideDomain() const { return outside_; }
  Index outsideTolerance() const;
  double weight() const;   // sum w
  double squares() const;  // sum w |error|^2
  double max() const;
  // The parameters of the largest error and the number of the point, counted from 0 over all blocks.
  struct Worst {
    std::array<double, D> parameters{};
    Index point = 0;
    double error = -1;
  };
  Worst worst() const;
  // By knot cells, the last direction fastest.
  const std::vector<Cell>& cells() const { return cells_; }
  // sum w B (z - X)^T: what the normal equations of a correction have on their right side.
  Net right() const;

 private:
  struct Strip {
    double weight = 0, squares = 0;
    Worst worst;
  };
  CellSweep sweep_;
  double tolerance_;
  Index rows_ = 0;                    // control points
  std::vector<double> coefficients_;  // of the pieces, strip by strip
  std::vector<double> moments_;
  std::vector<Cell> cells_;
  std::vector<Strip> strips_;
  Index seen_ = 0, outside_ = 0;
  std::array<Index, 2> sizes_;
};

}  // namespace strak
