#include "strak/fitting/data_dependent_fit.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "strak/base/error.h"
#include "strak/energy/beltrami_energy.h"

namespace strak {

namespace {

constexpr double kRounding = 1e-9;  // of the net's size

// K of the energy in the geometry of the fit, for a surface of the given area.
NetMatrix beltramiMatrix(const Spline<2>& fit, double area) {
  const Surface reference = fit.net().cols() == 1 ? graphOf<2>(fit) : fit;
  std::vector<int> all(static_cast<std::size_t>(reference.net().rows()));
  std::iota(all.begin(), all.end(), 0);
  const BeltramiEnergy energy(reference, std::move(all));
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

double rootMeanSquare(const Net& net) {
  return std::sqrt(net.squaredNorm() / static_cast<double>(std::max<Index>(net.rows(), 1)));
}

}  // namespace

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
  result.options.energy = {"data-dependent", thinPlate<2>().terms};
  while (result.rounds < iteration.rounds && !result.settled) {
    if (!iteration.progress.report(static_cast<double>(result.rounds) / iteration.rounds, "following the energy")) {
      result.fit.summary.stopped = true;
      break;
    }
    result.options.energyMatrix = beltramiMatrix(result.fit.spline, area);
    Fit<2> next = make(result.options, result.fit);
    const Net& net = next.spline.net();
    result.changes.push_back(rootMeanSquare(net - result.fit.spline.net()));
    result.settled = result.changes.back() <=
                     iteration.settled * next.summary.rms + kRounding * net.cwiseAbs().maxCoeff();
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
