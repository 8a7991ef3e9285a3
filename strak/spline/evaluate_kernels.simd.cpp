#include "strak/spline/evaluate_kernels.h"

#ifdef __AVX512F__
#include <immintrin.h>  // all its functions are always inlined, so none can reach another file
#endif

// One vector holds kPoints padded points, neighbours in the last direction.
//
// Everything is written for a fixed order, so that the sums stay in registers; for surfaces the degrees most used are
// fixed too.

namespace strak::STRAK_SIMD {

namespace {

// Loops over derivatives are written out early, so that the sums in their arrays become registers.
#ifdef __clang__
#define STRAK_UNROLL _Pragma("unroll")
#else
#define STRAK_UNROLL _Pragma("GCC unroll 20")
#endif

using Index = std::ptrdiff_t;

#ifdef __AVX512F__
constexpr int kPoints = 2;
#else
constexpr int kPoints = 1;
#endif
constexpr int kLanes = 4 * kPoints;

#ifdef __AVX__
using Quad = double __attribute__((vector_size(32)));

inline Quad splat4(double value) { return Quad{value, value, value, value}; }
#else
// Compilers carry vectors wider than the machine's through memory; two halves stay in registers.
struct Quad {
  using Half = double __attribute__((vector_size(16)));
  Half low, high;

  double operator[](int i) const { return i < 2 ? low[i] : high[i - 2]; }
  friend Quad operator+(const Quad& a, const Quad& b) { return {a.low + b.low, a.high + b.high}; }
  friend Quad operator*(const Quad& a, const Quad& b) { return {a.low * b.low, a.high * b.high}; }
  Quad& operator+=(const Quad& other) { return *this = *this + other; }
};

inline Quad splat4(double value) { return {Quad::Half{value, value}, Quad::Half{value, value}}; }
#endif

template <class V>
inline V load(const double* from) {
  V result;
  __builtin_memcpy(&result, from, sizeof(V));
  return result;
}

template <class V>
inline void store(double* to, const V& value) {
  __builtin_memcpy(to, &value, sizeof(V));
}

#ifdef __AVX512F__
using Vector = double __attribute__((vector_size(64)));

template <class V>
inline V splat(double value) {
  if constexpr (sizeof(V) == sizeof(Quad)) {
    return splat4(value);
  } else {
    return V{value, value, value, value, value, value, value, value};
  }
}

// The weights of kPoints neighbours, each four times.
inline Vector spread(const double* weights) {
  // The intrinsic is one masked load; from plain vectors GCC goes through memory.
  return _mm512_mask_broadcastsd_pd(_mm512_set1_pd(weights[0]), 0xF0, _mm_load_sd(weights + 1));
}

// The sum over the kPoints neighbours.
inline Quad fold(const Vector& value) {
  return __builtin_shufflevector(value, value, 0, 1, 2, 3) + __builtin_shufflevector(value, value, 4, 5, 6, 7);
}
#else
using Vector = Quad;

template <class V>
inline V splat(double value) {
  return splat4(value);
}

inline Vector spread(const double* weights) { return splat4(weights[0]); }
inline Quad fold(const Vector& value) { return value; }
#endif

// Where the derivative (a, b, c) stands in graded order.
constexpr int place(int directions, int a, int b, int c) {
  if (directions == 1) return a;
  if (directions == 2) return (a + b) * (a + b + 1) / 2 + b;
  const int total = a + b + c;
  const int rest = b + c;
  return total * (total + 1) * (total + 2) / 6 + rest * (rest + 1) / 2 + c;
}

// The same if c is the order in the last direction and a, b those in the directions before it.
constexpr int placeWithLast(int directions, int a, int b, int c) {
  return directions == 1 ? place(1, c, 0, 0) : directions == 2 ? place(2, a, c, 0) : place(3, a, b, c);
}

constexpr int countOf(int directions, int order) {
  return directions == 1 ? order + 1 : directions == 2 ? place(2, order + 1, 0, 0) : place(3, order + 1, 0, 0);
}

// Writes `lanes` <= 4 columns of each derivative; derivative k begins at out + k * columns. Where the columns are fewer
// than 4 and there is only one plane, a whole vector may be written as long as later derivatives overwrite the surplus.
template <int kCount>
inline void write(const Quad (&values)[kCount], Index columns, Index lanes, double* out) {
  for (Index k = 0; k < kCount; ++k) {
    double* to = out + k * columns;
    if (lanes == 4 || (lanes == columns && (kCount - k) * columns >= 4)) {
      store(to, values[k]);
    } else {
      if (lanes & 2) {
        to[0] = values[k][0];
        to[1] = values[k][1];
      }
      if (lanes & 1) to[lanes - 1] = values[k][lanes - 1];
    }
  }
}

template <class Work>
inline void withOrder(int order, const Work& work) {
  switch (order) {
    case 0:
      return work.template operator()<0>();
    case 1:
      return work.template operator()<1>();
    case 2:
      return work.template operator()<2>();
    default:
      return work.template operator()<3>();
  }
}

inline Index findSpan(const BasisView& basis, double u) {
  const double x = (u - basis.from) * basis.bucketScale;
  const double last = static_cast<double>(basis.bucketCount - 1);
  const Index bucket = x > 0 ? static_cast<Index>(x < last ? x : last) : 0;
  Index span = basis.buckets[bucket];
  Index high = basis.buckets[bucket + 1];
  if (high - span > 1) {
    while (span < high) {
      const Index middle = (span + high + 1) / 2;
      if (u >= basis.starts[middle]) {
        span = middle;
      } else {
        high = middle - 1;
      }
    }
    return span;
  }
  return span + static_cast<Index>((high > span) & (u >= basis.starts[span + 1]));
}

template <class V, int kOrder>
void basisWeightsOf(const BasisView& basis, const double* parameters, Index stride, Index count, Index* first,
                    double* weights) {
  const Index functions = basis.degree + 1;
  const Index width = basis.width;
  for (Index r = 0; r < count; ++r) {
    const double u = parameters[r * stride];
    const Index span = findSpan(basis, u);
    first[r] = basis.first[span];
    const double scale = basis.scales[span];
    const V t = splat<V>((u - basis.centres[span]) * scale);
    const double* coefficients = basis.coefficients + span * functions * width;
    double* out = weights + r * (kOrder + 1) * width;
    for (Index x = 0; x < width; x += static_cast<Index>(sizeof(V) / sizeof(double))) {
      V sums[kOrder + 1] = {};  // sums[k]: the k-th derivative by t, over k!
      sums[0] = load<V>(coefficients + (functions - 1) * width + x);
      for (Index power = functions - 2; power >= 0; --power) {
        STRAK_UNROLL
        for (int k = kOrder; k > 0; --k) sums[k] = sums[k] * t + sums[k - 1];
        sums[0] = sums[0] * t + load<V>(coefficients + power * width + x);
      }
      store(out + x, sums[0]);
      double factor = 1;
      STRAK_UNROLL
      for (int k = 1; k <= kOrder; ++k) {
        factor *= k * scale;
        store(out + k * width + x, sums[k] * splat<V>(factor));
      }
    }
  }
}

// One point of a curve, surface or volume: sums[place(a, b, c)] += ..., over all kPoints neighbours at once.
template <int kDirections, int kOrder>
void contractPointsOf(const NetView& net, const WeightsView* weights, Index count, double* out, Index outStride) {
  constexpr int kLast = kDirections - 1;
  constexpr int kDerivatives = countOf(kDirections, kOrder);
  const int n0 = net.degrees[0] + 1;
  const int n1 = kDirections == 3 ? net.degrees[1] + 1 : 1;
  const int vectors = (net.degrees[kLast] + kPoints) / kPoints;
  const Index width = net.widths[kLast];
  const Index lastRow = 4 * net.sizes[kLast];
  const Index stride0 = kDirections == 3 ? net.sizes[1] * lastRow : lastRow;
  for (Index r = 0; r < count; ++r) {
    const double* w0 = weights[0].weights + r * (kOrder + 1) * net.widths[0];
    const double* w1 = kDirections == 3 ? weights[1].weights + r * (kOrder + 1) * net.widths[1] : nullptr;
    const double* wLast = weights[kLast].weights + r * (kOrder + 1) * width;
    Index start = weights[0].first[r];
    for (int k = 1; k < kDirections; ++k) start = start * net.sizes[k] + weights[k].first[r];
    for (int column = 0; column < net.columns; column += 4) {
      const double* points = net.points + column / 4 * net.planeStride + 4 * start;
      Vector sums[kDerivatives] = {};
      for (Index m = 0; m < vectors; ++m) {
        Vector spreads[kOrder + 1];
        STRAK_UNROLL
        for (int c = 0; c <= kOrder; ++c) spreads[c] = spread(wLast + c * width + m * kPoints);
        const double* at = points + m * kLanes;
        if constexpr (kDirections == 1) {
          const auto x = load<Vector>(at);
          STRAK_UNROLL
          for (int c = 0; c <= kOrder; ++c) sums[c] += x * spreads[c];
        } else if constexpr (kDirections == 2) {
          Vector line[kOrder + 1] = {};
          for (int i = 0; i < n0; ++i) {
            const auto x = load<Vector>(at + i * stride0);
            STRAK_UNROLL
            for (int a = 0; a <= kOrder; ++a) line[a] += x * splat<Vector>(w0[a * net.widths[0] + i]);
          }
          STRAK_UNROLL
          for (int a = 0; a <= kOrder; ++a) {
            STRAK_UNROLL
            for (int b = 0; a + b <= kOrder; ++b) sums[place(2, a, b, 0)] += line[a] * spreads[b];
          }
        } else {
          Vector sheet[countOf(2, kOrder)] = {};
          for (int j = 0; j < n1; ++j) {
            Vector line[kOrder + 1] = {};
            for (int i = 0; i < n0; ++i) {
              const auto x = load<Vector>(at + i * stride0 + j * lastRow);
              STRAK_UNROLL
              for (int a = 0; a <= kOrder; ++a) line[a] += x * splat<Vector>(w0[a * net.widths[0] + i]);
            }
            STRAK_UNROLL
            for (int a = 0; a <= kOrder; ++a) {
              STRAK_UNROLL
              for (int b = 0; a + b <= kOrder; ++b)
                sheet[place(2, a, b, 0)] += line[a] * splat<Vector>(w1[b * net.widths[1] + j]);
            }
          }
          STRAK_UNROLL
          for (int a = 0; a <= kOrder; ++a) {
            STRAK_UNROLL
            for (int b = 0; a + b <= kOrder; ++b) {
              STRAK_UNROLL
              for (int c = 0; a + b + c <= kOrder; ++c) {
                sums[place(3, a, b, c)] += sheet[place(2, a, b, 0)] * spreads[c];
              }
            }
          }
        }
      }
      Quad values[kDerivatives];
      STRAK_UNROLL
      for (int k = 0; k < kDerivatives; ++k) values[k] = fold(sums[k]);
      const int lanes = net.columns - column < 4 ? net.columns - column : 4;
      write(values, net.columns, lanes, out + r * outStride + column);
    }
  }
}

template <int kOrder>
void contractLinesOf(const double* weights, int width, int degree, const double* source, Index sourceStride,
                     Index length, double* target, Index targetStride) {
  const auto sum = [&]<class V>(Index x) {
    V sums[kOrder + 1] = {};
    for (int i = 0; i <= degree; ++i) {
      const auto value = load<V>(source + i * sourceStride + x);
      STRAK_UNROLL
      for (int a = 0; a <= kOrder; ++a) sums[a] += value * splat<V>(weights[a * width + i]);
    }
    STRAK_UNROLL
    for (int a = 0; a <= kOrder; ++a) store(target + a * targetStride + x, sums[a]);
  };
  Index x = 0;
  for (; x + kLanes <= length; x += kLanes) sum.template operator()<Vector>(x);
  for (; x < length; x += 4) sum.template operator()<Quad>(x);
}

template <int kDirections, int kOrder>
void contractLastOf(const NetView& net, const double* lines, Index lineStride, const WeightsView& weights, Index count,
                    int firstColumn, double* out, Index outStride) {
  constexpr int kDerivatives = countOf(kDirections, kOrder);
  constexpr int kHasFirst = kDirections > 1;  // directions before the last
  constexpr int kHasSecond = kDirections > 2;
  const int vectors = (net.degrees[kDirections - 1] + kPoints) / kPoints;
  const Index width = net.widths[kDirections - 1];
  const int lanes = net.columns - firstColumn < 4 ? net.columns - firstColumn : 4;
  for (Index r = 0; r < count; ++r) {
    const double* w = weights.weights + r * (kOrder + 1) * width;
    const double* at = lines + 4 * weights.first[r];
    Vector sums[kDerivatives] = {};
    for (Index m = 0; m < vectors; ++m) {
      Vector spreads[kOrder + 1];
      STRAK_UNROLL
      for (int c = 0; c <= kOrder; ++c) spreads[c] = spread(w + c * width + m * kPoints);
      int line = 0;
      STRAK_UNROLL
      for (int a = 0; a <= kHasFirst * kOrder; ++a) {
        STRAK_UNROLL
        for (int b = 0; b <= kHasSecond * (kOrder - a); ++b) {
          const auto x = load<Vector>(at + line++ * lineStride + m * kLanes);
          STRAK_UNROLL
          for (int c = 0; a + b + c <= kOrder; ++c) {
            sums[placeWithLast(kDirections, a, b, c)] += x * spreads[c];
          }
        }
      }
    }
    Quad values[kDerivatives];
    STRAK_UNROLL
    for (int k = 0; k < kDerivatives; ++k) values[k] = fold(sums[k]);
    write(values, net.columns, lanes, out + r * outStride + firstColumn);
  }
}

template <class Work>
inline void withDirections(int directions, const Work& work) {
  switch (directions) {
    case 1:
      return work.template operator()<1>();
    case 2:
      return work.template operator()<2>();
    default:
      return work.template operator()<3>();
  }
}

}  // namespace

void basisWeights(const BasisView& basis, const double* parameters, Index stride, Index count, int order, Index* first,
                  double* weights) {
  withOrder(order, [&]<int kOrder>() {
    if (basis.width % kLanes == 0) {
      basisWeightsOf<Vector, kOrder>(basis, parameters, stride, count, first, weights);
    } else {
      basisWeightsOf<Quad, kOrder>(basis, parameters, stride, count, first, weights);
    }
  });
}

void contractPoints(const NetView& net, const WeightsView* weights, Index count, int order, double* out,
                    Index outStride) {
  withDirections(net.directions, [&]<int kDirections>() {
    withOrder(order, [&]<int kOrder>() { contractPointsOf<kDirections, kOrder>(net, weights, count, out, outStride); });
  });
}

void contractLines(const double* weights, int width, int degree, int order, const double* source, Index sourceStride,
                   Index length, double* target, Index targetStride) {
  withOrder(order, [&]<int kOrder>() {
    contractLinesOf<kOrder>(weights, width, degree, source, sourceStride, length, target, targetStride);
  });
}

void contractLast(const NetView& net, const double* lines, Index lineStride, const WeightsView& weights, Index count,
                  int order, int firstColumn, double* out, Index outStride) {
  withDirections(net.directions, [&]<int kDirections>() {
    withOrder(order, [&]<int kOrder>() {
      contractLastOf<kDirections, kOrder>(net, lines, lineStride, weights, count, firstColumn, out, outStride);
    });
  });
}

}  // namespace strak::STRAK_SIMD
