#include "strak/energy/energy_operator.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "strak/base/error.h"

namespace strak {

namespace {

// y = (A along one direction) x, where the net is seen as outer x n x inner.
Net alongDirection(const BandMatrix& matrix, const Net& x, Index outer, Index inner) {
  const Index n = matrix.size;
  Net y = Net::Zero(x.rows(), x.cols());
  for (Index o = 0; o < outer; ++o) {
    for (Index i = 0; i < n; ++i) {
      auto target = y.middleRows((o * n + i) * inner, inner);
      for (Index j = std::max<Index>(0, i - matrix.bandwidth); j <= std::min(n - 1, i + matrix.bandwidth); ++j) {
        const double factor = matrix(i, j);
        if (factor != 0) target += factor * x.middleRows((o * n + j) * inner, inner);
      }
    }
  }
  return y;
}

}  // namespace

template <int D>
EnergyOperator<D>::EnergyOperator(const QuadraticEnergy<D>& energy, const std::array<KnotVector, D>& knots) {
  std::array<std::map<std::pair<int, int>, int>, D> known;
  const auto factorOf = [&](std::size_t k, int a, int b) {
    if (a < 0 || b < 0 || a > 3 || b > 3) {
      throw InvalidInput(fmt::format("the energy '{}' asks for derivative {} in direction {}: orders 0 to 3 are possible",
                                     energy.name, std::max(a, b), directionName(static_cast<int>(k))));
    }
    const auto [place, isNew] = known[k].try_emplace({a, b}, static_cast<int>(factors_[k].size()));
    if (isNew) factors_[k].push_back(gramMatrix(knots[k], a, b));
    return place->second;
  };
  const auto add = [&](double coefficient, const std::array<int, D>& a, const std::array<int, D>& b) {
    KroneckerTerm<D> term{coefficient, {}};
    for (std::size_t k = 0; k < D; ++k) term.factor[k] = factorOf(k, a[k], b[k]);
    const auto same = std::find_if(terms_.begin(), terms_.end(), [&](const auto& t) { return t.factor == term.factor; });
    if (same != terms_.end()) {
      same->coefficient += coefficient;
    } else {
      terms_.push_back(term);
    }
  };
  for (std::size_t k = 0; k < D; ++k) factorOf(k, 0, 0);  // so that the sizes are known even without terms
  for (const auto& term : energy.terms) {
    if (term.a == term.b) {
      add(term.coefficient, term.a, term.b);
    } else {
      add(term.coefficient / 2, term.a, term.b);
      add(term.coefficient / 2, term.b, term.a);
    }
  }
}

template <int D>
typename Spline<D>::Sizes EnergyOperator<D>::sizes() const {
  typename Spline<D>::Sizes result;
  for (std::size_t k = 0; k < D; ++k) result[k] = factors_[k].front().size;
  return result;
}

template <int D>
double EnergyOperator<D>::value(const Eigen::Ref<const Net>& net) const {
  return net.cwiseProduct(product(net)).sum();
}

template <int D>
Net EnergyOperator<D>::product(const Eigen::Ref<const Net>& x) const {
  const auto n = sizes();
  Index rows = 1;
  for (Index size : n) rows *= size;
  if (x.rows() != rows) {
    throw InvalidInput(fmt::format("the net has {} points but the energy belongs to {}: use the same knots", x.rows(), rows));
  }
  Net result = Net::Zero(x.rows(), x.cols());
  for (const auto& term : terms_) {
    Net y = x;
    Index outer = 1;
    Index inner = rows;
    for (std::size_t k = 0; k < D; ++k) {
      inner /= n[k];
      y = alongDirection(factors_[k][static_cast<std::size_t>(term.factor[k])], y, outer, inner);
      outer *= n[k];
    }
    result += term.coefficient * y;
  }
  return result;
}

template <int D>
Eigen::VectorXd EnergyOperator<D>::diagonal() const {
  const auto n = sizes();
  Index rows = 1;
  for (Index size : n) rows *= size;
  Eigen::VectorXd result = Eigen::VectorXd::Zero(rows);
  for (Index r = 0; r < rows; ++r) {
    for (const auto& term : terms_) {
      double value = term.coefficient;
      Index rest = r;
      for (int k = D - 1; k >= 0; --k) {
        const auto d = static_cast<std::size_t>(k);
        value *= factors_[d][static_cast<std::size_t>(term.factor[d])](rest % n[d], rest % n[d]);
        rest /= n[d];
      }
      result[r] += value;
    }
  }
  return result;
}

template <int D>
typename EnergyOperator<D>::Stencil EnergyOperator<D>::row(const typename Spline<D>::Sizes& index) const {
  const auto n = sizes();
  Stencil stencil;
  std::size_t total = 1;
  for (std::size_t k = 0; k < D; ++k) {
    const Index p = factors_[k].front().bandwidth;
    stencil.first[k] = std::max<Index>(0, index[k] - p);
    stencil.count[k] = std::min(n[k] - 1, index[k] + p) - stencil.first[k] + 1;
    total *= static_cast<std::size_t>(stencil.count[k]);
  }
  stencil.values.assign(total, 0);
  for (const auto& term : terms_) {
    for (std::size_t s = 0; s < total; ++s) {
      double value = term.coefficient;
      auto rest = static_cast<Index>(s);
      for (int k = D - 1; k >= 0; --k) {
        const auto d = static_cast<std::size_t>(k);
        const Index j = stencil.first[d] + rest % stencil.count[d];
        rest /= stencil.count[d];
        value *= factors_[d][static_cast<std::size_t>(term.factor[d])](index[d], j);
      }
      stencil.values[s] += value;
    }
  }
  return stencil;
}

template <int D>
Eigen::SparseMatrix<double> EnergyOperator<D>::matrix() const {
  const auto n = sizes();
  Index rows = 1;
  for (Index size : n) rows *= size;
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (Index r = 0; r < rows; ++r) {
    typename Spline<D>::Sizes index;
    Index rest = r;
    for (int k = D - 1; k >= 0; --k) {
      index[static_cast<std::size_t>(k)] = rest % n[static_cast<std::size_t>(k)];
      rest /= n[static_cast<std::size_t>(k)];
    }
    const Stencil stencil = row(index);
    for (std::size_t s = 0; s < stencil.values.size(); ++s) {
      auto place = static_cast<Index>(s);
      Index column = 0;
      Index stride = 1;
      for (int k = D - 1; k >= 0; --k) {
        const auto d = static_cast<std::size_t>(k);
        column += (stencil.first[d] + place % stencil.count[d]) * stride;
        place /= stencil.count[d];
        stride *= n[d];
      }
      if (stencil.values[s] != 0) entries.emplace_back(r, column, stencil.values[s]);
    }
  }
  Eigen::SparseMatrix<double> result(rows, rows);
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

template class EnergyOperator<1>;
template class EnergyOperator<2>;
template class EnergyOperator<3>;

}  // namespace strak
