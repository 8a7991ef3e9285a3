#include "strak/solve/modal_solver.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "strak/base/error.h"
#include "strak/solve/kernels.h"

namespace strak {

using Eigen::Index;

namespace {

int longAxisOf(const BoxLayout& layout) { return layout.directions == 3 ? 0 : 1; }

bool isShort(const BoxLayout& layout, int axis) {
  return axis != longAxisOf(layout) && layout.direction[static_cast<std::size_t>(axis)] >= 0;
}

}  // namespace

ModalBasis::ModalBasis(const BoxLayout& layout, const std::vector<const BandMatrix*>& stiffness,
                       const std::vector<const BandMatrix*>& mass) {
  for (int axis = 1; axis < 3; ++axis) {
    if (!isShort(layout, axis)) continue;
    const auto d = static_cast<std::size_t>(layout.direction[static_cast<std::size_t>(axis)]);
    const Index n = layout.size[static_cast<std::size_t>(axis)];
    Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(stiffness[d]->dense(), mass[d]->dense());
    if (solver.info() != Eigen::Success) {
      throw Failure("the eigenvalues of a Gram matrix were not found: rescale the knots (their spans differ too much)");
    }
    const Index padded = (n + 7) / 8 * 8;
    auto& s = forward[static_cast<std::size_t>(axis)];
    auto& t = backward[static_cast<std::size_t>(axis)];
    s = RowMatrix::Zero(n, padded);
    s.leftCols(n) = solver.eigenvectors();
    t = RowMatrix::Zero(n, padded);
    t.leftCols(n) = solver.eigenvectors().transpose();
  }
}

ModalSolver::ModalSolver(const BoxLayout& layout, const std::vector<KroneckerProduct>& products,
                         const ModalBasis& basis)
    : layout_(layout), basis_(basis), longAxis_(longAxisOf(layout)), work_(layout) {
  const Index planeRows = longAxis_ == 0 ? layout_.size[1] : 1;
  const Index modes = planeRows * layout_.width;
  const Index slabs = layout_.size[static_cast<std::size_t>(longAxis_)];
  const auto longDirection = static_cast<std::size_t>(layout_.direction[static_cast<std::size_t>(longAxis_)]);

  // Diagonal of S^T V S.
  const auto quotients = [&](int axis, const BandMatrix& v) {
    const auto& s = basis_.forward[static_cast<std::size_t>(axis)];
    Eigen::VectorXd q = Eigen::VectorXd::Zero(v.size);
    for (Index i = 0; i < v.size; ++i) {
      for (Index j = std::max<Index>(0, i - v.bandwidth); j <= std::min(v.size - 1, i + v.bandwidth); ++j) {
        const double entry = v(i, j);
        for (Index k = 0; k < v.size; ++k) q[k] += entry * s(i, k) * s(j, k);
      }
    }
    return q;
  };
  std::vector<const BandMatrix*> longFactors;
  std::vector<std::vector<double>> modeFactors;
  for (const auto& product : products) {
    const BandMatrix& factor = *product.factors[longDirection];
    std::vector<double> values(static_cast<std::size_t>(modes), 0.0);
    const auto shortFactor = [&](int axis) {
      return isShort(layout_, axis)
                 ? quotients(
                       axis,
                       *product.factors[static_cast<std::size_t>(layout_.direction[static_cast<std::size_t>(axis)])])
                 : Eigen::VectorXd::Ones(axis == 1 ? planeRows : layout_.size[2]).eval();
    };
    const Eigen::VectorXd byRow = longAxis_ == 0 ? shortFactor(1) : Eigen::VectorXd::Ones(1).eval();
    const Eigen::VectorXd byColumn = shortFactor(2);
    for (Index q = 0; q < planeRows; ++q) {
      for (Index k = 0; k < layout_.size[2]; ++k) {
        values[static_cast<std::size_t>(q * layout_.width + k)] = product.coefficient * byRow[q] * byColumn[k];
      }
    }
    std::size_t t = 0;
    while (t < longFactors.size() && longFactors[t] != &factor) ++t;
    if (t == longFactors.size()) {
      longFactors.push_back(&factor);
      modeFactors.push_back(std::move(values));
    } else {
      for (std::size_t j = 0; j < values.size(); ++j) modeFactors[t][j] += values[j];
    }
    bandwidth_ = factor.bandwidth;
  }
  std::vector<double> used(static_cast<std::size_t>(modes), 0.0);
  for (Index q = 0; q < planeRows; ++q) {
    std::fill_n(used.begin() + q * layout_.width, layout_.size[2], 1.0);
  }
  factors_.assign(static_cast<std::size_t>(slabs * (bandwidth_ + 1) * modes), 0.0);
  std::vector<const double*> rows;
  rows.reserve(modeFactors.size());
  for (const auto& values : modeFactors) rows.push_back(values.data());
  std::vector<double> entries(rows.size());
  for (Index i = 0; i < slabs; ++i) {
    for (int d = 0; d <= std::min<Index>(bandwidth_, i); ++d) {
      for (std::size_t t = 0; t < rows.size(); ++t) entries[t] = (*longFactors[t])(i, i - d);
      kernels::chosen().combineRows(static_cast<Index>(rows.size()), entries.data(), rows.data(),
                                    factors_.data() + (i * (bandwidth_ + 1) + d) * modes, modes);
    }
  }
  conditionIndicator_ = kernels::chosen().factorBands(slabs, bandwidth_, modes, used.data(), factors_.data());
}

void ModalSolver::solve(const Field& b, Field& x) {
  const auto& k = kernels::chosen();
  const Index stride = layout_.stride;
  const Index width = layout_.width;
  const Index rowStride = layout_.rowStride();
  const Index planeRows = longAxis_ == 0 ? layout_.size[1] : 1;
  const bool shortColumns = isShort(layout_, 2);
  const bool shortRows = isShort(layout_, 1);

  // Into the modes: columns first, then the rows of every plane.
  const auto alongColumns = [&](const Field& from, Field& to, const ModalBasis::RowMatrix& s) {
    k.multiply(layout_.rows() * layout_.components, width, layout_.size[2], from.row(0, 0), stride, s.data(), s.cols(),
               to.row(0, 0), stride);
  };
  const auto alongRows = [&](const Field& from, Field& to, const ModalBasis::RowMatrix& s) {
    for (Index plane = 0; plane < layout_.size[0]; ++plane) {
      k.multiply(layout_.size[1], rowStride, layout_.size[1], s.data(), s.cols(), from.row(plane * layout_.size[1], 0),
                 rowStride, to.row(plane * layout_.size[1], 0), rowStride);
    }
  };
  const Field* modal = &b;
  if (shortColumns) {
    alongColumns(b, work_, basis_.forward[2]);
    modal = &work_;
  }
  if (shortRows) {
    alongRows(*modal, x, basis_.backward[1]);
    modal = &x;
  }
  if (modal != &x) std::copy_n(modal->data(), modal->size(), x.data());

  // L D L^T along the slabs, all modes and components at once.
  const Index slabs = layout_.size[static_cast<std::size_t>(longAxis_)];
  const Index modes = planeRows * width;
  const Index slabStride = planeRows * rowStride;
  const auto factor = [&](Index i, Index d, Index q) {
    return factors_.data() + (i * (bandwidth_ + 1) + d) * modes + q * width;
  };
  const auto each = [&](const auto& work) {
    for (Index q = 0; q < planeRows; ++q) {
      for (int c = 0; c < layout_.components; ++c) work(q, q * rowStride + c * stride);
    }
  };
  double* base = x.row(0, 0);
  for (Index i = 0; i < slabs; ++i) {
    each([&](Index q, Index offset) {
      double* target = base + i * slabStride + offset;
      for (Index d = 1; d <= std::min<Index>(bandwidth_, i); ++d) {
        k.subtractProduct(target, factor(i, d, q), target - d * slabStride, width);
      }
    });
  }
  for (Index i = slabs - 1; i >= 0; --i) {
    each([&](Index q, Index offset) {
      double* target = base + i * slabStride + offset;
      k.multiplyPointwise(target, factor(i, 0, q), width);
      for (Index d = 1; d <= std::min<Index>(bandwidth_, slabs - 1 - i); ++d) {
        k.subtractProduct(target, factor(i + d, d, q), target + d * slabStride, width);
      }
    });
  }

  // And back.
  if (shortRows) {
    alongRows(x, work_, basis_.forward[1]);
    if (shortColumns) {
      alongColumns(work_, x, basis_.backward[2]);
    } else {
      std::copy_n(work_.data(), work_.size(), x.data());
    }
  } else if (shortColumns) {
    alongColumns(x, work_, basis_.backward[2]);
    std::copy_n(work_.data(), work_.size(), x.data());
  }
}

}  // namespace strak
