#pragma once
//
// The integrands of the exact energies at one point of a surface, as squares of residuals, with their derivatives.
//
// With g_ij = X_i . X_j, h_ij = X_ij . n, Gamma^l_ij = g^lm X_ij . X_m and
//   C_ijk = X_ijk . n - Gamma^m_ij h_mk - Gamma^m_ki h_mj - Gamma^m_kj h_mi   (= nabla_k h_ij, symmetric by Codazzi)
// in the orthonormal frame of the bisectors of X_u / |X_u| and X_v / |X_v| (it does not depend on the speeds of u and
// v):
//   plate      k1^2 + k2^2 = h11^2 + 2 h12^2 + h22^2,
//   roughness  |nabla h|^2 = C111^2 + 3 C112^2 + 3 C122^2 + C222^2,
// each times the area element. The roughness measures the isophotes of all lights at once and bounds the curvature
// variation from above.

#include <Eigen/Core>
#include <array>

namespace strak {

// The derivatives of a surface in the order u, v, uu, uv, vv, uuu, uuv, uvv, vvv.
inline constexpr int kShapeDerivatives = 9;
using ShapeDerivatives = Eigen::Matrix<double, kShapeDerivatives, 3, Eigen::RowMajor>;

// Four residuals of the roughness, then three of the plate energy; their squares are the integrands per du dv.
inline constexpr int kShapeResiduals = 7;
inline constexpr int kRoughnessResiduals = 4;
struct ShapeResiduals {
  std::array<double, kShapeResiduals> value{};
  // Row r * 3 + c: the derivative of residual r by coordinate c of each of the nine derivatives.
  Eigen::Matrix<double, 3 * kShapeResiduals, kShapeDerivatives, Eigen::RowMajor> derivative;
};

// Returns false where the surface has no normal or the parameter lines touch: all is zero then.
bool shapeResiduals(const ShapeDerivatives& x, ShapeResiduals& out);

// The values alone.
bool shapeResiduals(const ShapeDerivatives& x, std::array<double, kShapeResiduals>& value);

}  // namespace strak
