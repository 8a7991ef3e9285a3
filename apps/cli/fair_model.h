#pragma once
//
// Fairs the objects of an open file and puts them back, one decision an object: faired, left alone, or refused.

#include <functional>
#include <string>
#include <vector>

#include "apps/cli/fair_knots.h"
#include "strak/exchange/model.h"
#include "strak/fairing/certified_fairing.h"
#include "strak/report/fair_report.h"

namespace strak::cli {

// The names of the energies of the shape itself, and of the one in the geometry of the step before.
inline constexpr const char* kExactEnergy = "exact";
inline constexpr const char* kDataDependentEnergy = "data-dependent";

// What happens to the joins of faces: they stay as they are, or become smoother, with the faces on both sides moving.
enum class JoinWish { keep, g1, g2 };

// In which planes borders are those of a symmetric half, and may move: none, any that holds a border to which its face
// is perpendicular, or those with that axis for a normal.
enum class SymmetryWish { none, any, x, y, z };

struct FairModelOptions {
  std::vector<Index> selected;  // numbers of the objects to fair
  // exact (surfaces in space; thin-plate for all else), data-dependent (surfaces in space), or as energyNamed has it
  std::string energy = kExactEnergy;
  std::vector<Index> holdRows{3};  // one number for all ends, or one an end
  JoinWish join = JoinWish::keep;
  SymmetryWish symmetry = SymmetryWish::none;  // with `join` only
  bool refine = true;                          // knots may be inserted where nothing is free
  KnotOptions knots;                           // what is done to the knots before and after
  CertifiedFairingOptions fairing;             // its progress is not used
  std::string curveMethod;                     // a method for curves alone (fair_curve.h); empty: as `fairing` says
  Index maxExtrema = -1;                       // curvature extrema wished at most of a curve; negative: no wish
  bool showProgress = true;                    // a bar on a terminal
  std::function<bool()> stopped;               // asked again and again; true ends the work with the best so far
};

struct FairModelResult {
  std::vector<FairedObject> objects;  // one an object of the model
  Audit before, after;
};

// Surfaces that share their geometry are faired once. Objects are worked on in parallel; the result does not depend on
// the number of threads. A changed object that makes the model's audit worse (validity, gaps beyond rounding,
// tolerances) is put back as it was and listed with that reason.
// Throws InvalidInput or Failure instead of listing a reason if only one object is selected.
FairModelResult fairModel(Model& model, const FairModelOptions& options);

}  // namespace strak::cli
