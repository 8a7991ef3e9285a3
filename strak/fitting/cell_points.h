#pragma once
//
// Points of a fit, sorted into the knot cells of a net block by block, so that each strip of cells is one task and its
// sums stay in the cache.
//
// Within a strip the points keep their order, so sums over them do not depend on the number of threads, nor on how the
// points were divided into blocks.

#include <functional>
#include <vector>

#include "strak/fitting/fit_kernels.h"
#include "strak/spline/spline.h"

namespace strak {

// A block of points, a row each: where in the domain (D columns) and what is measured there (1 column for functions, 2
// or 3 for points in space). `weights`: one number >= 0 a point, or empty: all 1. Only looked at, not kept.
template <int D>
struct FitPoints {
  Eigen::Ref<const Net> parameters;
  Eigen::Ref<const Net> values;
  Eigen::Ref<const Eigen::VectorXd> weights = Eigen::VectorXd();

  Index count() const { return parameters.rows(); }
};

// The spans of one direction: where they lie and the basis functions in them.
class FitSpans {
 public:
  explicit FitSpans(const KnotVector& knots);

  Index count() const { return static_cast<Index>(centres_.size()); }
  int degree() const { return degree_; }
  double from() const { return starts_.front(); }
  double to() const { return starts_.back(); }
  // The number of the span that holds u, which must lie in the domain.
  int find(double u) const;
  double local(int span, double u) const {
    return (u - centres_[static_cast<std::size_t>(span)]) * scales_[static_cast<std::size_t>(span)];
  }
  Index firstFunction(Index span) const { return first_[static_cast<std::size_t>(span)]; }
  // Row a: the Chebyshev coefficients of the span's a-th basis function, degree + 1 of them.
  const Net& functions(Index span) const { return functions_[static_cast<std::size_t>(span)]; }
  // Row a * (degree + 1) + b: those of the product of functions a and b, 2 degree + 1 of them.
  Net products(Index span) const;
  double start(Index span) const { return starts_[static_cast<std::size_t>(span)]; }

 private:
  int degree_;
  std::vector<double> starts_, centres_, scales_;
  std::vector<Index> first_;
  std::vector<Net> functions_;
  std::vector<int> buckets_;  // the last span that begins at or before the bucket
  double bucketScale_ = 0;
};

// The points of one block and strip, as a sweep hands them out.
struct StripOfPoints {
  Index strip = 0;
  fitkernels::StripPoints points{};
  const Index* numbers = nullptr;  // of the points in the block that was given
};

class CellSweep {
 public:
  // One or two directions; to a single one a second of degree 0 is added.
  CellSweep(const std::vector<KnotVector>& knots, Index columns);

  const FitSpans& spans(int direction) const { return spans_[static_cast<std::size_t>(direction)]; }
  const fitkernels::CellLayout& layout() const { return layout_; }
  Index strips() const { return spans_[0].count(); }
  Index cellsPerStrip() const { return spans_[1].count(); }

  // Calls `work` for every strip that has points: different strips at once, those of one strip one after another in the
  // order of the points. Returns how many points lie outside the domain; they are left out. Throws InvalidInput with
  // the point's number (counted from 1 + `countedBefore`) for numbers that are not finite or weights that are negative,
  // and for blocks of another shape.
  template <int D>
  Index sweep(const FitPoints<D>& points, Index countedBefore,
              const std::function<void(const StripOfPoints&)>& work) const;

 private:
  template <int D>
  Index sweepBlock(const FitPoints<D>& points, Index begin, Index count, Index countedBefore,
                   const std::function<void(const StripOfPoints&)>& work) const;

  std::vector<FitSpans> spans_;
  fitkernels::CellLayout layout_{};
};

}  // namespace strak
