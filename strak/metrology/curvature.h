#pragma once
//
// Curvature of surfaces and curves at a point, independent of the parametrization.

#include <Eigen/Core>
#include <optional>

#include "strak/spline/spline.h"

namespace strak {

// Curvature of a surface in space. Signs follow the unit normal X_u x X_v / |X_u x X_v|.
struct SurfaceCurvature {
  Eigen::Vector3d point, normal;
  double gaussian = 0;           // k1 k2
  double mean = 0;               // (k1 + k2) / 2
  double principal[2] = {0, 0};  // k1 >= k2
  Eigen::Vector3d direction[2];  // unit principal directions; any orthonormal pair at umbilics
  bool regular = true;           // false where X_u x X_v vanishes: then all curvatures are zero and say nothing
};

// The unit normal X_u x X_v / |X_u x X_v|, or nothing where the tangents are parallel or one vanishes.
std::optional<Eigen::Vector3d> unitNormal(const Eigen::Vector3d& tangentU, const Eigen::Vector3d& tangentV);

// From the derivatives X, X_u, X_v, X_uu, X_uv, X_vv (rows of `d`, 3 columns, as strak::derivatives gives). Throws
// InvalidInput if there are fewer rows or another number of columns.
SurfaceCurvature surfaceCurvature(const Eigen::Ref<const Net>& d);
SurfaceCurvature surfaceCurvature(const Surface& surface, double u, double v);

// How strongly a surface is curved at a place and how its curvature changes there, without directions. All zero where
// it is not regular.
struct CurvatureRates {
  double area = 0;               // |X_u x X_v|
  double principal[2] = {0, 0};  // k1 >= k2
  // The covariant derivative C of the second fundamental form in the frame of the principal directions: (C_111, C_112,
  // C_122, C_222). C is symmetric (Codazzi), C_111 = dk1/de1, C_222 = dk2/de2 and
  // |C|^2 = C_111^2 + 3 C_112^2 + 3 C_122^2 + C_222^2.
  Eigen::Vector4d derivative = Eigen::Vector4d::Zero();
  bool regular = false;
};

// From all derivatives up to third order (10 rows, as above):
// C_ijk = X_ijk.n - h_k^l X_ij.X_l - Gamma^l_ki h_lj - Gamma^l_kj h_il. Throws InvalidInput as above.
CurvatureRates curvatureRates(const Eigen::Ref<const Net>& d);

// Normal curvature in the tangent direction a X_u + b X_v.
double normalCurvature(const Surface& surface, double u, double v, double a, double b);

// Curvature of a curve (2D: signed, 3D: >= 0) and, in 3D, its torsion.
struct CurveCurvature {
  double curvature = 0, torsion = 0;
  bool regular = true;
};
CurveCurvature curveCurvature(const Curve& curve, double u);

}  // namespace strak
