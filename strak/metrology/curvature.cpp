#include "strak/metrology/curvature.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "strak/base/error.h"
#include "strak/metrology/piece.h"
#include "strak/spline/evaluate.h"

namespace strak {

namespace {

// Below these the tangents carry no direction, only rounding: relative length of one to the other, sine of their angle.
constexpr double kLeastTangentRatio = 1e-14;
constexpr double kLeastSine = 1e-12;

void checkRows(const Eigen::Ref<const Net>& d, Index rows) {
  if (d.rows() < rows || d.cols() != 3) {
    throw InvalidInput("curvature needs derivatives of a surface in space: give a row a derivative and three columns");
  }
}

// The tangents, and how much of a plane they span.
struct TangentPlane {
  Eigen::Vector3d tangents[2];
  Eigen::Vector3d cross;
  double u, area;  // |X_u|, |X_u x X_v|
  bool regular;

  TangentPlane(const Eigen::Vector3d& tangentU, const Eigen::Vector3d& tangentV)
      : tangents{tangentU, tangentV}, cross(tangentU.cross(tangentV)), u(tangentU.norm()), area(cross.norm()) {
    const double v = tangentV.norm();
    regular = area > kLeastSine * u * v && std::min(u, v) > kLeastTangentRatio * std::max(u, v) && std::isfinite(area);
  }
};

// The first and second fundamental forms, and an orthonormal tangent frame e_a = sum_i frame(a, i) X_i. Only `regular`
// says something where it is false.
struct LocalGeometry : TangentPlane {
  Eigen::Vector3d second[3];  // X_uu, X_uv, X_vv
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Eigen::Matrix2d frame = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d h = Eigen::Matrix2d::Zero();  // h(i, j) = X_ij . n

  explicit LocalGeometry(const Eigen::Ref<const Net>& d) : TangentPlane(vectorOf(d, 1), vectorOf(d, 2)) {
    if (!regular) return;
    for (int i = 0; i < 3; ++i) second[i] = vectorOf(d, 3 + i);
    normal = cross / area;
    frame << 1 / u, 0, -tangents[0].dot(tangents[1]) / (u * area), u / area;
    h << second[0].dot(normal), second[1].dot(normal), second[1].dot(normal), second[2].dot(normal);
  }

  static Eigen::Vector3d vectorOf(const Eigen::Ref<const Net>& d, Index row) {
    return Eigen::Map<const Eigen::Vector3d>(d.data() + row * d.outerStride());
  }
};

// The principal curvatures k1 >= k2, and the principal directions as rows of coefficients of X_u and X_v.
struct Principal {
  double k[2];
  Eigen::Matrix2d frame;
};

Principal principalFrame(const LocalGeometry& g) {
  const Eigen::Matrix2d s = g.frame * g.h * g.frame.transpose();
  const double mean = (s(0, 0) + s(1, 1)) / 2, difference = (s(0, 0) - s(1, 1)) / 2;
  const double scale = std::max(std::abs(difference), std::abs(s(0, 1)));
  if (!(scale > 0)) return {{mean, mean}, g.frame};
  // Half the angle of (x, y), between -90 and 90 degrees; of cosine and sine the larger one first, without loss.
  const double x = difference / scale, y = s(0, 1) / scale;
  const double length = std::sqrt(x * x + y * y), radius = scale * length;
  const double larger = std::sqrt((1 + std::abs(x) / length) / 2), smaller = std::abs(y) / (2 * length * larger);
  const double cosine = x < 0 ? smaller : larger, sine = std::copysign(x < 0 ? larger : smaller, y);
  Eigen::Matrix2d rotation;
  rotation << cosine, sine, -sine, cosine;
  return {{mean + radius, mean - radius}, rotation * g.frame};
}

}  // namespace

std::optional<Eigen::Vector3d> unitNormal(const Eigen::Vector3d& tangentU, const Eigen::Vector3d& tangentV) {
  const TangentPlane plane(tangentU, tangentV);
  if (!plane.regular) return std::nullopt;
  return plane.cross / plane.area;
}

SurfaceCurvature surfaceCurvature(const Eigen::Ref<const Net>& d) {
  checkRows(d, 6);
  SurfaceCurvature result;
  result.point = d.row(0).transpose();
  const LocalGeometry g(d);
  result.regular = g.regular;
  result.normal = g.normal;
  result.direction[0].setZero();
  result.direction[1].setZero();
  if (!g.regular) return result;
  const Principal principal = principalFrame(g);
  for (int a = 0; a < 2; ++a) {
    result.principal[a] = principal.k[a];
    result.direction[a] = principal.frame(a, 0) * g.tangents[0] + principal.frame(a, 1) * g.tangents[1];
  }
  result.gaussian = principal.k[0] * principal.k[1];
  result.mean = (principal.k[0] + principal.k[1]) / 2;
  return result;
}

SurfaceCurvature surfaceCurvature(const Surface& surface, double u, double v) {
  return surfaceCurvature(derivatives<2>(surface, {u, v}, 2));
}

CurvatureRates curvatureRates(const Eigen::Ref<const Net>& d) {
  checkRows(d, 10);
  const LocalGeometry g(d);
  CurvatureRates result;
  result.regular = g.regular;
  if (!g.regular) return result;
  const Principal principal = principalFrame(g);
  result.area = g.area;
  for (int a = 0; a < 2; ++a) result.principal[a] = principal.k[a];

  const Eigen::Matrix2d inverse = principal.frame.transpose() * principal.frame;  // of the metric: sum of e_a e_a
  // first(i + j, l) = X_ij . X_l, christoffel(i + j, l) = Gamma^l_ij; X_ij depends on i + j only.
  Eigen::Matrix<double, 3, 2> first;
  for (int s = 0; s < 3; ++s) {
    for (int l = 0; l < 2; ++l) first(s, l) = g.second[s].dot(g.tangents[l]);
  }
  const Eigen::Matrix<double, 3, 2> christoffel = first * inverse;
  const Eigen::Matrix2d shape = g.h * inverse;  // h_k^l

  // C_ijk with s = i + j + k: the symmetric choice i <= j <= k.
  Eigen::Vector4d c;
  for (int s = 0; s < 4; ++s) {
    const int i = s > 2 ? 1 : 0, j = s > 1 ? 1 : 0, k = s > 0 ? 1 : 0;
    c[s] = LocalGeometry::vectorOf(d, 6 + s).dot(g.normal) - shape.row(k).dot(first.row(i + j)) -
           christoffel.row(k + i).dot(g.h.col(j).transpose()) - christoffel.row(k + j).dot(g.h.col(i).transpose());
  }
  // C(x, y, .) of two tangent vectors given by their coefficients.
  const auto apply = [&](const auto& x, const auto& y) {
    const double c11 = c[0] * x[0] + c[1] * x[1], c12 = c[1] * x[0] + c[2] * x[1], c22 = c[2] * x[0] + c[3] * x[1];
    return Eigen::RowVector2d(c11 * y[0] + c12 * y[1], c12 * y[0] + c22 * y[1]);
  };
  const Eigen::RowVector2d e1 = principal.frame.row(0), e2 = principal.frame.row(1);
  const Eigen::RowVector2d along1 = apply(e1, e1), along2 = apply(e2, e2);
  result.derivative << along1.dot(e1), along1.dot(e2), along2.dot(e1), along2.dot(e2);
  return result;
}

double normalCurvature(const Surface& surface, double u, double v, double a, double b) {
  const LocalGeometry g(derivatives<2>(surface, {u, v}, 2));
  const double length = (a * g.tangents[0] + b * g.tangents[1]).squaredNorm();
  if (!g.regular || !(length > 0)) return 0;
  return (a * a * g.h(0, 0) + 2 * a * b * g.h(0, 1) + b * b * g.h(1, 1)) / length;
}

CurveCurvature curveCurvature(const Curve& curve, double u) {
  CurveJet jet;
  CurvePiece(curve, curve.knots(0).findSpan(u)).at(u, 3, jet);
  CurveCurvature result;
  const double speed = jet[1].norm();
  result.regular = speed > 0 && std::isfinite(speed);
  if (!result.regular) return result;
  const Eigen::Vector3d binormal = jet[1].cross(jet[2]);
  result.curvature = binormal.norm() / (speed * speed * speed);
  if (curve.pointDimension() == 2) {
    result.curvature = std::copysign(result.curvature, binormal[2]);
  } else if (binormal.squaredNorm() > 0) {
    result.torsion = binormal.dot(jet[3]) / binormal.squaredNorm();
  }
  return result;
}

}  // namespace strak
