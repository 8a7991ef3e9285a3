#include "strak/fairing/fairing_problem.h"

#include <fmt/format.h>

#include <algorithm>

#include "strak/base/error.h"

namespace strak {

namespace {

constexpr double kRounding = 1e-16;

template <int D>
int largestDegree(const Spline<D>& spline) {
  int degree = 0;
  for (int k = 0; k < D; ++k) degree = std::max(degree, spline.degree(k));
  return degree;
}

// The smallest box that contains all free points.
template <int D>
IndexBox boxAround(const typename Spline<D>::Sizes& sizes, const HeldPoints& held) {
  IndexBox box{std::vector<Index>(sizes.begin(), sizes.end()), std::vector<Index>(D, 0)};
  std::vector<Index> last(D, -1);
  for (std::size_t r = 0; r < held.size(); ++r) {
    if (held[r]) continue;
    auto rest = static_cast<Index>(r);
    for (std::size_t k = D; k-- > 0;) {
      const Index i = rest % sizes[k];
      rest /= sizes[k];
      box.first[k] = std::min(box.first[k], i);
      last[k] = std::max(last[k], i);
    }
  }
  for (std::size_t k = 0; k < D; ++k) box.count[k] = last[k] - box.first[k] + 1;
  return box;
}

}  // namespace

template <int D>
FairingProblem<D>::FairingProblem(const Spline<D>& input, const QuadraticEnergy<D>& energy, const HeldPoints& held,
                                  ParameterScale scale)
    : input_(input), op_(energy, scaledKnots(input, scale)), held_(held) {
  if (!held.empty() && static_cast<Index>(held.size()) != input.net().rows()) {
    throw InvalidInput(fmt::format("the list of held points has {} entries but the net has {} points: give one a point",
                                   held.size(), input.net().rows()));
  }
  const auto sizes = op_.sizes();
  held_.resize(static_cast<std::size_t>(input.net().rows()), 0);
  for (std::size_t r = 0; r < held_.size(); ++r) {
    auto rest = static_cast<Index>(r);
    for (std::size_t k = D; k-- > 0;) {
      const Index i = rest % sizes[k];
      rest /= sizes[k];
      if (!(op_.factors(static_cast<int>(k)).front()(i, i) > 0)) held_[r] = 1;
    }
    if (!held_[r]) ++freePoints_;
  }
  const Net centred = centredNet();
  const Net gradient = op_.product(centred);
  energyBefore_ = centred.cwiseProduct(gradient).sum();
  noise_ = kRounding * op_.diagonal().dot(centred.rowwise().squaredNorm());
  if (freePoints_ == 0) return;

  const IndexBox box = boxAround<D>(sizes, held_);
  boxEnergy_.emplace(op_, box);
  const int components = static_cast<int>(input.net().cols());
  layout_.emplace(std::vector<Index>(sizes.begin(), sizes.end()), box.first, box.count, components,
                  largestDegree(input));
  linear_ = Field(*layout_);
  isFree_ = Field(layout_->scalar());
  packBox(*layout_, gradient, Eigen::RowVectorXd::Zero(components), linear_);
  for (Index r = 0; r < layout_->rows(); ++r) {
    for (Index j = 0; j < layout_->size[2]; ++j) {
      isFree_.row(r, 0)[j] = held_[static_cast<std::size_t>(layout_->netRow(r, j))] ? 0 : 1;
    }
  }
}

// An energy without a mass term does not see translations, but rounding does.
template <int D>
Net FairingProblem<D>::centredNet() const {
  for (const auto& term : op_.terms()) {
    bool seesConstants = true;
    for (int k = 0; k < D; ++k) {
      const auto [a, b] = op_.factorOrders(k)[static_cast<std::size_t>(term.factor[static_cast<std::size_t>(k)])];
      seesConstants = seesConstants && a == 0 && b == 0;
    }
    if (seesConstants) return input_.net();
  }
  return input_.net().rowwise() - input_.net().colwise().mean();
}

template <int D>
Net FairingProblem<D>::halfGradient() const {
  return op_.product(centredNet());
}

template <int D>
BallProblem FairingProblem<D>::ball(double radius) {
  if (!basis_) {
    basis_.emplace(*layout_, boxEnergy_->stiffness(), boxEnergy_->mass().factors);
    kronecker_.emplace(*layout_, boxEnergy_->products());
  }
  BallProblem problem;
  problem.energy = &*kronecker_;
  problem.linear = &linear_;
  problem.free = &isFree_;
  problem.products = boxEnergy_->products();
  problem.lowerBound = boxEnergy_->lowerBound();
  problem.massProduct = boxEnergy_->mass();
  problem.basis = &*basis_;
  problem.radius = radius;
  problem.scale = energyBefore_;
  problem.noise = noise_;
  return problem;
}

template class FairingProblem<1>;
template class FairingProblem<2>;
template class FairingProblem<3>;

}  // namespace strak
