#include "strak/fairing/held_rows.h"

#include <algorithm>
#include <numeric>

namespace strak {

bool isCrease(const KnotVector& knots, Index multiplicity, int energyOrder) {
  return multiplicity > knots.degree() - energyOrder + 1;
}

namespace {

// Rows first..last (inclusive, perhaps empty) that are held together.
struct Range {
  Index first, last;
};

// The held ranges of one direction, from the low end over the creases to the high end.
std::vector<Range> heldRanges(const KnotVector& knots, const HeldBorders& borders, int energyOrder) {
  const Index p = knots.degree();
  const Index n = knots.size();
  // At an end with fewer than p knots p - m + 1 rows take part in the position there instead of one.
  const Index low = p - std::min<Index>(p, knots.multiplicity(knots.from()));
  const Index high = p - std::min<Index>(p, knots.multiplicity(knots.to()));
  const Index lowRows = borders.low > 0 ? borders.low + low : 0;
  const Index highRows = borders.high > 0 ? borders.high + high : 0;
  std::vector<Range> ranges{{0, std::min(lowRows, n) - 1}};
  for (const auto& knot : knots.innerKnots()) {
    if (!isCrease(knots, knot.multiplicity, energyOrder)) continue;
    // Rows s - p .. s - m take part in the position at the knot; each further row outwards adds a derivative. With
    // m = p + 1 the two sides are apart and have a row each.
    const Index s = knots.findSpan(knot.value);
    const Index near = s - p;
    const Index far = s - knot.multiplicity;
    ranges.push_back({std::max<Index>(0, std::min(near, far) - borders.crease + 1),
                      std::min(n - 1, std::max(near, far) + borders.crease - 1)});
  }
  ranges.push_back({std::max<Index>(0, n - highRows), n - 1});
  return ranges;
}

std::vector<double> breakpoints(const KnotVector& knots) {
  std::vector<double> values{knots.from()};
  for (const auto& knot : knots.innerKnots()) values.push_back(knot.value);
  values.push_back(knots.to());
  return values;
}

// Halves the longest stretch of `points` `count` times and returns the new values.
std::vector<double> halveLongest(std::vector<double> points, Index count) {
  std::vector<double> added;
  for (; count > 0; --count) {
    std::size_t longest = 0;
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
      // Lengths equal to rounding count as equal, so that the first of them is taken on every scale of the knots.
      if (points[i + 1] - points[i] > (1 + 1e-9) * (points[longest + 1] - points[longest])) longest = i;
    }
    const double middle = std::midpoint(points[longest], points[longest + 1]);
    if (!(points[longest] < middle && middle < points[longest + 1])) break;  // no number lies between
    points.insert(points.begin() + static_cast<std::ptrdiff_t>(longest) + 1, middle);
    added.push_back(middle);
  }
  return added;
}

}  // namespace

std::vector<std::uint8_t> heldRows(const KnotVector& knots, const HeldBorders& borders, int energyOrder) {
  std::vector<std::uint8_t> held(static_cast<std::size_t>(knots.size()), 0);
  for (const Range& range : heldRanges(knots, borders, energyOrder)) {
    for (Index i = range.first; i <= range.last; ++i) held[static_cast<std::size_t>(i)] = 1;
  }
  return held;
}

std::vector<double> knotsForRoom(const KnotVector& knots, const HeldBorders& borders, int energyOrder, Index minFree) {
  const std::vector<Range> ranges = heldRanges(knots, borders, energyOrder);
  const std::vector<double> points = breakpoints(knots);
  std::vector<double> ends{knots.from()};
  for (const auto& knot : knots.innerKnots()) {
    if (isCrease(knots, knot.multiplicity, energyOrder)) ends.push_back(knot.value);
  }
  ends.push_back(knots.to());

  std::vector<double> added;
  Index free = 0;
  for (std::size_t k = 0; k + 1 < ranges.size(); ++k) {
    const Index room = ranges[k + 1].first - ranges[k].last - 1;
    const auto from = std::find(points.begin(), points.end(), ends[k]);
    const auto to = std::find(points.begin(), points.end(), ends[k + 1]);
    const std::vector<double> here = halveLongest(std::vector<double>(from, to + 1), 1 - std::min<Index>(room, 1));
    added.insert(added.end(), here.begin(), here.end());
    free += std::max<Index>(room, 1);
  }
  std::vector<double> all = points;
  all.insert(all.end(), added.begin(), added.end());
  std::sort(all.begin(), all.end());
  const std::vector<double> more = halveLongest(std::move(all), std::max<Index>(0, minFree - free));
  added.insert(added.end(), more.begin(), more.end());
  return added;
}

std::vector<double> midSpans(const KnotVector& knots, double from, double to) {
  std::vector<double> middles;
  for (Index s : knots.spans()) {
    if (knots[s + 1] <= from || knots[s] >= to) continue;
    const double middle = std::midpoint(knots[s], knots[s + 1]);
    if (knots[s] < middle && middle < knots[s + 1]) middles.push_back(middle);
  }
  return middles;
}

}  // namespace strak
