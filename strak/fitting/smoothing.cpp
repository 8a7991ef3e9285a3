#include "strak/fitting/smoothing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "strak/base/error.h"

namespace strak {

using Eigen::Index;

namespace {

constexpr double kDecade = 2.302585092994046;
constexpr double kStep = kDecade;       // of the first look at the whole range, in log lambda
constexpr int kHalvings = 3;            // of that step, around the best
constexpr double kDerivative = 0.2;     // step of the difference for the freedom of a given weight
constexpr std::size_t kNeighbours = 6;  // samples that the derivative of log det M is taken from
constexpr int kBisections = 30;
constexpr double kNoiseAccuracy = 1e-3;  // of the logarithm of lambda
constexpr double kSoftest = 1e-6;        // of the ratio of data and energy, by their traces
// Fits with hardly any freedom left to the errors say nothing about them.
constexpr double kLeastFreeShare = 0.02;

// The derivative at x of the polynomial through the given points.
double slopeAt(double x, const std::vector<std::pair<double, double>>& points) {
  double slope = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    double term = 0, denominator = 1;
    for (std::size_t m = 0; m < points.size(); ++m) {
      if (m == i) continue;
      denominator *= points[i].first - points[m].first;
      double product = 1;
      for (std::size_t l = 0; l < points.size(); ++l) {
        if (l != i && l != m) product *= x - points[l].first;
      }
      term += product;
    }
    slope += points[i].second * term / denominator;
  }
  return slope;
}

// The fits along the weights, each made once.
class Path {
 public:
  Path(const SmoothingProblem& problem, Smoothing::Choice choice, NetCholesky& solver)
      : problem_(problem), choice_(choice), solver_(solver) {
    stiffness_ = problem.energy.times(problem.reference);
    free_ = static_cast<double>(problem.data.size());
    for (const char held : problem.held) free_ -= held != 0 ? 1 : 0;
  }

  int factorizations() const { return factorizations_; }

  // Factors at log lambda = x; false if that is not possible.
  bool sample(double x) {
    if (samples_.count(x) != 0) return samples_[x].valid;
    Sample& s = samples_[x];
    s.valid = factorAt(std::exp(x));
    if (!s.valid) return false;
    s.logDeterminant = solver_.logDeterminant();
    NetVectors e;
    s.meanSquare = solve(std::exp(x), e);
    if (choice_ == Smoothing::Choice::restrictedLikelihood) s.energy = energyOf(problem_.reference + e);
    return true;
  }

  double freedom(double x) const {
    std::vector<std::pair<double, double>> near;
    for (const auto& [at, s] : samples_) {
      if (s.valid) near.emplace_back(at, s.logDeterminant);
    }
    const std::size_t count = std::min(kNeighbours, near.size());
    std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end(),
                      [&](const auto& a, const auto& b) { return std::abs(a.first - x) < std::abs(b.first - x); });
    near.resize(count);
    return std::clamp(free_ - slopeAt(x, near), 0.0, free_);
  }

  double freeShare(double x) const { return 1 - freedom(x) / problem_.points; }
  double meanSquare(double x) const { return samples_.at(x).meanSquare; }

  double crossValidation(double x) const {
    const double share = freeShare(x);
    if (share < kLeastFreeShare) return std::numeric_limits<double>::infinity();
    return meanSquare(x) / (share * share);
  }

  // What the chosen weight makes least.
  double criterion(double x) const {
    return choice_ == Smoothing::Choice::restrictedLikelihood ? likelihood(x) : crossValidation(x);
  }

  // -2 log of the restricted likelihood, a coordinate, but for constants. Where the weight is largest the fit is all
  // but what the energy does not see: its freedom there is m, its energy that which held points leave at the least.
  double likelihood(double x) const {
    const double stiffest = valid().back();
    const double unseen = std::round(freedom(stiffest));
    const Sample& s = samples_.at(x);
    const double least = problem_.held.empty() ? 0 : samples_.at(stiffest).energy;
    const double penalised = s.meanSquare + std::exp(x) * std::max(s.energy - least, 0.0);
    return (problem_.points - unseen) * std::log(std::max(penalised, 1e-300)) + s.logDeterminant - (free_ - unseen) * x;
  }

  std::vector<double> valid() const {
    std::vector<double> result;
    for (const auto& [x, s] : samples_) {
      if (s.valid) result.push_back(x);
    }
    return result;
  }

  Smoothed result(double lambda, double freedom) {
    Smoothed r;
    r.lambda = lambda;
    if (!factorAt(lambda)) {
      throw InvalidInput(
          fmt::format("the points do not determine all {} control points with the smoothing weight {:g}: give a larger "
                      "weight or fewer control points",
                      problem_.data.size(), lambda));
    }
    NetVectors e;
    r.meanSquare = solve(lambda, e);
    r.net = problem_.reference + e;
    r.energy = energyOf(r.net);
    r.freedom = freedom;
    const double share = std::max(1 - freedom / problem_.points, 0.0);
    r.crossValidation = share > 0 ? r.meanSquare / (share * share) : std::numeric_limits<double>::infinity();
    r.factorizations = factorizations_;
    return r;
  }

 private:
  struct Sample {
    bool valid = false;
    double logDeterminant = 0, meanSquare = 0;
    double energy = 0;  // for the likelihood only
  };

  double energyOf(const NetVectors& net) const { return net.cwiseProduct(problem_.energy.times(net)).sum(); }

  bool factorAt(double lambda) {
    ++factorizations_;
    return solver_.factor(combined(problem_.data, lambda, problem_.energy), problem_.held);
  }

  double solve(double lambda, NetVectors& e) const {
    e = solver_.solve(problem_.right - lambda * stiffness_);
    const double change = e.cwiseProduct(problem_.data.times(e) - 2 * problem_.right).sum();
    return std::max(problem_.meanSquare + change, 0.0);
  }

  const SmoothingProblem& problem_;
  Smoothing::Choice choice_;
  NetCholesky& solver_;
  NetVectors stiffness_;  // K d0
  double free_ = 0;
  std::map<double, Sample> samples_;
  int factorizations_ = 0;
};

// Where the criterion is least among the samples.
double bestOf(const Path& path) {
  const auto all = path.valid();
  double best = all.back(), least = std::numeric_limits<double>::infinity();
  for (double x : all) {
    const double value = path.criterion(x);
    if (value <= least) {
      least = value;
      best = x;
    }
  }
  return best;
}

double chosenByCriterion(Path& path) {
  double step = kStep;
  for (int i = 0; i < kHalvings; ++i) {
    step /= 2;
    const double best = bestOf(path);
    path.sample(best - step);
    path.sample(best + step);
  }
  const double best = bestOf(path);
  // The vertex of the parabola through the best and its neighbours.
  const auto all = path.valid();
  const auto place = std::find(all.begin(), all.end(), best);
  if (place == all.begin() || place + 1 == all.end()) return best;
  const double a = *(place - 1), b = *(place + 1);
  const double fa = path.criterion(a), f = path.criterion(best), fb = path.criterion(b);
  if (!std::isfinite(fa) || !std::isfinite(fb) || !(fa + fb > 2 * f)) return best;
  const double left = (f - fa) / (best - a), right = (fb - f) / (b - best);
  if (!(right > left)) return best;
  return std::clamp((a + best) / 2 - left * (b - a) / 2 / (right - left), a, b);
}

// The weight that leaves errors of the given mean square, or the nearest there is. The errors grow with the weight.
double chosenByNoise(Path& path, double meanSquare, bool& reached) {
  const auto all = path.valid();
  reached = path.meanSquare(all.front()) <= meanSquare && path.meanSquare(all.back()) >= meanSquare;
  if (path.meanSquare(all.front()) >= meanSquare) return all.front();
  if (path.meanSquare(all.back()) <= meanSquare) return all.back();
  const auto above =
      std::partition_point(all.begin(), all.end(), [&](double x) { return path.meanSquare(x) <= meanSquare; });
  double low = *(above - 1), high = *above;
  for (int i = 0; i < kBisections && high - low > kNoiseAccuracy; ++i) {
    // In log-log scales the curve is nearly straight; halves now and then, so that no end stays for ever.
    const double fl = std::log(std::max(path.meanSquare(low), 1e-300) / meanSquare);
    const double fh = std::log(path.meanSquare(high) / meanSquare);
    const double share = i % 3 == 2 || !(fh > fl) ? 0.5 : std::clamp(-fl / (fh - fl), 0.02, 0.98);
    const double x = std::lerp(low, high, share);
    if (!path.sample(x)) return high;
    (path.meanSquare(x) <= meanSquare ? low : high) = x;
  }
  return (low + high) / 2;
}

}  // namespace

double softestSmoothing(const NetMatrix& data, const NetMatrix& energy) {
  const double stiffness = energy.trace();
  return stiffness > 0 ? std::min(kSoftest * data.trace() / stiffness, kStiffestSmoothing) : 0;
}

Smoothed smooth(const SmoothingProblem& problem, const Smoothing& smoothing, NetCholesky& solver) {
  if (!(smoothing.value >= 0) || !std::isfinite(smoothing.value)) {
    throw InvalidInput(fmt::format("the {} ({}) must be a finite number that is not negative",
                                   smoothing.choice == Smoothing::Choice::noise ? "noise" : "smoothing weight",
                                   smoothing.value));
  }
  Path path(problem, smoothing.choice, solver);
  if (smoothing.choice == Smoothing::Choice::fixed) {
    if (smoothing.value == 0) {
      double free = static_cast<double>(problem.data.size());
      for (const char held : problem.held) free -= held != 0 ? 1 : 0;
      return path.result(0, free);
    }
    const double x = std::log(smoothing.value);
    path.sample(x - kDerivative);
    path.sample(x + kDerivative);
    const bool both = path.valid().size() == 2;
    return path.result(smoothing.value, both ? path.freedom(x) : 0);
  }
  const double softest = softestSmoothing(problem.data, problem.energy);
  if (!(softest > 0)) {
    throw InvalidInput("the energy is zero for every control point: choose another one or the smoothing weight 0");
  }
  const double top = std::log(kStiffestSmoothing), bottom = std::log(softest);
  for (double x = top; x > bottom - kStep; x -= kStep) path.sample(x);
  if (path.valid().empty()) {
    throw InvalidInput(
        "no smoothing weight makes the fit unique: the degree may be too high, or the energy ignores "
        "more than they determine");
  }
  bool reached = true;
  const double x =
      smoothing.choice == Smoothing::Choice::noise
          ? chosenByNoise(path, smoothing.value * smoothing.value * static_cast<double>(problem.reference.cols()),
                          reached)
          : chosenByCriterion(path);
  path.sample(x);
  Smoothed result = path.result(std::exp(x), path.freedom(x));
  result.reached = reached;
  return result;
}

}  // namespace strak
