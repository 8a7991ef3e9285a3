#include "strak/energy/shape_energy.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "strak/base/error.h"
#include "strak/energy/shape_residuals.h"
#include "strak/solve/dense_kernels.h"
#include "strak/spline/basis.h"
#include "strak/spline/rational.h"

namespace strak {

namespace {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The orders (u, v) of the basis function's derivatives, in the order of ShapeDerivatives, after the value itself.
constexpr int kOrders[10][2] = {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}, {3, 0}, {2, 1}, {1, 2}, {0, 3}};

int orderIndex(int a, int b) {
  constexpr int at[4][4] = {{0, 2, 5, 9}, {1, 4, 8, -1}, {3, 7, -1, -1}, {6, -1, -1, -1}};
  return at[a][b];
}

double binomial(int n, int k) {
  constexpr double table[4][4] = {{1, 0, 0, 0}, {1, 1, 0, 0}, {1, 2, 1, 0}, {1, 3, 3, 1}};
  return table[n][k];
}

// Cells whose element matrices are formed at a time.
constexpr std::size_t kChunk = 64;

}  // namespace

struct ShapeEnergy::Direction {
  int degree = 0;
  KnotVector knots;
  std::vector<Index> spans;
  std::size_t nodes = 0;
  // For span s and node q: its weight, and the basis functions' derivatives 0..3.
  std::vector<double> weight, parameter;
  std::vector<RowMatrix> basis;
  // The speed ds/du of the metric's arc length and its two derivatives.
  std::vector<Eigen::Vector3d> speed;

  std::size_t at(int span, std::size_t node) const { return static_cast<std::size_t>(span) * nodes + node; }
  Index first(int span) const { return spans[static_cast<std::size_t>(span)] - degree; }

  Direction(const KnotVector& k, int wished) : degree(k.degree()), knots(k), spans(k.spans()) {
    const GaussRule rule = gaussLegendre(wished > 0 ? wished : degree + 1);
    nodes = rule.nodes.size();
    for (Index s : spans) {
      const double half = (k[s + 1] - k[s]) / 2, middle = (k[s + 1] + k[s]) / 2;
      for (std::size_t q = 0; q < nodes; ++q) {
        weight.push_back(half * rule.weights[q]);
        parameter.push_back(middle + half * rule.nodes[q]);
        basis.push_back(basisDerivatives(k, s, parameter.back(), 3));
      }
    }
  }

  // The arc length s(u) = sum sigma_i N_i(u) with the given speeds at the nodes, by least squares, not smoothed. Where
  // that would run backwards, straight: s proportional to u.
  void fitSpeed(const std::vector<double>& speeds);
};

void ShapeEnergy::Direction::fitSpeed(const std::vector<double>& speeds) {
  const Index n = knots.size();
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  double mean = 0, length = 0;
  for (std::size_t s = 0; s < spans.size(); ++s) {
    const Index low = first(static_cast<int>(s));
    for (std::size_t q = 0; q < nodes; ++q) {
      const std::size_t k = s * nodes + q;
      const auto d = basis[k].row(1);
      for (int i = 0; i <= degree; ++i) {
        right[low + i] += weight[k] * d[i] * speeds[k];
        for (int j = 0; j <= degree; ++j) entries.emplace_back(low + i, low + j, weight[k] * d[i] * d[j]);
      }
      mean += weight[k] * speeds[k];
      length += weight[k];
    }
  }
  mean /= length;
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  // Constants are free: fixed by a whiff of the identity.
  const double whiff = 1e-12 * matrix.diagonal().maxCoeff();
  for (Index i = 0; i < n; ++i) matrix.coeffRef(i, i) += whiff;
  const Eigen::VectorXd sigma = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(right);
  speed.assign(weight.size(), Eigen::Vector3d::Zero());
  double least = mean;
  for (std::size_t s = 0; s < spans.size(); ++s) {
    for (std::size_t q = 0; q < nodes; ++q) {
      const std::size_t k = s * nodes + q;
      speed[k] = basis[k].bottomRows(3) * sigma.segment(first(static_cast<int>(s)), degree + 1);
      least = std::min(least, speed[k][0]);
    }
  }
  constexpr double kBackwards = 0.02;
  if (!(least > kBackwards * mean)) speed.assign(weight.size(), Eigen::Vector3d(mean, 0, 0));
}

struct ShapeEnergy::Work {
  RowMatrix basis;           // kShapeDerivatives x m
  RowMatrix numerators;      // 10 x m
  RowMatrix points;          // m x 3
  Eigen::MatrixXd jacobian;  // 3 m x 7 nodes^2, a column a residual
  std::vector<double> scratch;
  Eigen::VectorXd residual, pointWeight;
  std::vector<int> unknown;
};

ShapeEnergy::ShapeEnergy(const Surface& surface, std::vector<int> unknownOf, int nodes)
    : unknownOf_(std::move(unknownOf)), columns_(surface.size(1)) {
  if (surface.pointDimension() != 3)
    throw InvalidInput("exact energies need a surface in space: give points with 3 coordinates");
  if (static_cast<Index>(unknownOf_.size()) != surface.net().rows()) {
    throw InvalidInput("exact energies need one number of an unknown a control point");
  }
  if (surface.isRational()) weights_ = strak::weights(surface);
  u_ = std::make_unique<Direction>(surface.knots(0), nodes);
  v_ = std::make_unique<Direction>(surface.knots(1), nodes);
  for (int a = 0; a < static_cast<int>(u_->spans.size()); ++a) {
    for (int b = 0; b < static_cast<int>(v_->spans.size()); ++b) {
      bool active = false;
      for (int i = 0; i <= u_->degree && !active; ++i) {
        for (int j = 0; j <= v_->degree && !active; ++j) {
          active = unknownOf_[static_cast<std::size_t>((u_->first(a) + i) * columns_ + v_->first(b) + j)] >= 0;
        }
      }
      if (active) cells_.push_back({a, b});
      active_.push_back(active ? 1 : 0);
    }
  }
}

ShapeEnergy::~ShapeEnergy() = default;
ShapeEnergy::ShapeEnergy(ShapeEnergy&&) noexcept = default;

bool ShapeEnergy::isActive(double u, double v) const {
  const auto number = [](const Direction& d, double t) {
    return static_cast<std::size_t>(std::lower_bound(d.spans.begin(), d.spans.end(), d.knots.findSpan(t)) -
                                    d.spans.begin());
  };
  return active_[number(*u_, u) * v_->spans.size() + number(*v_, v)] != 0;
}

std::vector<std::vector<int>> ShapeEnergy::cliques() const {
  std::vector<std::vector<int>> result;
  for (const Cell& cell : cells_) {
    std::vector<int> clique;
    for (int i = 0; i <= u_->degree; ++i) {
      for (int j = 0; j <= v_->degree; ++j) {
        clique.push_back(
            unknownOf_[static_cast<std::size_t>((u_->first(cell.u) + i) * columns_ + v_->first(cell.v) + j)]);
      }
    }
    result.push_back(std::move(clique));
  }
  return result;
}

void ShapeEnergy::gather(const Cell& cell, const Net& points, Work& work) const {
  const int m = (u_->degree + 1) * (v_->degree + 1);
  work.points.resize(m, 3);
  work.unknown.resize(static_cast<std::size_t>(m));
  if (weights_.size() > 0) work.pointWeight.resize(m);
  int k = 0;
  for (int i = 0; i <= u_->degree; ++i) {
    for (int j = 0; j <= v_->degree; ++j, ++k) {
      const Index row = (u_->first(cell.u) + i) * columns_ + v_->first(cell.v) + j;
      work.points.row(k) = points.row(row);
      work.unknown[static_cast<std::size_t>(k)] = unknownOf_[static_cast<std::size_t>(row)];
      if (weights_.size() > 0) work.pointWeight[k] = weights_[row];
    }
  }
}

// The derivatives of the (rational) basis functions at a node.
void ShapeEnergy::basisAt(const Cell& cell, std::size_t qu, std::size_t qv, Work& work) const {
  const RowMatrix &bu = u_->basis[u_->at(cell.u, qu)], &bv = v_->basis[v_->at(cell.v, qv)];
  const int nu = u_->degree + 1, nv = v_->degree + 1, m = nu * nv;
  work.basis.resize(kShapeDerivatives, m);
  if (weights_.size() == 0) {
    for (int k = 0; k < kShapeDerivatives; ++k) {
      const auto a = bu.row(kOrders[k + 1][0]), b = bv.row(kOrders[k + 1][1]);
      for (int i = 0; i < nu; ++i) work.basis.row(k).segment(i * nv, nv) = a[i] * b;
    }
    return;
  }
  // R = A / W, A = w N: W D^r R = D^r A - sum over 0 < s <= r of binomial(r, s) D^s W D^(r-s) R.
  RowMatrix& r = work.numerators;
  r.resize(10, m);
  double total[10];
  for (int k = 0; k < 10; ++k) {
    const auto a = bu.row(kOrders[k][0]), b = bv.row(kOrders[k][1]);
    for (int i = 0; i < nu; ++i) r.row(k).segment(i * nv, nv) = a[i] * b;
    r.row(k).array() *= work.pointWeight.transpose().array();
    total[k] = r.row(k).sum();
  }
  for (int k = 0; k < 10; ++k) {
    for (int a = 0; a <= kOrders[k][0]; ++a) {
      for (int b = 0; b <= kOrders[k][1]; ++b) {
        if (a + b == 0) continue;
        r.row(k) -= binomial(kOrders[k][0], a) * binomial(kOrders[k][1], b) * total[orderIndex(a, b)] *
                    r.row(orderIndex(kOrders[k][0] - a, kOrders[k][1] - b));
      }
    }
    r.row(k) /= total[0];
  }
  work.basis = r.bottomRows(kShapeDerivatives);
}

std::vector<ShapeEnergies> ShapeEnergy::valuesOfCells(const Net& points) const {
  std::vector<ShapeEnergies> cellValues(cells_.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells_.size(), 16), [&](const auto& range) {
    Work work;
    std::array<double, kShapeResiduals> r;
    for (std::size_t c = range.begin(); c != range.end(); ++c) {
      const Cell& cell = cells_[c];
      gather(cell, points, work);
      for (std::size_t i = 0; i < u_->nodes; ++i) {
        for (std::size_t j = 0; j < v_->nodes; ++j) {
          basisAt(cell, i, j, work);
          const ShapeDerivatives x = work.basis * work.points;
          shapeResiduals(x, r);
          const double w = u_->weight[u_->at(cell.u, i)] * v_->weight[v_->at(cell.v, j)];
          for (int k = 0; k < kRoughnessResiduals; ++k) cellValues[c].roughness += w * r[k] * r[k];
          for (int k = kRoughnessResiduals; k < kShapeResiduals; ++k) cellValues[c].plate += w * r[k] * r[k];
        }
      }
    }
  });
  return cellValues;
}

ShapeEnergies ShapeEnergy::values(const Net& points) const {
  ShapeEnergies sum;
  for (const auto& value : valuesOfCells(points)) {
    sum.plate += value.plate;
    sum.roughness += value.roughness;
  }
  return sum;
}

std::vector<ShapeEnergy::CellRoughness> ShapeEnergy::roughnessOfCells(const Net& points) const {
  const std::vector<ShapeEnergies> values = valuesOfCells(points);
  std::vector<CellRoughness> result(cells_.size());
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    result[c].roughness = values[c].roughness;
    for (int i = 0; i <= u_->degree; ++i) {
      for (int j = 0; j <= v_->degree; ++j) {
        result[c].points.push_back((u_->first(cells_[c].u) + i) * columns_ + v_->first(cells_[c].v) + j);
      }
    }
  }
  return result;
}

ShapeEnergies ShapeEnergy::addStep(const Net& points, const Weights& weights, BlockMatrix& matrix,
                                   Eigen::VectorXd& gradient) const {
  const Index m = (u_->degree + 1) * (v_->degree + 1);
  const auto nodes = static_cast<Index>(u_->nodes * v_->nodes);
  struct Element {
    Eigen::MatrixXd matrix;
    Eigen::VectorXd gradient;
    ShapeEnergies value;
    std::vector<int> unknown;
  };
  std::vector<Element> elements(std::min(kChunk, cells_.size()));
  tbb::enumerable_thread_specific<Work> works;
  ShapeEnergies sum;
  for (std::size_t start = 0; start < cells_.size(); start += kChunk) {
    const std::size_t count = std::min(kChunk, cells_.size() - start);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1), [&](const auto& range) {
      Work& work = works.local();
      ShapeResiduals r;
      for (std::size_t c = range.begin(); c != range.end(); ++c) {
        const Cell& cell = cells_[start + c];
        Element& element = elements[c];
        element.value = {};
        gather(cell, points, work);
        work.jacobian.resize(3 * m, kShapeResiduals * nodes);
        work.residual.resize(kShapeResiduals * nodes);
        Index row = 0;
        for (std::size_t i = 0; i < u_->nodes; ++i) {
          for (std::size_t j = 0; j < v_->nodes; ++j, row += kShapeResiduals) {
            basisAt(cell, i, j, work);
            const ShapeDerivatives x = work.basis * work.points;
            shapeResiduals(x, r);
            const double w = u_->weight[u_->at(cell.u, i)] * v_->weight[v_->at(cell.v, j)];
            const double q = std::sqrt(2 * w * weights.roughness), p = std::sqrt(2 * w * weights.plate);
            for (int k = 0; k < kShapeResiduals; ++k) {
              const double value = r.value[static_cast<std::size_t>(k)];
              const double factor = k < kRoughnessResiduals ? q : p;
              (k < kRoughnessResiduals ? element.value.roughness : element.value.plate) += w * value * value;
              work.residual[row + k] = factor * value;
              r.derivative.middleRows<3>(3 * k) *= factor;
            }
            // Row r * 3 + c of the product lies where column r, rows c m .. of the jacobian do.
            Eigen::Map<RowMatrix>(work.jacobian.data() + row * 3 * m, 3 * kShapeResiduals, m).noalias() =
                r.derivative * work.basis;
          }
        }
        element.matrix.setZero(3 * m, 3 * m);
        work.scratch.resize(static_cast<std::size_t>(dense::scratchSize(3 * m)));
        dense::chosen().addOuter(3 * m, work.jacobian.cols(), work.jacobian.data(), 3 * m, 1, element.matrix.data(),
                                 3 * m, work.scratch.data());
        element.gradient.noalias() = work.jacobian * work.residual;
        element.unknown = work.unknown;
      }
    });
    for (std::size_t c = 0; c < count; ++c) {
      const Element& element = elements[c];
      sum.plate += element.value.plate;
      sum.roughness += element.value.roughness;
      for (Index a = 0; a < m; ++a) {
        const int ua = element.unknown[static_cast<std::size_t>(a)];
        if (ua < 0) continue;
        for (int k = 0; k < 3; ++k) gradient[3 * ua + k] += element.gradient[k * m + a];
        for (Index b = 0; b < m; ++b) {
          const int ub = element.unknown[static_cast<std::size_t>(b)];
          if (ub < 0 || ua < ub) continue;
          double* block = matrix.block(ua, ub);
          for (int k = 0; k < 3; ++k) {
            for (int l = 0; l < 3; ++l) {
              const Index i = k * m + a, j = l * m + b;
              block[3 * k + l] += i >= j ? element.matrix(i, j) : element.matrix(j, i);
            }
          }
        }
      }
    }
  }
  if (weights.metric > 0) {
    const Net force = 2 * weights.metric * (metric_ * points);
    for (Index row = 0; row < metric_.outerSize(); ++row) {
      const int ua = unknownOf_[static_cast<std::size_t>(row)];
      if (ua < 0) continue;
      gradient.segment<3>(3 * ua) += force.row(row).transpose();
      for (decltype(metric_)::InnerIterator it(metric_, row); it; ++it) {
        const int ub = unknownOf_[static_cast<std::size_t>(it.col())];
        if (ub < 0 || ua < ub) continue;
        double* block = matrix.block(ua, ub);
        for (int k : {0, 4, 8}) block[k] += 2 * weights.metric * it.value();
      }
    }
  }
  return sum;
}

double ShapeEnergy::metric(const Net& points) const {
  return metric_.rows() == 0 ? 0 : points.cwiseProduct(metric_ * points).sum();
}

void ShapeEnergy::setMetric(const Net& points) {
  // The mean speeds, over all cells: the lines go through the held parts as well.
  std::vector<double> speedU(u_->weight.size(), 0.0), speedV(v_->weight.size(), 0.0);
  Work work;
  for (int a = 0; a < static_cast<int>(u_->spans.size()); ++a) {
    for (int b = 0; b < static_cast<int>(v_->spans.size()); ++b) {
      const Cell cell{a, b};
      gather(cell, points, work);
      for (std::size_t i = 0; i < u_->nodes; ++i) {
        for (std::size_t j = 0; j < v_->nodes; ++j) {
          basisAt(cell, i, j, work);
          const std::size_t ku = u_->at(a, i), kv = v_->at(b, j);
          speedU[ku] += v_->weight[kv] * (work.basis.row(0) * work.points).norm();
          speedV[kv] += u_->weight[ku] * (work.basis.row(1) * work.points).norm();
        }
      }
    }
  }
  for (double& s : speedU) s /= v_->knots.length();
  for (double& s : speedV) s /= u_->knots.length();
  u_->fitSpeed(speedU);
  v_->fitSpeed(speedV);

  const Index m = (u_->degree + 1) * (v_->degree + 1);
  std::vector<Eigen::Triplet<double>> entries;
  RowMatrix rows(4, m), element(m, m);
  for (const Cell& cell : cells_) {
    gather(cell, points, work);
    element.setZero();
    for (std::size_t i = 0; i < u_->nodes; ++i) {
      for (std::size_t j = 0; j < v_->nodes; ++j) {
        basisAt(cell, i, j, work);
        const std::size_t ku = u_->at(cell.u, i), kv = v_->at(cell.v, j);
        const Eigen::Vector3d &s = u_->speed[ku], &t = v_->speed[kv];
        const auto& b = work.basis;
        // Derivatives by arc length: d/ds = (1 / s') d/du, so f_ss = (f'' - (s''/s') f') / s'^2, and so on.
        const double s2 = s[0] * s[0], t2 = t[0] * t[0], ps = s[1] / s[0], pt = t[1] / t[0];
        rows.row(0) = (b.row(5) - 3 * ps * b.row(2) + (3 * ps * ps - s[2] / s[0]) * b.row(0)) / (s2 * s[0]);
        rows.row(1) = std::sqrt(3.0) * (b.row(6) - ps * b.row(3)) / (s2 * t[0]);
        rows.row(2) = std::sqrt(3.0) * (b.row(7) - pt * b.row(3)) / (s[0] * t2);
        rows.row(3) = (b.row(8) - 3 * pt * b.row(4) + (3 * pt * pt - t[2] / t[0]) * b.row(1)) / (t2 * t[0]);
        element.noalias() += (u_->weight[ku] * v_->weight[kv] * s[0] * t[0]) * rows.transpose() * rows;
      }
    }
    for (Index a = 0; a < m; ++a) {
      const Index rowA =
          (u_->first(cell.u) + a / (v_->degree + 1)) * columns_ + v_->first(cell.v) + a % (v_->degree + 1);
      for (Index b = 0; b < m; ++b) {
        const Index rowB =
            (u_->first(cell.u) + b / (v_->degree + 1)) * columns_ + v_->first(cell.v) + b % (v_->degree + 1);
        entries.emplace_back(rowA, rowB, element(a, b));
      }
    }
  }
  metric_.resize(static_cast<Index>(unknownOf_.size()), static_cast<Index>(unknownOf_.size()));
  metric_.setFromTriplets(entries.begin(), entries.end());
}

}  // namespace strak
