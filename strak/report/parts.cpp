#include "strak/report/parts.h"

#include <Eigen/SparseCore>

#include "strak/spline/basis.h"
#include "strak/spline/net_product.h"

namespace strak {

namespace {

// The same spline with exactly three coordinates.
template <int D>
Spline<D> inSpace(const Spline<D>& spline) {
  const Index dimension = spline.pointDimension(), rows = spline.net().rows();
  if (dimension == 3) return spline;
  Net net = Net::Zero(rows, spline.isRational() ? 4 : 3);
  const Eigen::VectorXd weights =
      spline.isRational() ? Eigen::VectorXd(spline.net().col(dimension)) : Eigen::VectorXd::Ones(rows);
  if (spline.isRational()) net.col(3) = weights;
  const Index shown = std::min<Index>(dimension, 3);
  // A function of D variables: its graph over the parameters, whose control points are the Greville abscissae.
  const bool graph = dimension == 1 && D < 3;
  net.middleCols(graph ? D : 0, shown) = spline.net().leftCols(shown);
  if (graph) {
    const auto sizes = spline.sizes();
    for (int k = 0; k < D; ++k) {
      const std::vector<double> greville = spline.knots(k).greville();
      Index stride = 1;
      for (int l = k + 1; l < D; ++l) stride *= sizes[static_cast<std::size_t>(l)];
      for (Index r = 0; r < rows; ++r)
        net(r, k) = weights[r] * greville[static_cast<std::size_t>(r / stride % spline.size(k))];
    }
  }
  return Spline<D>(spline.knots(), std::move(net), spline.isRational());
}

// The boundary face of a volume at the low or high end of a direction.
Surface face(const Volume& volume, int direction, bool high) {
  const KnotVector& knots = volume.knots(direction);
  const double at = high ? knots.to() : knots.from();
  const Index span = knots.findSpan(at);
  const auto basis = basisDerivatives(knots, span, at, 0);
  Eigen::SparseMatrix<double> row(1, knots.size());
  for (Index j = 0; j <= knots.degree(); ++j) row.insert(0, span - knots.degree() + j) = basis(0, j);
  Net net = multiplyAlong<3>(row, volume.net(), volume.sizes(), direction);
  const int u = direction == 0 ? 1 : 0, v = direction == 2 ? 1 : 2;
  return Surface({volume.knots(u), volume.knots(v)}, std::move(net), volume.isRational());
}

void add(const Curve& curve, Drawable& out) {
  out.plane = curve.pointDimension() <= 2;
  out.curves.push_back(inSpace(curve));
}

void add(const Surface& surface, Drawable& out) {
  out.plane = surface.pointDimension() == 2;
  out.surfaces.push_back(inSpace(surface));
}

void add(const Volume& volume, Drawable& out) {
  const Volume shown = inSpace(volume);
  for (int k = 0; k < 3; ++k)
    for (bool high : {false, true}) out.surfaces.push_back(face(shown, k, high));
}

}  // namespace

Drawable drawable(const AnySpline& spline) {
  Drawable out;
  std::visit([&](const auto& s) { add(s, out); }, spline);
  return out;
}

}  // namespace strak
