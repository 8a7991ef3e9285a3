#include "strak/fairing/optimal_fairing.h"

#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <deque>

#include "strak/base/cpu_time.h"
#include "strak/base/error.h"
#include "strak/energy/energy_operator.h"
#include "strak/solve/ball_minimizer.h"

namespace strak {

namespace {

constexpr double kRounding = 1e-16;

// The smallest box of the net that contains all free points.
struct FreeBox {
  std::vector<Index> first, count;
  Index freePoints = 0;
};

template <int D>
FreeBox freeBox(const typename Spline<D>::Sizes& sizes, const HeldPoints& held) {
  FreeBox box{std::vector<Index>(sizes.begin(), sizes.end()), std::vector<Index>(D, 0), 0};
  std::vector<Index> last(D, -1);
  for (std::size_t r = 0; r < held.size(); ++r) {
    if (held[r]) continue;
    ++box.freePoints;
    auto rest = static_cast<Index>(r);
    for (std::size_t k = D; k-- > 0;) {
      const Index i = rest % sizes[k];
      rest /= sizes[k];
      box.first[k] = std::min(box.first[k], i);
      last[k] = std::max(last[k], i);
    }
  }
  for (std::size_t k = 0; k < D; ++k) box.count[k] = last[k] - box.first[k] + 1;
  return box;
}

// The energy restricted to a box of points, as Kronecker products that the solvers take, with what is provable of it.
// The products point into `matrices` (a deque: its elements never move), so the struct is made once and not copied.
template <int D>
struct BoxEnergy {
  std::deque<BandMatrix> matrices;
  std::vector<KroneckerProduct> products, lowerBound;
  KroneckerProduct mass;
  std::vector<const BandMatrix*> stiffness, massFactors;

  BoxEnergy(const EnergyOperator<D>& op, const FreeBox& box) {
    // Factor by factor: the block on the box, and for N^(a) N^(b) with a + b = 2 c the sign with which it equals
    // N^(c) N^(c): integration by parts, exact where the box's functions vanish to sufficient order at the ends. That
    // turns the cross terms of (16) and of the Laplacian into squares.
    struct Factor {
      const BandMatrix* matrix;
      int order;  // c, or -1 for a factor that is no square
      double sign;
    };
    std::array<std::vector<Factor>, D> factors;
    for (std::size_t k = 0; k < D; ++k) {
      const auto& orders = op.factorOrders(static_cast<int>(k));
      const auto& all = op.factors(static_cast<int>(k));
      for (std::size_t i = 0; i < all.size(); ++i) {
        matrices.push_back(all[i].block(box.first[k], box.count[k]));
        factors[k].push_back({&matrices.back(), orders[i].first == orders[i].second ? orders[i].first : -1, 1});
      }
      for (std::size_t i = 0; i < all.size(); ++i) {
        const int total = orders[i].first + orders[i].second;
        if (factors[k][i].order >= 0 || total % 2 != 0) continue;
        const double sign = (orders[i].first - total / 2) % 2 == 0 ? 1 : -1;
        for (std::size_t j = 0; j < all.size(); ++j) {
          if (orders[j] != std::pair(total / 2, total / 2)) continue;
          const double difference =
              (factors[k][i].matrix->band - sign * factors[k][j].matrix->band).cwiseAbs().maxCoeff();
          if (difference <= 1e-12 * factors[k][j].matrix->band.cwiseAbs().maxCoeff()) {
            factors[k][i] = {factors[k][j].matrix, total / 2, sign};
          }
        }
      }
    }
    std::array<BandMatrix, D> pure;
    bool squares = true;
    for (const auto& term : op.terms()) {
      KroneckerProduct product{term.coefficient, {}};
      int directions = 0;
      std::size_t along = 0;
      for (std::size_t k = 0; k < D; ++k) {
        const Factor& factor = factors[k][static_cast<std::size_t>(term.factor[k])];
        product.coefficient *= factor.sign;
        product.factors.push_back(factor.matrix);
        if (factor.order != 0) {
          ++directions;
          along = k;
        }
        squares = squares && factor.order >= 0;
      }
      squares = squares && product.coefficient >= 0;
      if (directions == 1) {
        BandMatrix& sum = pure[along];
        const BandMatrix& matrix = *product.factors[along];
        if (sum.size == 0) sum = BandMatrix(matrix.size, matrix.bandwidth);
        sum.band += product.coefficient * matrix.band;
      }
      products.push_back(std::move(product));
    }
    mass.coefficient = 1;
    for (std::size_t k = 0; k < D; ++k) {
      massFactors.push_back(factors[k].front().matrix);  // EnergyOperator puts the mass matrix first
      mass.factors.push_back(massFactors.back());
    }
    for (std::size_t k = 0; k < D; ++k) {
      const bool hasPure = pure[k].size > 0;
      matrices.push_back(hasPure ? pure[k] : factors[k].back().matrix->block(0, box.count[k]));
      stiffness.push_back(&matrices.back());
      if (!hasPure || !squares) continue;
      KroneckerProduct product = mass;
      product.factors[k] = stiffness.back();
      lowerBound.push_back(std::move(product));
    }
  }
  BoxEnergy(const BoxEnergy&) = delete;
  BoxEnergy& operator=(const BoxEnergy&) = delete;
};

[[noreturn]] void refuseSingular(const std::string& name, int order) {
  throw InvalidInput(
      fmt::format("the held points leave motions free that the energy '{}' does not see: hold at least {} rows on two "
                  "opposite sides, or give a tolerance",
                  name, order));
}

// min q without tolerance where no lower bound P is known or P is singular: a sparse factor of K on the free points.
template <int D>
BallResult solveByFactor(const EnergyOperator<D>& op, const std::string& name, int order, const HeldPoints& held,
                         const Net& halfGradient, double wishedGap, double scale, Net& e) {
  Eigen::SparseMatrix<double> all = op.matrix();
  std::vector<Index> place(held.size(), -1);
  Index count = 0;
  for (std::size_t r = 0; r < held.size(); ++r) {
    if (!held[r]) place[r] = count++;
  }
  Eigen::VectorXd inverseRoot(count);
  for (std::size_t r = 0; r < held.size(); ++r) {
    if (place[r] < 0) continue;
    const auto row = static_cast<Index>(r);
    if (!(all.coeff(row, row) > 0)) refuseSingular(name, order);
    inverseRoot[place[r]] = 1 / std::sqrt(all.coeff(row, row));
  }
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (Index column = 0; column < all.outerSize(); ++column) {
    for (Eigen::SparseMatrix<double>::InnerIterator it(all, column); it; ++it) {
      const Index i = place[static_cast<std::size_t>(it.row())];
      const Index j = place[static_cast<std::size_t>(column)];
      if (i >= 0 && j >= 0) entries.emplace_back(i, j, it.value() * inverseRoot[i] * inverseRoot[j]);
    }
  }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
  if (factor.info() != Eigen::Success || factor.vectorD().minCoeff() < 1e-12) refuseSingular(name, order);

  Net linear(count, halfGradient.cols());
  for (std::size_t r = 0; r < held.size(); ++r) {
    if (place[r] >= 0) linear.row(place[r]) = halfGradient.row(static_cast<Index>(r)) * inverseRoot[place[r]];
  }
  Net x = -factor.solve(linear);
  Net residual;
  BallResult result;
  for (result.iterations = 1;; ++result.iterations) {
    residual = -linear - matrix * x;
    const Net correction = factor.solve(residual);
    result.bound = residual.cwiseProduct(correction).sum();
    result.value = linear.cwiseProduct(x).sum() - x.cwiseProduct(residual).sum();
    if (result.bound <= wishedGap * std::abs(scale + result.value)) break;
    if (result.iterations == 4) {
      result.stop = BallResult::Stop::precision;
      break;
    }
    x += correction;
  }
  for (std::size_t r = 0; r < held.size(); ++r) {
    if (place[r] >= 0) e.row(static_cast<Index>(r)) = x.row(place[r]) * inverseRoot[place[r]];
  }
  return result;
}

// d0 + e, rounded so that the distance measured in floating point stays within the radius.
void addWithin(double radius, const Net& e, MutableNetRef net) {
  for (Index r = 0; r < net.rows(); ++r) {
    const Point start = net.row(r);
    double factor = 1;
    Point moved = start + e.row(r);
    for (int attempt = 0; attempt < 60 && (moved - start).norm() > radius; ++attempt) {
      factor -= std::ldexp(1.0, attempt - 52);
      moved = start + factor * e.row(r);
    }
    if ((moved - start).norm() <= radius) net.row(r) = moved;
  }
}

}  // namespace

template <int D>
Faired<D> fairOptimally(const Spline<D>& input, const QuadraticEnergy<D>& energy,
                        const OptimalFairingOptions& options) {
  const double begin = threadSeconds();
  if (!(options.tolerance >= 0)) {
    throw InvalidInput(fmt::format("the tolerance is {}: give a length of 0 or more", options.tolerance));
  }
  if (!(options.gap >= 0)) throw InvalidInput(fmt::format("the wished gap is {}: give 0 or more", options.gap));
  if (!options.held.empty() && static_cast<Index>(options.held.size()) != input.net().rows()) {
    throw InvalidInput(fmt::format("the list of held points has {} entries but the net has {} points: give one a point",
                                   options.held.size(), input.net().rows()));
  }
  Faired<D> result{input, {}};
  FairingSummary& summary = result.summary;
  const auto knots = scaledKnots(input, options.scale);
  const EnergyOperator<D> op(energy, knots);
  const auto sizes = op.sizes();
  HeldPoints held = options.held;
  held.resize(static_cast<std::size_t>(input.net().rows()), 0);
  // A function whose support does not meet the domain is not seen by any energy: its point stays.
  for (std::size_t r = 0; r < held.size(); ++r) {
    auto rest = static_cast<Index>(r);
    for (std::size_t k = D; k-- > 0;) {
      const Index i = rest % sizes[k];
      rest /= sizes[k];
      if (!(op.factors(static_cast<int>(k)).front()(i, i) > 0)) held[r] = 1;
    }
  }

  // The energy of the input and its half gradient K d0, both free of the model's place (order >= 1 sees no
  // translation).
  const int components = static_cast<int>(input.net().cols());
  int halo = 0;
  for (int k = 0; k < D; ++k) halo = std::max(halo, input.degree(k));
  const Eigen::RowVectorXd centre = energy.order() > 0 ? Eigen::RowVectorXd(input.net().colwise().mean())
                                                       : Eigen::RowVectorXd::Zero(components).eval();
  const std::vector<Index> netSizes(sizes.begin(), sizes.end());
  Net halfGradient;
  double noise = 0;  // what rounding alone may do to an energy
  {
    const Net centred = input.net().rowwise() - centre;
    halfGradient = op.product(centred);
    summary.energyBefore = centred.cwiseProduct(halfGradient).sum();
    noise = kRounding * op.diagonal().dot(centred.rowwise().squaredNorm());
  }
  const FreeBox box = freeBox<D>(sizes, held);
  summary.freePoints = box.freePoints;
  summary.energyAfter = summary.energyBefore;
  if (box.freePoints == 0 || options.tolerance == 0) {
    summary.stopReason = StopReason::nothingFree;
    summary.seconds = threadSeconds() - begin;
    return result;
  }

  const BoxEnergy<D> boxEnergy(op, box);
  const BoxLayout layout(netSizes, box.first, box.count, components, halo);
  BallOptions ballOptions;
  ballOptions.gap = options.gap;
  ballOptions.maxIterations = options.maxIterations;
  ballOptions.progress = options.progress;
  Net e = Net::Zero(input.net().rows(), components);
  BallResult ball;
  const bool unlimited = std::isinf(options.tolerance);
  {
    const ModalBasis basis(layout, boxEnergy.stiffness, boxEnergy.massFactors);
    KroneckerOperator kronecker(layout, boxEnergy.products);
    Field linear(layout), solution(layout), isFree(layout.scalar());
    packBox(layout, halfGradient, Eigen::RowVectorXd::Zero(components), linear);
    halfGradient.resize(0, 0);
    for (Index r = 0; r < layout.rows(); ++r) {
      for (Index j = 0; j < layout.size[2]; ++j) {
        isFree.row(r, 0)[j] = held[static_cast<std::size_t>(layout.netRow(r, j))] ? 0 : 1;
      }
    }
    BallProblem problem;
    problem.energy = &kronecker;
    problem.linear = &linear;
    problem.free = &isFree;
    problem.products = boxEnergy.products;
    problem.lowerBound = boxEnergy.lowerBound;
    problem.massProduct = boxEnergy.mass;
    problem.basis = &basis;
    problem.radius = options.tolerance;
    problem.scale = summary.energyBefore;
    problem.noise = noise;
    ball = unlimited ? minimizeFreely(problem, ballOptions, solution) : minimizeInBalls(problem, ballOptions, solution);
    addBox(layout, solution, e);
  }
  if (ball.stop == BallResult::Stop::unproven) {
    ball = solveByFactor(op, energy.name, energy.order(), held, op.product(input.net().rowwise() - centre), options.gap,
                         summary.energyBefore, e);
  }

  addWithin(options.tolerance, e, result.spline.net());
  for (Index r = 0; r < e.rows(); ++r) {
    if (held[static_cast<std::size_t>(r)]) continue;
    const double move = (result.spline.net().row(r) - input.net().row(r)).norm();
    summary.largestMove = std::max(summary.largestMove, move);
    if (move >= options.tolerance * (1 - 1e-9)) ++summary.activePoints;
  }
  summary.energyAfter = summary.energyBefore + ball.value;
  const double reference = std::abs(summary.energyAfter);
  summary.gap = ball.bound <= 0 ? 0 : reference > 0 ? ball.bound / reference : kUnlimited;
  summary.steps = ball.iterations;
  const bool reached = ball.stop == BallResult::Stop::gap && (summary.gap <= options.gap || ball.bound <= 0);
  summary.stopReason = reached                                     ? StopReason::gap
                       : ball.stop == BallResult::Stop::iterations ? StopReason::steps
                       : ball.stop == BallResult::Stop::cancelled  ? StopReason::cancelled
                                                                   : StopReason::precision;
  summary.seconds = threadSeconds() - begin;
  return result;
}

template Faired<1> fairOptimally<1>(const Spline<1>&, const QuadraticEnergy<1>&, const OptimalFairingOptions&);
template Faired<2> fairOptimally<2>(const Spline<2>&, const QuadraticEnergy<2>&, const OptimalFairingOptions&);
template Faired<3> fairOptimally<3>(const Spline<3>&, const QuadraticEnergy<3>&, const OptimalFairingOptions&);

}  // namespace strak
