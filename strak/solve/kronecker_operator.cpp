#include "strak/solve/kronecker_operator.h"

#include <algorithm>

#include "strak/solve/kernels.h"

namespace strak {

using Eigen::Index;

namespace {

const BandMatrix& identity() {
  static const BandMatrix one = [] {
    BandMatrix m(1, 0);
    m.at(0, 0) = 1;
    return m;
  }();
  return one;
}

bool same(const BandMatrix& a, const BandMatrix& b) { return &a == &b || (a.size == b.size && a.band == b.band); }

}  // namespace

KroneckerOperator::KroneckerOperator(const BoxLayout& layout, const std::vector<KroneckerProduct>& products)
    : layout_(layout) {
  const auto factorOf = [&](const KroneckerProduct& product, std::size_t axis) -> const BandMatrix& {
    const int direction = layout_.direction[axis];
    return direction < 0 ? identity() : *product.factors[static_cast<std::size_t>(direction)];
  };
  std::vector<const BandMatrix*> columnFactors;
  for (const auto& product : products) {
    const BandMatrix& plane = factorOf(product, 0);
    const BandMatrix& row = factorOf(product, 1);
    const BandMatrix& column = factorOf(product, 2);
    planeBandwidth_ = plane.bandwidth;
    rowBandwidth_ = row.bandwidth;
    columnBandwidth_ = column.bandwidth;

    std::size_t columnIndex = 0;
    while (columnIndex < columnFactors.size() && !same(*columnFactors[columnIndex], column)) ++columnIndex;
    if (columnIndex == columnFactors.size()) {
      columnFactors.push_back(&column);
      std::vector<double> bands(static_cast<std::size_t>((2 * column.bandwidth + 1) * layout_.width), 0.0);
      for (int d = 0; d <= 2 * column.bandwidth; ++d) {
        for (Index j = 0; j < column.size; ++j)
          bands[static_cast<std::size_t>(d * layout_.width + j)] = column.band(j, d);
      }
      columnBands_.push_back(std::move(bands));
    }
    int planeIndex = 0;
    while (planeIndex < static_cast<int>(planeFactors_.size()) &&
           !same(planeFactors_[static_cast<std::size_t>(planeIndex)], plane)) {
      ++planeIndex;
    }
    if (planeIndex == static_cast<int>(planeFactors_.size())) {
      planeFactors_.push_back(plane);
      planes_.push_back({planeIndex, {}, {}});
    }
    PlaneOperator& op = planes_[static_cast<std::size_t>(planeIndex)];
    std::size_t s = 0;
    while (s < op.columnBands.size() && op.columnBands[s] != columnIndex) ++s;
    if (s == op.columnBands.size()) {
      op.columnBands.push_back(columnIndex);
      op.rowFactors.emplace_back(static_cast<std::size_t>(row.band.size()), 0.0);
    }
    for (Index i = 0; i < row.band.size(); ++i) {
      op.rowFactors[s][static_cast<std::size_t>(i)] += product.coefficient * row.band.data()[i];
    }
  }
  std::size_t mostTerms = 1;
  for (const auto& op : planes_) mostTerms = std::max(mostTerms, op.columnBands.size());
  const auto window = 2 * static_cast<std::size_t>(rowBandwidth_) + 1;
  ring_.resize(window * mostTerms * static_cast<std::size_t>(layout_.components * layout_.width) + 8);
  const auto planeWindow = (2 * static_cast<std::size_t>(planeBandwidth_) + 1) * planes_.size();
  if (layout_.size[0] > 1) planeRing_.resize(planeWindow * static_cast<std::size_t>(layout_.planeStride()));
  factors_.resize(std::max(window * mostTerms, planeWindow));
  rows_.resize(factors_.size());
}

void KroneckerOperator::applyPlane(const PlaneOperator& op, const double* x, double* y) {
  const Index rows = layout_.size[1];
  const Index width = layout_.width;
  const int p = rowBandwidth_;
  const Index window = 2 * p + 1;
  const auto terms = static_cast<Index>(op.columnBands.size());
  const int components = layout_.components;
  const auto ringRow = [&](Index row, Index s, int c) {
    return ring_.data() + (((row % window) * terms + s) * components + c) * width;
  };
  const auto prepare = [&](Index row) {
    for (Index s = 0; s < terms; ++s) {
      for (int c = 0; c < components; ++c) {
        kernels::chosen().bandTimesRow(columnBands_[op.columnBands[static_cast<std::size_t>(s)]].data(), width,
                                       columnBandwidth_, x + row * layout_.rowStride() + c * layout_.stride,
                                       ringRow(row, s, c), width);
      }
    }
  };
  for (Index row = 0; row < std::min<Index>(p, rows); ++row) prepare(row);
  for (Index i = 0; i < rows; ++i) {
    if (i + p < rows) prepare(i + p);
    const Index low = std::max<Index>(0, i - p);
    const Index high = std::min(rows - 1, i + p);
    for (int c = 0; c < components; ++c) {
      Index count = 0;
      for (Index s = 0; s < terms; ++s) {
        const double* factors = op.rowFactors[static_cast<std::size_t>(s)].data() + i * window + p - i;
        for (Index j = low; j <= high; ++j) {
          factors_[static_cast<std::size_t>(count)] = factors[j];
          rows_[static_cast<std::size_t>(count)] = ringRow(j, s, c);
          ++count;
        }
      }
      kernels::chosen().combineRows(count, factors_.data(), rows_.data(),
                                    y + i * layout_.rowStride() + c * layout_.stride, width);
    }
  }
}

void KroneckerOperator::apply(const Field& x, Field& y) {
  if (planes_.empty()) {
    y.setZero();
    return;
  }
  if (layout_.size[0] == 1 && planes_.size() == 1 && planeBandwidth_ == 0) {
    applyPlane(planes_.front(), x.row(0, 0), y.row(0, 0));
    return;
  }
  const int p = planeBandwidth_;
  const Index window = 2 * p + 1;
  const auto terms = static_cast<Index>(planes_.size());
  const Index plane = layout_.planeStride();
  if (planeRing_.empty()) planeRing_.resize(static_cast<std::size_t>(window * terms * plane));
  const auto ringPlane = [&](Index i, Index q) { return planeRing_.data() + ((i % window) * terms + q) * plane; };
  const auto prepare = [&](Index i) {
    for (Index q = 0; q < terms; ++q)
      applyPlane(planes_[static_cast<std::size_t>(q)], x.row(i * layout_.size[1], 0), ringPlane(i, q));
  };
  for (Index i = 0; i < std::min<Index>(p, layout_.size[0]); ++i) prepare(i);
  for (Index i = 0; i < layout_.size[0]; ++i) {
    if (i + p < layout_.size[0]) prepare(i + p);
    Index count = 0;
    for (Index q = 0; q < terms; ++q) {
      const BandMatrix& factor =
          planeFactors_[static_cast<std::size_t>(planes_[static_cast<std::size_t>(q)].planeFactor)];
      for (Index j = std::max<Index>(0, i - p); j <= std::min(layout_.size[0] - 1, i + p); ++j) {
        factors_[static_cast<std::size_t>(count)] = factor(i, j);
        rows_[static_cast<std::size_t>(count)] = ringPlane(j, q);
        ++count;
      }
    }
    kernels::chosen().combineRows(count, factors_.data(), rows_.data(), y.row(i * layout_.size[1], 0), plane);
  }
}

Field KroneckerOperator::diagonal() const {
  Field result(layout_.scalar());
  const int p = rowBandwidth_;
  for (Index r = 0; r < layout_.rows(); ++r) {
    double* target = result.row(r, 0);
    const Index i = r % layout_.size[1];
    for (const auto& op : planes_) {
      const double outer =
          planeFactors_[static_cast<std::size_t>(op.planeFactor)](r / layout_.size[1], r / layout_.size[1]);
      for (std::size_t s = 0; s < op.columnBands.size(); ++s) {
        const double factor = outer * op.rowFactors[s][static_cast<std::size_t>(i * (2 * p + 1) + p)];
        const double* band = columnBands_[op.columnBands[s]].data() + columnBandwidth_ * layout_.width;
        for (Index j = 0; j < layout_.size[2]; ++j) target[j] += factor * band[j];
      }
    }
  }
  return result;
}

}  // namespace strak
