#include "strak/fitting/fit_kernels.h"

// The compiler turns the innermost loops, whose lengths it knows for degrees up to 9, into vectors.

namespace strak::fitkernels::STRAK_SIMD {

namespace {

using Index = std::ptrdiff_t;

constexpr Index kBatch = 32;      // points whose polynomials are made at once
constexpr Index kMostTerms = 64;  // degrees up to 31

// out[r * stride + i] = T_i(at r), i = 0 .. terms - 1.
inline void chebyshev(const double* records, Index length, Index count, Index terms, Index stride, double* out) {
  for (Index r = 0; r < count; ++r) {
    const double x = records[r * length];
    double* t = out + r * stride;
    double before = 1, now = x;
    for (Index i = 0; i < terms; ++i) {
      t[i] = before;
      const double next = 2 * x * now - before;
      before = now;
      now = next;
    }
  }
}

// kWidth 0: as the layout says.
template <int kWidth>
void addMomentsOf(const StripPoints& points, const CellLayout& layout, bool withMatrix, double* cells) {
  const Index width = kWidth > 0 ? kWidth : layout.width;
  // Terms up to the degree, padded.
  const Index rightWidth = kWidth > 0 ? ((kWidth - 1) / 2 + 4) / 4 * 4 : layout.rightWidth;
  const Index rows = 2 * layout.degree[0] + 1, rightRows = layout.degree[0] + 1;
  const Index columns = layout.columns;
  alignas(64) double u[kBatch * kMostTerms];
  alignas(64) double v[kBatch * kMostTerms];
  for (Index begin = 0; begin < points.count; begin += kBatch) {
    const Index count = points.count - begin < kBatch ? points.count - begin : kBatch;
    const double* records = points.records + begin * points.length;
    chebyshev(records, points.length, count, withMatrix ? rows : rightRows, kMostTerms, u);
    chebyshev(records + 1, points.length, count, withMatrix ? width : rightWidth, width, v);
    for (Index r = 0; r < count; ++r) {
      const double* record = records + r * points.length;
      double* cell = cells + points.cells[begin + r] * layout.length;
      const double weight = record[2];
      const double* tu = u + r * kMostTerms;
      const double* tv = v + r * width;
      if (withMatrix) {
        for (Index i = 0; i < rows; ++i) {
          const double factor = weight * tu[i];
          double* to = cell + i * width;
          for (Index j = 0; j < width; ++j) to[j] += factor * tv[j];
        }
      }
      cell += rows * width;
      for (Index c = 0; c < columns; ++c) {
        const double value = weight * record[3 + c];
        for (Index i = 0; i < rightRows; ++i) {
          const double factor = value * tu[i];
          for (Index j = 0; j < rightWidth; ++j) cell[j] += factor * tv[j];
          cell += rightWidth;
        }
      }
    }
  }
}

template <int kRightWidth>
void evaluateCellsOf(const StripPoints& points, const CellLayout& layout, const double* coefficients, double* values) {
  const Index width = kRightWidth > 0 ? kRightWidth : layout.rightWidth;
  const Index rows = layout.degree[0] + 1;
  alignas(64) double u[kBatch * kMostTerms];
  alignas(64) double v[kBatch * kMostTerms];
  double sum[kMostTerms];
  for (Index begin = 0; begin < points.count; begin += kBatch) {
    const Index count = points.count - begin < kBatch ? points.count - begin : kBatch;
    const double* records = points.records + begin * points.length;
    chebyshev(records, points.length, count, rows, kMostTerms, u);
    chebyshev(records + 1, points.length, count, width, width, v);
    for (Index r = 0; r < count; ++r) {
      const double* c = coefficients + points.cells[begin + r] * (layout.columns * rows * width);
      const double* tu = u + r * kMostTerms;
      const double* tv = v + r * width;
      for (Index column = 0; column < layout.columns; ++column) {
        for (Index j = 0; j < width; ++j) sum[j] = 0;
        for (Index i = 0; i < rows; ++i) {
          const double factor = tu[i];
          for (Index j = 0; j < width; ++j) sum[j] += factor * c[j];
          c += width;
        }
        double value = 0;
        for (Index j = 0; j < width; ++j) value += sum[j] * tv[j];
        values[(begin + r) * layout.columns + column] = value;
      }
    }
  }
}

}  // namespace

void addMoments(const StripPoints& points, const CellLayout& layout, bool withMatrix, double* cells) {
  switch (layout.width) {
    case 4:
      return addMomentsOf<4>(points, layout, withMatrix, cells);
    case 8:
      return addMomentsOf<8>(points, layout, withMatrix, cells);
    case 12:
      return addMomentsOf<12>(points, layout, withMatrix, cells);
    case 16:
      return addMomentsOf<16>(points, layout, withMatrix, cells);
    case 20:
      return addMomentsOf<20>(points, layout, withMatrix, cells);
    default:
      return addMomentsOf<0>(points, layout, withMatrix, cells);
  }
}

void evaluateCells(const StripPoints& points, const CellLayout& layout, const double* coefficients, double* values) {
  switch (layout.rightWidth) {
    case 4:
      return evaluateCellsOf<4>(points, layout, coefficients, values);
    case 8:
      return evaluateCellsOf<8>(points, layout, coefficients, values);
    default:
      return evaluateCellsOf<0>(points, layout, coefficients, values);
  }
}

}  // namespace strak::fitkernels::STRAK_SIMD
