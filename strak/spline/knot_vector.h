#pragma once
//
// Knot vectors: a degree and a non-decreasing sequence of knots, clamped or not, uniform or not.

#include <Eigen/Core>
#include <vector>

namespace strak {

using Index = Eigen::Index;

// A degree p >= 0 and n + p + 1 knots U[0] <= ... <= U[n + p], n >= p + 1 the number of basis functions.
// The domain is [U[p], U[n]]; it is not empty. No knot has a multiplicity above p + 1. A plain value, checked once.
class KnotVector {
 public:
  // The line [0, 1] with degree 0.
  KnotVector();

  // Throws InvalidInput if the rules above are broken; `name` ("u", "v", ...) is used in the message.
  KnotVector(int degree, std::vector<double> knots, const char* name = "u");

  // `spans` equal spans on [from, to] with (degree + 1)-fold end knots.
  static KnotVector uniformClamped(int degree, Index spans, double from = 0, double to = 1);

  int degree() const { return degree_; }
  Index size() const { return static_cast<Index>(knots_.size()) - degree_ - 1; }  // number of basis functions
  const std::vector<double>& knots() const { return knots_; }
  double operator[](Index i) const { return knots_[static_cast<std::size_t>(i)]; }

  double from() const { return knots_[static_cast<std::size_t>(degree_)]; }
  double to() const { return knots_[static_cast<std::size_t>(size())]; }
  double length() const { return to() - from(); }

  // The knot span of u: the largest i in [p, n - 1] with U[i] <= u and U[i] < U[i + 1]; u outside the domain gives the
  // first or the last span. O(log n).
  Index findSpan(double u) const;

  // The indices i of the spans [U[i], U[i + 1]] inside the domain that have a positive length, ascending.
  std::vector<Index> spans() const;

  // Multiplicity of the value u among all knots (exact comparison).
  int multiplicity(double u) const;

  // The different knot values strictly inside the domain with their multiplicities, ascending.
  struct InnerKnot {
    double value;
    int multiplicity;
  };
  std::vector<InnerKnot> innerKnots() const;

  // Greville abscissae, the mean of p knots each: the control points of the function f(u) = u. Degree 0: mid-spans.
  std::vector<double> greville() const;

  bool isClamped() const;

  // The same knots mapped affinely to the domain [from, to]. Throws InvalidInput unless from < to.
  KnotVector rescaled(double from, double to) const;

  bool operator==(const KnotVector&) const = default;

 private:
  int degree_;
  std::vector<double> knots_;
};

// The knots that the basis functions alive inside [from, to] need, and the index of the first of these functions: the
// result's domain is [from, to]. Both ends must be knots of the domain, from < to; else InvalidInput.
struct ActiveKnots {
  KnotVector knots;
  Index first;
};
ActiveKnots activeKnots(const KnotVector& knots, double from, double to);

}  // namespace strak
