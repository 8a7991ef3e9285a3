#pragma once
//
// Any spline, rational ones too, as a polynomial one of a wished degree on uniform or on adapted knots, within a
// tolerance.
//
// The corners stay; a border is the best approximation of that border alone in the mean square, and the inside that
// between its borders: least squares in one direction after the other. Source: Lee, Lee and Park, Semi-automatic Method
// for Surface Smoothing, 2.2. Their points are integrals here, and the number of spans to begin with is (1) with the
// sums taken a direction: the new spline has as many numbers as the old one,
//   spans = ceil(old spans (old degree + 1) / (degree + 1)).
// They repeat it with more patches by hand; here lines of the spline in either direction, approximated alone, say where
// more are needed, and the deviation is certified.

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "strak/metrology/deviation.h"

namespace strak {

enum class KnotSpacing {
  uniform,  // equal spans and single knots: as smooth as the degree allows, also where the input is not
  adapted,  // the input's knots, as often as they must be to keep its creases, and halves of spans where needed
};

struct ConversionOptions {
  int degree = 3;  // in all directions, 1 to 15
  KnotSpacing spacing = KnotSpacing::uniform;
  double tolerance = std::numeric_limits<double>::infinity();  // of the certified deviation; infinity: the first spans
  Index mostPoints = 200'000;                                  // control points
  // Of uniform knots, a direction: as many as a neighbour has along a common side. 0: as few as will do.
  std::array<Index, 3> leastSpans{};
  // Of the certified deviation of a side alone, in the order of Converted::sides; not of a curve, whose ends stay.
  std::array<double, 6> sideTolerances = anyDeviation();

  static constexpr std::array<double, 6> anyDeviation() {
    std::array<double, 6> any{};
    for (double& tolerance : any) tolerance = std::numeric_limits<double>::infinity();
    return any;
  }
};

template <int D>
struct Converted {
  Spline<D> spline;        // polynomial, on the domain of the input
  Deviation<D> deviation;  // from the input, parameter by parameter
  // The same of the 2 D sides alone: low and high in direction 0, low and high in direction 1, ... (ends of a curve).
  std::array<double, 2 * static_cast<std::size_t>(D)> sides{};
  bool unchanged = false;            // the input was such a spline already: it comes back to the bit
  bool reached = true;               // the tolerances; if not, the above is what mostPoints allow
  int rounds = 0;                    // nets that were made and certified
  std::vector<std::string> creases;  // of the input, that uniform knots round: "12.3 degrees at u = 0.5"
};

// Directions that are such splines already keep their knots. Throws InvalidInput for a degree outside the limits, a
// tolerance that is not positive, a spline that jumps inside, and where not even the first spans are fewer than
// mostPoints allow; as certifyDeviation and polynomialOnto do. Cost: some rounds of O(points degree^2) and their
// certificates; 0.1 s for 100 x 100 points.
template <int D>
Converted<D> convertSpline(const Spline<D>& spline, const ConversionOptions& options);

}  // namespace strak
