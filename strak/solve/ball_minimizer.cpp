#include "strak/solve/ball_minimizer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "strak/solve/alternating_directions.h"
#include "strak/solve/kernels.h"

namespace strak {

using Eigen::Index;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// A modal factorization with a smaller pivot than this fraction of its diagonal proves nothing.
constexpr double kSingular = 1e-13;

void copyField(const Field& from, Field& to) { std::copy_n(from.data(), from.size(), to.data()); }

// How much of the mean multiplier the preconditioner is shifted by (good for nets of 200 to 500 a side).
constexpr double kShift = 0.3;

// field_r *= factors_r at every point, all components.
void scalePoints(const BoxLayout& layout, const Field& factors, Field& field) {
  for (Index r = 0; r < layout.rows(); ++r) {
    for (int c = 0; c < layout.components; ++c) {
      kernels::chosen().multiplyPointwise(field.row(r, c), factors.row(r, 0), layout.width);
    }
  }
}

// What the certificate needs at one point of the search: the multipliers and both sums over the points.
struct Multipliers {
  double frankWolfe = 0;  // bound by itself
  double slack = 0;       // sum lambda (radius^2 - |e|^2)
  double mean = 0;        // mean lambda over the points of the box
};

// h = K e + g on entry in `h`; on exit h holds r = h + Lambda e, zero at held points; lambda is a scalar field.
Multipliers multipliersOf(const BallProblem& p, const Field& diagonal, const Field& e, Field& h, Field& lambda) {
  const BoxLayout& layout = p.energy->layout();
  const int components = layout.components;
  Multipliers result;
  for (Index r = 0; r < layout.rows(); ++r) {
    const double* isFree = p.free->row(r, 0);
    const double* d = diagonal.row(r, 0);
    double* l = lambda.row(r, 0);
    for (Index j = 0; j < layout.size[2]; ++j) {
      double ee = 0, eh = 0, hh = 0;
      if (isFree[j] == 0) {
        for (int c = 0; c < components; ++c) h.row(r, c)[j] = 0;
        l[j] = 0;
        continue;
      }
      for (int c = 0; c < components; ++c) {
        const double x = e.row(r, c)[j];
        const double y = h.row(r, c)[j];
        ee += x * x;
        eh += x * y;
        hh += y * y;
      }
      result.frankWolfe += 2 * (eh + p.radius * std::sqrt(hh));
      // Active: the unconstrained target of this point, e - h / K_rr, lies outside its ball.
      const double target = ee - 2 * eh / d[j] + hh / (d[j] * d[j]);
      l[j] = eh < 0 && target > p.radius * p.radius ? -eh / ee : 0;
      if (l[j] > 0) {
        for (int c = 0; c < components; ++c) h.row(r, c)[j] += l[j] * e.row(r, c)[j];
        result.slack += l[j] * (p.radius * p.radius - ee);
        result.mean += l[j];
      }
    }
  }
  result.mean /= static_cast<double>(layout.points());
  return result;
}

// y += Lambda x
void addDiagonal(const BoxLayout& layout, const Field& lambda, const Field& x, Field& y) {
  for (Index r = 0; r < layout.rows(); ++r) {
    const double* l = lambda.row(r, 0);
    for (int c = 0; c < layout.components; ++c) {
      const double* from = x.row(r, c);
      double* to = y.row(r, c);
      for (Index j = 0; j < layout.width; ++j) to[j] += l[j] * from[j];
    }
  }
}

// Largest eigenvalue of D^-1 K on the free points, from below, by power iteration from a rough field.
double largestEigenvalue(const BallProblem& p, const Field& inverseDiagonal) {
  const BoxLayout& layout = p.energy->layout();
  Field x(layout), y(layout);
  for (Index r = 0; r < layout.rows(); ++r) {
    for (int c = 0; c < layout.components; ++c) {
      for (Index j = 0; j < layout.size[2]; ++j) {
        // Alternating signs are near the roughest eigenvector; the drift keeps all others in.
        const double sign = (r % layout.size[1] + r / layout.size[1] + j) % 2 == 0 ? 1 : -1;
        x.row(r, c)[j] = sign * (1 + 0.3 * std::sin(1.0 + 0.7 * static_cast<double>(r) + 1.3 * static_cast<double>(j)));
      }
    }
  }
  scalePoints(layout, *p.free, x);
  double eigenvalue = 1;
  for (int i = 0; i < 16; ++i) {
    p.energy->apply(x, y);
    scalePoints(layout, inverseDiagonal, y);
    const double xy = dot(x, y);
    const double xx = dot(x, x);
    const double yy = dot(y, y);
    if (!(yy > 0) || !(xx > 0)) break;
    eigenvalue = std::max(xy / xx, std::sqrt(yy / xx));
    const double factor = 1 / std::sqrt(yy);
    x.setZero();
    addScaled(x, factor, y);
  }
  return eigenvalue;
}

// The upper bound of r . (K + Lambda)^-1 r by conjugate-gradient steps y with the remainder bounded by P^-1:
// 2 r.y - y.(K + Lambda) y + s . P^-1 s, s = r - (K + Lambda) y. Stops once a remainder below `worthwhile` is expected.
double boundInverse(const BallProblem& p, ModalSolver& lower, const Multipliers& multipliers, const Field& lambda,
                    const Field& r, double worthwhile, Field& y) {
  constexpr Index kMaxSteps = 60;
  const BoxLayout& layout = p.energy->layout();
  // The mean of the multipliers, as a multiple of the mass matrix, stands for Lambda in the preconditioner.
  double massRowSum = 1;
  for (const BandMatrix* mass : p.massProduct.factors) massRowSum *= mass->band.row(mass->size / 2).sum();
  std::vector<KroneckerProduct> shifted = p.products;
  shifted.push_back(p.massProduct);
  shifted.back().coefficient = kShift * multipliers.mean / massRowSum;
  ModalSolver preconditioner(layout, shifted, *p.basis);

  Field s(layout), z(layout), direction(layout), image(layout);
  y.setZero();
  copyField(r, s);
  preconditioner.solve(s, z);
  scalePoints(layout, *p.free, z);
  copyField(z, direction);
  double sz = dot(s, z);
  for (Index i = 0; i < kMaxSteps && sz >= worthwhile; ++i) {
    p.energy->apply(direction, image);
    addDiagonal(layout, lambda, direction, image);
    scalePoints(layout, *p.free, image);
    const double curvature = dot(direction, image);
    if (!(curvature > 0)) break;
    addScaled(y, sz / curvature, direction);
    addScaled(s, -sz / curvature, image);
    preconditioner.solve(s, z);
    scalePoints(layout, *p.free, z);
    const double next = dot(s, z);
    scaleAndAdd(direction, next / sz, z);
    sz = next;
  }
  lower.solve(s, z);
  // y . (K + Lambda) y = y . (r - s)
  return dot(r, y) + dot(y, s) + dot(s, z);
}

BallResult finish(BallResult result, double value, double bound, Index iterations, BallResult::Stop stop) {
  result.value = value;
  result.bound = std::max(bound, 0.0);
  result.iterations = iterations;
  result.stop = stop;
  return result;
}

// How far the search is on a logarithmic scale from the first bound to the wished one.
double fractionDone(double first, double now, double wished) {
  if (!(first > wished) || !(now > 0) || !std::isfinite(first)) return now <= wished ? 1 : 0;
  return std::clamp(std::log(first / now) / std::log(first / wished), 0.0, 1.0);
}

}  // namespace

BallResult minimizeFreely(const BallProblem& p, const BallOptions& options, Field& e) {
  const BoxLayout& layout = p.energy->layout();
  if (p.lowerBound.empty()) return finish({}, 0, kInfinity, 0, BallResult::Stop::unproven);
  ModalSolver lower(layout, p.lowerBound, *p.basis);
  if (lower.conditionIndicator() < kSingular) return finish({}, 0, kInfinity, 0, BallResult::Stop::unproven);
  ModalSolver preconditioner(layout, p.products, *p.basis);
  Field r(layout), z(layout), direction(layout), image(layout);
  e.setZero();
  addScaled(r, -1, *p.linear);
  scalePoints(layout, *p.free, r);
  double best = kInfinity;
  double first = 0;
  Index stalled = 0;
  double rz = 0;
  for (Index i = 0;; ++i) {
    preconditioner.solve(r, z);
    scalePoints(layout, *p.free, z);
    const double next = dot(r, z);
    const double value = dot(*p.linear, e) - dot(e, r);
    // A step gains about a decade: go on to nine digits even where fewer would do.
    const double wished = std::max(std::min(options.gap, 1e-9) * std::abs(p.scale + value), p.noise);
    if (i == 0) first = next;
    // r.z is an estimate of the bound that costs nothing; the proof is worth its solve only near the end.
    if (next <= wished || stalled > 3 || i >= options.maxIterations) {
      lower.solve(r, image);
      const double bound = dot(r, image);
      if (bound <= wished) return finish({}, value, bound, i, BallResult::Stop::gap);
      if (i >= options.maxIterations) return finish({}, value, bound, i, BallResult::Stop::iterations);
      if (stalled > 3) return finish({}, value, bound, i, BallResult::Stop::precision);
    }
    if (!options.progress.report(fractionDone(first, next, wished), "solving")) {
      lower.solve(r, image);
      return finish({}, value, dot(r, image), i, BallResult::Stop::cancelled);
    }
    stalled = next < 0.5 * best ? 0 : stalled + (i > 30 ? 1 : 0);
    best = std::min(best, next);
    if (i == 0) {
      copyField(z, direction);
    } else {
      scaleAndAdd(direction, next / rz, z);
    }
    rz = next;
    p.energy->apply(direction, image);
    scalePoints(layout, *p.free, image);
    const double curvature = dot(direction, image);
    if (!(curvature > 0)) return finish({}, value, rz, i, BallResult::Stop::precision);
    addScaled(e, rz / curvature, direction);
    addScaled(r, -rz / curvature, image);
  }
}

namespace {

// Accelerated projected gradients from e = 0.
BallResult minimizeByProjectedGradients(const BallProblem& p, const BallOptions& options, Field& e) {
  const BoxLayout& layout = p.energy->layout();
  const auto& k = kernels::chosen();
  const Field diagonal = p.energy->diagonal();
  Field step(layout.scalar());  // 1 / K_rr at free points, later over the step length
  for (Index r = 0; r < layout.rows(); ++r) {
    for (Index j = 0; j < layout.size[2]; ++j) {
      step.row(r, 0)[j] = p.free->row(r, 0)[j] > 0 ? 1 / diagonal.row(r, 0)[j] : 0;
    }
  }
  const double lipschitz = 1.03 * largestEigenvalue(p, step);
  const auto scaleStep = [&](double factor) {
    for (Index r = 0; r < layout.rows(); ++r) {
      for (Index j = 0; j < layout.size[2]; ++j) step.row(r, 0)[j] *= factor;
    }
  };
  scaleStep(1 / lipschitz);

  std::optional<ModalSolver> lower;
  if (!p.lowerBound.empty()) {
    lower.emplace(layout, p.lowerBound, *p.basis);
    if (lower->conditionIndicator() < kSingular) lower.reset();
  }
  Field xOld(layout), kx(layout), kxOld(layout), r(layout), lambda(layout.scalar());
  Field scratch(layout);
  Field& x = e;
  x.setZero();

  double t = 1;
  double lowest = 0;               // value at the last check
  double lowerValue = -kInfinity;  // best proven lower bound of min q so far
  double first = 0;
  Index stalled = 0;
  double bestBound = kInfinity;
  // Checking the plain bounds costs two multiplications with the eigenbasis: rare on big boxes.
  double massRowSum = 1;
  for (const BandMatrix* mass : p.massProduct.factors) massRowSum *= mass->band.row(mass->size / 2).sum();
  const Index checkEvery = layout.size[2] > 150 ? 50 : 10;
  Index nextSharp = 100;
  for (Index i = 0;; ++i) {
    if (i % checkEvery == 0 || i >= options.maxIterations) {
      const double value = dot(x, kx) + 2 * dot(x, *p.linear);
      if (value > lowest + 1e-13 * p.scale) {  // the step was too long after all: shorten it and lose the momentum
        scaleStep(1 / 1.3);
        t = 1;
      }
      lowest = value;
      copyField(kx, r);
      addScaled(r, 1, *p.linear);
      const Multipliers m = multipliersOf(p, diagonal, x, r, lambda);
      lowerValue = std::max(lowerValue, value - m.frankWolfe);
      const double wished = std::max(options.gap * std::abs(p.scale + value), p.noise);
      if (lower && value - lowerValue > wished) {
        lower->solve(r, scratch);
        lowerValue = std::max(lowerValue, value - m.slack - dot(r, scratch));
        if (i >= nextSharp && value - lowerValue > wished) {
          lowerValue =
              std::max(lowerValue, value - m.slack - boundInverse(p, *lower, m, lambda, r, 0.1 * wished, scratch));
          nextSharp = i + std::max(checkEvery, i / 4);
        }
      }
      const double bound = value - lowerValue;
      if (i == 0) first = bound;
      if (bound <= wished) return finish({}, value, bound, i, BallResult::Stop::gap);
      if (i >= options.maxIterations) return finish({}, value, bound, i, BallResult::Stop::iterations);
      if (!options.progress.report(fractionDone(first, bound, wished), "solving")) {
        return finish({}, value, bound, i, BallResult::Stop::cancelled);
      }
      stalled = bound < 0.9 * bestBound ? 0 : stalled + 1;
      bestBound = std::min(bestBound, bound);
      if (stalled > 200) return finish({}, value, bound, i, BallResult::Stop::precision);
    }
    const double tNext = (1 + std::sqrt(1 + 4 * t * t)) / 2;
    const double momentum = (t - 1) / tNext;
    double restart = 0;
    for (Index row = 0; row < layout.rows(); ++row) {
      k.projectedStep(layout.components, layout.stride, layout.width, x.row(row, 0), xOld.row(row, 0), kx.row(row, 0),
                      kxOld.row(row, 0), p.linear->row(row, 0), step.row(row, 0), momentum, p.radius, &restart);
    }
    std::swap(x, xOld);
    std::swap(kx, kxOld);
    p.energy->apply(x, kx);
    t = restart > 0 ? 1 : tNext;
  }
}

}  // namespace

BallResult minimizeInBalls(const BallProblem& p, const BallOptions& options, Field& e) {
  // Most nets are certified by then; the others are stiff and better served by a factor if they are small enough.
  constexpr Index kPatience = 2500;
  if (p.energy->layout().points() > kMaxFactoredPoints) return minimizeByProjectedGradients(p, options, e);
  BallOptions first = options;
  first.maxIterations = std::min(options.maxIterations, kPatience);
  BallResult result = minimizeByProjectedGradients(p, first, e);
  if (result.stop == BallResult::Stop::gap || result.stop == BallResult::Stop::cancelled ||
      result.iterations >= options.maxIterations) {
    return result;
  }
  BallOptions second = options;
  second.maxIterations = options.maxIterations - result.iterations;
  const double lowerValue = result.value - result.bound;
  const Index before = result.iterations;
  result = minimizeByAlternatingDirections(p, second, e);
  result.iterations += before;
  result.bound = std::min(result.bound, std::max(result.value - lowerValue, 0.0));
  return result;
}

BallResult boundAt(const BallProblem& p, const Field& e) {
  const BoxLayout& layout = p.energy->layout();
  Field h(layout), solution(layout), lambda(layout.scalar());
  p.energy->apply(e, h);
  const double value = dot(e, h) + 2 * dot(e, *p.linear);
  addScaled(h, 1, *p.linear);
  double bound = kInfinity;
  double slack = 0;
  if (std::isfinite(p.radius)) {
    const Multipliers m = multipliersOf(p, p.energy->diagonal(), e, h, lambda);
    bound = m.frankWolfe;
    slack = m.slack;
  } else {
    scalePoints(layout, *p.free, h);
  }
  if (!p.lowerBound.empty()) {
    ModalSolver lower(layout, p.lowerBound, *p.basis);
    if (lower.conditionIndicator() >= kSingular) {
      lower.solve(h, solution);
      bound = std::min(bound, slack + dot(h, solution));
    }
  }
  return finish({}, value, bound, 0, BallResult::Stop::gap);
}

}  // namespace strak
