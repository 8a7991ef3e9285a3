#pragma once
//
// Fewer control points: knots are removed as long as the certified deviation and the figures of fairness hold.
//
// Rounds: all knot lines are ranked by what the removal of each alone would cost (Lyche and Moerken's weights,
// knot_removal.h), many that are no neighbours are taken out together, and the control points are fitted anew by the
// best approximation in the mean square on the fewer knots (energy/projection.h). The number taken out is halved until
// the deviation holds; the fairness is checked at the end, and the removals are gone back until it holds.

#include <array>
#include <string>
#include <vector>

#include "strak/base/progress.h"
#include "strak/fairing/faired.h"
#include "strak/metrology/deviation.h"

namespace strak {

template <int D>
struct SimplifyOptions {
  double tolerance = 0;  // of the certified deviation from the reference; 0 undoes knot insertions only
  // Rows whose image stays to rounding (1e-12 of the size), as in FairingPlanOptions: the value along that side and so
  // many derivatives less one. A knot that such a row needs stays. Sides that meet (closed splines) keep the larger of
  // their direction's numbers, at least one row; so do sides shrunk to a point.
  std::array<Index, 2 * D> rows = heldRows(3);
  // Without this, the rows are the best approximation of their image on the fewer knots, within the tolerance: the same
  // for two surfaces that share a side, so that they still meet. Corners, and all that crosses the side, are kept
  // anyway.
  bool exactStrips = true;
  // The figures of fairness may grow by at most this factor, and not above the reference's where they are below them;
  // what the integration cannot tell (0.1 %, on nets above 10,000 points 1 %) is allowed on top.
  double fairnessGrowth = 1.01;
  Progress progress;

  static constexpr std::array<Index, 2 * D> heldRows(Index count) {
    std::array<Index, 2 * D> rows{};
    for (Index& r : rows) r = count;
    return rows;
  }
};

template <int D>
struct Simplified {
  Spline<D> spline;        // clamped; the input itself if no knot could go
  Deviation<D> deviation;  // from the reference
  Index knotsRemoved = 0;  // over all directions, copies counted
  std::vector<std::string> notes;
};

// `spline` on fewer knots, at most options.tolerance away from `reference` (the same domain; degrees and knots may
// differ). Surfaces in space keep plate, curvature variation and isophote roughness (metrology/fairness.h), curves in
// the plane or in space bending and curvature variation; for all else only the deviation counts. Knots of full
// multiplicity (C0 lines) go only where nothing moves. Rational splines are treated in homogeneous space, with weights
// of their own in the end. The tolerance must leave room beyond the distance that `spline` has already.
// Throws InvalidInput for a negative tolerance, negative rows, a growth below 1, or another domain or dimension.
// Cost: some tens of fits, O(points degree^2) each, with as many certificates, and a few integrations of the fairness.
template <int D>
Simplified<D> simplify(const Spline<D>& spline, const Spline<D>& reference, const SimplifyOptions<D>& options);

template <int D>
Simplified<D> simplify(const Spline<D>& spline, const SimplifyOptions<D>& options) {
  return simplify(spline, spline, options);
}

}  // namespace strak
