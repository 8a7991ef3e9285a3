#include "strak/spline/periodic.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "strak/base/error.h"
#include "strak/spline/knot_insertion.h"
#include "strak/spline/reparametrize.h"

namespace strak {
namespace {

// The knots of one period, the seam `multiplicity`-fold, continued by `degree` or so on both sides.
KnotVector periodicKnots(const KnotVector& clamped, int multiplicity, const char* name) {
  const auto p = static_cast<std::size_t>(clamped.degree());
  const auto m = static_cast<std::size_t>(multiplicity);
  const double from = clamped.from(), to = clamped.to(), period = clamped.length();
  const auto& knots = clamped.knots();
  const std::vector<double> inner(knots.begin() + static_cast<std::ptrdiff_t>(p) + 1,
                                  knots.end() - static_cast<std::ptrdiff_t>(p) - 1);
  std::vector<double> low, high;  // outwards from the domain
  for (double shift = period; low.size() < p + 1 - m; shift += period) {
    for (std::size_t i = inner.size(); i-- > 0;) low.push_back(inner[i] - shift);
    low.insert(low.end(), m, from - shift);
  }
  for (double shift = period; high.size() < p + 1 - m; shift += period) {
    for (double knot : inner) high.push_back(knot + shift);
    high.insert(high.end(), m, to + shift);
  }
  std::vector<double> all(low.rend() - static_cast<std::ptrdiff_t>(p + 1 - m), low.rend());
  all.insert(all.end(), m, from);
  all.insert(all.end(), inner.begin(), inner.end());
  all.insert(all.end(), m, to);
  all.insert(all.end(), high.begin(), high.begin() + static_cast<std::ptrdiff_t>(p + 1 - m));
  return {clamped.degree(), std::move(all), name};
}

// The net seen as `outer` slabs of `count` rows of `inner` control points, count being those along one direction.
template <int D>
struct Slabs {
  Index outer = 1, count = 1, inner = 1;

  Slabs(const Spline<D>& spline, int direction) : count(spline.size(direction)) {
    for (int k = 0; k < direction; ++k) outer *= spline.size(k);
    for (int k = direction + 1; k < D; ++k) inner *= spline.size(k);
  }
  Index row(Index o, Index i) const { return (o * count + i) * inner; }
};

template <int D>
Net rowsAt(const Net& net, const Slabs<D>& slabs, Index i) {
  Net rows(slabs.outer * slabs.inner, net.cols());
  for (Index o = 0; o < slabs.outer; ++o) {
    rows.middleRows(o * slabs.inner, slabs.inner) = net.middleRows(slabs.row(o, i), slabs.inner);
  }
  return rows;
}

template <int D>
void setRowsAt(Net& net, const Slabs<D>& slabs, Index i, const Net& rows) {
  for (Index o = 0; o < slabs.outer; ++o) {
    net.middleRows(slabs.row(o, i), slabs.inner) = rows.middleRows(o * slabs.inner, slabs.inner);
  }
}

// The control points number i on the knots `wanted` of the polynomial that `spline` is on its span from `start`.
template <int D>
Net continued(const Spline<D>& spline, const Slabs<D>& slabs, int direction, double start, const KnotVector& wanted,
              Index i) {
  const int p = spline.degree(direction);
  std::vector<double> weights(static_cast<std::size_t>(p) + 1);
  const Index span = refinementRow(spline.knots(direction), start, wanted.knots().data() + i + 1, weights.data());
  Net rows = Net::Zero(slabs.outer * slabs.inner, spline.net().cols());
  for (int k = 0; k <= p; ++k) {
    rows += weights[static_cast<std::size_t>(k)] * rowsAt(spline.net(), slabs, span - p + k);
  }
  return rows;
}

// Whether the points of two rows are the same in space and have the same weights.
bool agree(const Net& a, const Net& b, bool rational, double size, double tolerance) {
  if (!rational) return (a - b).cwiseAbs().maxCoeff() <= tolerance * size;
  const Index d = a.cols() - 1;
  if (!(a.col(d).minCoeff() > 0 && b.col(d).minCoeff() > 0)) return false;
  if (!((a.col(d) - b.col(d)).cwiseAbs().cwiseQuotient(a.col(d)).maxCoeff() <= tolerance)) return false;
  const Net x = a.leftCols(d).array().colwise() / a.col(d).array();
  const Net y = b.leftCols(d).array().colwise() / b.col(d).array();
  return (x - y).cwiseAbs().maxCoeff() <= tolerance * size;
}

}  // namespace

template <int D>
std::optional<Spline<D>> toPeriodic(const Spline<D>& spline, int direction, int smoothness, double relativeTolerance) {
  const KnotVector& knots = spline.knots(direction);
  const int p = knots.degree();
  if (smoothness < 0 || smoothness >= std::max(p, 1)) {
    throw InvalidInput(fmt::format("a seam of degree {} cannot be asked to be smooth of order {}: give 0 to {}", p,
                                   smoothness, p - 1));
  }
  const Index n = knots.size();
  if (p == 0 || !knots.isClamped() || n < 2 * (smoothness + 1)) return std::nullopt;
  const Net points = spline.euclideanNet();
  const double size = (points.colwise().maxCoeff() - points.colwise().minCoeff()).stableNorm();
  const Slabs<D> slabs(spline, direction);
  if (!agree(rowsAt(spline.net(), slabs, 0), rowsAt(spline.net(), slabs, n - 1), spline.isRational(), size,
             relativeTolerance)) {
    return std::nullopt;
  }

  std::array<KnotVector, D> wanted = spline.knots();
  KnotVector& periodic = wanted[static_cast<std::size_t>(direction)];
  periodic = periodicKnots(knots, p - smoothness, directionName(direction));
  const double lastSpan = knots[knots.spans().back()];
  Net net = spline.net();
  for (Index i = 0; i <= smoothness; ++i) {
    // Continued from the first span and from the last one; where nothing has to be continued the points are there.
    const Index twin = n - 1 - smoothness + i;
    const Net low = i == smoothness ? rowsAt(spline.net(), slabs, i)
                                    : continued(spline, slabs, direction, knots.from(), periodic, i);
    const Net high =
        i == 0 ? rowsAt(spline.net(), slabs, twin) : continued(spline, slabs, direction, lastSpan, periodic, twin);
    if (!agree(low, high, spline.isRational(), size, relativeTolerance)) return std::nullopt;
    const Net both = i == smoothness ? low : i == 0 ? high : Net(0.5 * (low + high));
    setRowsAt(net, slabs, i, both);
    setRowsAt(net, slabs, twin, both);
  }
  return Spline<D>(std::move(wanted), std::move(net), spline.isRational());
}

template <int D>
int seamSmoothness(const Spline<D>& spline, int direction, double relativeTolerance) {
  int smooth = -1;
  for (int s = 0; s < spline.degree(direction); ++s) {
    if (!toPeriodic(spline, direction, s, relativeTolerance)) break;
    smooth = s;
  }
  return smooth;
}

template <int D>
Spline<D> toClamped(const Spline<D>& spline, int direction) {
  const KnotVector& knots = spline.knots(direction);
  if (knots.isClamped()) return spline;
  const Slabs<D> before(spline, direction);
  // A seam of multiplicity m: the rows from p - m on repeat the first ones.
  const Index overlap = knots.degree() + 1 - std::min(knots.degree(), knots.multiplicity(knots.from()));
  bool closed = knots.size() >= 2 * overlap;
  for (Index i = 0; i < overlap && closed; ++i) {
    closed = rowsAt(spline.net(), before, i) == rowsAt(spline.net(), before, knots.size() - overlap + i);
  }
  Spline<D> result = subPatch(spline, direction, knots.from(), knots.to());
  if (closed) {
    const Slabs<D> slabs(result, direction);
    Net net = result.net();
    setRowsAt(net, slabs, slabs.count - 1, rowsAt(net, slabs, 0));
    result = Spline<D>(result.knots(), std::move(net), result.isRational());
  }
  return result;
}

#define STRAK_INSTANTIATE(D)                                                           \
  template int seamSmoothness<D>(const Spline<D>&, int, double);                       \
  template std::optional<Spline<D>> toPeriodic<D>(const Spline<D>&, int, int, double); \
  template Spline<D> toClamped<D>(const Spline<D>&, int);
STRAK_INSTANTIATE(1)
STRAK_INSTANTIATE(2)
STRAK_INSTANTIATE(3)
#undef STRAK_INSTANTIATE

}  // namespace strak
