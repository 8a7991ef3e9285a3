#pragma once
//
// Symmetric sparse matrices of 3 x 3 blocks: what energies of points in space couple, one block a pair of points.

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace strak {

// Which pairs of points are coupled: for every column j the rows i >= j, ascending, the diagonal first.
struct BlockPattern {
  std::vector<Eigen::Index> start;  // of each column in `rows`; size() + 1 entries
  std::vector<int> rows;

  Eigen::Index size() const { return static_cast<Eigen::Index>(start.size()) - 1; }
  Eigen::Index blocks() const { return static_cast<Eigen::Index>(rows.size()); }
  // The place of block (i, j), i >= j, among the blocks; it must exist. O(log of the column's length).
  Eigen::Index place(int i, int j) const;
};

// The pattern in which all points of one clique are coupled with one another. Negative entries are skipped, repeated
// ones count once. Cost O(sum of squared lengths).
BlockPattern patternOfCliques(Eigen::Index size, const std::vector<std::vector<int>>& cliques);

// Blocks are stored row-major, nine numbers each, in the order of the pattern. Of the diagonal blocks the whole block
// is stored and must be kept symmetric.
class BlockMatrix {
 public:
  explicit BlockMatrix(std::shared_ptr<const BlockPattern> pattern)
      : pattern_(std::move(pattern)), values_(9 * static_cast<std::size_t>(pattern_->blocks()), 0.0) {}

  const BlockPattern& pattern() const { return *pattern_; }
  const std::shared_ptr<const BlockPattern>& sharedPattern() const { return pattern_; }
  Eigen::Index size() const { return pattern_->size(); }
  void setZero() { values_.assign(values_.size(), 0.0); }
  double* at(Eigen::Index place) { return values_.data() + 9 * place; }
  const double* at(Eigen::Index place) const { return values_.data() + 9 * place; }
  double* block(int i, int j) { return at(pattern_->place(i, j)); }

  // y = A x; three numbers a point.
  Eigen::VectorXd times(const Eigen::VectorXd& x) const;
  // The mean of each point's three diagonal entries: does not depend on the axes.
  Eigen::VectorXd pointDiagonal() const;
  // Adds d[i] times the identity to diagonal block i.
  void addDiagonal(const Eigen::VectorXd& d);

 private:
  std::shared_ptr<const BlockPattern> pattern_;
  std::vector<double> values_;
};

}  // namespace strak
