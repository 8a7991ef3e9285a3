#include "strak/spline/evaluate.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <vector>

#include "strak/base/error.h"
#include "strak/spline/basis.h"

namespace strak {

namespace {

using Orders = std::array<int, 3>;

// The partial derivatives in the order of the result.
template <int D>
std::vector<Orders> graded(int order) {
  std::vector<Orders> result;
  for (int total = 0; total <= order; ++total) {
    for (int a = total; a >= 0; --a) {
      if (D == 1 && a < total) break;
      for (int b = total - a; b >= 0; --b) {
        if (D == 2 && b < total - a) break;
        result.push_back({a, b, total - a - b});
      }
    }
  }
  return result;
}

int binomial(int n, int k) {
  int result = 1;
  for (int i = 1; i <= k; ++i) result = result * (n - k + i) / i;
  return result;
}

// Turns the derivatives of a homogeneous point into those of the point of space: w X = A differentiated by Leibniz.
void dehomogenize(const std::vector<Orders>& partials, int columns, const double* homogeneous, double* out) {
  const int dimension = columns - 1;
  const double weight = homogeneous[dimension];
  for (std::size_t r = 0; r < partials.size(); ++r) {
    double* target = out + r * static_cast<std::size_t>(dimension);
    for (int c = 0; c < dimension; ++c)
      target[c] = homogeneous[r * static_cast<std::size_t>(columns) + static_cast<std::size_t>(c)];
    for (std::size_t s = 1; s <= r; ++s) {
      int factor = 1;
      Orders rest{};
      for (std::size_t k = 0; k < 3; ++k) {
        rest[k] = partials[r][k] - partials[s][k];
        factor = rest[k] < 0 ? 0 : factor * binomial(partials[r][k], partials[s][k]);
      }
      if (factor == 0) continue;
      std::size_t lower = 0;
      while (partials[lower] != rest) ++lower;
      const double w =
          factor * homogeneous[s * static_cast<std::size_t>(columns) + static_cast<std::size_t>(dimension)];
      for (int c = 0; c < dimension; ++c)
        target[c] -= w * out[lower * static_cast<std::size_t>(dimension) + static_cast<std::size_t>(c)];
    }
    for (int c = 0; c < dimension; ++c) target[c] /= weight;
  }
}

template <int D>
void derivativesAtPoint(const Spline<D>& spline, const std::array<double, D>& u, const std::vector<Orders>& partials,
                        int order, double* out) {
  std::array<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>, 3> basis;
  std::array<Index, 3> first{};
  std::array<Index, 3> stride{};
  for (auto& b : basis) b = Eigen::MatrixXd::Ones(1, 1);
  Index rows = 1;
  for (int k = D - 1; k >= 0; --k) {
    const auto d = static_cast<std::size_t>(k);
    const Index span = spline.knots(k).findSpan(u[d]);
    basis[d] = basisDerivatives(spline.knots(k), span, u[d], order);
    first[d] = span - spline.degree(k);
    stride[d] = rows;
    rows *= spline.size(k);
  }
  const Net& net = spline.net();
  Net sums(static_cast<Index>(partials.size()), net.cols());
  for (std::size_t r = 0; r < partials.size(); ++r) {
    Point sum = Point::Zero(net.cols());
    for (Index i = 0; i < basis[0].cols(); ++i) {
      for (Index j = 0; j < basis[1].cols(); ++j) {
        for (Index k = 0; k < basis[2].cols(); ++k) {
          sum += basis[0](partials[r][0], i) * basis[1](partials[r][1], j) * basis[2](partials[r][2], k) *
                 net.row((first[0] + i) * stride[0] + (first[1] + j) * stride[1] + (first[2] + k) * stride[2]);
        }
      }
    }
    sums.row(static_cast<Index>(r)) = sum;
  }
  if (spline.isRational()) {
    dehomogenize(partials, static_cast<int>(net.cols()), sums.data(), out);
  } else {
    std::copy(sums.data(), sums.data() + sums.size(), out);
  }
}

template <int D>
std::vector<Orders> checkedPartials(int order) {
  if (order < 0 || order > 3)
    throw InvalidInput(fmt::format("derivatives of order {} are not offered: ask for 0 to 3", order));
  return graded<D>(order);
}

}  // namespace

template <int D>
Net derivatives(const Spline<D>& spline, const std::array<double, D>& u, int order) {
  const auto partials = checkedPartials<D>(order);
  Net result(static_cast<Index>(partials.size()), spline.pointDimension());
  derivativesAtPoint<D>(spline, u, partials, order, result.data());
  return result;
}

template <int D>
Point evaluate(const Spline<D>& spline, const std::array<double, D>& u) {
  return derivatives<D>(spline, u, 0).row(0);
}

template <int D>
Net derivativesAt(const Spline<D>& spline, const Eigen::Ref<const Net>& parameters, int order) {
  const auto partials = checkedPartials<D>(order);
  if (parameters.cols() != D) {
    throw InvalidInput(
        fmt::format("the parameters have {} columns but the spline has {} directions: give one column a direction",
                    parameters.cols(), D));
  }
  Net result(parameters.rows(), static_cast<Index>(partials.size()) * spline.pointDimension());
  tbb::parallel_for(tbb::blocked_range<Index>(0, parameters.rows(), 256), [&](const auto& range) {
    for (Index r = range.begin(); r < range.end(); ++r) {
      std::array<double, D> u;
      for (int k = 0; k < D; ++k) u[static_cast<std::size_t>(k)] = parameters(r, k);
      derivativesAtPoint<D>(spline, u, partials, order, &result(r, 0));
    }
  });
  return result;
}

template <int D>
Net derivativesOnGrid(const Spline<D>& spline, const std::array<std::vector<double>, D>& parameters, int order) {
  Index count = 1;
  for (const auto& values : parameters) count *= static_cast<Index>(values.size());
  Net all(count, D);
  for (Index r = 0; r < count; ++r) {
    Index rest = r;
    for (int k = D - 1; k >= 0; --k) {
      const auto& values = parameters[static_cast<std::size_t>(k)];
      const auto size = static_cast<Index>(values.size());
      all(r, k) = values[static_cast<std::size_t>(rest % size)];
      rest /= size;
    }
  }
  return derivativesAt<D>(spline, all, order);
}

#define STRAK_INSTANTIATE(D)                                                          \
  template Point evaluate<D>(const Spline<D>&, const std::array<double, D>&);         \
  template Net derivatives<D>(const Spline<D>&, const std::array<double, D>&, int);   \
  template Net derivativesAt<D>(const Spline<D>&, const Eigen::Ref<const Net>&, int); \
  template Net derivativesOnGrid<D>(const Spline<D>&, const std::array<std::vector<double>, D>&, int);
STRAK_INSTANTIATE(1)
STRAK_INSTANTIATE(2)
STRAK_INSTANTIATE(3)
#undef STRAK_INSTANTIATE

}  // namespace strak
