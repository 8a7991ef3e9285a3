#pragma once
//
// A control net under one-point moves: half the energy's gradient, the moves so far and the ranking numbers of all
// points, kept up to date in O((2p+1)^D) per move.

#include <vector>

#include "strak/energy/energy_operator.h"
#include "strak/fairing/held_points.h"
#include "strak/fairing/ranking_kernels.h"

namespace strak {

template <int D>
class RankedNet {
 public:
  // A place numbers a point in the padded layout of these arrays.
  using Place = std::ptrdiff_t;

  // `radius`: of the balls that bound the moves; `rankingRadius`: of those that the ranking number (5.9) sees, infinite
  // for the number (6). Points whose basis function vanishes on the domain count as held. `energy` must outlive this.
  // Throws InvalidInput if the energy does not see a free point or is too large for double precision.
  RankedNet(const EnergyOperator<D>& energy, const Net& net, const HeldPoints& held, double radius,
            double rankingRadius);
  RankedNet(const RankedNet&) = delete;
  RankedNet& operator=(const RankedNet&) = delete;

  const std::vector<Index>& freeRows() const { return freeRows_; }  // of the net, ascending
  const std::vector<Place>& freePlaces() const { return freePlaces_; }
  Index places() const { return static_cast<Index>(gain_.size()); }
  Index components() const { return grid_.components; }

  double gain(Place place) const { return gain_[static_cast<std::size_t>(place)]; }
  double weight(Place place) const { return weight_[static_cast<std::size_t>(place)]; }                // K_rr
  double gradient(Place place, Index component) const { return gradient_[number(place, component)]; }  // of K d
  double shift(Place place, Index component) const { return shift_[number(place, component)]; }        // d - d0

  // The place with the largest gain; the first of equals.
  Place largest() const { return kernels_.largest(grid_); }

  // Moves the point to its target or, if that lies outside, to the ball's point nearest to it (14). Returns the length
  // of the move; zero if the point lies there already, to rounding.
  double moveToTarget(Place place);

  // The point's gain is zero from now on.
  void retire(Place place);

  double startEnergy() const { return startEnergy_; }
  double energy() const;

 private:
  static constexpr std::size_t kLast = D - 1;

  void layOut();
  void copyLastDirection(const EnergyOperator<D>& energy);
  void copyLeadingDirections(const EnergyOperator<D>& energy);
  void fillPoints(const EnergyOperator<D>& energy, const Net& net, const HeldPoints& held);
  void buildTournament();
  std::size_t number(Place place, Index component) const {
    return static_cast<std::size_t>(component * grid_.plane + place);
  }

  const ranking::Kernels kernels_ = ranking::chosen();
  double radius_ = 0;
  double startEnergy_ = 0;

  typename Spline<D>::Sizes sizes_, pad_{};
  ranking::Grid grid_{};
  ranking::Stencil stencil_{};
  std::vector<std::ptrdiff_t> offsets_;
  std::vector<Index> unpadded_;          // number of a grid row among the rows of the net, -1 for padding
  std::vector<std::size_t> lastFactor_;  // which of the stencils' parts a term of the energy belongs to
  std::vector<double> outer_, inner_;    // the stencils' parts, per row of the net and per column
  std::vector<double> gradient_, shift_, weight_, inverse_, gain_;
  std::vector<std::vector<double>> levels_;

  std::vector<Index> freeRows_;
  std::vector<Place> freePlaces_;
  std::vector<double> startGradient_;  // of the free points
  std::vector<double> move_;
};

extern template class RankedNet<1>;
extern template class RankedNet<2>;
extern template class RankedNet<3>;

}  // namespace strak
