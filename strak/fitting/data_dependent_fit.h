#pragma once
//
// Fits with the data-dependent energy: how much the surface bends in the inner geometry of the fit before, so that
// neither the parameters nor the scale of the knots say what is fair.
//
// The first fit has a thin plate's energy. Then again and again
//   mean of w |z - X(u)|^2  +  lambda * area * int |Delta X|^2 dA -> min,
// Delta and dA those of the surface of the round before (strak/energy/beltrami_energy.h) and area that of the first, so
// that lambda means the same as with the other energies, until the surface settles; or with |Hess X|^2, which sees the
// borders of the surface as well. Of a function z = f(x, y) the
// reference is the graph (x, y, f) of the fit before, and the energy is that of f in its geometry; a flat graph gives
// the Laplacian's energy.
// Source: Greiner, "Variational design and fairing of spline surfaces" (1994); Hoschek and Juettler (5.3), (5.10).

#include <optional>
#include <string_view>

#include "strak/energy/beltrami_energy.h"
#include "strak/fitting/least_squares.h"

namespace strak {

struct DataDependentOptions {
  InnerBending bending = InnerBending::beltrami;
  int rounds = 10;
  // Settled when a round moves the surface along its normals by less than this part of the errors (root mean squares),
  // or by rounding.
  double settled = 0.05;
  Progress progress;
};

struct DataDependentFit {
  Fit<2> fit;
  FitOptions<2> options;        // with which it was made: the energy of the last round
  int rounds = 0;               // after the first fit
  std::vector<double> changes;  // of every round, root mean squares of the moves
  bool settled = false;
};

// "data-dependent" or "beltrami" (Beltrami's operator), "data-dependent-plate" (all second derivatives); nothing for
// another word.
std::optional<InnerBending> innerBendingNamed(std::string_view name);

// Makes a fit with these options on the knots of the fit before.
using EnergyFitMaker = std::function<Fit<2>(const FitOptions<2>& options, const Fit<2>& previous)>;

// Follows the energy from a fit with a thin plate's. `options` are its own; `make` may smooth, weight and correct as it
// likes. Cost a round: a fit and the energy's matrix, O((p + 1)^6) a knot cell. Throws InvalidInput unless both degrees
// are at least 2 and the fit is a function or a surface in space that is no line.
DataDependentFit followDataDependentEnergy(const Fit<2>& first, const FitOptions<2>& options,
                                           const EnergyFitMaker& make, const DataDependentOptions& iteration = {});

// The thin plate's fit and what follows from it, by least squares.
DataDependentFit fitDataDependently(const std::array<KnotVector, 2>& knots, Index columns, const PointPass<2>& points,
                                    FitOptions<2> options = {}, const DataDependentOptions& iteration = {});

}  // namespace strak
