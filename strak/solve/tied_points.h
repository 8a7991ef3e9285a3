#pragma once
//
// Points that follow from fewer unknown ones, x = T y: combinations of them, and unknowns that move in a plane or along
// a line only. For borders of which one is a part of another, and for borders in a plane of symmetry.
//
// T^T A T is formed block by block, with a pattern made once; nearly all points are unknowns themselves, and their
// blocks are copied.

#include <memory>
#include <vector>

#include "strak/solve/block_matrix.h"
#include "strak/solve/hull_minimizer.h"

namespace strak {

class TiedPoints {
 public:
  struct Term {
    int unknown = 0;
    double weight = 1;
  };

  // Point i is the sum over points[i] of weight * unknown. Throws InvalidInput for an unknown that is none.
  TiedPoints(Eigen::Index unknowns, std::vector<std::vector<Term>> points);

  // From now on the unknown moves perpendicular to the direction (any length but zero) only; of two directions along a
  // line, of three not at all.
  void confine(int unknown, const Eigen::Vector3d& direction);

  Eigen::Index points() const { return static_cast<Eigen::Index>(points_.size()); }
  Eigen::Index unknowns() const { return static_cast<Eigen::Index>(plane_.size()); }
  const std::vector<Term>& terms(int point) const { return points_[static_cast<std::size_t>(point)]; }
  bool isConfined(int unknown) const { return plane_[static_cast<std::size_t>(unknown)] >= 0; }
  // The projection onto what an unknown may do; of one that is not confined the identity.
  Eigen::Matrix3d projection(int unknown) const;

  // Where point i goes; three numbers an unknown.
  Eigen::Vector3d at(int point, const Eigen::VectorXd& y) const;
  // y with the forbidden part of confined unknowns taken away: T y stays the same.
  Eigen::VectorXd confined(Eigen::VectorXd y) const;
  // T^T g.
  Eigen::VectorXd reduced(const Eigen::VectorXd& gradient) const;
  // The same rows of y, in their order: exact for a confined y.
  BallRows reduced(const BallRows& rows) const;
  // Sets of points as sets of unknowns, for patternOfCliques.
  std::vector<std::vector<int>> reduced(const std::vector<std::vector<int>>& cliques) const;

 private:
  std::vector<std::vector<Term>> points_;
  std::vector<int> plane_;  // by unknowns: number of the projection, -1: not confined
  std::vector<Eigen::Matrix3d> projections_;
};

// Adds T^T A T to matrices of the unknowns' pattern.
class TiedMatrix {
 public:
  // `full`: the pattern of the points; `unknowns`: one that holds all pairs these lead to. `tied` must outlive it.
  TiedMatrix(const TiedPoints& tied, std::shared_ptr<const BlockPattern> full, const BlockPattern& unknowns);

  const std::shared_ptr<const BlockPattern>& full() const { return full_; }
  // What confined unknowns cannot do costs as much as what they can, so that the matrix stays regular. Cost: a pass
  // over the blocks.
  void add(const BlockMatrix& full, BlockMatrix& matrix) const;

 private:
  struct Share {
    Eigen::Index from, to;  // places of the blocks in the full matrix and the unknowns'
    double weight;
    bool transposed;
    int left, right;  // unknowns, for their projections
  };
  const TiedPoints& tied_;
  std::shared_ptr<const BlockPattern> full_;
  std::vector<Eigen::Index> direct_;  // by the full matrix's blocks: the place in the unknowns', -1: among the shares
  std::vector<Share> shares_;
};

}  // namespace strak
