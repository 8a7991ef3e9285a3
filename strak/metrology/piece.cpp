#include "strak/metrology/piece.h"

#include "strak/base/error.h"
#include "strak/spline/basis.h"

namespace strak {

namespace {

using Homogeneous = Eigen::Matrix<double, 4, Eigen::Dynamic>;

constexpr int kBinomial[4][4] = {{1, 0, 0, 0}, {1, 1, 0, 0}, {1, 2, 1, 0}, {1, 3, 3, 1}};

// Place of X_(u^a v^b) in a jet.
constexpr int jetIndex(int a, int b) { return (a + b) * (a + b + 1) / 2 + b; }

Eigen::Vector4d homogeneousPoint(const Net& net, Index row, bool rational) {
  Eigen::Vector4d point(0, 0, 0, 1);
  const Index dimension = net.cols() - (rational ? 1 : 0);
  for (Index c = 0; c < dimension; ++c) point[c] = net(row, c);
  if (rational) point[3] = net(row, dimension);
  return point;
}

// Moves the first point to the origin and returns where it was.
Eigen::Vector3d moveToOrigin(Homogeneous& points) {
  Eigen::Vector3d origin = points.col(0).head<3>() / points(3, 0);
  points.topRows<3>() -= origin * points.row(3);
  return origin;
}

// The derivatives of A / w from those of (A, w): w X = A differentiated by Leibniz.
void divideByWeight(const Eigen::Vector4d* homogeneous, int order, SurfaceJet& jet) {
  for (int total = 0; total <= order; ++total) {
    for (int b = 0; b <= total; ++b) {
      const int a = total - b;
      Eigen::Vector3d x = homogeneous[jetIndex(a, b)].head<3>();
      for (int i = 0; i <= a; ++i) {
        for (int j = 0; j <= b; ++j) {
          if (i + j == 0) continue;
          x -= kBinomial[a][i] * kBinomial[b][j] * homogeneous[jetIndex(i, j)][3] *
               jet[static_cast<std::size_t>(jetIndex(a - i, b - j))];
        }
      }
      jet[static_cast<std::size_t>(jetIndex(a, b))] = x / homogeneous[0][3];
    }
  }
}

void divideByWeight(const Eigen::Vector4d* homogeneous, int order, CurveJet& jet) {
  for (int a = 0; a <= order; ++a) {
    Eigen::Vector3d x = homogeneous[a].head<3>();
    for (int i = 1; i <= a; ++i) x -= kBinomial[a][i] * homogeneous[i][3] * jet[static_cast<std::size_t>(a - i)];
    jet[static_cast<std::size_t>(a)] = x / homogeneous[0][3];
  }
}

}  // namespace

SurfacePiece::SurfacePiece(const Surface& surface, Index spanU, Index spanV)
    : surface_(&surface), spans_{spanU, spanV} {
  if (surface.pointDimension() != 3) {
    throw InvalidInput("the surface does not lie in space: give control points with three coordinates");
  }
  const int p = surface.degree(0), q = surface.degree(1);
  points_.resize(4, Index{p + 1} * (q + 1));
  for (int i = 0; i <= p; ++i) {
    for (int j = 0; j <= q; ++j) {
      points_.col(i * (q + 1) + j) =
          homogeneousPoint(surface.net(), surface.row({spanU - p + i, spanV - q + j}), surface.isRational());
    }
  }
  origin_ = moveToOrigin(points_);
}

void SurfacePiece::at(double u, double v, int order, SurfaceJet& jet) const { evaluate(&u, 1, &v, 1, order, &jet); }

void SurfacePiece::grid(const std::vector<double>& us, const std::vector<double>& vs, int order,
                        std::vector<SurfaceJet>& jets) const {
  jets.resize(us.size() * vs.size());
  evaluate(us.data(), static_cast<Index>(us.size()), vs.data(), static_cast<Index>(vs.size()), order, jets.data());
}

void SurfacePiece::evaluate(const double* us, Index countU, const double* vs, Index countV, int order,
                            SurfaceJet* jets) const {
  const Index p = surface_->degree(0), q = surface_->degree(1), orders = order + 1;
  std::vector<double> basis(static_cast<std::size_t>(orders * (std::max(p, q) + 1)));
  // First along v: column (j * orders + b) * (p + 1) + i holds the b-th derivative at vs[j] of the i-th row of points.
  Homogeneous rows(4, countV * orders * (p + 1));
  for (Index j = 0; j < countV; ++j) {
    basisDerivatives(knots(1), spans_[1], vs[j], order, basis.data());
    for (Index b = 0; b < orders; ++b) {
      const Eigen::Map<const Eigen::VectorXd> n(basis.data() + b * (q + 1), q + 1);
      for (Index i = 0; i <= p; ++i) {
        Eigen::Vector4d sum = n[0] * points_.col(i * (q + 1));
        for (Index k = 1; k <= q; ++k) sum += n[k] * points_.col(i * (q + 1) + k);
        rows.col((j * orders + b) * (p + 1) + i) = sum;
      }
    }
  }
  Eigen::Vector4d homogeneous[10];
  for (Index i = 0; i < countU; ++i) {
    basisDerivatives(knots(0), spans_[0], us[i], order, basis.data());
    for (Index j = 0; j < countV; ++j) {
      for (Index b = 0; b < orders; ++b) {
        const Index row = (j * orders + b) * (p + 1);
        for (Index a = 0; a < orders - b; ++a) {
          const double* n = basis.data() + a * (p + 1);
          Eigen::Vector4d sum = n[0] * rows.col(row);
          for (Index k = 1; k <= p; ++k) sum += n[k] * rows.col(row + k);
          homogeneous[jetIndex(static_cast<int>(a), static_cast<int>(b))] = sum;
        }
      }
      SurfaceJet& jet = jets[i * countV + j];
      if (surface_->isRational()) {
        divideByWeight(homogeneous, order, jet);
      } else {
        for (std::size_t r = 0; r < static_cast<std::size_t>(orders * (orders + 1) / 2); ++r)
          jet[r] = homogeneous[r].head<3>();
      }
      jet[0] += origin_;
    }
  }
}

CurvePiece::CurvePiece(const Curve& curve, Index span) : curve_(&curve), span_(span) {
  if (curve.pointDimension() != 2 && curve.pointDimension() != 3) {
    throw InvalidInput("the curve lies neither in the plane nor in space: give control points with 2 or 3 coordinates");
  }
  const int p = curve.degree(0);
  points_.resize(4, p + 1);
  for (int i = 0; i <= p; ++i) points_.col(i) = homogeneousPoint(curve.net(), span - p + i, curve.isRational());
  origin_ = moveToOrigin(points_);
}

void CurvePiece::at(double u, int order, CurveJet& jet) const {
  const auto basis = basisDerivatives(curve_->knots(0), span_, u, order);
  Eigen::Vector4d homogeneous[4];
  for (int a = 0; a <= order; ++a) homogeneous[a] = points_ * basis.row(a).transpose();
  if (curve_->isRational()) {
    divideByWeight(homogeneous, order, jet);
  } else {
    for (int a = 0; a <= order; ++a) jet[static_cast<std::size_t>(a)] = homogeneous[a].head<3>();
  }
  jet[0] += origin_;
}

}  // namespace strak
