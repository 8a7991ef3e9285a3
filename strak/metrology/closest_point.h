#pragma once
//
// The point of a curve or a surface that is closest to a given point.

#include <vector>

#include "strak/spline/spline.h"

namespace strak {

template <int D>
struct ClosestPoint {
  std::array<double, D> parameters{};
  Point point;
  double distance = 0;
  bool converged = true;  // false: Newton's method ended by its step limit; the point is still the best one seen
};

struct ClosestPointOptions {
  Index cellsPerDirection = 16;  // the spans are cut until there are at least so many cells in each direction
  Index maxStarts =
      64;  // of Newton's method for one point; bounds the work where all is equally far (a sphere's centre)
};

// Finds closest points on one curve (D = 1) or surface (2) again and again. The spline must outlive it. Thread-safe.
//
// Method: boxes around the Bezier points of small cells in a tree; cells that may hold something nearer are visited,
// the nearest first, and Newton's method is started in each. Newton's method is the full one ((5.13) of Hoschek and
// Juettler with the second derivatives, quadratic at any distance) with a line search; at the edges of the domain and
// at C0 knots the condition is the sign of the derivative, not zero. What is found is the global minimum unless one
// cell holds several minima or maxStarts is reached.
template <int D>
class ClosestPointFinder {
 public:
  // Throws InvalidInput unless the options are positive. Cost: O(points) plus one evaluation a cell.
  explicit ClosestPointFinder(const Spline<D>& spline, const ClosestPointOptions& options = {});

  // Throws InvalidInput if the point has another dimension than the spline or is not finite.
  ClosestPoint<D> find(const Eigen::Ref<const Point>& point) const;

  // The minimum that Newton's method reaches from these parameters.
  ClosestPoint<D> findFrom(const Eigen::Ref<const Point>& point, const std::array<double, D>& start) const;

 private:
  using Parameters = std::array<double, D>;

  // A stretch of a direction on which the spline is C1.
  struct Stretch {
    double from, to;
  };
  struct Cell {
    double from, to;
    Index span;
    Stretch stretch;
  };
  using Cells = std::array<Index, D>;
  struct Node {
    Index children[2] = {-1, -1};  // none: a leaf
    Cells cell{};
  };

  Index build(const Cells& first, const Cells& end);
  double boxDistance(Index node, const Point& point) const;
  void checkPoint(const Eigen::Ref<const Point>& point) const;
  ClosestPoint<D> newton(const Point& point, Parameters u, const std::array<Stretch, D>& box) const;

  const Spline<D>* spline_;
  ClosestPointOptions options_;
  std::array<std::vector<Cell>, D> cells_;
  std::vector<Node> nodes_;
  std::vector<Eigen::VectorXd> low_, high_;  // boxes of the nodes
};

extern template class ClosestPointFinder<1>;
extern template class ClosestPointFinder<2>;

// The same for a single point.
template <int D>
ClosestPoint<D> closestPoint(const Spline<D>& spline, const Eigen::Ref<const Point>& point,
                             const ClosestPointOptions& options = {});

}  // namespace strak
