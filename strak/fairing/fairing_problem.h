#pragma once
//
// A fairing task set up for the solvers: the energy on the smallest box of the net that holds all free points, with the
// displacements of the points as unknowns. What optimal fairing and the certificate have in common.

#include <optional>

#include "strak/energy/box_energy.h"
#include "strak/energy/parameter_scale.h"
#include "strak/fairing/held_points.h"
#include "strak/solve/ball_minimizer.h"

namespace strak {

template <int D>
class FairingProblem {
 public:
  // `held` as in the fairing options; points that no energy can see (their function's support does not meet the domain)
  // are held as well. The model's place does not matter: the net is centred first.
  // `input` must live as long as this object. Throws InvalidInput if `held` has another length than the net has points.
  FairingProblem(const Spline<D>& input, const QuadraticEnergy<D>& energy, const HeldPoints& held,
                 ParameterScale scale);
  FairingProblem(const FairingProblem&) = delete;
  FairingProblem& operator=(const FairingProblem&) = delete;

  const EnergyOperator<D>& energy() const { return op_; }
  const HeldPoints& held() const { return held_; }
  Index freePoints() const { return freePoints_; }
  double energyBefore() const { return energyBefore_; }
  double noise() const { return noise_; }  // what rounding alone may do to an energy

  // Half the gradient of the input's energy, K d0, for all points of the net.
  Net halfGradient() const;

  // The problem for the solvers, in displacements of the free points. Needs at least one free point; valid as long as
  // this object lives.
  BallProblem ball(double radius);
  const BoxLayout& layout() const { return *layout_; }

 private:
  Net centredNet() const;

  const Spline<D>& input_;
  EnergyOperator<D> op_;
  HeldPoints held_;
  Index freePoints_ = 0;
  double energyBefore_ = 0, noise_ = 0;
  std::optional<BoxEnergy<D>> boxEnergy_;
  std::optional<BoxLayout> layout_;
  std::optional<ModalBasis> basis_;
  std::optional<KroneckerOperator> kronecker_;
  Field linear_, isFree_;
};

}  // namespace strak
