#pragma once
//
// A spline and the knots that are taken out of it: what making it smooth at its knots and making do with fewer of them
// have in common.
//
// Knots go in rounds: the cheapest by Lyche and Moerken's weights (knot_removal.h), no two neighbours, as many together
// as the proof lets pass; then all control points are fitted anew, from the first spline, by the best approximation in
// the mean square (energy/projection.h).

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "strak/base/progress.h"
#include "strak/energy/projection.h"
#include "strak/metrology/deviation.h"

namespace strak {

// One copy of a knot taken out of one direction.
struct TakenKnot {
  int direction;
  double knot;
};

template <int D>
struct KnotReductionOptions {
  double tolerance = 0;             // of the certified deviation from the reference; 0 lets only inserted knots go
  std::array<Index, 2 * D> rows{};  // derivatives kept at the sides, the value included
  bool exactStrips = true;          // the image of those rows along the sides stays to rounding, too
  std::size_t mostRefusals = 8;     // single knots that may fail before the search ends
  Progress progress;
};

template <int D>
class KnotReduction {
 public:
  static constexpr double kRounding = 1e-12;  // of the size: what exact strips may move

  // `reference` must live as long as this object. Throws InvalidInput for a negative tolerance or rows, and for splines
  // with points of different dimension.
  KnotReduction(const Spline<D>& spline, const Spline<D>& reference, const KnotReductionOptions<D>& options);

  const Spline<D>& fine() const { return fine_; }  // the spline with clamped ends

  // Whether one more copy of a knot may go; `cost` is how far control points would move, `multiplicity` what is left.
  struct Candidate {
    int direction;
    double knot, cost;
    int multiplicity;
    bool costsNothing;  // but rounding
  };
  using Rule = std::function<bool(const Candidate&)>;

  // Takes out knots by the rule as long as tolerance and strips hold.
  void collect(const Rule& mayGo);
  const std::vector<TakenKnot>& taken() const { return taken_; }

  // The best approximation without the first `count` knots of the list; nothing where a weight would not stay positive.
  std::optional<Spline<D>> fit(std::size_t count) const;
  // Whether the strips stay and the deviation from the reference is proven to keep the tolerance.
  bool keepsShape(const Spline<D>& coarse) const;
  // Whether it is the first spline, to rounding.
  bool isSame(const Spline<D>& coarse) const;
  // Whether the strips of other directions need this knot of those in `knots`.
  bool neededByStrips(int direction, const KnotVector& knots, double knot) const;

 private:
  KeptEnds endsOf(int direction, const Net& points) const;
  void noteHeldRows();
  std::vector<TakenKnot> round(const Spline<D>& now, const Rule& mayGo) const;
  std::vector<double> stuckKnots(int direction, const KnotVector& knots) const;
  bool stopped() const { return !options_.progress.report(-1, "fewer knots"); }

  KnotReductionOptions<D> options_;
  Spline<D> fine_;
  const Spline<D>& reference_;
  std::optional<Spline<D>> fineReference_;
  double size_ = 0, weight_ = 1;
  std::array<KeptEnds, static_cast<std::size_t>(D)> ends_;
  std::vector<std::uint8_t> held_;
  std::array<std::optional<Curve>, static_cast<std::size_t>(D)> strips_;  // all lines in strips, as one curve
  std::vector<TakenKnot> taken_;
  std::array<std::vector<double>, static_cast<std::size_t>(D)> refused_;
};

extern template class KnotReduction<1>;
extern template class KnotReduction<2>;
extern template class KnotReduction<3>;

}  // namespace strak
