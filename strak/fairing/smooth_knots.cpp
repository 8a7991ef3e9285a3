#include "strak/fairing/smooth_knots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "strak/base/error.h"
#include "strak/fairing/knot_reduction.h"
#include "strak/metrology/continuity.h"
#include "strak/spline/basis.h"
#include "strak/spline/net_product.h"
#include "strak/spline/reparametrize.h"

namespace strak {
namespace {

constexpr double kDegrees = 57.29577951308232;  // in a radian

using Angles = std::map<double, double>;  // by knot

int multiplicityWished(const KnotVector& knots, int continuity) { return std::max(1, knots.degree() - continuity); }

// The derivative at u of every line of control points by the polynomial of one span.
template <int D>
Net derivativesAlong(const Spline<D>& spline, int direction, Index span, double u) {
  const KnotVector& knots = spline.knots(direction);
  const auto basis = basisDerivatives(knots, span, u, 1);
  const Net part = sliceAlong<D>(spline.net(), spline.sizes(), direction, span - knots.degree(), knots.degree() + 1);
  auto sizes = spline.sizes();
  sizes[static_cast<std::size_t>(direction)] = knots.degree() + 1;
  const auto sum = [&](int order) {
    return mapLines<D>(part, sizes, direction, 1, [&](const auto& lines) -> Net { return basis.row(order) * lines; });
  };
  Net first = sum(1);
  if (!spline.isRational()) return first;
  const Net value = sum(0);
  const Index dimension = spline.pointDimension();
  Net result(first.rows(), dimension);
  for (Index r = 0; r < first.rows(); ++r) {
    const double w = value(r, dimension);
    result.row(r) = (first.row(r).head(dimension) - first(r, dimension) / w * value.row(r).head(dimension)) / w;
  }
  return result;
}

template <int D>
Angles anglesOf(const Spline<D>& spline, int direction) {
  Angles angles;
  if constexpr (D == 2) {
    if (spline.pointDimension() == 3) {
      for (const auto& line : innerContinuity(spline)) {
        if (line.direction == direction) angles[line.knot] = line.continuity.angle.max;
      }
      return angles;
    }
  }
  const KnotVector& knots = spline.knots(direction);
  const std::vector<Index> spans = knots.spans();
  for (std::size_t s = 1; s < spans.size(); ++s) {
    const double u = knots[spans[s]];
    const Net before = derivativesAlong(spline, direction, spans[s - 1], u);
    const Net after = derivativesAlong(spline, direction, spans[s], u);
    double& worst = angles[u];
    for (Index r = 0; r < before.rows(); ++r) {
      const double a = before.row(r).stableNorm(), b = after.row(r).stableNorm();
      if (!(a > 0) || !(b > 0)) continue;
      const double cosine = before.row(r).dot(after.row(r)) / a / b;
      const double sine = (before.row(r) / a - after.row(r) / b).norm();
      // Near zero the chord is exact where the cosine is not.
      worst =
          std::max(worst, cosine > 0.9 ? 2 * std::asin(std::min(1.0, sine / 2)) : std::acos(std::max(-1.0, cosine)));
    }
  }
  return angles;
}

std::string count(Index n, const char* word) { return fmt::format("{} {}{}", n, word, n == 1 ? "" : "s"); }

template <int D>
std::vector<std::string> notesOf(const std::vector<SmoothedKnot>& lines, double deviation) {
  const char* word = D == 1 ? "inner knot" : "inner knot line";
  Index whole = 0, partly = 0;
  std::map<std::string, Index> kept;
  for (const SmoothedKnot& line : lines) {
    if (line.kept.empty()) {
      ++whole;
    } else {
      partly += line.multiplicityAfter < line.multiplicityBefore ? 1 : 0;
      ++kept[line.kept];
    }
  }
  std::vector<std::string> notes;
  if (whole + partly > 0) {
    notes.push_back(fmt::format("{} made smooth{}: the shape moved by at most {:.3g}.", count(whole + partly, word),
                                partly > 0 ? fmt::format(" ({} of them in part)", partly) : "", deviation));
  }
  for (const auto& [reason, number] : kept) notes.push_back(fmt::format("{} kept: {}.", count(number, word), reason));
  return notes;
}

}  // namespace

template <int D>
SmoothedKnots<D> smoothKnots(const Spline<D>& spline, const SmoothKnotsOptions<D>& options) {
  if (!(options.creaseAngle >= 0)) {
    throw InvalidInput(fmt::format("the crease angle is {}: give 0 or more", options.creaseAngle));
  }
  if (options.continuity < 0) {
    throw InvalidInput(fmt::format("cannot smooth to C{}: give 0 or more", options.continuity));
  }
  KnotReductionOptions<D> reducing;
  reducing.tolerance = options.tolerance;
  reducing.rows = options.rows;
  reducing.exactStrips = options.exactStrips;
  reducing.mostRefusals = std::numeric_limits<std::size_t>::max();
  reducing.progress = options.progress;
  KnotReduction<D> reduction(spline, spline, reducing);
  const Spline<D>& fine = reduction.fine();

  SmoothedKnots<D> result{spline, {}, {}, {}};
  for (int k = 0; k < D; ++k) {
    const int wished = multiplicityWished(fine.knots(k), options.continuity);
    const auto inner = fine.knots(k).innerKnots();
    if (std::none_of(inner.begin(), inner.end(), [&](const auto& knot) { return knot.multiplicity > wished; })) {
      continue;
    }
    const Angles angles = anglesOf(fine, k);
    for (const auto& knot : inner) {
      if (knot.multiplicity <= wished) continue;
      const auto angle = angles.find(knot.value);
      result.lines.push_back(
          {k, knot.value, knot.multiplicity, knot.multiplicity, angle == angles.end() ? 0 : angle->second, ""});
    }
  }
  const auto lineOf = [&](int direction, double knot) {
    return std::find_if(result.lines.begin(), result.lines.end(),
                        [&](const SmoothedKnot& line) { return line.direction == direction && line.knot == knot; });
  };
  reduction.collect([&](const auto& candidate) {
    const auto line = lineOf(candidate.direction, candidate.knot);
    return line != result.lines.end() && line->angle <= options.creaseAngle &&
           candidate.multiplicity > multiplicityWished(fine.knots(candidate.direction), options.continuity);
  });

  const std::size_t taken = reduction.taken().size();
  if (taken > 0) {
    result.spline = *reduction.fit(taken);
    result.deviation = certifyDeviation(result.spline, spline);
  }
  for (const TakenKnot& knot : reduction.taken()) --lineOf(knot.direction, knot.knot)->multiplicityAfter;
  for (SmoothedKnot& line : result.lines) {
    const KnotVector& now = result.spline.knots(line.direction);
    if (line.multiplicityAfter <= multiplicityWished(now, options.continuity)) continue;
    if (line.angle > options.creaseAngle) {
      line.kept = fmt::format("an angle above {:.3g} degrees is meant as a crease", options.creaseAngle * kDegrees);
    } else if (reduction.neededByStrips(line.direction, now, line.knot)) {
      line.kept = kNeededByBorders;
    } else {
      line.kept = "the tolerance does not allow more";
    }
  }
  result.notes = notesOf<D>(result.lines, result.deviation.upper);
  return result;
}

template SmoothedKnots<1> smoothKnots(const Spline<1>&, const SmoothKnotsOptions<1>&);
template SmoothedKnots<2> smoothKnots(const Spline<2>&, const SmoothKnotsOptions<2>&);
template SmoothedKnots<3> smoothKnots(const Spline<3>&, const SmoothKnotsOptions<3>&);

}  // namespace strak
