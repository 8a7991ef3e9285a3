#include "strak/fairing/held_points.h"

#include <fmt/format.h>

#include <algorithm>

#include "strak/base/error.h"

namespace strak {

template <int D>
HeldPoints holdStrips(const Spline<D>& spline, const std::array<Index, 2 * D>& rows) {
  for (Index count : rows) {
    if (count < 0) throw InvalidInput(fmt::format("cannot hold {} rows: give 0 or more", count));
  }
  HeldPoints held(static_cast<std::size_t>(spline.net().rows()), 0);
  for (std::size_t r = 0; r < held.size(); ++r) {
    auto rest = static_cast<Index>(r);
    for (int k = D - 1; k >= 0; --k) {
      const Index i = rest % spline.size(k);
      rest /= spline.size(k);
      const std::size_t side = 2 * static_cast<std::size_t>(k);
      if (i < rows[side] || spline.size(k) - 1 - i < rows[side + 1]) held[r] = 1;
    }
  }
  return held;
}

HeldPoints holdBoth(const HeldPoints& a, const HeldPoints& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  if (a.size() != b.size()) throw InvalidInput("the two lists of held points belong to different nets");
  HeldPoints both(a.size());
  std::transform(a.begin(), a.end(), b.begin(), both.begin(), [](auto x, auto y) { return x || y ? 1 : 0; });
  return both;
}

template HeldPoints holdStrips<1>(const Spline<1>&, const std::array<Index, 2>&);
template HeldPoints holdStrips<2>(const Spline<2>&, const std::array<Index, 4>&);
template HeldPoints holdStrips<3>(const Spline<3>&, const std::array<Index, 6>&);

}  // namespace strak
