#include "strak/fitting/drawing_weights.h"

#include <limits>
#include <vector>

#include "strak/fitting/loss.h"

namespace strak {

Eigen::VectorXd drawingWeights(const Eigen::VectorXd& given, const Eigen::VectorXd& distances, Net& parameters) {
  Eigen::VectorXd weights = given.size() != 0 ? given : Eigen::VectorXd::Ones(distances.size());
  std::vector<double> counting;
  for (Index r = 0; r < weights.size(); ++r) {
    if (weights[r] > 0) counting.push_back(distances[r]);
  }
  if (counting.empty()) return weights;
  const double scale =
      robustScale(Eigen::Map<const Eigen::VectorXd>(counting.data(), static_cast<Index>(counting.size())));
  if (!(scale > 0)) return weights;
  Eigen::RowVectorXd from = Eigen::RowVectorXd::Constant(parameters.cols(), std::numeric_limits<double>::infinity());
  Eigen::RowVectorXd to = -from;
  for (Index r = 0; r < weights.size(); ++r) {
    if (!(weights[r] > 0)) continue;
    weights[r] *= lossWeight(Loss::huber, distances[r], scale);
    if (distances[r] > kOutlier * scale) continue;
    from = from.cwiseMin(parameters.row(r));
    to = to.cwiseMax(parameters.row(r));
  }
  for (Index r = 0; r < parameters.rows(); ++r) parameters.row(r) = parameters.row(r).cwiseMax(from).cwiseMin(to);
  return weights;
}

}  // namespace strak
