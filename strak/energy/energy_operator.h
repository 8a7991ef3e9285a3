#pragma once
//
// A quadratic energy on given knots: E(X) = sum over p, q of K_pq d_p . d_q with K a short sum of Kronecker products of
// 1D Gram matrices. Nothing of the size of K is stored unless asked for.
//
// Source: Hadenfeld (9) and its symmetrised form for energies with cross terms,
//   K = sum_t (c_t / 2) [ (x)_k U_k^{a_k, b_k} + (x)_k U_k^{b_k, a_k} ].

#include <Eigen/SparseCore>
#include <array>
#include <utility>
#include <vector>

#include "strak/energy/gram.h"
#include "strak/energy/quadratic_energy.h"

namespace strak {

// One Kronecker product: coefficient * (x)_k factors[k][factor[k]].
template <int D>
struct KroneckerTerm {
  double coefficient;
  std::array<int, D> factor;  // index into EnergyOperator::factors(k)
};

template <int D>
class EnergyOperator {
 public:
  // Throws InvalidInput if a term's derivative order is negative or above 3 in a direction.
  EnergyOperator(const QuadraticEnergy<D>& energy, const std::array<KnotVector, D>& knots);

  // The different 1D Gram matrices of direction k (the mass matrix first), and the sum of products that makes K
  // (symmetric as a whole).
  const std::vector<BandMatrix>& factors(int direction) const { return factors_[static_cast<std::size_t>(direction)]; }
  // Which derivatives they integrate: factors(k)[i] = integral N^(first) N^(second).
  const std::vector<std::pair<int, int>>& factorOrders(int direction) const {
    return orders_[static_cast<std::size_t>(direction)];
  }
  const std::vector<KroneckerTerm<D>>& terms() const { return terms_; }
  typename Spline<D>::Sizes sizes() const;

  // E of a net (all columns together). Cost as product().
  double value(const Eigen::Ref<const Net>& net) const;
  // K x, row for row of the net. Cost O(N p) per term and column; the gradient of E is twice this.
  Net product(const Eigen::Ref<const Net>& x) const;
  Net gradient(const Eigen::Ref<const Net>& net) const { return 2 * product(net); }

  // K_rr for every control point r.
  Eigen::VectorXd diagonal() const;

  // The row of K at `index`: a dense box of neighbours first[k] .. first[k] + count[k] - 1, last direction fastest.
  struct Stencil {
    typename Spline<D>::Sizes first, count;
    std::vector<double> values;
  };
  Stencil row(const typename Spline<D>::Sizes& index) const;

  // K as a sparse matrix (both triangles). Memory 16 N (2p + 1)^D bytes.
  Eigen::SparseMatrix<double> matrix() const;

 private:
  std::array<std::vector<BandMatrix>, D> factors_;
  std::array<std::vector<std::pair<int, int>>, D> orders_;
  std::vector<KroneckerTerm<D>> terms_;
};

}  // namespace strak
