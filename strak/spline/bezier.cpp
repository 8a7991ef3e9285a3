#include "strak/spline/bezier.h"

#include <algorithm>

#include "strak/spline/knot_insertion.h"
#include "strak/spline/reparametrize.h"

namespace strak {

KnotVector bezierKnots(const KnotVector& knots) {
  const int p = knots.degree();
  const auto ends = static_cast<std::size_t>(p) + 1;
  std::vector<double> result(ends, knots.from());
  for (const auto& knot : knots.innerKnots()) {
    result.insert(result.end(), static_cast<std::size_t>(std::max(p, knot.multiplicity)), knot.value);
  }
  result.insert(result.end(), ends, knots.to());
  return {p, std::move(result)};
}

template <int D>
Spline<D> bezierForm(const Spline<D>& spline) {
  std::array<KnotVector, D> knots;
  for (std::size_t k = 0; k < D; ++k) knots[k] = bezierKnots(spline.knots()[k]);
  return refine(clamped(spline), knots);
}

template <int D>
std::vector<BezierPiece<D>> bezierPieces(const Spline<D>& spline) {
  const Spline<D> form = bezierForm(spline);
  std::array<std::vector<Index>, D> spans;
  std::size_t count = 1;
  Index points = 1;
  for (std::size_t k = 0; k < D; ++k) {
    spans[k] = form.knots()[k].spans();
    count *= spans[k].size();
    points *= form.knots()[k].degree() + 1;
  }
  std::vector<BezierPiece<D>> result(count);
  std::array<std::size_t, D> at{};
  for (auto& piece : result) {
    for (std::size_t k = 0; k < D; ++k) {
      piece.from[k] = form.knots()[k][spans[k][at[k]]];
      piece.to[k] = form.knots()[k][spans[k][at[k]] + 1];
    }
    piece.points.resize(points, form.net().cols());
    for (Index r = 0; r < points; ++r) {
      typename Spline<D>::Sizes index;
      Index rest = r;
      for (std::size_t k = D; k-- > 0;) {
        const Index side = form.knots()[k].degree() + 1;
        index[k] = spans[k][at[k]] - side + 1 + rest % side;
        rest /= side;
      }
      piece.points.row(r) = form.net().row(form.row(index));
    }
    for (std::size_t k = D; k-- > 0;) {
      if (++at[k] < spans[k].size()) break;
      at[k] = 0;
    }
  }
  return result;
}

template Spline<1> bezierForm<1>(const Spline<1>&);
template Spline<2> bezierForm<2>(const Spline<2>&);
template Spline<3> bezierForm<3>(const Spline<3>&);
template std::vector<BezierPiece<1>> bezierPieces<1>(const Spline<1>&);
template std::vector<BezierPiece<2>> bezierPieces<2>(const Spline<2>&);
template std::vector<BezierPiece<3>> bezierPieces<3>(const Spline<3>&);

}  // namespace strak
