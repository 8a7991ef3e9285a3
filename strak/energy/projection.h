#pragma once
//
// The best approximation of splines on other knots, of any degree, in the mean square over the domain, with the ends of
// every line kept.
//
// For surfaces and volumes one direction is projected after the other: the L2 projection of a tensor product is the
// product of the projections. Source: the normal equations with exact Gram matrices (de Boor, A Practical Guide to
// Splines, ch. XIV).

#include <Eigen/SparseCholesky>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

// The integrals of A_i B_j over the common domain, A the basis on `a` (rows), B the one on `b`; exact but for rounding.
// Degrees and knots may differ. Cost O((a + b) degree^3).
Eigen::SparseMatrix<double> mixedGram(const KnotVector& a, const KnotVector& b);

// How many derivatives are kept at the two ends, the value included: 1 keeps the point, 2 the tangent, 3 the curvature.
struct KeptEnds {
  Index low = 0, high = 0;
};

// Places of a domain and the weights that make sums of values there integrals. Both ends are among them, with weight 0.
struct Samples {
  std::vector<double> places, weights;
};

// The ends, and a Gauss rule of `perCell` nodes between all neighbouring breaks of the two knot vectors.
Samples samplesBetween(const KnotVector& a, const KnotVector& b, int perCell);

// All basis functions at parameters in the domain, a row a parameter. Cost O(parameters degree^2).
Eigen::SparseMatrix<double> basisMatrix(const KnotVector& knots, const std::vector<double>& parameters);

// min over c of the integral of |sum c_i M_i - sum d_j N_j|^2, N the basis on `from`, M the one on `to`; what lies in
// the span of M is reproduced to rounding.
class Projection {
 public:
  // Both knot vectors must be clamped and have the same domain; no end can keep more than degree + 1 derivatives (more
  // are cut to that). Throws InvalidInput for other knots and if more is kept than there are control points; Failure if
  // the knots lie so unevenly that the equations are singular. Cost O((from + to) degree^3).
  Projection(const KnotVector& from, const KnotVector& to, KeptEnds ends = {});

  // Of any function, known at places: fromSize() is their number, `lines` of apply() has a row a place. The ends keep
  // their points. `to` as above, `samples` as samplesBetween() makes them.
  Projection(const Samples& samples, const KnotVector& to);

  Index fromSize() const { return mixed_.cols(); }
  Index toSize() const { return mixed_.rows(); }

  // `lines` has a row a control point on `from`; the columns are independent. Cost O(degree) a number.
  Net apply(const Eigen::Ref<const Net>& lines) const;

 private:
  void factor(const KnotVector& to);
  Net solve(const Eigen::Ref<const Net>& right, Net kept) const;

  Eigen::SparseMatrix<double> mixed_, gram_;  // integrals of M_i N_j and M_i M_j
  Eigen::MatrixXd low_, high_;                // the kept control points by the first and last ones of `from`
  Eigen::VectorXd scale_;                     // of the free unknowns: makes the diagonal 1
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>> factor_;
};

// The spline on other knots, `ends` one a direction. Rational ones are projected in homogeneous space; throws Failure
// if a weight would not stay positive, else as Projection does.
template <int D>
Spline<D> projectOnto(const Spline<D>& spline, const typename Spline<D>::Knots& knots,
                      const std::array<KeptEnds, static_cast<std::size_t>(D)>& ends);

// The best polynomial spline on `knots` (clamped, on the domain of `spline`) with the corners kept: a border depends on
// the border alone, so splines that share one still do. Polynomial splines are projected exactly, rational ones by
// values at Gauss nodes, as many in every cell as make the error of the sums small beside that of the approximation.
// Throws InvalidInput above 10^7 such values, else as Projection does.
template <int D>
Spline<D> polynomialOnto(const Spline<D>& spline, const typename Spline<D>::Knots& knots);

}  // namespace strak
