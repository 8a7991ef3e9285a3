#include "strak/solve/tied_points.h"

#include <algorithm>
#include <map>

#include "strak/base/error.h"

namespace strak {

using Eigen::Index;
using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

TiedPoints::TiedPoints(Index unknowns, std::vector<std::vector<Term>> points)
    : points_(std::move(points)), plane_(static_cast<std::size_t>(unknowns), -1) {
  for (const auto& terms : points_) {
    for (const Term& term : terms) {
      if (term.unknown < 0 || term.unknown >= unknowns)
        throw InvalidInput("a tied point follows an unknown that is none");
    }
  }
}

Eigen::Matrix3d TiedPoints::projection(int unknown) const {
  const int plane = plane_[static_cast<std::size_t>(unknown)];
  return plane < 0 ? Eigen::Matrix3d::Identity() : projections_[static_cast<std::size_t>(plane)];
}

void TiedPoints::confine(int unknown, const Eigen::Vector3d& direction) {
  constexpr double kSameDirection = 1e-6;
  const Eigen::Matrix3d now = projection(unknown);
  const Eigen::Vector3d left = now * direction.normalized();
  if (left.norm() < kSameDirection) return;
  const Eigen::Vector3d n = left.normalized();
  int& plane = plane_[static_cast<std::size_t>(unknown)];
  if (plane < 0) {
    plane = static_cast<int>(projections_.size());
    projections_.emplace_back();
  }
  projections_[static_cast<std::size_t>(plane)] = now - n * n.transpose();
}

Eigen::Vector3d TiedPoints::at(int point, const Eigen::VectorXd& y) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Term& term : terms(point)) {
    const Eigen::Vector3d unknown = y.segment<3>(3 * static_cast<Index>(term.unknown));
    sum += term.weight * (isConfined(term.unknown) ? projection(term.unknown) * unknown : unknown);
  }
  return sum;
}

Eigen::VectorXd TiedPoints::confined(Eigen::VectorXd y) const {
  for (int u = 0; u < static_cast<int>(plane_.size()); ++u) {
    if (isConfined(u)) y.segment<3>(3 * u) = (projection(u) * y.segment<3>(3 * u)).eval();
  }
  return y;
}

Eigen::VectorXd TiedPoints::reduced(const Eigen::VectorXd& gradient) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(3 * unknowns());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    for (const Term& term : points_[i]) {
      sum.segment<3>(3 * term.unknown) += term.weight * gradient.segment<3>(3 * static_cast<Index>(i));
    }
  }
  return confined(std::move(sum));
}

BallRows TiedPoints::reduced(const BallRows& rows) const {
  BallRows result;
  result.radius = rows.radius;
  for (std::size_t r = 0; r < rows.radius.size(); ++r) {
    std::map<int, double> sum;
    for (auto k = static_cast<std::size_t>(rows.start[r]); k < static_cast<std::size_t>(rows.start[r + 1]); ++k) {
      for (const Term& term : terms(rows.point[k])) sum[term.unknown] += rows.weight[k] * term.weight;
    }
    for (const auto& [unknown, weight] : sum) {
      result.point.push_back(unknown);
      result.weight.push_back(weight);
    }
    result.start.push_back(static_cast<Index>(result.point.size()));
  }
  return result;
}

std::vector<std::vector<int>> TiedPoints::reduced(const std::vector<std::vector<int>>& cliques) const {
  std::vector<std::vector<int>> result;
  for (const auto& clique : cliques) {
    std::vector<int>& unknowns = result.emplace_back();
    for (int point : clique) {
      if (point < 0) continue;
      for (const Term& term : terms(point)) unknowns.push_back(term.unknown);
    }
    std::sort(unknowns.begin(), unknowns.end());
    unknowns.erase(std::unique(unknowns.begin(), unknowns.end()), unknowns.end());
  }
  return result;
}

TiedMatrix::TiedMatrix(const TiedPoints& tied, std::shared_ptr<const BlockPattern> full, const BlockPattern& unknowns)
    : tied_(tied), full_(std::move(full)) {
  const auto isPlain = [&](int point) {
    const auto& terms = tied_.terms(point);
    return terms.size() == 1 && terms.front().weight == 1 && !tied_.isConfined(terms.front().unknown);
  };
  for (int j = 0; j < static_cast<int>(full_->size()); ++j) {
    const auto from = full_->start[static_cast<std::size_t>(j)], to = full_->start[static_cast<std::size_t>(j) + 1];
    for (Index place = from; place < to; ++place) {
      const int i = full_->rows[static_cast<std::size_t>(place)];
      const bool plain = isPlain(i) && isPlain(j);
      const int ui = plain ? tied_.terms(i).front().unknown : -1, uj = plain ? tied_.terms(j).front().unknown : -1;
      direct_.push_back(plain && ui >= uj && (ui > uj || i == j) ? unknowns.place(ui, uj) : -1);
      if (direct_.back() >= 0) continue;
      // Of a block beside the diagonal its transpose is there, too, above the diagonal.
      const auto add = [&](int row, int column, bool transposed) {
        for (const TiedPoints::Term& a : tied_.terms(row)) {
          for (const TiedPoints::Term& b : tied_.terms(column)) {
            if (a.unknown < b.unknown) continue;
            shares_.push_back(
                {place, unknowns.place(a.unknown, b.unknown), a.weight * b.weight, transposed, a.unknown, b.unknown});
          }
        }
      };
      add(i, j, false);
      if (i != j) add(j, i, true);
    }
  }
}

void TiedMatrix::add(const BlockMatrix& full, BlockMatrix& matrix) const {
  for (Index place = 0; place < full_->blocks(); ++place) {
    const Index to = direct_[static_cast<std::size_t>(place)];
    if (to < 0) continue;
    const double* block = full.at(place);
    double* sum = matrix.at(to);
    for (int k = 0; k < 9; ++k) sum[k] += block[k];
  }
  for (const Share& share : shares_) {
    Block block = share.weight * Eigen::Map<const Block>(full.at(share.from));
    if (share.transposed) block.transposeInPlace();
    if (tied_.isConfined(share.left)) block = (tied_.projection(share.left) * block).eval();
    if (tied_.isConfined(share.right)) block = (block * tied_.projection(share.right)).eval();
    Eigen::Map<Block>(matrix.at(share.to)) += block;
  }
  for (int u = 0; u < static_cast<int>(tied_.unknowns()); ++u) {
    if (!tied_.isConfined(u)) continue;
    Eigen::Map<Block> block(matrix.block(u, u));
    const Eigen::Matrix3d forbidden = Eigen::Matrix3d::Identity() - tied_.projection(u);
    const double had = (forbidden * block).trace(), free = 3 - forbidden.trace();
    const double wished = free > 0.5 ? (block.trace() - had) / free : 1;
    const double more = wished - had / forbidden.trace();
    if (more > 0) block += more * forbidden;
  }
}

}  // namespace strak
