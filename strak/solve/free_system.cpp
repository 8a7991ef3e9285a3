#include "strak/solve/free_system.h"

#include <algorithm>
#include <array>
#include <limits>

namespace strak {

using Eigen::Index;

FreeSystem::FreeSystem(const BallProblem& p) {
  const BoxLayout& layout = p.energy->layout();
  const Index columns = layout.size[2];
  number.assign(static_cast<std::size_t>(layout.points()), -1);
  for (Index r = 0; r < layout.rows(); ++r) {
    for (Index j = 0; j < columns; ++j) {
      if (p.free->row(r, 0)[j] > 0) number[static_cast<std::size_t>(r * columns + j)] = count++;
    }
  }
  linear = toPoints(layout, *p.linear);
  std::array<Index, 3> reach{0, 0, 0};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (layout.direction[axis] >= 0) {
      reach[axis] = p.products.front().factors[static_cast<std::size_t>(layout.direction[axis])]->bandwidth;
    }
  }
  const auto factor = [&](const KroneckerProduct& product, std::size_t axis, Index i, Index j) {
    const int direction = layout.direction[axis];
    return direction < 0 ? 1.0 : (*product.factors[static_cast<std::size_t>(direction)])(i, j);
  };
  std::vector<Eigen::Triplet<double>> entries;
  for (Index point = 0; point < layout.points(); ++point) {
    const Index row = number[static_cast<std::size_t>(point)];
    if (row < 0) continue;
    const std::array<Index, 3> at{point / columns / layout.size[1], point / columns % layout.size[1], point % columns};
    std::array<Index, 3> low, high;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::max<Index>(0, at[axis] - reach[axis]);
      high[axis] = std::min(layout.size[axis] - 1, at[axis] + reach[axis]);
    }
    for (Index a = low[0]; a <= high[0]; ++a) {
      for (Index b = low[1]; b <= high[1]; ++b) {
        for (Index c = low[2]; c <= high[2]; ++c) {
          const Index column = number[static_cast<std::size_t>((a * layout.size[1] + b) * columns + c)];
          if (column < 0 || column > row) continue;  // the lower triangle is enough
          double value = 0;
          for (const auto& product : p.products) {
            value += product.coefficient * factor(product, 0, at[0], a) * factor(product, 1, at[1], b) *
                     factor(product, 2, at[2], c);
          }
          entries.emplace_back(static_cast<int>(row), static_cast<int>(column), value);
        }
      }
    }
  }
  matrix.resize(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
}

FreeSystem::Points FreeSystem::toPoints(const BoxLayout& layout, const Field& field) const {
  Points result(count, layout.components);
  for (Index r = 0; r < layout.rows(); ++r) {
    for (Index j = 0; j < layout.size[2]; ++j) {
      const Index n = number[static_cast<std::size_t>(r * layout.size[2] + j)];
      if (n < 0) continue;
      for (int c = 0; c < layout.components; ++c) result(n, c) = field.row(r, c)[j];
    }
  }
  return result;
}

void FreeSystem::toField(const BoxLayout& layout, const Points& values, Field& field) const {
  for (Index r = 0; r < layout.rows(); ++r) {
    for (Index j = 0; j < layout.size[2]; ++j) {
      const Index n = number[static_cast<std::size_t>(r * layout.size[2] + j)];
      for (int c = 0; c < layout.components; ++c) field.row(r, c)[j] = n < 0 ? 0 : values(n, c);
    }
  }
}

ShiftedFactor::ShiftedFactor(const Eigen::SparseMatrix<double>& matrix) : matrix_(matrix) {
  solver_.analyzePattern(matrix_);
}

bool ShiftedFactor::factor(const Eigen::VectorXd& shift) {
  Eigen::SparseMatrix<double> shifted = matrix_;
  shifted.diagonal() += shift;
  solver_.factorize(shifted);
  return solver_.info() == Eigen::Success;
}

double dualValue(const FreeSystem& system, double radius, const Eigen::VectorXd& lambda, const FreeSystem::Points& z,
                 ShiftedFactor& factor) {
  if (!factor.factor(lambda)) return -std::numeric_limits<double>::infinity();
  const FreeSystem::Points h = system.times(z) + system.linear;
  const FreeSystem::Points rest = h + lambda.asDiagonal() * z;
  const double value = z.cwiseProduct(h + system.linear).sum();
  const Eigen::VectorXd slack = radius * radius - z.rowwise().squaredNorm().array();
  return value - lambda.dot(slack) - rest.cwiseProduct(factor.solve(rest)).sum();
}

}  // namespace strak
