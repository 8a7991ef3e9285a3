#include "strak/spline/reparametrize.h"

#include <fmt/format.h>

#include <algorithm>

#include "strak/base/error.h"
#include "strak/spline/knot_insertion.h"
#include "strak/spline/net_product.h"

namespace strak {

namespace {

// The net with its points visited in the order that `index` tells: row r of the result is row index(position of r).
template <int D, class IndexOf>
Net reordered(const Net& net, const typename Spline<D>::Sizes& sizes, const IndexOf& index) {
  Net result(net.rows(), net.cols());
  typename Spline<D>::Sizes at{};
  for (Index r = 0; r < net.rows(); ++r) {
    result.row(r) = net.row(index(at));
    for (std::size_t k = D; k-- > 0;) {
      if (++at[k] < sizes[k]) break;
      at[k] = 0;
    }
  }
  return result;
}

}  // namespace

template <int D>
Spline<D> withDomain(const Spline<D>& spline, int direction, double from, double to) {
  auto knots = spline.knots();
  auto& changed = knots[static_cast<std::size_t>(direction)];
  changed = changed.rescaled(from, to);
  return {std::move(knots), spline.net(), spline.isRational()};
}

template <int D>
Spline<D> reversed(const Spline<D>& spline, int direction) {
  const KnotVector& old = spline.knots(direction);
  std::vector<double> mirrored;
  for (auto u = old.knots().rbegin(); u != old.knots().rend(); ++u) {
    // The ends of the domain must be met exactly, and rounding must not push an inner knot beyond them.
    double value = (old.from() - *u) + old.to();
    value = *u <= old.from() ? std::max(value, old.to()) : std::min(value, old.to());
    value = *u >= old.to() ? std::min(value, old.from()) : std::max(value, old.from());
    if (*u == old.from()) value = old.to();
    if (*u == old.to()) value = old.from();
    mirrored.push_back(value);
  }
  auto knots = spline.knots();
  knots[static_cast<std::size_t>(direction)] = KnotVector(old.degree(), std::move(mirrored), directionName(direction));
  const auto from = [&](typename Spline<D>::Sizes at) {
    auto& i = at[static_cast<std::size_t>(direction)];
    i = spline.size(direction) - 1 - i;
    return spline.row(at);
  };
  return {std::move(knots), reordered<D>(spline.net(), spline.sizes(), from), spline.isRational()};
}

template <int D>
Spline<D> permuted(const Spline<D>& spline, const typename Spline<D>::Directions& order) {
  std::array<KnotVector, D> knots;
  typename Spline<D>::Sizes sizes;
  for (std::size_t k = 0; k < D; ++k) {
    if (order[k] < 0 || order[k] >= D || std::count(order.begin(), order.end(), order[k]) != 1) {
      throw InvalidInput(
          fmt::format("the new order of the directions does not name each of 0 to {} once: correct it", D - 1));
    }
    knots[k] = spline.knots(order[k]);
    sizes[k] = spline.size(order[k]);
  }
  const auto from = [&](const typename Spline<D>::Sizes& at) {
    typename Spline<D>::Sizes old;
    for (std::size_t k = 0; k < D; ++k) old[static_cast<std::size_t>(order[k])] = at[k];
    return spline.row(old);
  };
  return {std::move(knots), reordered<D>(spline.net(), sizes, from), spline.isRational()};
}

Surface transposed(const Surface& surface) { return permuted<2>(surface, {1, 0}); }

template <int D>
Spline<D> subPatch(const Spline<D>& spline, int direction, double from, double to) {
  const KnotVector& old = spline.knots(direction);
  if (!(from < to) || from < old.from() || to > old.to()) {
    throw InvalidInput(fmt::format("[{}, {}] is not a part of the domain [{}, {}] of direction {}: choose one inside",
                                   from, to, old.from(), old.to(), directionName(direction)));
  }
  std::vector<double> missing;
  for (const double end : {from, to}) {
    missing.insert(missing.end(), static_cast<std::size_t>(old.degree() + 1 - old.multiplicity(end)), end);
  }
  const Spline<D> refined = insertKnots(spline, direction, missing);
  auto knots = refined.knots();
  const auto [active, first] = activeKnots(refined.knots(direction), from, to);
  Net net = sliceAlong<D>(refined.net(), refined.sizes(), direction, first, active.size());
  knots[static_cast<std::size_t>(direction)] = active;
  return {std::move(knots), std::move(net), spline.isRational()};
}

template <int D>
Spline<D> subPatch(const Spline<D>& spline, const typename Spline<D>::Parameter& from,
                   const typename Spline<D>::Parameter& to) {
  Spline<D> result = spline;
  for (int k = 0; k < D; ++k) {
    result = subPatch(result, k, from[static_cast<std::size_t>(k)], to[static_cast<std::size_t>(k)]);
  }
  return result;
}

template <int D>
Spline<D> clamped(const Spline<D>& spline) {
  Spline<D> result = spline;
  for (int k = 0; k < D; ++k) result = subPatch(result, k, spline.knots(k).from(), spline.knots(k).to());
  return result;
}

#define STRAK_INSTANTIATE(D)                                                                                    \
  template Spline<D> withDomain<D>(const Spline<D>&, int, double, double);                                      \
  template Spline<D> reversed<D>(const Spline<D>&, int);                                                        \
  template Spline<D> permuted<D>(const Spline<D>&, const std::array<int, D>&);                                  \
  template Spline<D> subPatch<D>(const Spline<D>&, int, double, double);                                        \
  template Spline<D> subPatch<D>(const Spline<D>&, const std::array<double, D>&, const std::array<double, D>&); \
  template Spline<D> clamped<D>(const Spline<D>&);
STRAK_INSTANTIATE(1)
STRAK_INSTANTIATE(2)
STRAK_INSTANTIATE(3)
#undef STRAK_INSTANTIATE

}  // namespace strak
