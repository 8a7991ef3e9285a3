#pragma once
//
// Quadratic fairness energies as data: E(X) = sum over terms of c * integral (D^a X) . (D^b X) over the domain, a and b
// derivative orders per direction (Hadenfeld (2), (15), (16); Hoschek and Juettler (5.2)).

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

template <int D>
struct EnergyTerm {
  double coefficient;
  std::array<int, D> a, b;
};

// A plain list of terms. Energies are added and scaled term by term, so that every mixture is an energy too.
template <int D>
struct QuadraticEnergy {
  std::string name;
  std::vector<EnergyTerm<D>> terms;

  // The highest derivative order of any term, summed over the directions: 2 for the thin plate.
  int order() const;
};

// E = sum over directions k, l of (X_kl)^2: u'' for curves, (2) X_uu^2 + 2 X_uv^2 + X_vv^2 for surfaces.
template <int D>
QuadraticEnergy<D> thinPlate();

// (sum over k of X_kk)^2, the squared Laplacian. Its kernel is larger than the thin plate's.
template <int D>
QuadraticEnergy<D> laplacian();

// (15): the sum of the squared pure third derivatives. Not invariant to rotations of the parameters.
template <int D>
QuadraticEnergy<D> thirdOrder();

// (16): |grad of the Laplacian|^2, the right form of Q2 (the printed one has a misprint).
template <int D>
QuadraticEnergy<D> laplacianGradient();

// The sum over k, l, m of (X_klm)^2: all third derivatives, invariant to rotations of the parameters.
template <int D>
QuadraticEnergy<D> thirdDerivatives();

// Q3 = X_uuv^2 + X_uvv^2 (all mixed third derivatives of the form kkl, k != l). Infinite-dimensional kernel: f(u) +
// g(v). Exists for D >= 2 only; throws InvalidInput for curves.
template <int D>
QuadraticEnergy<D> q3();

// The energy of that name, or a mixture "thin-plate + 0.01 * third-derivatives". Names: thin-plate, laplacian,
// third-order, laplacian-gradient, third-derivatives, q3. Throws InvalidInput with the list of names for an unknown
// one.
template <int D>
QuadraticEnergy<D> energyNamed(std::string_view text);

}  // namespace strak
