#pragma once
//
// Symmetric matrices over the control points of a net that couple only neighbours: what least squares and quadratic
// energies need as a whole (where a Kronecker sum is not enough), and their Cholesky factors.

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "strak/solve/nested_cholesky.h"

namespace strak {

using NetVectors = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// sizes[0] x sizes[1] control points, the last index fastest; (i, j) and (k, l) are coupled if |i - k| <= reach[0] and
// |j - l| <= reach[1]. Both triangles are stored: a row is a box of (2 reach[0] + 1) x (2 reach[1] + 1) numbers around
// its point, zero outside the net. Curves are nets of 1 x n.
struct NetMatrix {
  std::array<Eigen::Index, 2> sizes{0, 0};
  std::array<int, 2> reach{0, 0};
  std::vector<double> values;

  NetMatrix() = default;
  NetMatrix(std::array<Eigen::Index, 2> theSizes, std::array<int, 2> theReach);

  Eigen::Index size() const { return sizes[0] * sizes[1]; }
  Eigen::Index rowLength() const { return Eigen::Index{2 * reach[0] + 1} * (2 * reach[1] + 1); }
  // The number that couples point `row` to the one (di, dj) away.
  double& at(Eigen::Index row, int di, int dj) {
    return values[static_cast<std::size_t>(row * rowLength() + (di + reach[0]) * (2 * reach[1] + 1) + dj + reach[1])];
  }
  double at(Eigen::Index row, int di, int dj) const { return const_cast<NetMatrix*>(this)->at(row, di, dj); }

  double trace() const;
  // A x, a row a point.
  NetVectors times(const Eigen::Ref<const NetVectors>& x) const;
};

// a + factor * b of two matrices of one shape.
NetMatrix combined(const NetMatrix& a, double factor, const NetMatrix& b);

// Cholesky factors of such matrices, by nested dissection (nested_cholesky.h): three neighbours of a line are one of
// its points, so that nothing is wasted but the blocks' corners.
class NetCholesky {
 public:
  NetCholesky(std::array<Eigen::Index, 2> sizes, std::array<int, 2> reach);

  // Factors `matrix` scaled to a unit diagonal; points with held[r] != 0 are left out (empty: none). Returns false if
  // it is not positive definite, or a pivot of the scaled matrix is below `leastPivot`: not to be told from singular.
  // For n x n nets O(n^3) operations. Multi-threaded; the result does not depend on the number of threads.
  bool factor(const NetMatrix& matrix, const std::vector<char>& held = {}, double leastPivot = 1e-14);

  // The solution at the points that are not held, zero at the others. Any number of columns.
  NetVectors solve(const Eigen::Ref<const NetVectors>& right) const;

  // Of the matrix without the held points.
  double logDeterminant() const { return logDeterminant_; }

 private:
  std::array<Eigen::Index, 2> sizes_;
  std::array<int, 2> reach_;
  Eigen::Index blocksPerLine_;
  std::shared_ptr<const BlockPattern> pattern_;
  BlockMatrix matrix_;
  NestedCholesky factor_;
  Eigen::VectorXd scale_;  // 1 / square root of the diagonal, 0 where held
  double logDeterminant_ = 0;
};

}  // namespace strak
