#pragma once
//
// What `strak fair` does to the knots: smooth where no crease is meant, before fairing; fewer of them, after it.

#include <array>
#include <vector>

#include "strak/exchange/model.h"
#include "strak/fairing/simplify.h"
#include "strak/fairing/smooth_knots.h"
#include "strak/report/fair_report.h"

namespace strak::cli {

struct KnotOptions {
  bool simplify = false;
  bool simplifyBorders = false;  // the held rows may be approximated, too
  bool smooth = false;
  double creaseAngle = SmoothKnotsOptions<2>{}.creaseAngle;  // radians

  bool any() const { return simplify || smooth; }
};

// Whether what lies along the sides of the domain is all that the object's neighbours touch: then strips there are
// enough to keep the joins. Trimming curves inside need every point near them where it is.
bool onlySidesMatter(const Object& object);

// Whether faces of the model may share edges: then what lies along the sides must stay to rounding.
bool mayHaveNeighbours(const Model& model);

// What an object's knots are worked on with.
template <int D>
struct KnotRules {
  KnotOptions options;
  double tolerance = 0;  // of the whole way from the object as it was
  std::array<Index, 2 * D> rows{};
  bool exact = false;     // held rows keep their image along the sides, because neighbours lie there
  bool onlySides = true;  // onlySidesMatter() for all objects with this spline
};

// Whether the faired object is rougher than it was before its knots were made smooth, by the figures that the entry
// has. An angle or a jump of the curvature at a knot line that went counts as the roughness it stands for
// (JoinEnergy): an integral does not see it.
bool rougherThanInput(const Surface& original, const FairedObject& entry);
bool rougherThanInput(const Curve& original, const FairedObject& entry);
inline bool rougherThanInput(const Volume&, const FairedObject&) { return false; }

// Whether smoothing needs the borders to move.
bool needsBorders(const Surface& surface, const KnotRules<2>& rules);

// `spline` with smooth inner knots, within half of the tolerance; tells the entry.
template <int D>
Spline<D> withSmoothKnots(const Spline<D>& spline, const KnotRules<D>& rules, FairedObject& entry);

// The part of the tolerance that fairing may use: what smoothing has left, and of that four fifths if knots are to be
// removed afterwards.
double toleranceForFairing(const KnotOptions& options, double tolerance, double smoothed);

// `faired` on fewer knots, within the tolerance from `original` and as fair; tells the entry.
template <int D>
Spline<D> withFewerKnots(const Spline<D>& faired, const Spline<D>& original, const KnotRules<D>& rules,
                         const Progress& progress, FairedObject& entry);

}  // namespace strak::cli
