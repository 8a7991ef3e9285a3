#include "strak/solve/net_matrix.h"

#include <algorithm>
#include <cmath>

namespace strak {

using Eigen::Index;

namespace {

// Points of a line that are one point of the block matrix.
constexpr Index kGroup = 3;

Index blocksOf(Index points) { return (points + kGroup - 1) / kGroup; }

std::shared_ptr<const BlockPattern> patternOf(const std::array<Index, 2>& sizes, const std::array<int, 2>& reach) {
  auto pattern = std::make_shared<BlockPattern>();
  const Index lines = sizes[0], blocks = blocksOf(sizes[1]);
  // Neighbours `reach` apart are at most so many groups apart.
  const Index across = (reach[1] + kGroup - 1) / kGroup;
  pattern->start.push_back(0);
  for (Index i = 0; i < lines; ++i) {
    for (Index b = 0; b < blocks; ++b) {
      for (Index k = i; k <= std::min(lines - 1, i + reach[0]); ++k) {
        const Index from = k == i ? b : std::max<Index>(0, b - across);
        for (Index c = from; c <= std::min(blocks - 1, b + across); ++c) {
          pattern->rows.push_back(static_cast<int>(k * blocks + c));
        }
      }
      pattern->start.push_back(static_cast<Index>(pattern->rows.size()));
    }
  }
  return pattern;
}

Eigen::MatrixX3d placesOf(const std::array<Index, 2>& sizes) {
  const Index blocks = blocksOf(sizes[1]);
  Eigen::MatrixX3d places(sizes[0] * blocks, 3);
  for (Index i = 0; i < sizes[0]; ++i) {
    for (Index b = 0; b < blocks; ++b) {
      places.row(i * blocks + b) << static_cast<double>(i), static_cast<double>(kGroup * b), 0;
    }
  }
  return places;
}

}  // namespace

NetMatrix::NetMatrix(std::array<Index, 2> theSizes, std::array<int, 2> theReach) : sizes(theSizes), reach(theReach) {
  values.assign(static_cast<std::size_t>(size() * rowLength()), 0.0);
}

double NetMatrix::trace() const {
  double sum = 0;
  for (Index r = 0; r < size(); ++r) sum += at(r, 0, 0);
  return sum;
}

NetVectors NetMatrix::times(const Eigen::Ref<const NetVectors>& x) const {
  NetVectors y = NetVectors::Zero(x.rows(), x.cols());
  const int p = reach[0], q = reach[1];
  for (Index i = 0; i < sizes[0]; ++i) {
    for (Index j = 0; j < sizes[1]; ++j) {
      const Index row = i * sizes[1] + j;
      const auto from = std::max<Index>(-q, -j), to = std::min<Index>(q, sizes[1] - 1 - j);
      for (Index di = std::max<Index>(-p, -i); di <= std::min<Index>(p, sizes[0] - 1 - i); ++di) {
        const double* a = values.data() + row * rowLength() + (di + p) * (2 * q + 1) + q;
        const Index first = row + di * sizes[1];
        for (Index dj = from; dj <= to; ++dj) {
          for (Index c = 0; c < x.cols(); ++c) y(row, c) += a[dj] * x(first + dj, c);
        }
      }
    }
  }
  return y;
}

NetMatrix combined(const NetMatrix& a, double factor, const NetMatrix& b) {
  NetMatrix sum = a;
  for (std::size_t k = 0; k < sum.values.size(); ++k) sum.values[k] += factor * b.values[k];
  return sum;
}

NetCholesky::NetCholesky(std::array<Index, 2> sizes, std::array<int, 2> reach)
    : sizes_(sizes),
      reach_(reach),
      blocksPerLine_(blocksOf(sizes[1])),
      pattern_(patternOf(sizes, reach)),
      matrix_(pattern_),
      factor_(pattern_, placesOf(sizes)) {}

bool NetCholesky::factor(const NetMatrix& matrix, const std::vector<char>& held, double leastPivot) {
  const Index n = matrix.size();
  scale_.resize(n);
  double logScale = 0;
  for (Index r = 0; r < n; ++r) {
    const bool isHeld = !held.empty() && held[static_cast<std::size_t>(r)] != 0;
    const double d = matrix.at(r, 0, 0);
    if (!isHeld && !(d > 0)) return false;
    scale_[r] = isHeld ? 0 : 1 / std::sqrt(d);
    if (!isHeld) logScale += std::log(d);
  }
  matrix_.setZero();
  const int p = reach_[0], q = reach_[1];
  for (Index i = 0; i < sizes_[0]; ++i) {
    for (Index b = 0; b < blocksPerLine_; ++b) {
      const auto block = static_cast<int>(i * blocksPerLine_ + b);
      for (Index entry = pattern_->start[static_cast<std::size_t>(block)];
           entry < pattern_->start[static_cast<std::size_t>(block) + 1]; ++entry) {
        // The block's rows belong to the group `other`, its columns to `block`.
        const Index other = pattern_->rows[static_cast<std::size_t>(entry)];
        const Index k = other / blocksPerLine_, c = other % blocksPerLine_;
        double* out = matrix_.at(entry);
        for (Index s = 0; s < kGroup; ++s) {
          const Index l = kGroup * c + s;
          for (Index t = 0; t < kGroup; ++t) {
            const Index j = kGroup * b + t;
            if (l >= sizes_[1] || j >= sizes_[1]) {
              out[kGroup * s + t] = other == block && s == t ? 1 : 0;
              continue;
            }
            if (std::abs(l - j) > q || k - i > p) continue;
            const Index row = k * sizes_[1] + l, column = i * sizes_[1] + j;
            out[kGroup * s + t] =
                scale_[row] * scale_[column] * matrix.at(row, static_cast<int>(i - k), static_cast<int>(j - l));
            if (row == column) out[kGroup * s + t] = 1;
          }
        }
      }
    }
  }
  if (!factor_.factor(matrix_)) return false;
  const Eigen::VectorXd diagonal = factor_.factorDiagonal();
  const double least = diagonal.minCoeff();
  if (!(least * least >= leastPivot)) return false;
  logDeterminant_ = logScale + 2 * diagonal.array().log().sum();
  return true;
}

NetVectors NetCholesky::solve(const Eigen::Ref<const NetVectors>& right) const {
  NetVectors result(right.rows(), right.cols());
  Eigen::VectorXd b(3 * pattern_->size());
  for (Index c = 0; c < right.cols(); ++c) {
    b.setZero();
    for (Index i = 0; i < sizes_[0]; ++i) {
      for (Index j = 0; j < sizes_[1]; ++j) {
        const Index row = i * sizes_[1] + j;
        b[kGroup * blocksPerLine_ * i + j] = scale_[row] * right(row, c);
      }
    }
    const Eigen::VectorXd x = factor_.solve(b);
    for (Index i = 0; i < sizes_[0]; ++i) {
      for (Index j = 0; j < sizes_[1]; ++j) {
        const Index row = i * sizes_[1] + j;
        result(row, c) = scale_[row] * x[kGroup * blocksPerLine_ * i + j];
      }
    }
  }
  return result;
}

}  // namespace strak
