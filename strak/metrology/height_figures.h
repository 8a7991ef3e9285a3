#pragma once
//
// Peak to valley and RMS of measured heights, or of a form, after what does not count is removed: their mean, a plane,
// a polynomial, a sphere.

#include "strak/spline/spline.h"

namespace strak {

struct HeightFigures {
  Eigen::VectorXd residuals;  // a number a point
  double peakToValley = 0;    // largest minus smallest residual
  double rms = 0;             // root of the mean square of the residuals
  Point centre;               // of the sphere (circle) that was removed
  double radius = 0;          // ... and how large it is; zero for polynomials
};

// Rows (x, z) or (x, y, z), the last column the height. Removes the polynomial of this total degree (0: the mean, 1:
// line or plane, 2: parabola or quadric, ...) that fits the heights best in the sense of least squares; its
// coefficients are found in coordinates from -1 to 1 and corrected once, so that what is a polynomial leaves nothing
// but rounding. Where the points do not determine it (all on a line), the residuals are those of any best one. Throws
// InvalidInput for no points, other columns, numbers that are not finite or a degree outside [0, 8]. Cost: a pass of
// O(terms^2) a point.
HeightFigures figuresWithoutPolynomial(const Eigen::Ref<const Net>& points, int degree);

// Rows (x, y) or (x, y, z). Removes the circle or sphere for which the sum of the squared distances is least; the
// residuals are the distances, positive outside. Gauss-Newton from the algebraic fit. Throws InvalidInput as above and
// where the points are too few, or lie on a line or in a plane, so that there is none.
HeightFigures figuresWithoutSphere(const Eigen::Ref<const Net>& points);

}  // namespace strak
