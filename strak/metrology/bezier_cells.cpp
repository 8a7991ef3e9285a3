#include "strak/metrology/bezier_cells.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "strak/spline/bezier.h"

namespace strak {

namespace {

constexpr double kSamePoint = 1e-9;  // of the size: sides closer than this are one
constexpr double kRounding = 1e-14;  // of the largest coordinate, a control point's

using Vector = PointBox::Vector;

HomogeneousPoints homogeneous(const Net& net, bool rational, const Vector& origin) {
  HomogeneousPoints points = HomogeneousPoints::Zero(net.rows(), 4);
  const Index dimension = net.cols() - (rational ? 1 : 0);
  points.leftCols(dimension) = net.leftCols(dimension);
  if (rational) {
    points.col(3) = net.rightCols(1);
  } else {
    points.col(3).setOnes();
  }
  points.leftCols<3>() -= points.col(3) * origin.matrix().transpose();
  return points;
}

// The rows of a net with index i in direction k.
template <int D>
std::vector<Index> rowsAt(const Spline<D>& spline, std::size_t k, Index i) {
  std::vector<Index> rows;
  Index inner = 1;
  for (std::size_t l = k + 1; l < D; ++l) inner *= spline.sizes()[l];
  const Index n = spline.sizes()[k];
  for (Index first = i * inner; first < spline.net().rows(); first += n * inner) {
    for (Index r = first; r < first + inner; ++r) rows.push_back(r);
  }
  return rows;
}

}  // namespace

template <int D>
BezierCells<D>::BezierCells(const Spline<D>& spline) : form_(bezierForm(spline)) {
  const Net net = spline.euclideanNet();
  const Point low = net.colwise().minCoeff(), high = net.colwise().maxCoeff();
  size_ = (high - low).stableNorm();
  rounding_ = kRounding * net.cwiseAbs().maxCoeff();
  Vector origin = Vector::Zero();
  for (Index c = 0; c < low.size(); ++c) origin[c] = (low[c] + high[c]) / 2;
  for (std::size_t k = 0; k < D; ++k) {
    const KnotVector& knots = form_.knots()[k];
    breaks_[k].push_back(knots.from());
    for (Index s : knots.spans()) breaks_[k].push_back(knots[s + 1]);
    torn_[k].assign(breaks_[k].size(), 0);
  }
  const auto pieces = bezierPieces(form_);
  points_.resize(pieces.size());
  boxes_.resize(pieces.size());
  tangents_.resize(pieces.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, pieces.size(), 256), [&](const auto& range) {
    for (std::size_t c = range.begin(); c < range.end(); ++c) {
      points_[c] = homogeneous(pieces[c].points, form_.isRational(), origin);
      boxes_[c] = boxOf(points_[c]);
      Parameters lengths;
      for (std::size_t k = 0; k < D; ++k) lengths[k] = pieces[c].to[k] - pieces[c].from[k];
      tangents_[c] = tangentsOf(points_[c], lengths);
    }
  });
  findSides();
}

template <int D>
std::size_t BezierCells<D>::number(const Cell& cell) const {
  Index c = 0;
  for (std::size_t k = 0; k < D; ++k) c = c * count(k) + cell[k];
  return static_cast<std::size_t>(c);
}

template <int D>
void BezierCells<D>::findSides() {
  const Net net = form_.euclideanNet();
  const auto same = [&](Index a, Index b) { return (net.row(a) - net.row(b)).norm() <= kSamePoint * size_; };
  for (std::size_t k = 0; k < D; ++k) {
    const auto low = rowsAt(form_, k, 0), high = rowsAt(form_, k, form_.sizes()[k] - 1);
    closed_[k] = true;
    pole_[k] = {D > 1, D > 1};
    for (std::size_t i = 0; i < low.size(); ++i) {
      closed_[k] = closed_[k] && same(low[i], high[i]);
      pole_[k][0] = pole_[k][0] && same(low[i], low[0]);
      pole_[k][1] = pole_[k][1] && same(high[i], high[0]);
    }
    const int p = form_.knots()[k].degree();
    const auto spans = form_.knots()[k].spans();
    for (std::size_t s = 1; s < spans.size(); ++s) {
      if (spans[s] - spans[s - 1] <= p) continue;  // neighbours share their border points
      const auto below = rowsAt(form_, k, spans[s - 1]), above = rowsAt(form_, k, spans[s] - p);
      for (std::size_t i = 0; i < below.size(); ++i) {
        if (!same(below[i], above[i])) torn_[k][s] = 1;
      }
    }
  }
}

template <int D>
PointBox BezierCells<D>::boxOf(const HomogeneousPoints& points) const {
  PointBox box;
  for (Index r = 0; r < points.rows(); ++r) box.add((points.row(r).head<3>() / points(r, 3)).transpose().array());
  box.grow(Vector::Constant(rounding_));
  return box;
}

// w S_u = A_u - S w_u, and S is near the middle c of the box: A_u - c w_u and the rest.
template <int D>
TangentBoxes<D> BezierCells<D>::tangentsOf(const HomogeneousPoints& points, const Parameters& lengths) const {
  TangentBoxes<D> result;
  const PointBox box = form_.isRational() ? boxOf(points) : PointBox();
  const Vector c = form_.isRational() ? box.middle() : Vector(Vector::Zero());
  const double w = points.col(3).maxCoeff();
  Index step = points.rows();
  for (std::size_t k = 0; k < D; ++k) {
    const Index p = form_.knots()[k].degree(), side = p + 1;
    step /= side;
    const double scale = static_cast<double>(p) / lengths[k];
    double weights = 0;
    for (Index r = 0; r < points.rows(); ++r) {
      if (r / step % side == p) continue;
      const Eigen::Array4d d = scale * (points.row(r + step) - points.row(r)).transpose().array();
      result[k].add(d.head<3>() - c * d[3]);
      weights = std::max(weights, std::abs(d[3]));
    }
    if (p == 0) result[k].add(Vector::Zero());
    result[k].grow(Vector::Constant(2 * scale * rounding_ * w));
    if (weights > 0) result[k].grow(weights * box.half());
  }
  return result;
}

template <int D>
HomogeneousPoints BezierCells<D>::part(HomogeneousPoints points, std::size_t k, double from, double to) const {
  Index step = 1;
  for (std::size_t l = k + 1; l < D; ++l) step *= form_.knots()[l].degree() + 1;
  const Index p = form_.knots()[k].degree(), side = p + 1;
  const auto cut = [&](double t, bool low) {
    for (Index line = 0; line < points.rows() / side; ++line) {
      const Index first = line / step * step * side + line % step;
      for (Index r = 1; r <= p; ++r) {
        for (Index j = 0; j <= p - r; ++j) {
          const Index i = low ? p - j : j;  // the row that is replaced
          const Index a = first + (low ? i - 1 : i) * step;
          points.row(first + i * step) = (1 - t) * points.row(a) + t * points.row(a + step);
        }
      }
    }
  };
  if (to < 1) cut(to, true);
  if (from > 0) cut(from / to, false);
  return points;
}

template class BezierCells<1>;
template class BezierCells<2>;

}  // namespace strak
