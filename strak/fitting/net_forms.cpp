#include "strak/fitting/net_forms.h"

#include <fmt/format.h>

#include <algorithm>

#include "strak/base/error.h"

namespace strak {

namespace {

// The coordinates of a point are neighbours on its line, so that the factor's blocks are the points.
std::array<Index, 2> interleaved(const std::array<Index, 2>& sizes, Index coordinates) {
  return {sizes[0], sizes[1] * coordinates};
}

std::array<int, 2> interleaved(const std::array<int, 2>& reach, Index coordinates) {
  return {reach[0], static_cast<int>(coordinates * (reach[1] + 1) - 1)};
}

}  // namespace

double valueOf(const NetForm& form, const Net& change, Index columnsOfNet) {
  double sum = form.offset;
  for (Index i = 0; i < form.values.rows(); ++i) {
    for (Index j = 0; j < form.values.cols(); ++j) {
      sum += form.values(i, j) * change.row((form.line + i) * columnsOfNet + form.column + j).dot(form.direction);
    }
  }
  return sum;
}

FormSystem::FormSystem(const NetMatrix& matrix, Index coordinates, const std::vector<Index>& held)
    : matrix_(matrix),
      coordinates_(coordinates),
      solver_(interleaved(matrix.sizes, coordinates), interleaved(matrix.reach, coordinates)) {
  if (held.empty()) return;
  held_.assign(static_cast<std::size_t>(matrix.size() * coordinates), 0);
  for (Index r : held) {
    if (r < 0 || r >= matrix.size()) throw InvalidInput(fmt::format("there is no control point {} to hold", r));
    std::fill_n(held_.begin() + r * coordinates, coordinates, char{1});
  }
}

double FormSystem::strength(const NetForm& form) const {
  double best = 0;
  for (Index i = 0; i < form.values.rows(); ++i) {
    for (Index j = 0; j < form.values.cols(); ++j) {
      const Index point = (form.line + i) * matrix_.sizes[1] + form.column + j;
      if (!held_.empty() && held_[static_cast<std::size_t>(point * coordinates_)] != 0) continue;
      const double value = form.values(i, j);
      best = std::max(best, value * value * form.direction.squaredNorm() / matrix_.at(point, 0, 0));
    }
  }
  return best;
}

bool FormSystem::factor(const std::vector<NetForm>& forms) {
  NetMatrix matrix(interleaved(matrix_.sizes, coordinates_), interleaved(matrix_.reach, coordinates_));
  const auto c = static_cast<int>(coordinates_);
  for (Index r = 0; r < matrix_.size(); ++r) {
    for (int di = -matrix_.reach[0]; di <= matrix_.reach[0]; ++di) {
      for (int dj = -matrix_.reach[1]; dj <= matrix_.reach[1]; ++dj) {
        for (int k = 0; k < c; ++k) matrix.at(r * c + k, di, c * dj) = matrix_.at(r, di, dj);
      }
    }
  }
  for (const NetForm& form : forms) {
    const auto p = static_cast<int>(form.values.rows()), q = static_cast<int>(form.values.cols()) * c;
    for (int i = 0; i < p; ++i) {
      for (int j = 0; j < q; ++j) {
        const double left = form.weight * form.values(i, j / c) * form.direction[j % c];
        const Index row = ((form.line + i) * matrix_.sizes[1] + form.column) * c + j;
        for (int m = 0; m < p; ++m) {
          for (int l = 0; l < q; ++l) {
            matrix.at(row, m - i, l - j) += left * form.values(m, l / c) * form.direction[l % c];
          }
        }
      }
    }
  }
  return solver_.factor(matrix, held_);
}

Net FormSystem::solve(const std::vector<NetForm>& forms, const std::vector<double>& multipliers) const {
  Net right = Net::Zero(matrix_.size(), coordinates_);
  for (std::size_t k = 0; k < forms.size(); ++k) {
    const NetForm& form = forms[k];
    const double force = -form.weight * (form.offset + multipliers[k]);
    for (Index i = 0; i < form.values.rows(); ++i) {
      for (Index j = 0; j < form.values.cols(); ++j) {
        right.row((form.line + i) * matrix_.sizes[1] + form.column + j) += force * form.values(i, j) * form.direction;
      }
    }
  }
  const NetVectors solved = solver_.solve(Eigen::Map<const NetVectors>(right.data(), right.size(), 1));
  return Eigen::Map<const Net>(solved.data(), right.rows(), coordinates_);
}

}  // namespace strak
