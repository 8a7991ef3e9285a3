#include "strak/energy/shape_residuals.h"

#include <Eigen/Geometry>
#include <cmath>

namespace strak {

namespace {

// The residuals depend on the derivatives through 16 scalar products only: g (3), X_ij . X_l (6), X_ij . N (3) and
// X_ijk . N (4), N = X_u x X_v. They are differentiated by these automatically, and these by hand.
constexpr int kScalars = 16;

// A number with its derivatives by the scalars.
struct Dual {
  double v = 0;
  Eigen::Array<double, kScalars, 1> d = Eigen::Array<double, kScalars, 1>::Zero();

  Dual() = default;
  Dual(double value) : v(value) {}  // NOLINT(google-explicit-constructor): constants mix with duals
};

Dual operator+(const Dual& a, const Dual& b) {
  Dual r(a.v + b.v);
  r.d = a.d + b.d;
  return r;
}
Dual operator-(const Dual& a, const Dual& b) {
  Dual r(a.v - b.v);
  r.d = a.d - b.d;
  return r;
}
Dual operator*(const Dual& a, const Dual& b) {
  Dual r(a.v * b.v);
  r.d = a.d * b.v + b.d * a.v;
  return r;
}
Dual operator*(double a, const Dual& b) {
  Dual r(a * b.v);
  r.d = a * b.d;
  return r;
}
Dual operator/(const Dual& a, const Dual& b) {
  const double q = a.v / b.v;
  Dual r(q);
  r.d = (a.d - q * b.d) / b.v;
  return r;
}
Dual sqrt(const Dual& a) {
  Dual r(std::sqrt(a.v));
  r.d = a.d * (0.5 / r.v);
  return r;
}
double valueOf(double a) { return a; }
double valueOf(const Dual& a) { return a.v; }

// s: guu guv gvv | uu.u uu.v uv.u uv.v vv.u vv.v | uu.N uv.N vv.N | uuu.N uuv.N uvv.N vvv.N
template <class Scalar>
bool residualsOf(const std::array<Scalar, kScalars>& s, std::array<Scalar, kShapeResiduals>& r) {
  using std::sqrt;
  const Scalar &e = s[0], &f = s[1], &g = s[2];
  const Scalar det = e * g - f * f;
  // 1 - cos^2 of the angle between the parameter lines, relative to rounding.
  if (!(valueOf(det) > 1e-20 * valueOf(e) * valueOf(g))) return false;
  const Scalar area = sqrt(det);
  const Scalar perArea = Scalar(1.0) / area, perDet = Scalar(1.0) / det;
  const Scalar huu = s[9] * perArea, huv = s[10] * perArea, hvv = s[11] * perArea;
  // Christoffel symbols [ij][l].
  Scalar gamma[3][2];
  for (int ij = 0; ij < 3; ++ij) {
    const Scalar &au = s[static_cast<std::size_t>(3 + 2 * ij)], &av = s[static_cast<std::size_t>(4 + 2 * ij)];
    gamma[ij][0] = (g * au - f * av) * perDet;
    gamma[ij][1] = (e * av - f * au) * perDet;
  }
  const Scalar c0 = s[12] * perArea - 3.0 * (gamma[0][0] * huu + gamma[0][1] * huv);
  const Scalar c1 =
      s[13] * perArea - (gamma[0][0] * huv + gamma[0][1] * hvv) - 2.0 * (gamma[1][0] * huu + gamma[1][1] * huv);
  const Scalar c2 =
      s[14] * perArea - (gamma[2][0] * huu + gamma[2][1] * huv) - 2.0 * (gamma[1][0] * huv + gamma[1][1] * hvv);
  const Scalar c3 = s[15] * perArea - 3.0 * (gamma[2][0] * huv + gamma[2][1] * hvv);

  // The frame e1 = a X_u + b X_v, e2 = -c X_u + d X_v.
  const Scalar lu = sqrt(e), lv = sqrt(g);
  const Scalar product = lu * lv;
  // 1 - |cos| by the determinant: no cancellation where the lines nearly touch.
  const Scalar plus = valueOf(f) >= 0 ? product + f : det / (product - f);
  const Scalar minus = valueOf(f) >= 0 ? det / (product + f) : product - f;
  const Scalar sum = Scalar(1.0) / sqrt(2.0 * plus / product), difference = Scalar(1.0) / sqrt(2.0 * minus / product);
  const Scalar a = sum / lu, b = sum / lv, c = difference / lu, d = difference / lv;

  const Scalar root = sqrt(area);
  const double root2 = std::sqrt(2.0), root3 = std::sqrt(3.0);
  const Scalar aa = a * a, ab = a * b, bb = b * b, ac = a * c, ad = a * d, bc = b * c, bd = b * d, cc = c * c,
               cd = c * d, dd = d * d;
  r[4] = root * (aa * huu + 2.0 * ab * huv + bb * hvv);
  r[5] = root2 * root * (bd * hvv + (ad - bc) * huv - ac * huu);
  r[6] = root * (cc * huu - 2.0 * cd * huv + dd * hvv);
  r[0] = root * (aa * a * c0 + 3.0 * aa * b * c1 + 3.0 * bb * a * c2 + bb * b * c3);
  r[1] = root3 * root * ((aa * d - 2.0 * ab * c) * c1 + (2.0 * ab * d - bb * c) * c2 + bb * d * c3 - aa * c * c0);
  r[2] = root3 * root * (cc * a * c0 + (cc * b - 2.0 * ac * d) * c1 + (dd * a - 2.0 * bc * d) * c2 + dd * b * c3);
  r[3] = root * (3.0 * cc * d * c1 - 3.0 * dd * c * c2 + dd * d * c3 - cc * c * c0);
  return true;
}

std::array<double, kScalars> scalarsOf(const ShapeDerivatives& x) {
  const Eigen::RowVector3d u = x.row(0), v = x.row(1), n = u.cross(v);
  std::array<double, kScalars> s{u.dot(u), u.dot(v), v.dot(v)};
  for (int ij = 0; ij < 3; ++ij) {
    s[static_cast<std::size_t>(3 + 2 * ij)] = x.row(2 + ij).dot(u);
    s[static_cast<std::size_t>(4 + 2 * ij)] = x.row(2 + ij).dot(v);
    s[static_cast<std::size_t>(9 + ij)] = x.row(2 + ij).dot(n);
  }
  for (int k = 0; k < 4; ++k) s[static_cast<std::size_t>(12 + k)] = x.row(5 + k).dot(n);
  return s;
}

}  // namespace

bool shapeResiduals(const ShapeDerivatives& x, std::array<double, kShapeResiduals>& value) {
  if (residualsOf(scalarsOf(x), value)) return true;
  value.fill(0);
  return false;
}

bool shapeResiduals(const ShapeDerivatives& x, ShapeResiduals& out) {
  const std::array<double, kScalars> values = scalarsOf(x);
  std::array<Dual, kScalars> s;
  for (std::size_t k = 0; k < s.size(); ++k) {
    s[k].v = values[k];
    s[k].d[static_cast<Eigen::Index>(k)] = 1;
  }
  std::array<Dual, kShapeResiduals> r;
  if (!residualsOf(s, r)) {
    out.value.fill(0);
    out.derivative.setZero();
    return false;
  }
  const Eigen::RowVector3d u = x.row(0), v = x.row(1), n = u.cross(v);
  // What multiplies each scalar's derivative in the gradients by X_u and X_v through N: d(y . N) = du . (v x y) + dv .
  // (y x u).
  Eigen::Matrix<double, 7, 3, Eigen::RowMajor> byU, byV;
  for (int k = 0; k < 7; ++k) {
    const Eigen::RowVector3d y = x.row(2 + k);
    byU.row(k) = v.cross(y);
    byV.row(k) = y.cross(u);
  }
  for (int k = 0; k < kShapeResiduals; ++k) {
    const auto& d = r[static_cast<std::size_t>(k)].d;
    out.value[static_cast<std::size_t>(k)] = r[static_cast<std::size_t>(k)].v;
    Eigen::RowVector3d du = 2 * d[0] * u + d[1] * v, dv = d[1] * u + 2 * d[2] * v;
    auto rows = out.derivative.middleRows<3>(3 * k);
    for (int ij = 0; ij < 3; ++ij) {
      const double byAu = d[3 + 2 * ij], byAv = d[4 + 2 * ij], byH = d[9 + ij];
      rows.col(2 + ij) = (byAu * u + byAv * v + byH * n).transpose();
      du += byAu * x.row(2 + ij) + byH * byU.row(ij);
      dv += byAv * x.row(2 + ij) + byH * byV.row(ij);
    }
    for (int t = 0; t < 4; ++t) {
      rows.col(5 + t) = d[12 + t] * n.transpose();
      du += d[12 + t] * byU.row(3 + t);
      dv += d[12 + t] * byV.row(3 + t);
    }
    rows.col(0) = du.transpose();
    rows.col(1) = dv.transpose();
  }
  return true;
}

}  // namespace strak
