#include "strak/fairing/rebuild.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "strak/base/error.h"
#include "strak/energy/projection.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/net_product.h"
#include "strak/spline/reparametrize.h"

namespace strak {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

constexpr int kHighestDegree = 15;  // beyond, Gram matrices of Bernstein polynomials lose too many digits
constexpr Index kMostPoints = 10'000'000;
constexpr Index kMostReweighted = 500;  // unknowns; the normal equations are dense

template <int D>
using Sizes = typename Spline<D>::Sizes;

template <int D>
Index product(const Sizes<D>& sizes) {
  return std::accumulate(sizes.begin(), sizes.end(), Index{1}, std::multiplies<>());
}

template <int D>
Sizes<D> sizesOf(const std::array<KnotVector, static_cast<std::size_t>(D)>& knots) {
  Sizes<D> sizes;
  for (std::size_t k = 0; k < D; ++k) sizes[k] = knots[k].size();
  return sizes;
}

// The matrix on all functions of `matrices`, one a direction, applied to a net.
template <int D>
Net multiplyAll(const std::array<Sparse, static_cast<std::size_t>(D)>& matrices, Net net, Sizes<D> sizes) {
  for (std::size_t k = 0; k < D; ++k) {
    net = multiplyAlong<D>(matrices[k], net, sizes, static_cast<int>(k));
    sizes[k] = matrices[k].rows();
  }
  return net;
}

// Places to look at the deviation: in every span those of the Chebyshev polynomials, denser to its ends as the extrema
// of a best approximation are.
std::vector<double> watchPlaces(const KnotVector& source, const KnotVector& target, Index most) {
  const auto spans = static_cast<Index>(target.spans().size());
  const Index wished =
      std::max<Index>(5 * (target.degree() + 1) * spans, 4 * static_cast<Index>(source.spans().size()));
  const Index each = std::max<Index>(target.degree() + 2, std::min(wished, most) / spans);
  std::vector<double> places;
  for (Index s : target.spans()) {
    for (Index i = 0; i < each; ++i) {
      const double x = (1 - std::cos(M_PI * (static_cast<double>(i) + 0.5) / static_cast<double>(each))) / 2;
      places.push_back(target[s] + x * (target[s + 1] - target[s]));
    }
  }
  return places;
}

// Fits the inner control points with the outer ones kept.
template <int D>
class InnerFit {
 public:
  using Knots = std::array<KnotVector, static_cast<std::size_t>(D)>;

  InnerFit(const Spline<D>& source, const Knots& knots) : source_(source), knots_(knots), sizes_(sizesOf<D>(knots)) {
    for (std::size_t k = 0; k < D; ++k) inner_[k] = sizes_[k] - 2;
  }

  // `net` has the border in place and zeros inside; only those change.
  void meanSquare(Net& net) const {
    std::array<Sparse, static_cast<std::size_t>(D)> fromSource, fromNet;
    Net data = source_.net();
    Sizes<D> dataSizes = source_.sizes();
    typename Spline<D>::Grid grid;
    for (std::size_t k = 0; k < D; ++k) {
      fromNet[k] = mixedGram(knots_[k], knots_[k]).middleRows(1, inner_[k]);
      if (!source_.isRational()) {
        fromSource[k] = mixedGram(knots_[k], source_.knots()[k]).middleRows(1, inner_[k]);
        continue;
      }
      const int degree = source_.knots()[k].degree();
      const Samples samples = samplesBetween(source_.knots()[k], knots_[k], (knots_[k].degree() + degree) / 2 + 3);
      const auto weights =
          Eigen::Map<const Eigen::VectorXd>(samples.weights.data(), static_cast<Index>(samples.weights.size()));
      const Sparse basis = basisMatrix(knots_[k], samples.places).transpose();
      fromSource[k] = Sparse(basis * weights.asDiagonal()).middleRows(1, inner_[k]);
      grid[k] = samples.places;
      dataSizes[k] = static_cast<Index>(samples.places.size());
    }
    if (source_.isRational()) {
      if (product<D>(dataSizes) > kMostPoints) {
        throw InvalidInput("a rational spline of this size cannot be rebuilt in one piece: cut it into parts");
      }
      data = derivativesOnGrid(source_, grid, 0);
    }
    Net inner = multiplyAll<D>(fromSource, std::move(data), dataSizes) - multiplyAll<D>(fromNet, net, sizes_);
    for (std::size_t k = 0; k < D; ++k) {
      const Sparse gram = Sparse(fromNet[k].middleCols(1, inner_[k]));
      const Eigen::SimplicialLDLT<Sparse> factor(gram);
      if (factor.info() != Eigen::Success) throw Failure("the best approximation is not determined: give fewer spans");
      inner = mapLines<D>(inner, inner_, static_cast<int>(k), inner_[k],
                          [&](const auto& lines) -> Net { return factor.solve(lines); });
    }
    put(inner, net);
  }

  // Lawson's steps from there: the weight of a place grows with its deviation. Returns whether the largest one fell.
  bool reweight(Net& net, int steps) const {
    const Index unknowns = product<D>(inner_);
    if (steps == 0 || unknowns > kMostReweighted) return false;
    constexpr Index kMostPlaces[] = {4000, 160, 26};  // a direction
    typename Spline<D>::Grid grid;
    std::array<Sparse, static_cast<std::size_t>(D)> basis;
    for (std::size_t k = 0; k < D; ++k) {
      grid[k] = watchPlaces(source_.knots()[k], knots_[k], kMostPlaces[D - 1]);
      basis[k] = basisMatrix(knots_[k], grid[k]);
    }
    const Net wished = derivativesOnGrid(source_, grid, 0);
    const Watch watch(basis, sizes_);
    const auto residual = [&](const Net& from) -> Net { return wished - multiplyAll<D>(basis, from, sizes_); };

    Net border = net;
    put(Net::Zero(unknowns, net.cols()), border);
    const Net withoutInner = residual(border);
    Eigen::VectorXd lengths = residual(net).rowwise().norm();
    Net best = net;
    double least = lengths.maxCoeff();
    const double first = least;
    Eigen::VectorXd weights = Eigen::VectorXd::Ones(lengths.size());
    int sinceBetter = 0;
    for (int step = 0; step < steps && sinceBetter < kPatience && lengths.maxCoeff() > 0; ++step) {
      weights = weights.cwiseProduct(lengths / lengths.maxCoeff());
      // A little for everywhere: without it the equations become singular once few places carry all weight.
      weights = (weights / weights.maxCoeff()).array() + kLeastWeight;
      Net inner(unknowns, net.cols());
      if (!watch.solve(weights, withoutInner, inner)) break;
      Net next = border;
      put(inner, next);
      lengths = residual(next).rowwise().norm();
      const double now = lengths.maxCoeff();
      sinceBetter = now < (1 - kGain) * least ? 0 : sinceBetter + 1;
      if (now < least) {
        least = now;
        best = std::move(next);
      }
    }
    net = std::move(best);
    return least < first;
  }

 private:
  static constexpr int kPatience = 8;           // steps without a gain
  static constexpr double kGain = 1e-3;         // of the largest deviation
  static constexpr double kLeastWeight = 1e-9;  // of the largest weight

  // The functions of the inner control points at all places, and the weighted normal equations.
  class Watch {
   public:
    Watch(const std::array<Sparse, static_cast<std::size_t>(D)>& basis, const Sizes<D>& sizes) {
      std::vector<Entry> rows[D];
      std::vector<std::size_t> starts[D];
      for (std::size_t k = 0; k < D; ++k) {
        const Eigen::SparseMatrix<double, Eigen::RowMajor> byRow = basis[k];
        for (Index r = 0; r < byRow.rows(); ++r) {
          starts[k].push_back(rows[k].size());
          for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator it(byRow, r); it; ++it) {
            if (it.col() >= 1 && it.col() + 1 < sizes[k]) rows[k].push_back({it.col() - 1, it.value()});
          }
        }
        starts[k].push_back(rows[k].size());
      }
      // The tensor product, the last direction fastest.
      std::vector<Entry> entries{{0, 1.0}};
      std::vector<std::size_t> at{0, 1};
      for (std::size_t k = 0; k < D; ++k) {
        std::vector<Entry> next;
        std::vector<std::size_t> nextAt{0};
        for (std::size_t r = 0; r + 1 < at.size(); ++r) {
          for (std::size_t s = 0; s + 1 < starts[k].size(); ++s) {
            for (std::size_t a = at[r]; a < at[r + 1]; ++a) {
              for (std::size_t b = starts[k][s]; b < starts[k][s + 1]; ++b) {
                next.push_back(
                    {entries[a].column * (sizes[k] - 2) + rows[k][b].column, entries[a].value * rows[k][b].value});
              }
            }
            nextAt.push_back(next.size());
          }
        }
        entries = std::move(next);
        at = std::move(nextAt);
      }
      entries_ = std::move(entries);
      at_ = std::move(at);
    }

    bool solve(const Eigen::VectorXd& weights, const Net& wished, Net& inner) const {
      Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(inner.rows(), inner.rows());
      Net right = Net::Zero(inner.rows(), inner.cols());
      for (std::size_t r = 0; r + 1 < at_.size(); ++r) {
        const double weight = weights(static_cast<Index>(r));
        for (std::size_t i = at_[r]; i < at_[r + 1]; ++i) {
          const double here = weight * entries_[i].value;
          right.row(entries_[i].column) += here * wished.row(static_cast<Index>(r));
          // Columns ascend within a row: the lower triangle.
          for (std::size_t j = i; j < at_[r + 1]; ++j) {
            normal(entries_[j].column, entries_[i].column) += here * entries_[j].value;
          }
        }
      }
      const Eigen::LDLT<Eigen::MatrixXd> factor(normal);
      if (factor.info() != Eigen::Success || !factor.isPositive()) return false;
      inner = factor.solve(Eigen::MatrixXd(right));
      return inner.allFinite();
    }

   private:
    struct Entry {
      Index column;
      double value;
    };
    std::vector<Entry> entries_;
    std::vector<std::size_t> at_;
  };

  void put(const Net& inner, Net& net) const {
    Index next = 0;
    for (Index r = 0; r < net.rows(); ++r) {
      Index rest = r;
      bool inside = true;
      for (std::size_t k = D; k-- > 0;) {
        const Index i = rest % sizes_[k];
        rest /= sizes_[k];
        inside = inside && i > 0 && i + 1 < sizes_[k];
      }
      if (inside) net.row(r) = inner.row(next++);
    }
  }

  const Spline<D>& source_;
  const Knots& knots_;
  Sizes<D> sizes_, inner_;
};

// The net and, for the outermost call, the one before reweighting.
struct Fit {
  Net net, meanSquare;
};

template <int D>
Fit fit(const Spline<D>& source, const std::array<KnotVector, static_cast<std::size_t>(D)>& knots, int steps) {
  const Sizes<D> sizes = sizesOf<D>(knots);
  Fit result;
  result.net = Net::Zero(product<D>(sizes), source.pointDimension());
  for (int k = 0; k < D; ++k) {
    const auto at = static_cast<std::size_t>(k);
    Index behind = 1;
    for (std::size_t l = at + 1; l < D; ++l) behind *= sizes[l];
    for (const bool high : {false, true}) {
      const Net side = sliceAlong<D>(source.net(), source.sizes(), k, high ? source.size(k) - 1 : 0, 1);
      Net fitted;
      if constexpr (D == 1) {
        fitted = source.isRational() ? Net(side.leftCols(side.cols() - 1) / side(0, side.cols() - 1)) : side;
      } else {
        std::array<KnotVector, static_cast<std::size_t>(D - 1)> had, has;
        for (std::size_t l = 0, next = 0; l < D; ++l) {
          if (l == at) continue;
          had[next] = source.knots()[l];
          has[next++] = knots[l];
        }
        fitted = fit<D - 1>(Spline<D - 1>(had, side, source.isRational()), has, steps).net;
      }
      const Index index = high ? sizes[at] - 1 : 0;
      for (Index r = 0; r < fitted.rows(); ++r) {
        result.net.row((r / behind * sizes[at] + index) * behind + r % behind) = fitted.row(r);
      }
    }
  }
  if (std::all_of(sizes.begin(), sizes.end(), [](Index n) { return n > 2; })) {
    const InnerFit<D> inner(source, knots);
    inner.meanSquare(result.net);
    result.meanSquare = result.net;
    inner.reweight(result.net, steps);
  } else {
    result.meanSquare = result.net;
  }
  return result;
}

}  // namespace

template <int D>
Rebuilt<D> rebuild(const Spline<D>& spline, const RebuildOptions<D>& options) {
  std::array<KnotVector, static_cast<std::size_t>(D)> knots;
  double points = 1;
  for (std::size_t k = 0; k < D; ++k) {
    const char* name = directionName(static_cast<int>(k));
    if (options.degree[k] < 1 || options.degree[k] > kHighestDegree) {
      throw InvalidInput(fmt::format("cannot rebuild with degree {} in direction {}: give 1 to {}", options.degree[k],
                                     name, kHighestDegree));
    }
    if (options.spans[k] < 1) {
      throw InvalidInput(
          fmt::format("cannot rebuild with {} spans in direction {}: give at least 1", options.spans[k], name));
    }
    points *= static_cast<double>(options.spans[k]) + options.degree[k];
    if (points > static_cast<double>(kMostPoints)) {
      throw InvalidInput(fmt::format("so many spans would make a net above {} points: give fewer", kMostPoints));
    }
    const KnotVector& had = spline.knots()[k];
    knots[k] = KnotVector::uniformClamped(options.degree[k], options.spans[k], had.from(), had.to());
  }
  // Seen from its middle, so that it does not matter where the model lies.
  Spline<D> source = clamped(spline);
  const Point middle = source.euclideanNet().colwise().mean();
  const Index dimension = source.pointDimension();
  Net centred = source.net();
  for (Index r = 0; r < centred.rows(); ++r) {
    centred.row(r).head(dimension) -= (source.isRational() ? centred(r, dimension) : 1.0) * middle;
  }
  source = Spline<D>(source.knots(), std::move(centred), source.isRational());

  Fit fitted = fit<D>(source, knots, std::max(0, options.reweightings));
  const auto back = [&](Net& net) {
    net.rowwise() += middle;
    return Spline<D>(knots, std::move(net));
  };
  const bool reweighted = fitted.net != fitted.meanSquare;
  Rebuilt<D> result{back(fitted.net), {}, {}};
  result.deviation = certifyDeviation(result.spline, spline);
  result.meanSquare = result.deviation;
  if (!reweighted) return result;
  Spline<D> other = back(fitted.meanSquare);
  result.meanSquare = certifyDeviation(other, spline);
  if (result.meanSquare.upper < result.deviation.upper) {
    result.spline = std::move(other);
    result.deviation = result.meanSquare;
  }
  return result;
}

template Rebuilt<1> rebuild(const Spline<1>&, const RebuildOptions<1>&);
template Rebuilt<2> rebuild(const Spline<2>&, const RebuildOptions<2>&);
template Rebuilt<3> rebuild(const Spline<3>&, const RebuildOptions<3>&);

}  // namespace strak
