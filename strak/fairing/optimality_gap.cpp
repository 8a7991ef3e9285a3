#include "strak/fairing/optimality_gap.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "strak/base/error.h"
#include "strak/fairing/fairing_problem.h"

namespace strak {

template <int D>
double optimalityGap(const Spline<D>& input, const Spline<D>& faired, const QuadraticEnergy<D>& energy,
                     const HeldPoints& held, double tolerance, ParameterScale scale) {
  if (input.knots() != faired.knots() || input.net().cols() != faired.net().cols()) {
    throw InvalidInput(
        "the faired spline has other knots or another dimension than the input: give both on the same knots");
  }
  if (!(tolerance >= 0)) throw InvalidInput(fmt::format("the tolerance is {}: give a length of 0 or more", tolerance));
  FairingProblem<D> problem(input, energy, held, scale);
  const Net moves = faired.net() - input.net();
  for (Index r = 0; r < moves.rows(); ++r) {
    const bool isHeld = problem.held()[static_cast<std::size_t>(r)] != 0;
    const double move = moves.row(r).norm();
    if (move > (isHeld ? 0 : tolerance)) {
      throw InvalidInput(fmt::format("control point {} has moved by {}, more than {}: this net is not allowed", r, move,
                                     isHeld ? 0 : tolerance));
    }
  }
  if (problem.freePoints() == 0) return 0;
  const BallProblem ball = problem.ball(tolerance);
  Field e(problem.layout());
  packBox(problem.layout(), moves, Eigen::RowVectorXd::Zero(moves.cols()), e);
  const BallResult result = boundAt(ball, e);
  if (result.bound <= 0) return 0;
  const double reached = std::abs(problem.energyBefore() + result.value);
  return reached > 0 ? result.bound / reached : std::numeric_limits<double>::infinity();
}

template double optimalityGap<1>(const Spline<1>&, const Spline<1>&, const QuadraticEnergy<1>&, const HeldPoints&,
                                 double, ParameterScale);
template double optimalityGap<2>(const Spline<2>&, const Spline<2>&, const QuadraticEnergy<2>&, const HeldPoints&,
                                 double, ParameterScale);
template double optimalityGap<3>(const Spline<3>&, const Spline<3>&, const QuadraticEnergy<3>&, const HeldPoints&,
                                 double, ParameterScale);

}  // namespace strak
