#include "strak/fitting/least_squares.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "strak/base/error.h"
#include "strak/energy/energy_operator.h"
#include "strak/spline/basis.h"

namespace strak {

namespace {

// Stiff enough to see through the noise to the shape whose lengths are wanted.
constexpr double kShapeSmoothing = 1e-3;
// Mean squares of the errors, in parts of the points' own, that are far enough above the rounding of the sums.
constexpr double kLeastErrors = 1e-9;
// Cells with a larger bimodality have two groups of heights; a larger share of the points in them is worth a word.
constexpr double kTwoGroups = 0.8;
constexpr double kManyTwoGroups = 0.05;
constexpr double kRounding = 1e-8;  // errors, in parts of the values, below which groups are patterns of rounding
// Eigenvalues of the polynomials' Gram matrix, relative to the largest, below which the points lie on a line.
constexpr double kLeastDetermination = 1e-12;

// The basis functions at a place, as a row over all control points.
template <int D>
Eigen::RowVectorXd basisRow(const std::array<KnotVector, D>& knots, const Eigen::Ref<const Point>& at) {
  std::array<Index, D> span;
  std::array<Net, D> basis;
  for (std::size_t k = 0; k < D; ++k) {
    const double u = at[static_cast<Index>(k)];
    if (!(u >= knots[k].from() && u <= knots[k].to())) {
      throw InvalidInput(fmt::format(
          "an interpolation condition lies at {} = {:g}, outside the domain [{:g}, {:g}]: give a larger one",
          directionName(static_cast<int>(k)), u, knots[k].from(), knots[k].to()));
    }
    span[k] = knots[k].findSpan(u);
    basis[k] = basisDerivatives(knots[k], span[k], u, 0);
  }
  const Index lines = D == 1 ? 1 : knots[0].size(), line = knots[D - 1].size();
  Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(lines * line);
  const Index p = D == 1 ? 0 : knots[0].degree(), q = knots[D - 1].degree();
  for (Index a = 0; a <= p; ++a) {
    for (Index b = 0; b <= q; ++b) {
      const Index i = D == 1 ? 0 : span[0] - p + a, j = span[D - 1] - q + b;
      row[i * line + j] = (D == 1 ? 1.0 : basis[0](0, a)) * basis[D - 1](0, b);
    }
  }
  return row;
}

// Moves the net least in the metric of the factored matrix, so that the conditions hold.
template <int D>
void meetConditions(const std::array<KnotVector, D>& knots, const FitOptions<D>& options, const NetCholesky& solver,
                    Net& net) {
  const Index count = options.conditionParameters.rows();
  if (count == 0) return;
  if (options.conditionParameters.cols() != D || options.conditionValues.rows() != count ||
      options.conditionValues.cols() != net.cols()) {
    throw InvalidInput(
        fmt::format("the interpolation conditions need a row of {} parameters and {} values each", D, net.cols()));
  }
  if (!options.conditionValues.allFinite()) {
    throw InvalidInput("an interpolation condition has a value that is not finite: correct or remove it");
  }
  Net rows(count, net.rows());
  for (Index r = 0; r < count; ++r) rows.row(r) = basisRow<D>(knots, options.conditionParameters.row(r));
  const Net moves = solver.solve(rows.transpose());
  const Eigen::MatrixXd compliance = rows * moves;
  const Eigen::LDLT<Eigen::MatrixXd> factor(compliance);
  const auto pivots = factor.vectorD().array();
  if (factor.info() != Eigen::Success || !(pivots.minCoeff() > 1e-13 * pivots.maxCoeff())) {
    throw InvalidInput(
        "the interpolation conditions contradict or repeat one another, or what is held leaves no room for "
        "them: remove some or use more control points");
  }
  // The second round removes the rounding of the first.
  for (int round = 0; round < 2; ++round) net += moves * factor.solve(Net(options.conditionValues - rows * net));
}

// The net of the polynomial x^power, x running from -1 to 1 over the domain, power <= 2 and <= degree: its blossom.
Eigen::VectorXd powerNet(const KnotVector& knots, int power) {
  const KnotVector unit = knots.rescaled(-1, 1);
  const int p = knots.degree();
  Eigen::VectorXd net = Eigen::VectorXd::Ones(knots.size());
  for (Index i = 0; power > 0 && i < net.size(); ++i) {
    double sum = 0, squares = 0;
    for (int k = 1; k <= p; ++k) {
      sum += unit[i + k];
      squares += unit[i + k] * unit[i + k];
    }
    net[i] = power == 1 ? sum / p : (sum * sum - squares) / (p * (p - 1));
  }
  return net;
}

// Whether the points determine the polynomials that an energy of this order does not see: those of lower total degree.
template <int D>
bool determinesPolynomials(const std::array<KnotVector, D>& knots, const NetMatrix& data, int order) {
  std::vector<Eigen::VectorXd> nets;
  for (int a = 0; a < order; ++a) {
    for (int b = 0; a + b < order; ++b) {
      if (b > knots[D - 1].degree() || (D == 1 && a > 0) || (D == 2 && a > knots[0].degree())) continue;
      const Eigen::VectorXd v = powerNet(knots[D - 1], b);
      if constexpr (D == 1) {
        nets.push_back(v);
      } else {
        const Net product = powerNet(knots[0], a) * v.transpose();
        nets.emplace_back(Eigen::Map<const Eigen::VectorXd>(product.data(), product.size()));
      }
    }
  }
  Net polynomials(data.size(), static_cast<Index>(nets.size()));
  for (std::size_t k = 0; k < nets.size(); ++k) polynomials.col(static_cast<Index>(k)) = nets[k];
  const Eigen::MatrixXd gram = polynomials.transpose() * data.times(polynomials);
  const Eigen::VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(gram).eigenvalues();
  return eigenvalues[0] > kLeastDetermination * eigenvalues[eigenvalues.size() - 1];
}

// The energy that was asked for, or the highest one whose polynomials the points determine.
template <int D>
QuadraticEnergy<D> energyFor(const std::array<KnotVector, D>& knots, const NetMatrix& data,
                             const FitOptions<D>& options) {
  const bool asked = !options.energy.terms.empty();
  QuadraticEnergy<D> energy = asked ? options.energy : fitEnergy<D>(knots);
  if (!options.held.empty()) return energy;
  if (!asked && energy.order() == 3 && !determinesPolynomials<D>(knots, data, 3)) energy = thinPlate<D>();
  const bool weighted = options.smoothing.choice != Smoothing::Choice::fixed || options.smoothing.value > 0;
  if (weighted && !determinesPolynomials<D>(knots, data, std::min(energy.order(), 3))) {
    throw InvalidInput(fmt::format(
        "the points do not determine a fit with the energy '{}': {}", energy.name,
        energy.order() <= 2 ? "they all lie on a line or at one place of the domain; measure beside it, too"
                            : "there are too few, or they lie on a line or a conic; use the energy thin-plate"));
  }
  return energy;
}

// With the given weight, or else the least that makes the fit unique.
Smoothed firstFit(const SmoothingProblem& problem, const Smoothing& smoothing, NetCholesky& solver) {
  if (smoothing.choice == Smoothing::Choice::fixed) return smooth(problem, smoothing, solver);
  double lambda = softestSmoothing(problem.data, problem.energy);
  while (lambda < kStiffestSmoothing && !solver.factor(combined(problem.data, lambda, problem.energy), problem.held)) {
    lambda *= 100;
  }
  return smooth(problem, Smoothing::fixed(lambda), solver);
}

}  // namespace

template <int D>
QuadraticEnergy<D> fitEnergy(const std::array<KnotVector, D>& knots) {
  int degree = knots[0].degree();
  for (const auto& k : knots) degree = std::min(degree, k.degree());
  if (degree >= 3) return thirdDerivatives<D>();
  if (degree == 2) return thinPlate<D>();
  QuadraticEnergy<D> gradient{"gradient", {}};
  for (std::size_t k = 0; k < D; ++k) {
    EnergyTerm<D> term{1, {}, {}};
    term.a[k] = term.b[k] = 1;
    gradient.terms.push_back(term);
  }
  return gradient;
}

template <int D>
std::array<KnotVector, D> normalisedKnots(const Spline<D>& spline, ParameterScale scale) {
  std::array<KnotVector, D> knots = scaledKnots<D>(spline, scale);
  double volume = 1;
  for (const auto& k : knots) volume *= k.length();
  const double unit = std::pow(volume, 1.0 / D);
  for (auto& k : knots) k = k.rescaled(0, k.length() / unit);
  return knots;
}

template <int D>
NetMatrix energyMatrixOf(const QuadraticEnergy<D>& energy, const std::array<KnotVector, D>& knots) {
  const EnergyOperator<D> op(energy, knots);
  NetMatrix matrix(netSizes<D>(knots), netReach<D>(knots));
  for (const auto& term : op.terms()) {
    const BandMatrix& v = op.factors(D - 1)[static_cast<std::size_t>(term.factor[D - 1])];
    for (Index i = 0; i < matrix.sizes[0]; ++i) {
      for (int di = -matrix.reach[0]; di <= matrix.reach[0]; ++di) {
        if (i + di < 0 || i + di >= matrix.sizes[0]) continue;
        double factor = term.coefficient;
        if constexpr (D == 2) factor *= op.factors(0)[static_cast<std::size_t>(term.factor[0])](i, i + di);
        for (Index j = 0; j < matrix.sizes[1]; ++j) {
          for (int dj = -matrix.reach[1]; dj <= matrix.reach[1]; ++dj) {
            if (j + dj < 0 || j + dj >= matrix.sizes[1]) continue;
            matrix.at(i * matrix.sizes[1] + j, di, dj) += factor * v(j, j + dj);
          }
        }
      }
    }
  }
  return matrix;
}

template <int D>
void takeErrors(Fit<D>& fit, const PointPass<D>& points, double tolerance) {
  FitErrors<D> errors(fit.spline, tolerance);
  points([&](const FitPoints<D>& block) { errors.add(block); });
  const auto worst = errors.worst();
  FitSummary& summary = fit.summary;
  summary.points = errors.count();
  summary.outsideDomain = errors.outsideDomain();
  summary.rms = std::sqrt(errors.squares() / errors.weight());
  summary.max = worst.error;
  summary.worstPoint = worst.point;
  summary.worstPlace.assign(worst.parameters.begin(), worst.parameters.end());
  summary.outsideTolerance = errors.outsideTolerance();
  fit.cells = errors.cells();
}

template <int D>
Fit<D> fitLeastSquares(const std::array<KnotVector, D>& knots, Index columns, const PointPass<D>& points,
                       const FitOptions<D>& options) {
  NormalEquations<D> equations(knots, columns);
  points([&](const FitPoints<D>& block) { equations.add(block); });
  if (equations.count() == 0) {
    throw InvalidInput(equations.outside() == 0 ? "there are no points to fit"
                                                : "no point lies inside the domain: give one that holds the points");
  }
  auto sums = equations.sums();
  if (!std::isfinite(sums.squares) || (sums.squares == 0 && sums.right.cwiseAbs().maxCoeff() > 0)) {
    throw InvalidInput("the coordinates are so large or so small that their squares are no numbers: use another unit");
  }
  if (!(sums.weight > 0)) throw InvalidInput("all points have the weight 0: give some a positive one");
  for (double& value : sums.matrix.values) value /= sums.weight;

  SmoothingProblem problem;
  problem.data = std::move(sums.matrix);
  problem.points = static_cast<double>(equations.measured());
  problem.right = sums.right / sums.weight;
  const Index rows = problem.data.size();
  problem.reference = Net::Zero(rows, columns);
  if (!options.held.empty()) {
    if (options.heldNet.rows() != rows || options.heldNet.cols() != columns) {
      throw InvalidInput(fmt::format("the held control points come from a net of {} x {} numbers: give one of {} x {}",
                                     options.heldNet.rows(), options.heldNet.cols(), rows, columns));
    }
    problem.held.assign(static_cast<std::size_t>(rows), 0);
    for (Index r : options.held) {
      if (r < 0 || r >= rows) throw InvalidInput(fmt::format("held control point {}: there are {}", r, rows));
      problem.held[static_cast<std::size_t>(r)] = 1;
      problem.reference.row(r) = options.heldNet.row(r);
    }
  }
  NetCholesky solver(problem.data.sizes, problem.data.reach);
  // The errors of the held points alone belong to the right side.
  problem.right -= problem.data.times(problem.reference);
  const NetVectors start = problem.reference;

  const QuadraticEnergy<D> energy = energyFor<D>(knots, problem.data, options);
  const auto energyIn = [&](const Net& net, ParameterScale scale) {
    return energyMatrixOf<D>(energy, normalisedKnots<D>(Spline<D>(knots, net), scale));
  };
  if (options.energyMatrix.size() > 0) {
    if (options.energyMatrix.sizes != problem.data.sizes || options.energyMatrix.reach != problem.data.reach) {
      throw InvalidInput("the energy's matrix belongs to other knots than the fit's: make it on those");
    }
    problem.energy = options.energyMatrix;
  } else if (columns > 1 && D > 1 && options.scale == ParameterScale::lengths) {
    problem.energy = energyIn(start, ParameterScale::unit);
    const Smoothed shape = smooth(problem, Smoothing::fixed(kShapeSmoothing), solver);
    problem.energy = energyIn(shape.net, options.scale);
  } else {
    problem.energy = energyIn(start, options.scale);
  }

  Fit<D> fit;
  FitSummary& summary = fit.summary;
  problem.meanSquare =
      sums.squares / sums.weight - start.cwiseProduct(2 * problem.right + problem.data.times(start)).sum();
  Smoothed smoothed;
  const bool exact = options.smoothing.choice == Smoothing::Choice::fixed && options.smoothing.value == 0;
  if (!exact) {
    smoothed = smooth(problem, options.smoothing, solver);
    summary.factorizations = smoothed.factorizations;
  }
  if (exact || !(smoothed.meanSquare > kLeastErrors * sums.squares / sums.weight)) {
    // Errors that small are lost in the rounding of the sums. From a first fit they are seen, in one pass more.
    smoothed = firstFit(problem, options.smoothing, solver);
    summary.factorizations += smoothed.factorizations;
    FitErrors<D> errors(Spline<D>(knots, smoothed.net), options.tolerance);
    points([&](const FitPoints<D>& block) { errors.add(block); });
    problem.reference = smoothed.net;
    problem.right = errors.right() / errors.weight();
    problem.meanSquare = errors.squares() / errors.weight();
    smoothed = smooth(problem, options.smoothing, solver);
    summary.factorizations += smoothed.factorizations;
  }

  Net net = smoothed.net;
  meetConditions<D>(knots, options, solver, net);
  // What is held is held to the bit.
  for (Index r : options.held) net.row(r) = options.heldNet.row(r);
  fit.spline = Spline<D>(knots, std::move(net));
  takeErrors<D>(fit, points, options.tolerance);
  summary.lambda = smoothed.lambda;
  summary.freedom = smoothed.freedom;
  summary.energyName = energy.name;
  summary.energy = smoothed.energy;
  summary.crossValidation = std::sqrt(smoothed.crossValidation);
  if (!smoothed.reached) {
    summary.warnings.push_back(
        fmt::format("no smoothing weight leaves the noise {:g}: the nearest one leaves {:g} a coordinate",
                    options.smoothing.value, std::sqrt(smoothed.meanSquare / static_cast<double>(columns))));
  }
  if (static_cast<double>(rows) > problem.points) {
    summary.warnings.push_back(
        fmt::format("{} control points are more than the {:.0f} points determine: the energy decides the rest", rows,
                    problem.points));
  }
  if (summary.outsideDomain > 0) {
    summary.warnings.push_back(fmt::format("{} points outside the domain were left out", summary.outsideDomain));
  }
  fit.system = combined(problem.data, smoothed.lambda, problem.energy);
  fit.energy = std::move(problem.energy);
  const bool rounding = !(summary.rms > kRounding * std::sqrt(sums.squares / sums.weight));
  if (const auto groups = twoGroups<D>(fit); groups.share > kManyTwoGroups && !rounding) {
    summary.warnings.push_back(
        fmt::format("in {:.0f} % of the knot cells' points the heights fall into two groups, for instance around "
                    "({:.6g}): the cloud "
                    "may have two sheets or steps there, which a smooth function cannot follow",
                    100 * groups.share, fmt::join(groups.place, ", ")));
  }
  return fit;
}

template <int D>
TwoGroups<D> twoGroups(const Fit<D>& fit) {
  std::array<std::vector<Index>, D> spans;
  for (std::size_t k = 0; k < D; ++k) spans[k] = fit.spline.knots()[k].spans();
  TwoGroups<D> result;
  double in = 0, all = 0, worst = 0;
  for (std::size_t c = 0; c < fit.cells.size(); ++c) {
    const double bimodality = fit.cells[c].bimodality();
    if (!(bimodality > 0)) continue;
    all += static_cast<double>(fit.cells[c].count);
    if (bimodality < kTwoGroups) continue;
    in += static_cast<double>(fit.cells[c].count);
    if (!(fit.cells[c].max > worst)) continue;
    worst = fit.cells[c].max;
    std::size_t rest = c;
    for (std::size_t k = D; k-- > 0;) {
      const KnotVector& knots = fit.spline.knots()[k];
      const Index span = spans[k][rest % spans[k].size()];
      rest /= spans[k].size();
      result.place[k] = (knots[span] + knots[span + 1]) / 2;
    }
  }
  result.share = all > 0 ? in / all : 0;
  return result;
}

template <int D>
Spline<D> graphOf(const Spline<D>& function) {
  if (function.net().cols() != 1) throw InvalidInput("only a function of one value has a graph");
  Net net(function.net().rows(), D + 1);
  std::array<std::vector<double>, D> places;
  for (std::size_t k = 0; k < D; ++k) places[k] = function.knots()[k].greville();
  for (Index r = 0; r < net.rows(); ++r) {
    Index rest = r;
    for (int k = D - 1; k >= 0; --k) {
      const auto& place = places[static_cast<std::size_t>(k)];
      const auto n = static_cast<Index>(place.size());
      net(r, k) = place[static_cast<std::size_t>(rest % n)];
      rest /= n;
    }
    net(r, D) = function.net()(r, 0);
  }
  return Spline<D>(function.knots(), std::move(net));
}

template QuadraticEnergy<1> fitEnergy<1>(const std::array<KnotVector, 1>&);
template QuadraticEnergy<2> fitEnergy<2>(const std::array<KnotVector, 2>&);
template std::array<KnotVector, 1> normalisedKnots<1>(const Spline<1>&, ParameterScale);
template std::array<KnotVector, 2> normalisedKnots<2>(const Spline<2>&, ParameterScale);
template Fit<1> fitLeastSquares<1>(const std::array<KnotVector, 1>&, Index, const PointPass<1>&, const FitOptions<1>&);
template Fit<2> fitLeastSquares<2>(const std::array<KnotVector, 2>&, Index, const PointPass<2>&, const FitOptions<2>&);
template void takeErrors<1>(Fit<1>&, const PointPass<1>&, double);
template void takeErrors<2>(Fit<2>&, const PointPass<2>&, double);
template NetMatrix energyMatrixOf<1>(const QuadraticEnergy<1>&, const std::array<KnotVector, 1>&);
template NetMatrix energyMatrixOf<2>(const QuadraticEnergy<2>&, const std::array<KnotVector, 2>&);
template TwoGroups<1> twoGroups<1>(const Fit<1>&);
template TwoGroups<2> twoGroups<2>(const Fit<2>&);
template Spline<1> graphOf<1>(const Spline<1>&);
template Spline<2> graphOf<2>(const Spline<2>&);

}  // namespace strak
