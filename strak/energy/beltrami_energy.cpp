#include "strak/energy/beltrami_energy.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "strak/base/error.h"
#include "strak/spline/basis.h"
#include "strak/spline/quotient_rule.h"
#include "strak/spline/rational.h"

namespace strak {

namespace {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Jet = Eigen::Matrix<double, 6, 3>;  // X and its derivatives, in the order of partialOrders<2>(2)

constexpr double kLeastLength = 1e-3;  // of the mean: shorter parameter steps count as this long
constexpr std::size_t kChunk = 64;     // cells whose matrices are formed at a time

// One direction's basis functions at the Gauss nodes of all spans.
struct Axis {
  int degree;
  std::vector<Index> first;  // of each span: its first basis function
  std::size_t nodes;
  std::vector<double> weight;    // by span and node
  std::vector<RowMatrix> basis;  // ... values and two derivatives

  Axis(const KnotVector& knots, int wished) : degree(knots.degree()) {
    const GaussRule rule = gaussLegendre(wished > 0 ? wished : degree + 1);
    nodes = rule.nodes.size();
    for (Index s : knots.spans()) {
      first.push_back(s - degree);
      const double half = (knots[s + 1] - knots[s]) / 2, middle = (knots[s + 1] + knots[s]) / 2;
      for (std::size_t q = 0; q < nodes; ++q) {
        weight.push_back(half * rule.weights[q]);
        basis.push_back(basisDerivatives(knots, s, middle + half * rule.nodes[q], 2));
      }
    }
  }
};

struct Cell {
  std::size_t u, v;  // spans
};

// The knot cells of a surface with their quadrature.
class Cells {
 public:
  Cells(const Surface& surface, int nodes)
      : u_(surface.knots(0), nodes),
        v_(surface.knots(1), nodes),
        columns_(surface.size(1)),
        points_(surface.euclideanNet()),
        rational_(surface.isRational()),
        weights_(weights(surface)) {}

  std::size_t nodes() const { return u_.nodes * v_.nodes; }
  Index functions() const { return (u_.degree + 1) * (v_.degree + 1); }

  // The control point of a cell's function k.
  Index row(const Cell& cell, Index k) const {
    return (u_.first[cell.u] + k / (v_.degree + 1)) * columns_ + v_.first[cell.v] + k % (v_.degree + 1);
  }

  std::vector<Cell> active(const std::vector<int>& unknownOf) const {
    std::vector<Cell> result;
    for (std::size_t a = 0; a < u_.first.size(); ++a) {
      for (std::size_t b = 0; b < v_.first.size(); ++b) {
        const Cell cell{a, b};
        bool moves = false;
        for (Index k = 0; k < functions() && !moves; ++k) {
          moves = unknownOf[static_cast<std::size_t>(row(cell, k))] >= 0;
        }
        if (moves) result.push_back(cell);
      }
    }
    return result;
  }

  // Calls visit(weight, basis, jet) at every node of the cell: the (rational) basis functions and the surface with
  // their derivatives.
  template <class Visit>
  void visit(const Cell& cell, const Visit& visit) const {
    static const QuotientRule<2> quotient(2);
    static const std::vector<std::array<int, 2>> orders = partialOrders<2>(2);
    const Index m = functions(), nv = v_.degree + 1;
    RowMatrix points(m, 3), homogeneous(6, m + 1), basis(6, m);
    Eigen::RowVectorXd w(m);
    for (Index k = 0; k < m; ++k) {
      points.row(k) = points_.row(row(cell, k));
      w[k] = weights_[row(cell, k)];
    }
    for (std::size_t i = cell.u * u_.nodes; i < (cell.u + 1) * u_.nodes; ++i) {
      for (std::size_t j = cell.v * v_.nodes; j < (cell.v + 1) * v_.nodes; ++j) {
        for (Index k = 0; k < 6; ++k) {
          const auto& order = orders[static_cast<std::size_t>(k)];
          const auto a = u_.basis[i].row(order[0]), b = v_.basis[j].row(order[1]);
          for (Index f = 0; f <= u_.degree; ++f) basis.row(k).segment(f * nv, nv) = a[f] * b;
        }
        if (rational_) {
          homogeneous.leftCols(m) = basis.array().rowwise() * w.array();
          homogeneous.col(m) = homogeneous.leftCols(m).rowwise().sum();
          quotient.apply(static_cast<int>(m) + 1, homogeneous.data(), basis.data());
        }
        visit(u_.weight[i] * v_.weight[j], basis, Jet(basis * points));
      }
    }
  }

 private:
  Axis u_, v_;
  Index columns_;
  Net points_;
  bool rational_;
  Eigen::VectorXd weights_;
};

// The reference's metric at a place.
struct Metric {
  Eigen::Matrix2d inverse;
  double area;

  // In steps of the mean speeds no length of a unit step is below kLeastLength.
  Metric(const Jet& x, const Eigen::Vector2d& speeds) {
    const Eigen::Vector3d a = x.row(1).transpose() / speeds[0], b = x.row(2).transpose() / speeds[1];
    constexpr double kLeast = kLeastLength * kLeastLength;
    Eigen::Matrix2d g;
    g << a.squaredNorm(), a.dot(b), a.dot(b), b.squaredNorm();
    double det = a.cross(b).squaredNorm();
    if (det > kLeast * g.trace()) {
      inverse << g(1, 1), -g(0, 1), -g(0, 1), g(0, 0);
      inverse /= det;
    } else {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(g);
      const Eigen::Vector2d safe = solver.eigenvalues().cwiseMax(kLeast);
      det = safe.prod();
      inverse = solver.eigenvectors() * safe.cwiseInverse().asDiagonal() * solver.eigenvectors().transpose();
    }
    area = std::sqrt(det) * speeds.prod();
    inverse = speeds.cwiseInverse().asDiagonal() * inverse * speeds.cwiseInverse().asDiagonal();
  }
};

// Delta of all basis functions. Since g^ij Gamma^k_ij = g^kl (g^ij X_ij . X_l), no single symbol is needed.
void beltrami(const Metric& metric, const RowMatrix& basis, const Jet& x, Eigen::Ref<Eigen::VectorXd> result) {
  const Eigen::Matrix2d& g = metric.inverse;
  const Eigen::Vector3d s = (g(0, 0) * x.row(3) + 2 * g(0, 1) * x.row(4) + g(1, 1) * x.row(5)).transpose();
  const Eigen::Vector2d c = g * (x.middleRows<2>(1) * s);
  result = (g(0, 0) * basis.row(3) + 2 * g(0, 1) * basis.row(4) + g(1, 1) * basis.row(5) - c[0] * basis.row(1) -
            c[1] * basis.row(2))
               .transpose();
}

// The second covariant derivatives of all basis functions in an orthonormal frame: those in its directions and, times
// the root of two, the mixed one.
void hessian(const Metric& metric, const RowMatrix& basis, const Jet& x, Eigen::Ref<Eigen::MatrixXd> result) {
  const Eigen::Matrix2d frame = metric.inverse.llt().matrixL();
  Eigen::Matrix<double, 3, Eigen::Dynamic> second(3, basis.cols());
  for (Index k = 0; k < 3; ++k) {
    const Eigen::Vector2d c = metric.inverse * (x.middleRows<2>(1) * x.row(3 + k).transpose());
    second.row(k) = basis.row(3 + k) - c[0] * basis.row(1) - c[1] * basis.row(2);
  }
  const double a = frame(0, 0), b = frame(1, 0), d = frame(1, 1);
  result.col(0) = (a * a * second.row(0) + 2 * a * b * second.row(1) + b * b * second.row(2)).transpose();
  result.col(1) = std::sqrt(2.0) * d * (a * second.row(1) + b * second.row(2)).transpose();
  result.col(2) = d * d * second.row(2).transpose();
}

// The mean lengths of X_u and X_v.
Eigen::Vector2d meanSpeeds(const Cells& cells, const std::vector<Cell>& active) {
  std::vector<Eigen::Vector3d> sums(active.size(), Eigen::Vector3d::Zero());
  tbb::parallel_for(std::size_t{0}, active.size(), [&](std::size_t c) {
    cells.visit(active[c], [&](double weight, const RowMatrix&, const Jet& x) {
      sums[c] += weight * Eigen::Vector3d(x.row(1).stableNorm(), x.row(2).stableNorm(), 1);
    });
  });
  Eigen::Vector3d total = Eigen::Vector3d::Zero();
  for (const auto& sum : sums) total += sum;
  return total.head<2>() / total[2];
}

// The pattern of all pairs of control points whose functions overlap, with zeros in it.
Eigen::SparseMatrix<double, Eigen::RowMajor> emptyMatrix(const Surface& surface) {
  const Index nu = surface.size(0), nv = surface.size(1), p = surface.degree(0), q = surface.degree(1);
  Eigen::SparseMatrix<double, Eigen::RowMajor> matrix(nu * nv, nu * nv);
  matrix.reserve(nu * nv * (2 * p + 1) * (2 * q + 1));
  for (Index row = 0; row < nu * nv; ++row) {
    matrix.startVec(row);
    const Index i = row / nv, j = row % nv;
    for (Index a = std::max<Index>(0, i - p); a <= std::min(nu - 1, i + p); ++a) {
      for (Index b = std::max<Index>(0, j - q); b <= std::min(nv - 1, j + q); ++b) {
        matrix.insertBackByOuterInner(row, a * nv + b) = 0;
      }
    }
  }
  matrix.finalize();
  return matrix;
}

}  // namespace

BeltramiEnergy::BeltramiEnergy(const Surface& reference, std::vector<int> unknownOf, int nodes, InnerBending bending)
    : unknownOf_(std::move(unknownOf)) {
  if (reference.pointDimension() != 3) {
    throw InvalidInput("the data-dependent energy needs a surface in space: give points with 3 coordinates");
  }
  if (static_cast<Index>(unknownOf_.size()) != reference.net().rows()) {
    throw InvalidInput("the data-dependent energy needs one number of an unknown a control point");
  }
  matrix_ = emptyMatrix(reference);
  const Cells cells(reference, nodes);
  const std::vector<Cell> active = cells.active(unknownOf_);
  if (active.empty()) return;
  const Eigen::Vector2d speeds = meanSpeeds(cells, active);
  if (!(speeds.minCoeff() > 0)) {
    throw InvalidInput("the reference of the data-dependent energy is a curve or a point: give a surface");
  }
  const Index m = cells.functions(), nv = reference.size(1), p = reference.degree(0), q = reference.degree(1);
  const Index parts = bending == InnerBending::hessian ? 3 : 1;  // numbers a node
  std::vector<Eigen::MatrixXd> elements(std::min(kChunk, active.size()));
  for (std::size_t start = 0; start < active.size(); start += kChunk) {
    const std::size_t count = std::min(kChunk, active.size() - start);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t c) {
      Eigen::MatrixXd rows(m, parts * static_cast<Index>(cells.nodes()));
      Index node = 0;
      cells.visit(active[start + c], [&](double weight, const RowMatrix& basis, const Jet& x) {
        const Metric metric(x, speeds);
        if (bending == InnerBending::hessian) {
          hessian(metric, basis, x, rows.middleCols(node, 3));
        } else {
          beltrami(metric, basis, x, rows.col(node));
        }
        rows.middleCols(node, parts) *= std::sqrt(weight * metric.area);
        node += parts;
      });
      elements[c].noalias() = rows * rows.transpose();
    });
    for (std::size_t c = 0; c < count; ++c) {
      for (Index k = 0; k < m; ++k) {
        const Index row = cells.row(active[start + c], k), i = row / nv, j = row % nv;
        const Index low = std::max<Index>(0, i - p), left = std::max<Index>(0, j - q);
        const Index width = std::min(nv - 1, j + q) - left + 1;
        double* values = matrix_.valuePtr() + matrix_.outerIndexPtr()[row];
        for (Index l = 0; l < m; ++l) {
          const Index other = cells.row(active[start + c], l);
          values[(other / nv - low) * width + other % nv - left] += elements[c](k, l);
        }
      }
    }
  }
}

double BeltramiEnergy::value(const Net& points) const {
  // Constants cost nothing; far from the origin they would cost digits.
  const Net about = points.rowwise() - points.colwise().mean();
  return about.cwiseProduct(matrix_ * about).sum();
}

void BeltramiEnergy::addTo(const Net& points, double weight, BlockMatrix& matrix, Eigen::VectorXd& gradient) const {
  const Net about = points.rowwise() - points.colwise().mean();
  const Net force = 2 * weight * (matrix_ * about);
  for (Index row = 0; row < matrix_.outerSize(); ++row) {
    const int ua = unknownOf_[static_cast<std::size_t>(row)];
    if (ua < 0) continue;
    gradient.segment<3>(3 * ua) += force.row(row).transpose();
    for (decltype(matrix_)::InnerIterator it(matrix_, row); it; ++it) {
      const int ub = unknownOf_[static_cast<std::size_t>(it.col())];
      if (ub < 0 || ua < ub || it.value() == 0) continue;
      double* block = matrix.block(ua, ub);
      for (int k : {0, 4, 8}) block[k] += 2 * weight * it.value();
    }
  }
}

}  // namespace strak
