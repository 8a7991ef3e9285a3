#include "strak/energy/energy_operator.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "strak/base/error.h"
#include "strak/solve/kronecker_operator.h"

namespace strak {

namespace {

template <int D>
std::vector<KroneckerProduct> productsOf(const EnergyOperator<D>& op) {
  std::vector<KroneckerProduct> products;
  for (const auto& term : op.terms()) {
    KroneckerProduct product{term.coefficient, {}};
    for (int k = 0; k < D; ++k) {
      product.factors.push_back(&op.factors(k)[static_cast<std::size_t>(term.factor[static_cast<std::size_t>(k)])]);
    }
    products.push_back(std::move(product));
  }
  return products;
}

}  // namespace

template <int D>
EnergyOperator<D>::EnergyOperator(const QuadraticEnergy<D>& energy, const std::array<KnotVector, D>& knots) {
  std::array<std::map<std::pair<int, int>, int>, D> known;
  const auto factorOf = [&](std::size_t k, int a, int b) {
    if (a < 0 || b < 0 || a > 3 || b > 3) {
      throw InvalidInput(
          fmt::format("the energy '{}' asks for derivative {} in direction {}: orders 0 to 3 are possible", energy.name,
                      std::max(a, b), directionName(static_cast<int>(k))));
    }
    const auto [place, isNew] = known[k].try_emplace({a, b}, static_cast<int>(factors_[k].size()));
    if (isNew) {
      factors_[k].push_back(gramMatrix(knots[k], a, b));
      orders_[k].emplace_back(a, b);
    }
    return place->second;
  };
  const auto add = [&](double coefficient, const std::array<int, D>& a, const std::array<int, D>& b) {
    KroneckerTerm<D> term{coefficient, {}};
    for (std::size_t k = 0; k < D; ++k) {
      term.factor[k] = factorOf(k, a[k], b[k]);
      // The square that partial integration may turn it into (BoxEnergy).
      if (a[k] != b[k] && (a[k] + b[k]) % 2 == 0) factorOf(k, (a[k] + b[k]) / 2, (a[k] + b[k]) / 2);
    }
    const auto same =
        std::find_if(terms_.begin(), terms_.end(), [&](const auto& t) { return t.factor == term.factor; });
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
    throw InvalidInput(
        fmt::format("the net has {} points but the energy belongs to {}: use the same knots", x.rows(), rows));
  }
  const std::vector<Index> sizeList(n.begin(), n.end());
  const std::vector<Index> first(D, 0);
  int halo = 0;
  for (const auto& factors : factors_) halo = std::max(halo, factors.front().bandwidth);
  const BoxLayout layout(sizeList, first, sizeList, static_cast<int>(x.cols()), halo);
  Field in(layout), out(layout);
  packBox(layout, x, Eigen::RowVectorXd::Zero(x.cols()), in);
  KroneckerOperator(layout, productsOf(*this)).apply(in, out);
  Net result = Net::Zero(x.rows(), x.cols());
  addBox(layout, out, result);
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
