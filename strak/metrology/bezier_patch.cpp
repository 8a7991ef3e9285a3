#include "strak/metrology/bezier_patch.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace strak {

namespace {

// The block seen as `outer` slabs of `count` rows of `inner` numbers, `count` being the points along `direction`.
struct Slabs {
  Index outer = 1, count = 1, inner = 1;
};

template <class Sizes>
Slabs slabsAlong(const Sizes& sizes, int direction, Index columns) {
  Slabs s;
  s.inner = columns;
  for (int k = 0; k < static_cast<int>(sizes.size()); ++k) {
    const auto size = static_cast<Index>(sizes[static_cast<std::size_t>(k)]);
    (k < direction ? s.outer : k == direction ? s.count : s.inner) *= size;
  }
  return s;
}

template <int D>
std::array<Index, D> pointCounts(const std::array<int, D>& degrees) {
  std::array<Index, D> counts;
  std::transform(degrees.begin(), degrees.end(), counts.begin(), [](int p) { return Index{p} + 1; });
  return counts;
}

double binomial(int n, int k) {
  double result = 1;
  for (int i = 1; i <= k; ++i) result = result * (n - k + i) / i;
  return result;
}

// The products C(p, i) C(q, j) ... in the order of the control points.
template <int D>
Eigen::VectorXd binomials(const std::array<int, D>& degrees) {
  Eigen::VectorXd result = Eigen::VectorXd::Ones(1);
  for (const int p : degrees) {
    Eigen::VectorXd next(result.size() * (p + 1));
    for (Index r = 0; r < result.size(); ++r) {
      for (int i = 0; i <= p; ++i) next[r * (p + 1) + i] = result[r] * binomial(p, i);
    }
    result = std::move(next);
  }
  return result;
}

}  // namespace

template <int D>
double BezierPatch<D>::bound() const {
  const Index dimension = points.cols() - (rational ? 1 : 0);
  double largest = 0;
  for (Index r = 0; r < points.rows(); ++r) {
    double square = points.row(r).head(dimension).squaredNorm();
    if (rational) square /= points(r, dimension) * points(r, dimension);
    largest = std::max(largest, square);
  }
  return std::sqrt(largest);
}

template <int D>
typename BezierPatch<D>::Corner BezierPatch<D>::corner(unsigned number) const {
  const Index dimension = points.cols() - (rational ? 1 : 0);
  Index row = 0;
  std::array<double, D> place;
  for (std::size_t k = 0; k < D; ++k) {
    const bool end = (number >> k) & 1U;
    row = row * (degrees[k] + 1) + (end ? degrees[k] : 0);
    place[k] = end ? to[k] : from[k];
  }
  return {points.row(row).head(dimension).norm() / (rational ? points(row, dimension) : 1), place};
}

template <int D>
typename BezierPatch<D>::Corner BezierPatch<D>::farthestCorner() const {
  Corner best = corner(0);
  for (unsigned number = 1; number < (1U << D); ++number) {
    const Corner other = corner(number);
    if (other.norm > best.norm) best = other;
  }
  return best;
}

template <int D>
int BezierPatch<D>::mostBent() const {
  int best = -1;
  double most = 0;
  for (int k = 0; k < D; ++k) {
    const auto s = slabsAlong(pointCounts<D>(degrees), k, points.cols());
    double bend = 0;
    for (Index o = 0; o < s.outer; ++o) {
      for (Index i = 1; i + 1 < s.count; ++i) {
        const double* row = points.data() + (o * s.count + i) * s.inner;
        for (Index c = 0; c < s.inner; ++c)
          bend = std::max(bend, std::abs(row[c - s.inner] - 2 * row[c] + row[c + s.inner]));
      }
    }
    if (bend > most) {
      most = bend;
      best = k;
    }
  }
  return best;
}

template <int D>
std::array<BezierPatch<D>, 2> BezierPatch<D>::halves(int direction) const {
  const auto d = static_cast<std::size_t>(direction);
  std::array<BezierPatch, 2> result{*this, *this};
  result[0].to[d] = result[1].from[d] = std::midpoint(from[d], to[d]);
  const auto s = slabsAlong(pointCounts<D>(degrees), direction, points.cols());
  for (Index o = 0; o < s.outer; ++o) {
    double* lower = result[0].points.data() + o * s.count * s.inner;
    double* upper = result[1].points.data() + o * s.count * s.inner;
    for (Index level = 1; level < s.count; ++level) {
      // Row i of `upper` for i <= last holds the points of this level; its first one belongs to the lower half.
      const Index last = s.count - 1 - level;
      for (Index i = 0; i <= last; ++i) {
        for (Index c = 0; c < s.inner; ++c)
          upper[i * s.inner + c] = (upper[i * s.inner + c] + upper[(i + 1) * s.inner + c]) / 2;
      }
      std::copy(upper, upper + s.inner, lower + level * s.inner);
    }
  }
  return result;
}

Eigen::MatrixXd spanToBezier(const KnotVector& knots, Index span, double from, double to) {
  const int p = knots.degree();
  Eigen::MatrixXd result(p + 1, p + 1);
  for (int j = 0; j <= p; ++j) {
    Eigen::MatrixXd rows = Eigen::MatrixXd::Identity(p + 1, p + 1);
    for (int r = 1; r <= p; ++r) {
      const double t = r <= j ? to : from;
      for (int i = p; i >= r; --i) {
        const double left = knots[span - p + i], right = knots[span + i - r + 1];
        rows.row(i) = ((right - t) / (right - left)) * rows.row(i - 1) + ((t - left) / (right - left)) * rows.row(i);
      }
    }
    result.row(j) = rows.row(p);
  }
  return result;
}

Eigen::MatrixXd bezierElevation(int degree, int raised) {
  // B_i^p = sum_j C(p, i) C(r - p, j - i) / C(r, j) B_j^r
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(raised + 1, degree + 1);
  for (int j = 0; j <= raised; ++j) {
    for (int i = std::max(0, j - (raised - degree)); i <= std::min(degree, j); ++i)
      result(j, i) = binomial(degree, i) * binomial(raised - degree, j - i) / binomial(raised, j);
  }
  return result;
}

template <int D>
Net applyMaps(const std::array<const Eigen::MatrixXd*, D>& maps, const Net& block) {
  std::array<Index, D> sizes;
  for (std::size_t k = 0; k < D; ++k) sizes[k] = maps[k]->cols();
  Net now = block;
  for (int k = 0; k < D; ++k) {
    const auto d = static_cast<std::size_t>(k);
    const Eigen::MatrixXd& map = *maps[d];
    const auto s = slabsAlong(sizes, k, block.cols());
    Net next = Net::Zero(now.rows() / s.count * map.rows(), block.cols());
    for (Index o = 0; o < s.outer; ++o) {
      for (Index i = 0; i < map.rows(); ++i) {
        double* out = next.data() + (o * map.rows() + i) * s.inner;
        for (Index j = 0; j < s.count; ++j) {
          const double factor = map(i, j);
          if (factor == 0) continue;
          const double* in = now.data() + (o * s.count + j) * s.inner;
          for (Index c = 0; c < s.inner; ++c) out[c] += factor * in[c];
        }
      }
    }
    sizes[d] = map.rows();
    now = std::move(next);
  }
  return now;
}

template <int D>
Net bezierProduct(const Net& points, const std::array<int, D>& degrees, const Net& factor,
                  const std::array<int, D>& factorDegrees) {
  // C(p, i) P_i is the coefficient of t^i (1 - t)^(p - i): such coefficients multiply like those of powers.
  const auto sizes = pointCounts<D>(degrees), factorSizes = pointCounts<D>(factorDegrees);
  const Net scaled = binomials<D>(degrees).asDiagonal() * points;
  const Eigen::VectorXd scaledFactor = binomials<D>(factorDegrees).cwiseProduct(factor.col(0));
  std::array<int, D> productDegrees;
  for (std::size_t k = 0; k < D; ++k) productDegrees[k] = degrees[k] + factorDegrees[k];
  const Eigen::VectorXd productBinomials = binomials<D>(productDegrees);
  Net result = Net::Zero(productBinomials.size(), points.cols());
  for (Index r = 0; r < points.rows(); ++r) {
    for (Index f = 0; f < factor.rows(); ++f) {
      Index row = 0, stride = 1, restR = r, restF = f;
      for (int k = D - 1; k >= 0; --k) {
        const auto d = static_cast<std::size_t>(k);
        row += (restR % sizes[d] + restF % factorSizes[d]) * stride;
        stride *= productDegrees[d] + 1;
        restR /= sizes[d];
        restF /= factorSizes[d];
      }
      result.row(row) += scaledFactor[f] * scaled.row(r);
    }
  }
  return productBinomials.cwiseInverse().asDiagonal() * result;
}

#define STRAK_INSTANTIATE(D)                                                           \
  template struct BezierPatch<D>;                                                      \
  template Net applyMaps<D>(const std::array<const Eigen::MatrixXd*, D>&, const Net&); \
  template Net bezierProduct<D>(const Net&, const std::array<int, D>&, const Net&, const std::array<int, D>&);
STRAK_INSTANTIATE(1)
STRAK_INSTANTIATE(2)
STRAK_INSTANTIATE(3)
#undef STRAK_INSTANTIATE

}  // namespace strak
