#include "strak/fairing/conversion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "strak/base/error.h"
#include "strak/energy/projection.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/net_product.h"
#include "strak/spline/reparametrize.h"

namespace strak {
namespace {

constexpr int kHighestDegree = 15;   // beyond, Gram matrices lose too many digits
constexpr double kEven = 1e-9;       // of a span: how far uniform knots may be from equal steps
constexpr double kFlat = 0.1;        // degrees: smaller creases are not worth a word
constexpr double kFirstShare = 0.7;  // of the tolerance for the lines of one direction: the directions add up
constexpr double kAlone = 0.95;      // the same for a side that is a single line
constexpr double kOnePoint = 1e-14;  // of the size: rounding
constexpr int kLines = 33;           // at most so many lines are looked at, in every other direction
constexpr int kLinesOfVolumes = 9;
constexpr int kMostRounds = 40;
constexpr double kLonger = 1.5;

// Equal spans between single knots; ends as they like, but not with other steps.
bool isUniform(const KnotVector& knots) {
  const auto spans = static_cast<double>(knots.spans().size());
  const double step = knots.length() / spans;
  double place = 1;
  for (const auto& inner : knots.innerKnots()) {
    if (inner.multiplicity != 1 || std::abs(inner.value - knots.from() - place * step) > kEven * step) return false;
    place += 1;
  }
  if (knots.isClamped()) return true;
  for (std::size_t i = 0; i + 1 < knots.knots().size(); ++i) {
    if (std::abs(knots.knots()[i + 1] - knots.knots()[i] - step) > kEven * step) return false;
  }
  return true;
}

bool isAsWished(const KnotVector& knots, const ConversionOptions& options) {
  return knots.degree() == options.degree && (options.spacing == KnotSpacing::adapted || isUniform(knots));
}

template <int D>
bool isAsWished(const Spline<D>& spline, const ConversionOptions& options) {
  bool wished = !spline.isRational();
  for (const KnotVector& knots : spline.knots()) wished = wished && isAsWished(knots, options);
  return wished;
}

// The least number of equal spans that has all knots of the input among theirs; nothing above `most`.
std::optional<Index> latticeOf(const KnotVector& knots, Index most) {
  for (Index n = 1; n <= most; ++n) {
    const double step = knots.length() / static_cast<double>(n);
    const auto inner = knots.innerKnots();
    const bool holds = std::all_of(inner.begin(), inner.end(), [&](const auto& knot) {
      const double at = (knot.value - knots.from()) / step;
      return std::abs(at - std::round(at)) <= kEven;
    });
    if (holds) return n;
  }
  return std::nullopt;
}

Index firstSpans(const KnotVector& knots, int degree) {
  return (static_cast<Index>(knots.spans().size()) * (knots.degree() + 1) + degree) / (degree + 1);
}

KnotVector uniformKnots(const KnotVector& domain, int degree, Index spans) {
  return KnotVector::uniformClamped(degree, spans, domain.from(), domain.to());
}

// The input's knots with its own continuity, or the highest there is.
KnotVector adaptedKnots(const KnotVector& knots, int degree) {
  std::vector<double> result(static_cast<std::size_t>(degree) + 1, knots.from());
  for (const auto& inner : knots.innerKnots()) {
    const int continuity = std::min(knots.degree() - inner.multiplicity, degree - 1);
    result.insert(result.end(), static_cast<std::size_t>(degree - std::max(continuity, 0)), inner.value);
  }
  result.insert(result.end(), static_cast<std::size_t>(degree) + 1, knots.to());
  return {degree, std::move(result)};
}

// With halves of the spans, ascending, whose error is above 1. So are those beside a halved one that are longer: what
// a long span does to the point at its end, no short neighbour can mend.
KnotVector halved(const KnotVector& knots, const std::vector<double>& errors) {
  const auto spans = knots.spans();
  const auto length = [&](std::size_t s) { return knots[spans[s] + 1] - knots[spans[s]]; };
  std::vector<std::size_t> open;
  std::vector<char> marked(spans.size(), 0);
  const auto mark = [&](std::size_t s) {
    if (marked[s] == 0) open.push_back(s);
    marked[s] = 1;
  };
  for (std::size_t s = 0; s < spans.size(); ++s) {
    if (errors[s] > 1) mark(s);
  }
  while (!open.empty()) {
    const std::size_t s = open.back();
    open.pop_back();
    if (s > 0 && length(s - 1) > kLonger * length(s)) mark(s - 1);
    if (s + 1 < spans.size() && length(s + 1) > kLonger * length(s)) mark(s + 1);
  }
  std::vector<double> result = knots.knots();
  for (std::size_t s = 0; s < spans.size(); ++s) {
    if (marked[s] != 0) result.push_back(std::midpoint(knots[spans[s]], knots[spans[s] + 1]));
  }
  std::sort(result.begin(), result.end());
  return {knots.degree(), std::move(result)};
}

// About `most` parameters, as dense as the spans, both ends among them.
std::vector<double> linePlaces(const KnotVector& knots, int most) {
  const auto spans = knots.spans();
  const auto steps = std::min<Index>(most - 1, 4 * static_cast<Index>(spans.size()));
  std::vector<double> places;
  for (Index i = 0; i < steps; ++i) {
    const double at = static_cast<double>(i) * static_cast<double>(spans.size()) / static_cast<double>(steps);
    const auto span = static_cast<std::size_t>(at);
    places.push_back(std::lerp(knots[spans[span]], knots[spans[span] + 1], at - static_cast<double>(span)));
  }
  places.push_back(knots.to());
  return places;
}

// How far lines of a spline may be from their approximation: those inside, and those on the sides.
template <int D>
struct Allowed {
  double inside = 0;
  std::array<double, 2 * static_cast<std::size_t>(D)> sides{};
};

// How far lines of the spline in one direction are from their approximation on `target`, by what they may be, a number
// a span of that.
template <int D>
std::vector<double> errorsAlong(const Spline<D>& spline, int direction, const KnotVector& target,
                                const Allowed<D>& allowed) {
  const auto along = static_cast<std::size_t>(direction);
  const KnotVector& had = spline.knots(direction);
  const Samples samples = samplesBetween(had, target, (had.degree() + target.degree()) / 2 + 3);
  typename Spline<D>::Grid grid;
  typename Spline<D>::Sizes sizes;
  for (std::size_t k = 0; k < D; ++k) {
    grid[k] = k == along ? samples.places : linePlaces(spline.knots()[k], D == 3 ? kLinesOfVolumes : kLines);
    sizes[k] = static_cast<Index>(grid[k].size());
  }
  const Projection projection(samples, target);
  const auto basis = basisMatrix(target, samples.places);
  const Net values = derivativesOnGrid(spline, grid, 0);
  const Net errors = values - mapLines<D>(values, sizes, direction, sizes[along],
                                          [&](const auto& lines) -> Net { return basis * projection.apply(lines); });
  const auto spans = target.spans();
  std::vector<double> largest(spans.size(), 0);
  for (Index r = 0; r < errors.rows(); ++r) {
    double limit = allowed.inside;
    Index rest = r, place = 0;
    for (std::size_t k = D; k-- > 0;) {
      const Index i = rest % sizes[k];
      rest /= sizes[k];
      if (k == along) {
        place = i;
      } else if (i == 0 || i == sizes[k] - 1) {
        limit = std::min(limit, allowed.sides[2 * k + (i == 0 ? 0 : 1)]);
      }
    }
    const Index span = target.findSpan(samples.places[static_cast<std::size_t>(place)]);
    const auto at = static_cast<std::size_t>(std::lower_bound(spans.begin(), spans.end(), span) - spans.begin());
    largest[at] = std::max(largest[at], errors.row(r).stableNorm() / limit);
  }
  return largest;
}

double largestOf(const std::vector<double>& values) { return *std::max_element(values.begin(), values.end()); }

// The angle in degrees between the legs of the net before and behind a knot of full multiplicity, and the gap at one
// where the spline jumps.
struct Break {
  double angle = 0, gap = 0;
};

template <int D>
Break breakAt(const Spline<D>& spline, int direction, const KnotVector::InnerKnot& knot) {
  const KnotVector& knots = spline.knots(direction);
  const Net points = spline.euclideanNet();
  const Index first = std::lower_bound(knots.knots().begin(), knots.knots().end(), knot.value) - knots.knots().begin();
  const bool jumps = knot.multiplicity > knots.degree();
  const auto line = [&](Index i) { return sliceAlong<D>(points, spline.sizes(), direction, i, 1); };
  const Net before = line(first - 1), behind = line(jumps ? first : first - 1);
  Break result;
  result.gap = (behind - before).rowwise().norm().maxCoeff();
  const Net in = before - line(first - 2), out = line(jumps ? first + 1 : first) - behind;
  for (Index r = 0; r < in.rows(); ++r) {
    const double a = in.row(r).stableNorm(), b = out.row(r).stableNorm();
    if (!(a > 0) || !(b > 0)) continue;
    const double chord = (in.row(r) / a - out.row(r) / b).norm();
    result.angle = std::max(result.angle, 2 * std::asin(std::min(1.0, chord / 2)) * 180 / std::numbers::pi);
  }
  return result;
}

template <int D>
std::vector<std::string> creasesOf(const Spline<D>& spline, bool told) {
  std::vector<std::string> result;
  for (int k = 0; k < D; ++k) {
    for (const auto& knot : spline.knots(k).innerKnots()) {
      if (knot.multiplicity < spline.degree(k)) continue;
      const Break there = breakAt<D>(spline, k, knot);
      if (there.gap > 0) {
        throw InvalidInput(fmt::format("it jumps by {:.4g} at {} = {:g}, which no such spline can follow: cut it there",
                                       there.gap, directionName(k), knot.value));
      }
      if (told && there.angle > kFlat) {
        result.push_back(fmt::format("{:.3g} degrees at {} = {:g}", there.angle, directionName(k), knot.value));
      }
    }
  }
  return result;
}

template <int D>
Spline<D - 1> sideOf(const Spline<D>& spline, int direction, bool high) {
  std::array<KnotVector, static_cast<std::size_t>(D - 1)> knots;
  for (int k = 0, next = 0; k < D; ++k) {
    if (k != direction) knots[static_cast<std::size_t>(next++)] = spline.knots(k);
  }
  return {knots, sliceAlong<D>(spline.net(), spline.sizes(), direction, high ? spline.size(direction) - 1 : 0, 1),
          spline.isRational()};
}

// A side that is one point stays exactly one: its normals would be those of rounding.
template <int D>
Spline<D> withPoles(const Spline<D>& made, const Spline<D>& source) {
  if constexpr (D == 1) return made;
  const Net had = source.euclideanNet();
  const double size = (had.colwise().maxCoeff() - had.colwise().minCoeff()).norm();
  Net net = made.net();
  Index behind = net.rows();
  for (int k = 0; k < D; ++k) {
    behind /= made.size(k);
    for (const bool high : {false, true}) {
      const Net side = sliceAlong<D>(had, source.sizes(), k, high ? source.size(k) - 1 : 0, 1);
      if ((side.rowwise() - side.row(0)).rowwise().norm().maxCoeff() > kOnePoint * size) continue;
      const Index last = high ? made.size(k) - 1 : 0;
      for (Index r = 0; r < net.rows(); ++r) {
        if (r / behind % made.size(k) == last) net.row(r) = side.row(0);
      }
    }
  }
  return {made.knots(), std::move(net)};
}

// The knots of a conversion on their way to the tolerance.
template <int D>
class Search {
 public:
  Search(const Spline<D>& source, const ConversionOptions& options) : source_(source), options_(options) {
    for (int k = 0; k < D; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const KnotVector& had = source.knots(k);
      kept_[at] = !source.isRational() && isAsWished(had, options);
      if (kept_[at]) {
        knots_[at] = had;
      } else if (options.spacing == KnotSpacing::adapted) {
        knots_[at] = adaptedKnots(had, options.degree);
      } else {
        const Index spans = std::max(firstSpans(had, options.degree), options.leastSpans[at]);
        lattice_[at] = latticeOf(had, 4 * spans).value_or(0);
        knots_[at] = uniformKnots(had, options.degree, spans);
      }
    }
  }

  const typename Spline<D>::Knots& knots() const { return knots_; }

  double points() const {
    double product = 1;
    for (const KnotVector& knots : knots_) product *= static_cast<double>(knots.size());
    return product;
  }

  // Until the lines of every direction are near enough, or the net is too large: false.
  bool grow(const Allowed<D>& allowed) {
    for (int k = 0; k < D; ++k) {
      if (kept_[static_cast<std::size_t>(k)]) continue;
      // Where the input's own knots are among those of few equal spans, it may be such a spline already.
      if (first_) tryLattice(k, allowed);
      while (true) {
        const std::vector<double> errors = errorsAlong<D>(source_, k, knots_[static_cast<std::size_t>(k)], allowed);
        if (!(largestOf(errors) > 1)) break;
        typename Spline<D>::Knots before = knots_;
        refine(k, errors);
        if (points() > static_cast<double>(options_.mostPoints)) {
          knots_ = std::move(before);
          return false;
        }
      }
    }
    first_ = false;
    return true;
  }

 private:
  void tryLattice(int k, const Allowed<D>& allowed) {
    const auto at = static_cast<std::size_t>(k);
    if (lattice_[at] == 0 || lattice_[at] < options_.leastSpans[at]) return;
    typename Spline<D>::Knots before = knots_;
    knots_[at] = uniformKnots(source_.knots(k), options_.degree, lattice_[at]);
    if (points() <= static_cast<double>(options_.mostPoints)) {
      if (largestOf(errorsAlong<D>(source_, k, knots_[at], allowed)) <= 1) return;
    }
    knots_ = std::move(before);
  }

  void refine(int k, const std::vector<double>& errors) {
    const auto at = static_cast<std::size_t>(k);
    if (options_.spacing == KnotSpacing::adapted) {
      knots_[at] = halved(knots_[at], errors);
      return;
    }
    // The error falls with the power degree + 1 of the spans' length, where nothing is in the way.
    const double factor = std::min(2.0, std::pow(largestOf(errors), 1.0 / (options_.degree + 1)));
    const auto had = static_cast<Index>(knots_[at].spans().size());
    Index spans = std::max(had + 1, static_cast<Index>(std::ceil(static_cast<double>(had) * factor)));
    if (const Index step = lattice_[at]; step > 1 && 4 * step <= spans) spans = (spans + step - 1) / step * step;
    knots_[at] = uniformKnots(source_.knots(k), options_.degree, spans);
  }

  const Spline<D>& source_;
  const ConversionOptions& options_;
  typename Spline<D>::Knots knots_;
  std::array<bool, static_cast<std::size_t>(D)> kept_{};
  std::array<Index, static_cast<std::size_t>(D)> lattice_{};
  bool first_ = true;
};

template <int D>
void certify(Converted<D>& result, const Spline<D>& source) {
  result.deviation = certifyDeviation<D>(result.spline, source);
  for (int k = 0; k < D; ++k) {
    for (const bool high : {false, true}) {
      const auto side = static_cast<std::size_t>(2 * k + (high ? 1 : 0));
      if constexpr (D == 1) {
        const double at = high ? source.knots(0).to() : source.knots(0).from();
        result.sides[side] = (evaluate<1>(result.spline, {at}) - evaluate<1>(source, {at})).norm();
      } else {
        result.sides[side] =
            certifyDeviation<D - 1>(sideOf<D>(result.spline, k, high), sideOf<D>(source, k, high)).upper;
      }
    }
  }
}

}  // namespace

template <int D>
Converted<D> convertSpline(const Spline<D>& spline, const ConversionOptions& options) {
  if (options.degree < 1 || options.degree > kHighestDegree) {
    throw InvalidInput(fmt::format("cannot convert to degree {}: give 1 to {}", options.degree, kHighestDegree));
  }
  const auto& sides = options.sideTolerances;
  if (!(options.tolerance > 0) || !std::all_of(sides.begin(), sides.end(), [](double side) { return side > 0; })) {
    throw InvalidInput("a conversion needs a tolerance above zero");
  }
  Converted<D> result;
  if (isAsWished<D>(spline, options)) {
    result.spline = spline;
    result.unchanged = true;
    return result;
  }
  const Spline<D> source = clamped(spline);
  result.creases = creasesOf<D>(source, options.spacing == KnotSpacing::uniform);
  Search<D> search(source, options);
  if (search.points() > static_cast<double>(options.mostPoints)) {
    // What neighbours ask for is a wish: without it there may be room.
    if (std::any_of(options.leastSpans.begin(), options.leastSpans.end(), [](Index least) { return least > 0; })) {
      result.spline = spline;
      result.reached = false;
      return result;
    }
    throw InvalidInput(fmt::format("it would have {:.0f} control points to begin with, above {}: allow more",
                                   search.points(), options.mostPoints));
  }
  Allowed<D> allowed;
  allowed.inside = kFirstShare * options.tolerance;
  bool any = std::isinf(options.tolerance);
  for (std::size_t s = 0; s < allowed.sides.size(); ++s) {
    allowed.sides[s] = (D == 2 ? kAlone : kFirstShare) * options.sideTolerances[s];
    any = any && std::isinf(allowed.sides[s]);
  }
  // The directions' errors and the places between the lines add up to more.
  const auto within = [](double deviation, double tolerance, double& target) {
    if (deviation <= tolerance) return true;
    target *= std::clamp(tolerance / deviation, 0.5, 0.9);
    return false;
  };
  for (bool fits = true; result.rounds < kMostRounds;) {
    if (!any) fits = search.grow(allowed);
    ++result.rounds;
    result.spline = withPoles<D>(polynomialOnto<D>(source, search.knots()), source);
    certify<D>(result, source);
    result.reached = within(result.deviation.upper, options.tolerance, allowed.inside);
    for (std::size_t s = 0; s < allowed.sides.size() && D > 1; ++s) {
      result.reached = within(result.sides[s], options.sideTolerances[s], allowed.sides[s]) && result.reached;
    }
    if (result.reached || !fits) break;
  }
  return result;
}

template Converted<1> convertSpline(const Spline<1>&, const ConversionOptions&);
template Converted<2> convertSpline(const Spline<2>&, const ConversionOptions&);
template Converted<3> convertSpline(const Spline<3>&, const ConversionOptions&);

}  // namespace strak
