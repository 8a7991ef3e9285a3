#include "strak/fitting/data_dependent_fit.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numeric>

#include "strak/base/error.h"
#include "strak/spline/evaluate.h"

namespace strak {

namespace {

constexpr const char* kBeltrami = "data-dependent";
constexpr const char* kHessian = "data-dependent-plate";
constexpr double kRounding = 1e-9;  // of the net's size

// K of the energy in the geometry of the fit, for a surface of the given area.
NetMatrix innerMatrix(const Spline<2>& fit, double area, InnerBending bending) {
  const Surface reference = fit.net().cols() == 1 ? graphOf<2>(fit) : fit;
  std::vector<int> all(static_cast<std::size_t>(reference.net().rows()));
  std::iota(all.begin(), all.end(), 0);
  const BeltramiEnergy energy(reference, std::move(all), 0, bending);
  NetMatrix matrix(netSizes<2>(fit.knots()), netReach<2>(fit.knots()));
  const Index columns = fit.size(1);
  for (Index row = 0; row < energy.matrix().outerSize(); ++row) {
    for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(energy.matrix(), row); entry; ++entry) {
      const Index di = entry.col() / columns - row / columns, dj = entry.col() % columns - row % columns;
      matrix.at(row, static_cast<int>(di), static_cast<int>(dj)) = area * entry.value();
    }
  }
  return matrix;
}

// Root mean square, over the control points' places, of how far `after` is from `before` along its normals: points
// that slide along the surface, which the energy hardly sees, do not count.
double distance(const Spline<2>& before, const Spline<2>& after) {
  const Surface::Grid grid{before.knots(0).greville(), before.knots(1).greville()};
  const Net at = derivativesOnGrid<2>(before, grid, 1);
  const Net move = derivativesOnGrid<2>(Spline<2>(before.knots(), after.net() - before.net()), grid, 0);
  double sum = 0;
  for (Index r = 0; r < at.rows(); ++r) {
    if (move.cols() == 1) {
      sum += move(r, 0) * move(r, 0);
      continue;
    }
    const Eigen::Vector3d u = at.row(r).segment<3>(3).transpose(), v = at.row(r).segment<3>(6).transpose();
    const double along = u.cross(v).stableNormalized().dot(move.row(r).transpose());
    sum += along * along;
  }
  return std::sqrt(sum / static_cast<double>(at.rows()));
}

}  // namespace

std::optional<InnerBending> innerBendingNamed(std::string_view name) {
  if (name == kBeltrami || name == "beltrami") return InnerBending::beltrami;
  if (name == kHessian) return InnerBending::hessian;
  return std::nullopt;
}

DataDependentFit followDataDependentEnergy(const Fit<2>& first, const FitOptions<2>& options,
                                           const EnergyFitMaker& make, const DataDependentOptions& iteration) {
  const Spline<2>& start = first.spline;
  if (start.degree(0) < 2 || start.degree(1) < 2) {
    throw InvalidInput("the data-dependent energy needs second derivatives: use degrees of at least 2");
  }
  if (start.net().cols() != 1 && start.net().cols() != 3) {
    throw InvalidInput("the data-dependent energy is for functions of two variables and surfaces in space");
  }
  double area = 1;
  for (const KnotVector& knots : scaledKnots<2>(start, ParameterScale::lengths)) area *= knots.length();
  DataDependentFit result;
  result.fit = first;
  result.options = options;
  // The name, and that planes are what the points must determine, as with the plate.
  result.options.energy = {iteration.bending == InnerBending::beltrami ? kBeltrami : kHessian, thinPlate<2>().terms};
  while (result.rounds < iteration.rounds && !result.settled) {
    if (!iteration.progress.report(static_cast<double>(result.rounds) / iteration.rounds, "following the energy")) {
      result.fit.summary.stopped = true;
      break;
    }
    result.options.energyMatrix = innerMatrix(result.fit.spline, area, iteration.bending);
    Fit<2> next = make(result.options, result.fit);
    const Net& net = next.spline.net();
    result.changes.push_back(distance(result.fit.spline, next.spline));
    result.settled =
        result.changes.back() <= iteration.settled * next.summary.rms + kRounding * net.cwiseAbs().maxCoeff();
    result.fit = std::move(next);
    ++result.rounds;
  }
  return result;
}

DataDependentFit fitDataDependently(const std::array<KnotVector, 2>& knots, Index columns, const PointPass<2>& points,
                                    FitOptions<2> options, const DataDependentOptions& iteration) {
  options.energy = thinPlate<2>();
  options.energyMatrix = {};
  const Fit<2> first = fitLeastSquares<2>(knots, columns, points, options);
  return followDataDependentEnergy(
      first, options,
      [&](const FitOptions<2>& own, const Fit<2>&) { return fitLeastSquares<2>(knots, columns, points, own); },
      iteration);
}

}  // namespace strak
