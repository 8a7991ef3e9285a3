#pragma once
//
// A convex quadratic function of points under balls on linear combinations of them: the inner problem of fairing inside
// a tolerance on a surface or a curve, where the combinations are the control points of the refined difference. Points
// of a plane have a third coordinate that is zero and coupled with nothing; it stays exactly zero.
//
// Method: primal-dual interior points with Nesterov and Todd's scaling and Mehrotra's correction, one sparse factor an
// iteration, from the start pulled into the balls. Source: Vandenberghe, "The CVXOPT linear and quadratic cone
// program solvers" (2010), sections 4 and 5. An augmented Lagrangian with semismooth Newton steps was tried first: as
// good where a ball or two are touched, 60 factors and more (750 on a race track of 1400 points) where hundreds are.

#include "strak/solve/block_matrix.h"
#include "strak/solve/nested_cholesky.h"

namespace strak {

// Row i demands |sum over k of weight[k] x[point[k]]| <= radius[i], k from start[i] to start[i + 1]. Points that share
// a row must be coupled in the matrix's pattern.
struct BallRows {
  std::vector<Eigen::Index> start{0};
  std::vector<int> point;
  std::vector<double> weight;
  std::vector<double> radius;

  Eigen::Index count() const { return static_cast<Eigen::Index>(radius.size()); }
  Eigen::VectorXd times(const Eigen::VectorXd& x) const;  // three numbers a row
  // The largest |row i of x| / radius[i]; 0 without rows.
  double largestRatio(const Eigen::VectorXd& x) const;
  // x in all balls: the points of rows that are too long drawn to zero, where every row holds; what is in no such row
  // stays.
  Eigen::VectorXd drawnIn(Eigen::VectorXd x) const;
};

struct HullProblem {
  const BlockMatrix* hessian = nullptr;     // A, positive definite
  Eigen::VectorXd linear;                   // b
  const BallRows* rows = nullptr;           // null or empty: no constraint
  const Eigen::VectorXd* offset = nullptr;  // three numbers a row, added to the rows' sums; null: none

  // The rows' sums with the offset, and the largest one by its radius.
  Eigen::VectorXd sums(const Eigen::VectorXd& x) const;
  double largestRatio(const Eigen::VectorXd& x) const;
};

struct HullOptions {
  double accuracy = 1e-5;  // of the value, absolute
  double firstGap = 10;    // some ten times what the value may fall
  int maxFactors = 60;
};

struct HullResult {
  bool solved = false;  // to the wished accuracy; if not, x is the best so far
  double value = 0;     // x^T A x / 2 + b^T x
  double gap = 0;       // the sum of the complementarity products: how far from the least value at most
  int factors = 0;
};

// Minimises x^T A x / 2 + b^T x. `x`, which must lie in all balls, is the start and the result; the result lies in them
// to a millionth of their radius. Cost: one factorisation where no ball is in the way, else some 8 to 25. Returns
// solved = false, with x as it was, if A is not positive definite.
HullResult minimizeInHull(const HullProblem& problem, NestedCholesky& factor, Eigen::VectorXd& x,
                          const HullOptions& options = {});

}  // namespace strak
