#include "strak/solve/dense_kernels.h"

#if defined(__AVX512F__)
#define STRAK_LANES 8
#define STRAK_TILE_VECTORS 3
#define STRAK_TILE_COLUMNS 8
#elif defined(__AVX2__)
#define STRAK_LANES 4
#define STRAK_TILE_VECTORS 3
#define STRAK_TILE_COLUMNS 4
#else
#define STRAK_LANES 2
#define STRAK_TILE_VECTORS 2
#define STRAK_TILE_COLUMNS 4
#endif

namespace strak::dense::STRAK_SIMD {

namespace {

using Size = std::ptrdiff_t;
constexpr Size kLanes = STRAK_LANES;
constexpr Size kVectors = STRAK_TILE_VECTORS;
constexpr Size kTileRows = kVectors * kLanes;
constexpr Size kTileColumns = STRAK_TILE_COLUMNS;
constexpr Size kNarrow = 16;  // columns that are eliminated one by one
static_assert(kTileRows <= kPad && kTileColumns <= kPad);

using Vec = double __attribute__((vector_size(STRAK_LANES * 8), aligned(8), may_alias));

inline Vec load(const double* p) { return *reinterpret_cast<const Vec*>(p); }
inline void store(double* p, Vec v) { *reinterpret_cast<Vec*>(p) = v; }

// Strips of `height` rows one after another, each column by column, padded with zeros.
void pack(Size n, Size k, const double* a, Size lda, Size height, double* out) {
  for (Size i = 0; i < n; i += height) {
    const Size rows = n - i < height ? n - i : height;
    for (Size p = 0; p < k; ++p) {
      const double* from = a + i + p * lda;
      for (Size r = 0; r < rows; ++r) *out++ = from[r];
      for (Size r = rows; r < height; ++r) *out++ = 0;
    }
  }
}

// tile = strip of A times strip of B transposed, kTileRows x kTileColumns.
inline void multiply(Size k, const double* a, const double* b, Vec (&tile)[kTileColumns][kVectors]) {
  for (Size c = 0; c < kTileColumns; ++c) {
    for (Size v = 0; v < kVectors; ++v) tile[c][v] = Vec{};
  }
  for (Size p = 0; p < k; ++p, a += kTileRows, b += kTileColumns) {
    Vec column[kVectors];
    for (Size v = 0; v < kVectors; ++v) column[v] = load(a + v * kLanes);
    for (Size c = 0; c < kTileColumns; ++c) {
      const double factor = b[c];
      for (Size v = 0; v < kVectors; ++v) tile[c][v] += column[v] * factor;
    }
  }
}

// C(i, j) += sign sum over p of A(i, p) A(j, p) for i < n, j < m, i >= j; k <= kBlock.
void addTrapezoid(Size n, Size m, Size k, const double* a, Size lda, double sign, double* c, Size ldc,
                  double* scratch) {
  double* left = scratch;
  double* right = scratch + kBlock * (n + kPad);
  pack(n, k, a, lda, kTileRows, left);
  pack(m, k, a, lda, kTileColumns, right);
  for (Size j = 0; j < m; j += kTileColumns) {
    const double* b = right + j * k;
    for (Size i = j / kTileRows * kTileRows; i < n; i += kTileRows) {
      Vec tile[kTileColumns][kVectors];
      multiply(k, left + i * k, b, tile);
      if (i >= j + kTileColumns && i + kTileRows <= n && j + kTileColumns <= m) {
        for (Size q = 0; q < kTileColumns; ++q) {
          for (Size v = 0; v < kVectors; ++v) {
            double* at = c + i + v * kLanes + (j + q) * ldc;
            store(at, load(at) + sign * tile[q][v]);
          }
        }
        continue;
      }
      for (Size q = 0; q < kTileColumns && j + q < m; ++q) {
        for (Size r = 0; r < kTileRows && i + r < n; ++r) {
          if (i + r >= j + q) c[i + r + (j + q) * ldc] += sign * tile[q][r / kLanes][r % kLanes];
        }
      }
    }
  }
}

}  // namespace

void addOuter(Size n, Size k, const double* a, Size lda, double sign, double* c, Size ldc, double* scratch) {
  for (Size p = 0; p < k; p += kBlock) {
    addTrapezoid(n, n, k - p < kBlock ? k - p : kBlock, a + p * lda, lda, sign, c, ldc, scratch);
  }
}

bool eliminate(Size all, Size own, double* left, double* rest, double* scratch) {
  for (Size j = 0; j < own; j += kBlock) {
    const Size blockEnd = own - j < kBlock ? own : j + kBlock;
    for (Size i = j; i < blockEnd; i += kNarrow) {
      const Size end = blockEnd - i < kNarrow ? blockEnd : i + kNarrow;
      for (Size c = i; c < end; ++c) {
        double* column = left + c * all;
        if (!(column[c] > 0)) return false;
        const double scale = 1 / __builtin_sqrt(column[c]);
        for (Size r = c; r < all; ++r) column[r] *= scale;
        for (Size d = c + 1; d < end; ++d) {
          double* other = left + d * all;
          const double factor = column[d];
          for (Size r = d; r < all; ++r) other[r] -= factor * column[r];
        }
      }
      if (end < blockEnd) {
        addTrapezoid(all - end, blockEnd - end, end - i, left + end + i * all, all, -1, left + end + end * all, all,
                     scratch);
      }
    }
    if (blockEnd < own) {
      addTrapezoid(all - blockEnd, own - blockEnd, blockEnd - j, left + blockEnd + j * all, all, -1,
                   left + blockEnd + blockEnd * all, all, scratch);
    }
  }
  if (own < all) addOuter(all - own, own, left + own, all, -1, rest, all - own, scratch);
  return true;
}

}  // namespace strak::dense::STRAK_SIMD
