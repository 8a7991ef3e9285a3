#pragma once
//
// The exact energies of a surface (shape_residuals.h) as functions of its control points: values, gradient and the
// Gauss-Newton matrix by quadrature over the knot cells that a free point moves; and the metric energy, a quadratic
// form that measures third derivatives in arc length.

#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "strak/solve/block_matrix.h"
#include "strak/spline/spline.h"

namespace strak {

struct ShapeEnergies {
  double plate = 0;      // int k1^2 + k2^2 dA; no unit
  double roughness = 0;  // int |nabla h|^2 dA; 1 / length^2
};

class ShapeEnergy {
 public:
  // `unknownOf`: for every control point the number of its unknown point, or -1 if it is held; points with the same
  // number are one and the same. `nodes` Gauss nodes a span and direction, 0: degree + 1. Of a rational surface the
  // weights stay, the unknowns are the points of space. Throws InvalidInput unless the surface lies in space.
  ShapeEnergy(const Surface& surface, std::vector<int> unknownOf, int nodes = 0);
  ~ShapeEnergy();
  ShapeEnergy(ShapeEnergy&&) noexcept;

  const std::vector<int>& unknownOf() const { return unknownOf_; }
  // The unknowns that each active cell couples, for patternOfCliques.
  std::vector<std::vector<int>> cliques() const;
  Index activeCells() const { return static_cast<Index>(cells_.size()); }
  // Whether the place lies in an active cell: the part of the surface that a free point moves.
  bool isActive(double u, double v) const;
  bool isWhole() const { return cells_.size() == active_.size(); }

  // The roughness of every active cell, and the control points that it depends on.
  struct CellRoughness {
    double roughness = 0;
    std::vector<Index> points;
  };
  std::vector<CellRoughness> roughnessOfCells(const Net& points) const;

  // Over the active cells. `points`: the net in space (euclideanNet). Multi-threaded, results independent of threads.
  ShapeEnergies values(const Net& points) const;

  // The weights of the squared residuals in the function F = roughness * Q + plate * P + metric * M that a step models.
  struct Weights {
    double roughness = 0, plate = 0, metric = 0;
  };
  // Adds the Gauss-Newton matrix of F (second derivatives, residuals linearised) and F's gradient. Returns the values.
  // Cost per cell: nodes^2 times 7 (3 m)^2 operations, m = (p + 1)(q + 1).
  ShapeEnergies addStep(const Net& points, const Weights& weights, BlockMatrix& matrix,
                        Eigen::VectorXd& gradient) const;

  // The metric energy M(X) = int |D_sss X|^2 + 3 |D_sst X|^2 + 3 |D_stt X|^2 + |D_ttt X|^2 ds dt, where s(u) and t(v)
  // are the mean arc lengths of the parameter lines of the surface with these points: flat, so that it is quadratic,
  // but independent of the parametrization. 1 / length^2. Zero until it is set.
  void setMetric(const Net& points);
  double metric(const Net& points) const;

 private:
  struct Direction;
  struct Cell {
    int u, v;  // spans among those of the directions
  };
  struct Work;
  std::vector<ShapeEnergies> valuesOfCells(const Net& points) const;
  void basisAt(const Cell& cell, std::size_t qu, std::size_t qv, Work& work) const;
  void gather(const Cell& cell, const Net& points, Work& work) const;

  std::vector<int> unknownOf_;
  Eigen::VectorXd weights_;  // empty if polynomial
  Index columns_ = 0;        // of the net
  std::unique_ptr<Direction> u_, v_;
  std::vector<Cell> cells_;
  std::vector<char> active_;                             // by spans, v fastest
  Eigen::SparseMatrix<double, Eigen::RowMajor> metric_;  // by control points
};

}  // namespace strak
