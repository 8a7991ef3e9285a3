#pragma once
//
// A spline prepared for evaluation at many parameters, in one go or one by one.
//
// Preparation takes O(net + spans p^3); after that a bi-quartic surface with second derivatives takes tens of
// nanoseconds a point on one thread. The derivatives are those of evaluate.h, in the same order.

#include "strak/spline/basis_table.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/quotient_rule.h"

namespace strak {

// Holds a copy of the control points (padded for the vector unit): later changes of the spline are not seen.
// A value; const use is thread-safe. `order` is the highest total order of derivatives, 0 to 3, else InvalidInput.
template <int D>
class Evaluator {
 public:
  explicit Evaluator(const Spline<D>& spline);

  int pointDimension() const { return columns_ - (rational_ ? 1 : 0); }
  const KnotVector& knots(int direction) const { return tables_[static_cast<std::size_t>(direction)].knots(); }

  // Writes derivativeCount(D, order) * pointDimension() numbers to out. Allocates nothing for degrees up to 15 and
  // nets of up to 4 columns.
  void derivatives(const std::array<double, D>& u, int order, double* out) const;

  // Many parameters, a row each. The second form writes into a matrix of parameters.rows() rows and derivativeCount *
  // pointDimension() columns and throws InvalidInput if it has another shape. Multi-threaded, the result does not
  // depend on the number of threads.
  Net derivativesAt(const Eigen::Ref<const Net>& parameters, int order) const;
  void derivativesAt(const Eigen::Ref<const Net>& parameters, int order, Eigen::Ref<Net> out) const;

  // All combinations of the parameters per direction, the last direction fastest. One direction after the other is
  // contracted, so a point costs little more than a point of a curve.
  using Parameters = std::array<std::vector<double>, D>;
  Net derivativesOnGrid(const Parameters& parameters, int order) const;
  void derivativesOnGrid(const Parameters& parameters, int order, Eigen::Ref<Net> out) const;

 private:
  struct alignas(32) PaddedPoint {
    double x[4];
  };
  struct GridLines;

  NetView view() const;
  Index rowLength(int order) const { return derivativeCount(D, order) * pointDimension(); }

  std::vector<BasisTable> tables_;
  typename Spline<D>::Sizes sizes_;
  int columns_;
  bool rational_;
  std::vector<PaddedPoint>
      points_;  // planes of 4 columns; one point of zeros behind, because vectors are read in pairs
  std::vector<QuotientRule<D>> quotient_;  // for order 0 .. 3 if rational
};

extern template class Evaluator<1>;
extern template class Evaluator<2>;
extern template class Evaluator<3>;

}  // namespace strak
