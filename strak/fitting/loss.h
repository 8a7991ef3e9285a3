#pragma once
//
// Losses that grow more slowly than squares, so that outliers do not move a fit. With r = |error| / s, s the scale of
// the noise, s^2 rho(r) takes the place of the square:
//   Huber   rho = r^2 up to k, 2 k r - k^2 beyond (k = 1.345; 95 % efficient for normal noise)
//   Tukey   rho = (c^2 / 3) (1 - (1 - (r / c)^2)^3) up to c, c^2 / 3 beyond (c = 4.685): far points do not count at all
//   l1      rho = 2 r
// Source: Huber, Robust Statistics (1981).

#include <Eigen/Core>
#include <string_view>

namespace strak {

enum class Loss { huber, tukey, absolute };

// "huber", "tukey", "l1"; throws InvalidInput for another word.
Loss lossNamed(std::string_view name);

// An error beyond so many scales is an outlier's.
inline constexpr double kOutlier = 4.685;

// s^2 rho(error / s) for an error that is not negative.
double lossOf(Loss loss, double error, double scale);

// The weight of least squares that has the same slope there; `least`: of l1 no error counts as smaller.
double lossWeight(Loss loss, double error, double scale, double least = 0);

// The scale of normal noise from the median of errors that are not negative, of which there must be one.
double robustScale(Eigen::VectorXd errors);

}  // namespace strak
