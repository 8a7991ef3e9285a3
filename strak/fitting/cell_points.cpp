#include "strak/fitting/cell_points.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "strak/base/error.h"
#include "strak/spline/basis.h"

namespace strak {

namespace {

constexpr Index kBlock = Index{1} << 17;  // points sorted at once
constexpr Index kChunk = Index{1} << 13;  // points of one task while sorting
constexpr int kHighestDegree = 31;

int padded(int n) { return (n + 3) / 4 * 4; }

// The Chebyshev coefficients of the polynomials whose values at the nodes cos((2k + 1) pi / (2n)) are the columns'.
Net chebyshevCoefficients(const Net& values) {
  const Index n = values.cols();
  Net result = Net::Zero(values.rows(), n);
  for (Index i = 0; i < n; ++i) {
    for (Index k = 0; k < n; ++k) {
      const double factor =
          (i == 0 ? 1.0 : 2.0) / static_cast<double>(n) *
          std::cos(static_cast<double>(i * (2 * k + 1)) * std::numbers::pi / static_cast<double>(2 * n));
      result.col(i) += factor * values.col(k);
    }
  }
  return result;
}

}  // namespace

FitSpans::FitSpans(const KnotVector& knots) : degree_(knots.degree()) {
  if (degree_ > kHighestDegree) {
    throw InvalidInput(fmt::format("a fit of degree {} is not offered: use at most {}", degree_, kHighestDegree));
  }
  const Index functions = degree_ + 1;
  Net values(functions, functions);
  std::vector<double> basis(static_cast<std::size_t>(functions));
  for (const Index span : knots.spans()) {
    const double half = (knots[span + 1] - knots[span]) / 2;
    const double centre = knots[span] + half;
    starts_.push_back(knots[span]);
    centres_.push_back(centre);
    scales_.push_back(1 / half);
    first_.push_back(span - degree_);
    for (Index k = 0; k < functions; ++k) {
      const double node =
          std::cos(static_cast<double>(2 * k + 1) * std::numbers::pi / static_cast<double>(2 * functions));
      basisDerivatives(knots, span, centre + half * node, 0, basis.data());
      for (Index a = 0; a < functions; ++a) values(a, k) = basis[static_cast<std::size_t>(a)];
    }
    functions_.push_back(chebyshevCoefficients(values));
  }
  starts_.push_back(knots.to());
  const auto buckets = 4 * centres_.size();
  bucketScale_ = static_cast<double>(buckets) / knots.length();
  // Spans are placed by the arithmetic that places parameters, which is monotone: the span found for a bucket never
  // begins behind a parameter in it.
  int span = 0;
  for (std::size_t b = 0; b < buckets; ++b) {
    while (static_cast<std::size_t>(span) + 1 < centres_.size() &&
           (starts_[static_cast<std::size_t>(span) + 1] - from()) * bucketScale_ < static_cast<double>(b)) {
      ++span;
    }
    buckets_.push_back(span);
  }
}

int FitSpans::find(double u) const {
  const auto bucket = std::min(static_cast<std::size_t>((u - from()) * bucketScale_), buckets_.size() - 1);
  auto span = static_cast<std::size_t>(buckets_[bucket]);
  while (span + 2 < starts_.size() && u >= starts_[span + 1]) ++span;
  return static_cast<int>(span);
}

Net FitSpans::products(Index span) const {
  const Net& f = functions(span);
  const Index n = f.cols();
  Net result = Net::Zero(n * n, 2 * n - 1);
  for (Index a = 0; a < n; ++a) {
    for (Index b = 0; b < n; ++b) {
      for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < n; ++j) {  // T_i T_j = (T_(i+j) + T_|i-j|) / 2
          const double half = f(a, i) * f(b, j) / 2;
          result(a * n + b, i + j) += half;
          result(a * n + b, std::abs(i - j)) += half;
        }
      }
    }
  }
  return result;
}

CellSweep::CellSweep(const std::vector<KnotVector>& knots, Index columns) {
  for (const auto& k : knots) spans_.emplace_back(k);
  if (knots.size() == 1) spans_.emplace_back(KnotVector());
  layout_.degree[0] = spans_[0].degree();
  layout_.degree[1] = spans_[1].degree();
  layout_.width = padded(2 * layout_.degree[1] + 1);
  layout_.rightWidth = padded((layout_.width - 1) / 2 + 1);
  layout_.columns = static_cast<int>(columns);
  layout_.length =
      Index{2 * layout_.degree[0] + 1} * layout_.width + columns * (layout_.degree[0] + 1) * layout_.rightWidth;
}

template <int D>
Index CellSweep::sweep(const FitPoints<D>& points, Index countedBefore,
                       const std::function<void(const StripOfPoints&)>& work) const {
  if (points.parameters.cols() != D || points.values.cols() != layout_.columns ||
      points.values.rows() != points.count() ||
      (points.weights.size() != 0 && points.weights.size() != points.count())) {
    throw InvalidInput(fmt::format(
        "a block of points has {} x {} parameters, {} x {} values and {} weights: give as many of each, {} and {} "
        "columns",
        points.count(), points.parameters.cols(), points.values.rows(), points.values.cols(), points.weights.size(), D,
        layout_.columns));
  }
  Index outside = 0;
  for (Index begin = 0; begin < points.count(); begin += kBlock) {
    outside += sweepBlock<D>(points, begin, std::min(kBlock, points.count() - begin), countedBefore, work);
  }
  return outside;
}

template <int D>
Index CellSweep::sweepBlock(const FitPoints<D>& points, Index begin, Index count, Index countedBefore,
                            const std::function<void(const StripOfPoints&)>& work) const {
  const auto stripCount = static_cast<std::size_t>(strips());
  const Index chunks = (count + kChunk - 1) / kChunk;
  // A counting sort by strips that keeps the order: first how many points of each chunk go where ...
  std::vector<int> strip(static_cast<std::size_t>(count));
  std::vector<Index> places(static_cast<std::size_t>(chunks) * (stripCount + 1), 0);
  const auto fail = [&](Index r, const char* what) {
    throw InvalidInput(fmt::format("point {} {}: correct or remove it", countedBefore + begin + r + 1, what));
  };
  const auto inChunks = [&](const auto& body) {
    tbb::parallel_for(Index{0}, chunks, [&](Index chunk) {
      body(chunk, places.data() + static_cast<std::size_t>(chunk) * (stripCount + 1));
    });
  };
  inChunks([&](Index chunk, Index* counts) {
    const Index end = std::min(count, (chunk + 1) * kChunk);
    for (Index r = chunk * kChunk; r < end; ++r) {
      bool inside = true;
      for (Index k = 0; k < D; ++k) {
        const double u = points.parameters(begin + r, k);
        if (!std::isfinite(u)) fail(r, "has a parameter that is not finite");
        inside = inside && u >= spans(static_cast<int>(k)).from() && u <= spans(static_cast<int>(k)).to();
      }
      const int s = inside ? spans_[0].find(points.parameters(begin + r, 0)) : static_cast<int>(stripCount);
      strip[static_cast<std::size_t>(r)] = s;
      ++counts[s];
    }
  });
  // ... then where they begin ...
  Index next = 0;
  std::vector<Index> starts;
  for (std::size_t s = 0; s <= stripCount; ++s) {
    starts.push_back(next);
    for (Index chunk = 0; chunk < chunks; ++chunk) {
      Index& place = places[static_cast<std::size_t>(chunk) * (stripCount + 1) + s];
      const Index here = place;
      place = next;
      next += here;
    }
  }
  // ... then they go there.
  const Index columns = layout_.columns, length = 3 + columns;
  std::vector<double> records(static_cast<std::size_t>(count * length));
  std::vector<int> cells(static_cast<std::size_t>(count));
  std::vector<Index> numbers(static_cast<std::size_t>(count));
  const bool weighted = points.weights.size() != 0;
  inChunks([&](Index chunk, Index* place) {
    const Index end = std::min(count, (chunk + 1) * kChunk);
    for (Index r = chunk * kChunk; r < end; ++r) {
      const int s = strip[static_cast<std::size_t>(r)];
      if (s == static_cast<int>(stripCount)) continue;
      const Index to = place[s]++;
      double* record = records.data() + to * length;
      record[0] = spans_[0].local(s, points.parameters(begin + r, 0));
      int cell = 0;
      record[1] = 0;
      if constexpr (D == 2) {
        const double v = points.parameters(begin + r, 1);
        cell = spans_[1].find(v);
        record[1] = spans_[1].local(cell, v);
      }
      record[2] = weighted ? points.weights[begin + r] : 1.0;
      if (!(record[2] >= 0) || !std::isfinite(record[2])) fail(r, "has a weight that is negative or not finite");
      for (Index c = 0; c < columns; ++c) {
        record[3 + c] = points.values(begin + r, c);
        if (!std::isfinite(record[3 + c])) fail(r, "has a coordinate that is not finite");
      }
      cells[static_cast<std::size_t>(to)] = cell;
      numbers[static_cast<std::size_t>(to)] = begin + r;
    }
  });
  tbb::parallel_for(std::size_t{0}, stripCount, [&](std::size_t s) {
    const Index first = starts[s], size = starts[s + 1] - first;
    if (size == 0) return;
    work({static_cast<Index>(s),
          {size, records.data() + first * length, length, cells.data() + first},
          numbers.data() + first});
  });
  return next - starts.back();
}

template Index CellSweep::sweep<1>(const FitPoints<1>&, Index, const std::function<void(const StripOfPoints&)>&) const;
template Index CellSweep::sweep<2>(const FitPoints<2>&, Index, const std::function<void(const StripOfPoints&)>&) const;

}  // namespace strak
