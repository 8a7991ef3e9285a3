#include "strak/fitting/normal_equations.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace strak {

namespace {

// Where control point (a, b) of the cell (s, t) stands in the net of sizes[0] x sizes[1].
Index rowOf(const CellSweep& sweep, Index lineLength, Index s, Index t, Index a, Index b) {
  return (sweep.spans(0).firstFunction(s) + a) * lineLength + sweep.spans(1).firstFunction(t) + b;
}

// The sums w z B of all cells, from their moments.
Net rightSide(const CellSweep& sweep, Index rows, Index lineLength, const std::vector<double>& cells) {
  const auto& layout = sweep.layout();
  const Index p1 = layout.degree[0] + 1, q1 = layout.degree[1] + 1;
  const Index before = (2 * p1 - 1) * layout.width;
  Net right = Net::Zero(rows, layout.columns);
  const double* cell = cells.data();
  for (Index s = 0; s < sweep.strips(); ++s) {
    const Net& fu = sweep.spans(0).functions(s);
    for (Index t = 0; t < sweep.cellsPerStrip(); ++t, cell += layout.length) {
      const Net& fv = sweep.spans(1).functions(t);
      for (Index c = 0; c < layout.columns; ++c) {
        const Eigen::Map<const Net, 0, Eigen::OuterStride<>> moments(cell + before + c * p1 * layout.rightWidth, p1, q1,
                                                                     Eigen::OuterStride<>(layout.rightWidth));
        const Net local = fu * moments * fv.transpose();
        for (Index a = 0; a < p1; ++a) {
          for (Index b = 0; b < q1; ++b) right(rowOf(sweep, lineLength, s, t, a, b), c) += local(a, b);
        }
      }
    }
  }
  return right;
}

// The length of a line of the net as CellSweep sees it: curves are nets of n x 1 there.
template <int D>
Index lineLength(const std::array<Index, 2>& sizes) {
  return D == 1 ? 1 : sizes[1];
}

}  // namespace

template <int D>
std::array<Index, 2> netSizes(const std::array<KnotVector, D>& knots) {
  if constexpr (D == 1)
    return {1, knots[0].size()};
  else
    return {knots[0].size(), knots[1].size()};
}

template <int D>
std::array<int, 2> netReach(const std::array<KnotVector, D>& knots) {
  if constexpr (D == 1)
    return {0, knots[0].degree()};
  else
    return {knots[0].degree(), knots[1].degree()};
}

template <int D>
NormalEquations<D>::NormalEquations(const std::array<KnotVector, D>& knots, Index columns)
    : sweep_({knots.begin(), knots.end()}, columns), sizes_(netSizes<D>(knots)), reach_(netReach<D>(knots)) {
  cells_.assign(static_cast<std::size_t>(sweep_.strips() * sweep_.cellsPerStrip() * sweep_.layout().length), 0.0);
  squares_.assign(static_cast<std::size_t>(sweep_.strips()), 0.0);
  measured_.assign(static_cast<std::size_t>(sweep_.strips()), 0);
}

template <int D>
Index NormalEquations<D>::measured() const {
  return std::accumulate(measured_.begin(), measured_.end(), Index{0});
}

template <int D>
void NormalEquations<D>::add(const FitPoints<D>& points) {
  const auto& layout = sweep_.layout();
  const Index outside = sweep_.sweep<D>(points, count_ + outside_, [&](const StripOfPoints& strip) {
    double* cells = cells_.data() + strip.strip * sweep_.cellsPerStrip() * layout.length;
    fitkernels::chosen().addMoments(strip.points, layout, true, cells);
    double& squares = squares_[static_cast<std::size_t>(strip.strip)];
    Index& measured = measured_[static_cast<std::size_t>(strip.strip)];
    for (Index r = 0; r < strip.points.count; ++r) {
      const double* record = strip.points.records + r * strip.points.length;
      double square = 0;
      for (int c = 0; c < layout.columns; ++c) square += record[3 + c] * record[3 + c];
      squares += record[2] * square;
      if (record[2] > 0) ++measured;
    }
  });
  outside_ += outside;
  count_ += points.count() - outside;
}

template <int D>
typename NormalEquations<D>::Sums NormalEquations<D>::sums() const {
  const auto& layout = sweep_.layout();
  const Index line = lineLength<D>(sizes_);
  Sums result;
  result.matrix = NetMatrix(sizes_, reach_);
  result.squares = std::accumulate(squares_.begin(), squares_.end(), 0.0);
  result.right = rightSide(sweep_, sizes_[0] * sizes_[1], line, cells_);
  const Index p1 = layout.degree[0] + 1, q1 = layout.degree[1] + 1;
  std::vector<Net> productsV;
  for (Index t = 0; t < sweep_.cellsPerStrip(); ++t) productsV.push_back(sweep_.spans(1).products(t).transpose());
  const double* cell = cells_.data();
  for (Index s = 0; s < sweep_.strips(); ++s) {
    const Net productsU = sweep_.spans(0).products(s);
    for (Index t = 0; t < sweep_.cellsPerStrip(); ++t, cell += layout.length) {
      result.weight += cell[0];
      if (!(cell[0] > 0)) continue;
      const Eigen::Map<const Net, 0, Eigen::OuterStride<>> moments(cell, 2 * p1 - 1, 2 * q1 - 1,
                                                                   Eigen::OuterStride<>(layout.width));
      const Net half = moments * productsV[static_cast<std::size_t>(t)];
      for (Index a = 0; a < p1; ++a) {
        for (Index k = a; k < p1; ++k) {
          const Eigen::RowVectorXd pairs = productsU.row(a * p1 + k) * half;
          for (Index b = 0; b < q1; ++b) {
            const Index row = rowOf(sweep_, line, s, t, a, b);
            for (Index l = 0; l < q1; ++l) {
              const Index other = rowOf(sweep_, line, s, t, k, l);
              const auto along = static_cast<int>(k - a), across = static_cast<int>(l - b);
              const double value = pairs[b * q1 + l];
              if constexpr (D == 1) {
                result.matrix.at(row, 0, along) += value;
                if (k > a) result.matrix.at(other, 0, -along) += value;
              } else {
                result.matrix.at(row, along, across) += value;
                if (k > a) result.matrix.at(other, -along, -across) += value;
              }
            }
          }
        }
      }
    }
  }
  return result;
}

template <int D>
FitErrors<D>::FitErrors(const Spline<D>& spline, double tolerance)
    : sweep_({spline.knots().begin(), spline.knots().end()}, spline.net().cols()),
      tolerance_(tolerance),
      sizes_(netSizes<D>(spline.knots())) {
  const auto& layout = sweep_.layout();
  const Index strips = sweep_.strips(), cells = sweep_.cellsPerStrip(), line = lineLength<D>(sizes_);
  const Index p1 = layout.degree[0] + 1, q1 = layout.degree[1] + 1;
  moments_.assign(static_cast<std::size_t>(strips * cells * layout.length), 0.0);
  cells_.resize(static_cast<std::size_t>(strips * cells));
  strips_.resize(static_cast<std::size_t>(strips));
  coefficients_.assign(static_cast<std::size_t>(strips * cells * layout.columns * p1 * layout.rightWidth), 0.0);
  double* to = coefficients_.data();
  Net local(p1, q1);
  for (Index s = 0; s < strips; ++s) {
    for (Index t = 0; t < cells; ++t) {
      for (Index c = 0; c < layout.columns; ++c, to += p1 * layout.rightWidth) {
        for (Index a = 0; a < p1; ++a) {
          for (Index b = 0; b < q1; ++b) local(a, b) = spline.net()(rowOf(sweep_, line, s, t, a, b), c);
        }
        Eigen::Map<Net, 0, Eigen::OuterStride<>>(to, p1, q1, Eigen::OuterStride<>(layout.rightWidth)) =
            sweep_.spans(0).functions(s).transpose() * local * sweep_.spans(1).functions(t);
      }
    }
  }
}

template <int D>
void FitErrors<D>::add(const FitPoints<D>& points) {
  const auto& layout = sweep_.layout();
  const Index columns = layout.columns, cellCount = sweep_.cellsPerStrip();
  const Index outside = sweep_.sweep<D>(points, seen_, [&](const StripOfPoints& strip) {
    const auto& from = strip.points;
    std::vector<double> values(static_cast<std::size_t>(from.count * columns));
    const Index pieces = cellCount * columns * (layout.degree[0] + 1) * layout.rightWidth;
    fitkernels::chosen().evaluateCells(from, layout, coefficients_.data() + strip.strip * pieces, values.data());
    std::vector<double> records(from.records, from.records + from.count * from.length);
    Strip& sums = strips_[static_cast<std::size_t>(strip.strip)];
    Cell* cells = cells_.data() + strip.strip * cellCount;
    for (Index r = 0; r < from.count; ++r) {
      double* record = records.data() + r * from.length;
      double squares = 0;
      for (Index c = 0; c < columns; ++c) {
        record[3 + c] -= values[static_cast<std::size_t>(r * columns + c)];
        squares += record[3 + c] * record[3 + c];
      }
      if (record[2] == 0) continue;  // does not count, wherever it is
      sums.weight += record[2];
      sums.squares += record[2] * squares;
      Cell& cell = cells[from.cells[r]];
      ++cell.count;
      const double error = std::sqrt(squares);
      if (error > tolerance_) ++cell.outside;
      cell.max = std::max(cell.max, error);
      if (columns == 1) {
        double power = 1;
        for (double& sum : cell.powers) sum += power *= record[3];
      }
      if (error > sums.worst.error) {
        const Index point = strip.numbers[r];
        sums.worst.error = error;
        sums.worst.point = seen_ + point;
        for (std::size_t k = 0; k < D; ++k) {
          sums.worst.parameters[k] = points.parameters(point, static_cast<Index>(k));
        }
      }
    }
    const fitkernels::StripPoints residuals{from.count, records.data(), from.length, from.cells};
    fitkernels::chosen().addMoments(residuals, layout, false,
                                    moments_.data() + strip.strip * cellCount * layout.length);
  });
  seen_ += points.count();
  outside_ += outside;
}

template <int D>
double FitErrors<D>::Cell::bimodality() const {
  constexpr Index kLeastPoints = 12;
  constexpr double kLeastShare = 0.2;  // of the smaller group: fewer are outliers
  constexpr double kMostSkew = (1 - 2 * kLeastShare) * (1 - 2 * kLeastShare) / (kLeastShare * (1 - kLeastShare));
  if (count < kLeastPoints) return 0;
  const auto n = static_cast<double>(count);
  const double mean = powers[0] / n, second = powers[1] / n, third = powers[2] / n, fourth = powers[3] / n;
  const double variance = second - mean * mean;
  if (!(variance > 0)) return 0;
  const double skew = third - 3 * mean * second + 2 * mean * mean * mean;
  const double kurt = fourth - 4 * mean * third + 6 * mean * mean * second - 3 * mean * mean * mean * mean;
  if (skew * skew > kMostSkew * variance * variance * variance) return 0;
  // Between 0 and 1 for every distribution, so skewness^2 + 1 <= kurtosis.
  return kurt > 0 ? std::min((skew * skew / variance + variance * variance) / kurt, 1.0) : 0;
}

template <int D>
Index FitErrors<D>::count() const {
  return seen_ - outside_;
}

template <int D>
Index FitErrors<D>::outsideTolerance() const {
  Index sum = 0;
  for (const Cell& cell : cells_) sum += cell.outside;
  return sum;
}

template <int D>
double FitErrors<D>::weight() const {
  double sum = 0;
  for (const Strip& strip : strips_) sum += strip.weight;
  return sum;
}

template <int D>
double FitErrors<D>::squares() const {
  double sum = 0;
  for (const Strip& strip : strips_) sum += strip.squares;
  return sum;
}

template <int D>
typename FitErrors<D>::Worst FitErrors<D>::worst() const {
  Worst worst;
  for (const Strip& strip : strips_) {
    if (strip.worst.error > worst.error) worst = strip.worst;
  }
  worst.error = std::max(worst.error, 0.0);
  return worst;
}

template <int D>
double FitErrors<D>::max() const {
  return worst().error;
}

template <int D>
Net FitErrors<D>::right() const {
  return rightSide(sweep_, sizes_[0] * sizes_[1], lineLength<D>(sizes_), moments_);
}

template std::array<Index, 2> netSizes<1>(const std::array<KnotVector, 1>&);
template std::array<Index, 2> netSizes<2>(const std::array<KnotVector, 2>&);
template std::array<int, 2> netReach<1>(const std::array<KnotVector, 1>&);
template std::array<int, 2> netReach<2>(const std::array<KnotVector, 2>&);
template class NormalEquations<1>;
template class NormalEquations<2>;
template class FitErrors<1>;
template class FitErrors<2>;

}  // namespace strak
