#include "strak/spline/evaluator.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#ifdef __linux__
#include <sys/mman.h>
#endif

#include <algorithm>
#include <cstdint>

#include "strak/base/cpu.h"
#include "strak/base/error.h"

namespace strak {

namespace {

constexpr Index kBlock = 64;  // parameters whose weights are kept at once: they stay in the first-level cache
constexpr Index kTask = 512;  // least points of a task
// One point needs no memory from the heap up to degree 15 and 4 columns.
constexpr int kStackWeights = 3 * 4 * 16;
constexpr int kStackDerivatives = 20 * 4;

void checkOrder(int order) {
  if (order < 0 || order > 3) {
    throw InvalidInput(fmt::format("derivatives of order {} are not offered: ask for 0 to 3", order));
  }
}

void checkShape(const Eigen::Ref<Net>& out, Index rows, Index columns) {
  if (out.rows() != rows || out.cols() != columns) {
    throw InvalidInput(fmt::format("the matrix for the derivatives has {} x {} numbers: give it {} x {}", out.rows(),
                                   out.cols(), rows, columns));
  }
}

// A matrix for results. Filling new memory in small pages takes longer than the evaluation, so big ones ask for large
// pages.
Net allocate(Index rows, Index columns) {
  Net result(rows, columns);
#ifdef __linux__
  constexpr std::uintptr_t kLargePage = std::uintptr_t{1} << 21;
  auto* const begin = reinterpret_cast<unsigned char*>(result.data());
  const auto size = static_cast<std::uintptr_t>(result.size()) * sizeof(double);
  const auto skip = kLargePage - 1 - (reinterpret_cast<std::uintptr_t>(begin) - 1) % kLargePage;
  // Advice only: if the system declines, the memory is the same.
  if (size >= skip + kLargePage) ::madvise(begin + skip, (size - skip) / kLargePage * kLargePage, MADV_HUGEPAGE);
#endif
  return result;
}

// The first basis functions and weights of a list of parameters in one direction.
struct Weights {
  std::vector<Index> first;
  std::vector<double> values;
  Index stride = 0;  // doubles a parameter

  void resize(const BasisTable& table, Index count, int order) {
    stride = Index{order + 1} * table.width();
    first.resize(static_cast<std::size_t>(count));
    values.resize(static_cast<std::size_t>(count * stride));
  }
  void compute(const BasisTable& table, const double* parameters, Index step, Index count, int order) {
    table.weights(parameters, step, count, order, first.data(), values.data());
  }
  WeightsView from(Index r) const { return {first.data() + r, values.data() + r * stride}; }
};

// The basis functions that are not zero at any of the parameters, as maximal intervals [begin, end).
std::vector<std::pair<Index, Index>> activeFunctions(const Weights& weights, int degree) {
  std::vector<Index> firsts = weights.first;
  std::sort(firsts.begin(), firsts.end());
  std::vector<std::pair<Index, Index>> result;
  for (const Index first : firsts) {
    if (result.empty() || first > result.back().second) result.emplace_back(first, first);
    result.back().second = first + degree + 1;
  }
  return result;
}

}  // namespace

template <int D>
Evaluator<D>::Evaluator(const Spline<D>& spline)
    : sizes_(spline.sizes()), columns_(static_cast<int>(spline.net().cols())), rational_(spline.isRational()) {
  for (const auto& knots : spline.knots()) tables_.emplace_back(knots);
  if (rational_) {
    for (int order = 0; order <= 3; ++order) quotient_.emplace_back(order);
  }
  const Net& net = spline.net();
  const Index planes = (net.cols() + 3) / 4;
  points_.resize(static_cast<std::size_t>(planes * net.rows() + 1), PaddedPoint{});
  for (Index plane = 0; plane < planes; ++plane) {
    const Index columns = std::min<Index>(4, net.cols() - 4 * plane);
    for (Index r = 0; r < net.rows(); ++r) {
      double* to = points_[static_cast<std::size_t>(plane * net.rows() + r)].x;
      for (Index c = 0; c < columns; ++c) to[c] = net(r, 4 * plane + c);
    }
  }
}

template <int D>
NetView Evaluator<D>::view() const {
  NetView result{};
  result.directions = D;
  result.columns = columns_;
  result.points = reinterpret_cast<const double*>(points_.data());
  Index count = 1;
  for (int k = 0; k < D; ++k) {
    const auto& table = tables_[static_cast<std::size_t>(k)];
    result.sizes[k] = table.knots().size();
    result.degrees[k] = table.knots().degree();
    result.widths[k] = table.width();
    count *= result.sizes[k];
  }
  result.planeStride = 4 * count;
  return result;
}

template <int D>
void Evaluator<D>::derivatives(const std::array<double, D>& u, int order, double* out) const {
  checkOrder(order);
  Index total = 0;
  for (const auto& table : tables_) total += Index{order + 1} * table.width();
  alignas(64) double stack[kStackWeights];
  std::vector<double> heap;
  double* memory = stack;
  if (total > kStackWeights) {
    heap.resize(static_cast<std::size_t>(total));
    memory = heap.data();
  }
  std::array<Index, D> first;
  std::array<WeightsView, D> weights;
  for (std::size_t k = 0; k < D; ++k) {
    tables_[k].weights(&u[k], 1, 1, order, &first[k], memory);
    weights[k] = {&first[k], memory};
    memory += Index{order + 1} * tables_[k].width();
  }
  if (rational_) {
    const Index length = Index{derivativeCount(D, order)} * columns_;
    double few[kStackDerivatives];
    std::vector<double> many(static_cast<std::size_t>(length > kStackDerivatives ? length : 0));
    double* homogeneous = many.empty() ? few : many.data();
    STRAK_SIMD_CHOOSE(contractPoints)(view(), weights.data(), 1, order, homogeneous, 0);
    quotient_[static_cast<std::size_t>(order)].apply(columns_, homogeneous, out);
  } else {
    STRAK_SIMD_CHOOSE(contractPoints)(view(), weights.data(), 1, order, out, 0);
  }
}

template <int D>
Net Evaluator<D>::derivativesAt(const Eigen::Ref<const Net>& parameters, int order) const {
  checkOrder(order);
  Net result = allocate(parameters.rows(), rowLength(order));
  derivativesAt(parameters, order, result);
  return result;
}

template <int D>
void Evaluator<D>::derivativesAt(const Eigen::Ref<const Net>& parameters, int order, Eigen::Ref<Net> out) const {
  checkOrder(order);
  if (parameters.cols() != D) {
    throw InvalidInput(
        fmt::format("the parameters have {} columns but the spline has {} directions: give one column a "
                    "direction",
                    parameters.cols(), D));
  }
  checkShape(out, parameters.rows(), rowLength(order));
  const NetView net = view();
  const auto contract = STRAK_SIMD_CHOOSE(contractPoints);
  const Index homogeneousLength = Index{derivativeCount(D, order)} * columns_;
  tbb::parallel_for(tbb::blocked_range<Index>(0, parameters.rows(), kTask), [&](const auto& range) {
    std::array<Weights, D> weights;
    for (std::size_t k = 0; k < D; ++k) weights[k].resize(tables_[k], kBlock, order);
    std::vector<double> homogeneous(static_cast<std::size_t>(rational_ ? kBlock * homogeneousLength : 0));
    for (Index begin = range.begin(); begin < range.end(); begin += kBlock) {
      const Index count = std::min(kBlock, range.end() - begin);
      std::array<WeightsView, D> views;
      for (std::size_t k = 0; k < D; ++k) {
        weights[k].compute(tables_[k], parameters.data() + begin * parameters.outerStride() + static_cast<Index>(k),
                           parameters.outerStride(), count, order);
        views[k] = weights[k].from(0);
      }
      double* to = out.data() + begin * out.outerStride();
      if (!rational_) {
        contract(net, views.data(), count, order, to, out.outerStride());
        continue;
      }
      contract(net, views.data(), count, order, homogeneous.data(), homogeneousLength);
      for (Index r = 0; r < count; ++r) {
        quotient_[static_cast<std::size_t>(order)].apply(columns_, homogeneous.data() + r * homogeneousLength,
                                                         to + r * out.outerStride());
      }
    }
  });
}

// The lines of points left when all directions but the last are contracted with the weights of grid parameters: what
// one task works with. Buffers are zero at first, because vectors read a point beyond the active ones, with weight
// zero.
template <int D>
struct Evaluator<D>::GridLines {
  using Intervals = std::vector<std::pair<Index, Index>>;

  const NetView net;
  const int order;
  const std::array<Weights, D>& weights;
  const std::array<Intervals, D>& active;
  const int planes;
  Index lineStride;      // of `lines`
  Index sheetStride;     // of `sheets`
  Index planeLines = 1;  // lines a plane
  Index sheetOf = -1;    // parameter of the first direction that `sheets` belongs to
  std::vector<PaddedPoint> sheets, lines;

  GridLines(const NetView& view, int derivativeOrder, const std::array<Weights, D>& allWeights,
            const std::array<Intervals, D>& allActive)
      : net(view), order(derivativeOrder), weights(allWeights), active(allActive), planes((view.columns + 3) / 4) {
    lineStride = 4 * (net.sizes[D - 1] + 1);
    sheetStride = D == 3 ? 4 * net.sizes[1] * net.sizes[2] : 0;
    if (D == 2) planeLines = order + 1;
    if (D == 3) planeLines = (order + 1) * (order + 2) / 2;
    if (D > 1) lines.resize(static_cast<std::size_t>(planes * planeLines * lineStride / 4), PaddedPoint{});
    if (D == 3) sheets.resize(static_cast<std::size_t>((order + 1) * sheetStride * planes / 4), PaddedPoint{});
  }

  static double* data(std::vector<PaddedPoint>& points) { return reinterpret_cast<double*>(points.data()); }

  // The lines of one plane, once moveTo() was called.
  const double* ofPlane(int plane) const {
    if (D == 1) return net.points + plane * net.planeStride;
    return reinterpret_cast<const double*>(lines.data()) + plane * planeLines * lineStride;
  }

  // Contracts for the line at parameters (i) of a surface, i * count1 + j of a volume.
  void moveTo(Index line, Index secondCount) {
    const auto contract = STRAK_SIMD_CHOOSE(contractLines);
    for (int plane = 0; plane < planes; ++plane) {
      const double* points = net.points + plane * net.planeStride;
      double* to = data(lines) + plane * planeLines * lineStride;
      if constexpr (D == 2) {
        const WeightsView w = weights[0].from(line);
        const Index row = 4 * net.sizes[1];
        for (const auto& [begin, end] : active[1]) {
          contract(w.weights, net.widths[0], net.degrees[0], order, points + w.first[0] * row + 4 * begin, row,
                   4 * (end - begin), to + 4 * begin, lineStride);
        }
      } else if constexpr (D == 3) {
        const Index row = 4 * net.sizes[2];
        double* sheet = data(sheets) + (order + 1) * sheetStride * plane;
        if (line / secondCount != sheetOf) {
          const WeightsView w = weights[0].from(line / secondCount);
          for (const auto& [begin, end] : active[1]) {
            contract(w.weights, net.widths[0], net.degrees[0], order,
                     points + (w.first[0] * net.sizes[1] + begin) * row, net.sizes[1] * row, (end - begin) * row,
                     sheet + begin * row, sheetStride);
          }
        }
        const WeightsView w = weights[1].from(line % secondCount);
        for (int a = 0; a <= order; ++a) {
          for (const auto& [begin, end] : active[2]) {
            contract(w.weights, net.widths[1], net.degrees[1], order - a,
                     sheet + a * sheetStride + w.first[0] * row + 4 * begin, row, 4 * (end - begin), to + 4 * begin,
                     lineStride);
          }
          to += (order + 1 - a) * lineStride;
        }
      }
    }
    if (D == 3) sheetOf = line / secondCount;
  }
};

template <int D>
Net Evaluator<D>::derivativesOnGrid(const Parameters& parameters, int order) const {
  checkOrder(order);
  Index count = 1;
  for (const auto& values : parameters) count *= static_cast<Index>(values.size());
  Net result = allocate(count, rowLength(order));
  derivativesOnGrid(parameters, order, result);
  return result;
}

template <int D>
void Evaluator<D>::derivativesOnGrid(const Parameters& parameters, int order, Eigen::Ref<Net> out) const {
  checkOrder(order);
  std::array<Index, D> counts;
  std::array<Weights, D> weights;
  std::array<typename GridLines::Intervals, D> active;
  Index lineCount = 1;
  for (std::size_t k = 0; k < D; ++k) {
    counts[k] = static_cast<Index>(parameters[k].size());
    weights[k].resize(tables_[k], counts[k], order);
    weights[k].compute(tables_[k], parameters[k].data(), 1, counts[k], order);
    active[k] = activeFunctions(weights[k], tables_[k].knots().degree());
    if (k + 1 < D) lineCount *= counts[k];
  }
  const Index lastCount = counts[D - 1];
  checkShape(out, lineCount * lastCount, rowLength(order));
  if (out.rows() == 0) return;

  const NetView net = view();
  const auto contract = STRAK_SIMD_CHOOSE(contractLast);
  const Index homogeneousLength = Index{derivativeCount(D, order)} * columns_;
  // A task takes some lines; a curve, which is one line, is cut into pieces instead.
  const Index pieces = D == 1 ? (lastCount + kTask - 1) / kTask : 1;
  const Index grain = D == 1 ? 1 : std::max<Index>(1, kTask / lastCount);
  tbb::parallel_for(tbb::blocked_range<Index>(0, lineCount * pieces, grain), [&](const auto& range) {
    GridLines lines(net, order, weights, active);
    std::vector<double> homogeneous(static_cast<std::size_t>(rational_ ? kBlock * homogeneousLength : 0));
    for (Index line = range.begin(); line < range.end(); ++line) {
      if (D > 1) lines.moveTo(line, counts[D == 3 ? 1 : 0]);
      const Index from = D == 1 ? line * kTask : 0;
      const Index to = D == 1 ? std::min(lastCount, from + kTask) : lastCount;
      for (Index begin = from; begin < to; begin += kBlock) {
        const Index count = std::min(kBlock, to - begin);
        double* target = out.data() + ((D == 1 ? 0 : line * lastCount) + begin) * out.outerStride();
        for (int plane = 0; plane < lines.planes; ++plane) {
          contract(net, lines.ofPlane(plane), lines.lineStride, weights[D - 1].from(begin), count, order, 4 * plane,
                   rational_ ? homogeneous.data() : target, rational_ ? homogeneousLength : out.outerStride());
        }
        for (Index r = 0; rational_ && r < count; ++r) {
          quotient_[static_cast<std::size_t>(order)].apply(columns_, homogeneous.data() + r * homogeneousLength,
                                                           target + r * out.outerStride());
        }
      }
    }
  });
}

template class Evaluator<1>;
template class Evaluator<2>;
template class Evaluator<3>;

}  // namespace strak
