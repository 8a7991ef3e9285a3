#include "strak/solve/kernels.h"

#if defined(__AVX512F__)
#define STRAK_LANES 8
#elif defined(__AVX2__)
#define STRAK_LANES 4
#else
#define STRAK_LANES 2
#endif

namespace strak::kernels::STRAK_SIMD {

namespace {

constexpr std::ptrdiff_t kLanes = STRAK_LANES;
// A vector that may stand at any address of doubles.
using Vec = double __attribute__((vector_size(STRAK_LANES * 8), aligned(8), may_alias));

inline Vec load(const double* p) { return *reinterpret_cast<const Vec*>(p); }
inline void store(double* p, Vec v) { *reinterpret_cast<Vec*>(p) = v; }
inline Vec broadcast(double a) { return a - Vec{}; }
inline double sum(Vec v) {
  double total = 0;
  for (int i = 0; i < kLanes; ++i) total += v[i];
  return total;
}

// Square roots lane by lane: the compiler turns this into one instruction.
inline Vec squareRoot(Vec v) {
  Vec result;
  for (int i = 0; i < kLanes; ++i) result[i] = __builtin_sqrt(v[i]);
  return result;
}

// kUnroll vectors of the row at j.
template <int kUnroll>
inline void bandBlock(const double* band, std::ptrdiff_t bandStride, int diagonals, const double* x, double* y) {
  Vec acc[kUnroll] = {};
  for (int d = 0; d < diagonals; ++d) {
    const double* b = band + d * bandStride;
    for (int u = 0; u < kUnroll; ++u) acc[u] += load(b + u * kLanes) * load(x + d + u * kLanes);
  }
  for (int u = 0; u < kUnroll; ++u) store(y + u * kLanes, acc[u]);
}

template <int kUnroll>
inline void combineBlock(std::ptrdiff_t count, const double* factors, const double* const* rows, std::ptrdiff_t j,
                         double* y) {
  Vec acc[kUnroll] = {};
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    const Vec f = broadcast(factors[k]);
    for (int u = 0; u < kUnroll; ++u) acc[u] += f * load(rows[k] + j + u * kLanes);
  }
  for (int u = 0; u < kUnroll; ++u) store(y + j + u * kLanes, acc[u]);
}

// kRows x (kUnroll vectors) of C, over a stretch of k; adds to C unless `first`.
template <int kRows, int kUnroll>
inline void multiplyBlock(std::ptrdiff_t k, const double* a, std::ptrdiff_t lda, const double* b, std::ptrdiff_t ldb,
                          double* c, std::ptrdiff_t ldc, bool first) {
  Vec acc[kRows][kUnroll];
  for (int r = 0; r < kRows; ++r) {
    for (int u = 0; u < kUnroll; ++u) acc[r][u] = first ? Vec{} : load(c + r * ldc + u * kLanes);
  }
  for (std::ptrdiff_t l = 0; l < k; ++l) {
    Vec row[kUnroll];
    for (int u = 0; u < kUnroll; ++u) row[u] = load(b + l * ldb + u * kLanes);
    for (int r = 0; r < kRows; ++r) {
      const Vec f = broadcast(a[r * lda + l]);
      for (int u = 0; u < kUnroll; ++u) acc[r][u] += f * row[u];
    }
  }
  for (int r = 0; r < kRows; ++r) {
    for (int u = 0; u < kUnroll; ++u) store(c + r * ldc + u * kLanes, acc[r][u]);
  }
}

template <int kUnroll>
void multiplyStrip(std::ptrdiff_t m, std::ptrdiff_t k, const double* a, std::ptrdiff_t lda, const double* b,
                   std::ptrdiff_t ldb, double* c, std::ptrdiff_t ldc, bool first) {
  std::ptrdiff_t i = 0;
  for (; i + 4 <= m; i += 4) multiplyBlock<4, kUnroll>(k, a + i * lda, lda, b, ldb, c + i * ldc, ldc, first);
  for (; i < m; ++i) multiplyBlock<1, kUnroll>(k, a + i * lda, lda, b, ldb, c + i * ldc, ldc, first);
}

}  // namespace

void bandTimesRow(const double* band, std::ptrdiff_t bandStride, int bandwidth, const double* x, double* y,
                  std::ptrdiff_t n) {
  const int diagonals = 2 * bandwidth + 1;
  const double* start = x - bandwidth;
  std::ptrdiff_t j = 0;
  for (; j + 4 * kLanes <= n; j += 4 * kLanes) bandBlock<4>(band + j, bandStride, diagonals, start + j, y + j);
  for (; j < n; j += kLanes) bandBlock<1>(band + j, bandStride, diagonals, start + j, y + j);
}

void combineRows(std::ptrdiff_t count, const double* factors, const double* const* rows, double* y, std::ptrdiff_t n) {
  std::ptrdiff_t j = 0;
  for (; j + 4 * kLanes <= n; j += 4 * kLanes) combineBlock<4>(count, factors, rows, j, y);
  for (; j < n; j += kLanes) combineBlock<1>(count, factors, rows, j, y);
}

void multiply(std::ptrdiff_t m, std::ptrdiff_t n, std::ptrdiff_t k, const double* a, std::ptrdiff_t lda,
              const double* b, std::ptrdiff_t ldb, double* c, std::ptrdiff_t ldc) {
  // Strips of columns with stretches of k that stay in the first-level cache.
  constexpr int kUnroll = kLanes == 2 ? 2 : 4;
  constexpr std::ptrdiff_t kStretch = 128;
  for (std::ptrdiff_t l = 0; l < k; l += kStretch) {
    const std::ptrdiff_t part = k - l < kStretch ? k - l : kStretch;
    std::ptrdiff_t j = 0;
    for (; j + kUnroll * kLanes <= n; j += kUnroll * kLanes) {
      multiplyStrip<kUnroll>(m, part, a + l, lda, b + l * ldb + j, ldb, c + j, ldc, l == 0);
    }
    for (; j < n; j += kLanes) multiplyStrip<1>(m, part, a + l, lda, b + l * ldb + j, ldb, c + j, ldc, l == 0);
  }
}

double dot(const double* x, const double* y, std::ptrdiff_t n) {
  Vec acc[4] = {};
  std::ptrdiff_t j = 0;
  for (; j + 4 * kLanes <= n; j += 4 * kLanes) {
    for (int u = 0; u < 4; ++u) acc[u] += load(x + j + u * kLanes) * load(y + j + u * kLanes);
  }
  for (; j < n; j += kLanes) acc[0] += load(x + j) * load(y + j);
  return sum((acc[0] + acc[1]) + (acc[2] + acc[3]));
}

void addScaled(double* y, double factor, const double* x, std::ptrdiff_t n) {
  const Vec f = broadcast(factor);
  for (std::ptrdiff_t j = 0; j < n; j += kLanes) store(y + j, load(y + j) + f * load(x + j));
}

void scaleAndAdd(double* y, double factor, const double* x, std::ptrdiff_t n) {
  const Vec f = broadcast(factor);
  for (std::ptrdiff_t j = 0; j < n; j += kLanes) store(y + j, f * load(y + j) + load(x + j));
}

void multiplyPointwise(double* y, const double* factors, std::ptrdiff_t n) {
  for (std::ptrdiff_t j = 0; j < n; j += kLanes) store(y + j, load(y + j) * load(factors + j));
}

void subtractProduct(double* y, const double* factors, const double* x, std::ptrdiff_t n) {
  for (std::ptrdiff_t j = 0; j < n; j += kLanes) store(y + j, load(y + j) - load(factors + j) * load(x + j));
}

double factorBands(std::ptrdiff_t size, int bandwidth, std::ptrdiff_t modes, const double* used, double* t) {
  const std::ptrdiff_t entry = modes;
  const std::ptrdiff_t row = (bandwidth + 1) * entry;
  Vec worst = broadcast(1);
  for (std::ptrdiff_t j = 0; j < modes; j += kLanes) {
    const Vec isUsed = load(used + j);
    for (std::ptrdiff_t i = 0; i < size; ++i) {
      double* ti = t + i * row + j;
      const std::ptrdiff_t width = i < bandwidth ? i : bandwidth;
      // First c = L D of this row, from the left; then L = c / D and the pivot.
      for (std::ptrdiff_t d = width; d >= 1; --d) {
        const double* other = ti - d * row;  // row i - d
        Vec c = load(ti + d * entry);
        for (std::ptrdiff_t e = width; e > d; --e) c -= load(ti + e * entry) * load(other + (e - d) * entry);
        store(ti + d * entry, c);
      }
      const Vec before = load(ti);
      Vec pivot = before;
      for (std::ptrdiff_t d = width; d >= 1; --d) {
        const Vec c = load(ti + d * entry);
        const Vec l = c * load(ti - d * row);
        pivot -= c * l;
        store(ti + d * entry, l);
      }
      const Vec ratio = isUsed > 0 ? pivot / before : broadcast(1);
      worst = ratio < worst ? ratio : worst;
      store(ti, isUsed > 0 ? 1 / pivot : Vec{});
    }
  }
  double least = worst[0];
  for (int i = 1; i < kLanes; ++i) least = worst[i] < least ? worst[i] : least;
  return least;
}

void projectedStep(int components, std::ptrdiff_t stride, std::ptrdiff_t n, const double* x, double* xOld,
                   const double* kx, const double* kxOld, const double* linear, const double* step, double momentum,
                   double radius, double* restart) {
  const Vec beta = broadcast(momentum);
  const Vec delta = broadcast(radius);
  Vec restartSum = {};
  for (std::ptrdiff_t j = 0; j < n; j += kLanes) {
    const Vec s = load(step + j);
    const auto gradient = [&](std::ptrdiff_t at) {
      return load(kx + at) + beta * (load(kx + at) - load(kxOld + at)) + load(linear + at);
    };
    Vec norm = {};
    for (int c = 0; c < components; ++c) {
      const std::ptrdiff_t at = c * stride + j;
      const Vec next = load(x + at) + beta * (load(x + at) - load(xOld + at)) - s * gradient(at);
      norm += next * next;
      store(xOld + at, next);
    }
    norm = squareRoot(norm);
    const Vec shrink = norm > delta ? delta / norm : broadcast(1);
    const Vec weight = s > 0 ? 1 / s : Vec{};
    for (int c = 0; c < components; ++c) {
      const std::ptrdiff_t at = c * stride + j;
      const Vec next = load(xOld + at);
      const Vec y = next + s * gradient(at);
      const Vec z = next * shrink;
      restartSum += weight * (y - z) * (z - load(x + at));
      store(xOld + at, z);
    }
  }
  *restart += sum(restartSum);
}

}  // namespace strak::kernels::STRAK_SIMD
