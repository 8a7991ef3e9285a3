#pragma once
//
// Random splines for property tests: all degrees, knots of every kind, points of any dimension; the same on every
// machine.

#include <algorithm>
#include <random>

#include "strak/spline/spline.h"

namespace strak::testing {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  double uniform(double from = 0, double to = 1) {
    return from + (to - from) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  int integer(int from, int to) {
    return from + static_cast<int>(engine_() % static_cast<std::uint64_t>(to - from + 1));
  }
  bool coin() { return integer(0, 1) == 1; }

 private:
  std::mt19937_64 engine_;
};

enum class KnotKind { uniformClamped, nonUniform, repeated, discontinuous, unclamped, unclampedRepeated };
constexpr KnotKind kKnotKinds[] = {KnotKind::uniformClamped, KnotKind::nonUniform, KnotKind::repeated,
                                   KnotKind::discontinuous,  KnotKind::unclamped,  KnotKind::unclampedRepeated};

inline KnotVector randomKnots(Random& random, KnotKind kind, int degree, int spans) {
  double u = random.uniform(-2, 2);
  if (kind == KnotKind::uniformClamped) return KnotVector::uniformClamped(degree, spans, u, u + random.uniform(0.5, 3));
  const auto step = [&] { return u += random.uniform(0.1, 1); };
  const bool open = kind == KnotKind::unclamped || kind == KnotKind::unclampedRepeated;
  std::vector<double> knots;
  if (open) {
    for (int i = 0; i < degree; ++i) knots.push_back(step());
    knots.push_back(step());
  } else {
    knots.assign(static_cast<std::size_t>(degree + 1), u);
  }
  for (int s = 1; s < spans; ++s) {
    int multiplicity = 1;
    if (kind == KnotKind::repeated || kind == KnotKind::unclampedRepeated) {
      multiplicity = random.integer(1, std::max(1, degree));
    }
    if (kind == KnotKind::discontinuous) multiplicity = random.integer(1, degree + 1);
    knots.insert(knots.end(), static_cast<std::size_t>(multiplicity), step());
  }
  if (open) {
    for (int i = 0; i <= degree; ++i) knots.push_back(step());
    // Some repeated knots at and outside the ends of the domain.
    if (kind == KnotKind::unclampedRepeated && degree > 1) {
      knots[0] = knots[1];
      knots[knots.size() - 1] = knots[knots.size() - 2];
    }
  } else {
    knots.insert(knots.end(), static_cast<std::size_t>(degree + 1), step());
  }
  return {degree, std::move(knots)};
}

inline KnotVector randomKnots(Random& random, int maxDegree) {
  const auto kind = kKnotKinds[random.integer(0, 5)];
  const int degree = random.integer(0, maxDegree);
  return randomKnots(random, kind, degree, random.integer(1, 5));
}

template <int D>
Spline<D> randomSpline(Random& random, const std::array<KnotVector, static_cast<std::size_t>(D)>& knots, int dimension,
                       bool rational) {
  Index rows = 1;
  for (const auto& direction : knots) rows *= direction.size();
  Net net(rows, dimension + (rational ? 1 : 0));
  for (Index r = 0; r < rows; ++r) {
    const double weight = rational ? random.uniform(0.5, 2) : 1;
    for (int c = 0; c < dimension; ++c) net(r, c) = weight * random.uniform(-1, 1);
    if (rational) net(r, dimension) = weight;
  }
  return {knots, std::move(net), rational};
}

template <int D>
Spline<D> randomSpline(Random& random, int maxDegree, bool mayBeRational = true) {
  std::array<KnotVector, static_cast<std::size_t>(D)> knots;
  for (auto& direction : knots) direction = randomKnots(random, maxDegree);
  const int dimension = random.integer(1, 6);
  return randomSpline<D>(random, knots, dimension, mayBeRational && random.coin());
}

// A parameter of the domain: any, a knot, or an end.
inline double randomParameter(Random& random, const KnotVector& knots) {
  switch (random.integer(0, 7)) {
    case 0:
      return knots.from();
    case 1:
      return knots.to();
    case 2:
      return std::clamp(knots[random.integer(0, static_cast<int>(knots.knots().size()) - 1)], knots.from(), knots.to());
    default:
      return random.uniform(knots.from(), knots.to());
  }
}

template <int D>
typename Spline<D>::Parameter randomParameter(Random& random, const Spline<D>& spline) {
  typename Spline<D>::Parameter u;
  for (int k = 0; k < D; ++k) u[static_cast<std::size_t>(k)] = randomParameter(random, spline.knots(k));
  return u;
}

// A parameter inside a span, away from all knots: there no side has to be chosen.
inline double innerParameter(Random& random, const KnotVector& knots) {
  const auto spans = knots.spans();
  const Index span = spans[static_cast<std::size_t>(random.integer(0, static_cast<int>(spans.size()) - 1))];
  return knots[span] + random.uniform(0.1, 0.9) * (knots[span + 1] - knots[span]);
}

template <int D>
typename Spline<D>::Parameter innerParameter(Random& random, const Spline<D>& spline) {
  typename Spline<D>::Parameter u;
  for (int k = 0; k < D; ++k) u[static_cast<std::size_t>(k)] = innerParameter(random, spline.knots(k));
  return u;
}

}  // namespace strak::testing
