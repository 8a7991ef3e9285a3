#include "strak/energy/parameter_scale.h"

#include <fmt/format.h>

#include <algorithm>

#include "strak/base/error.h"
#include "strak/spline/basis.h"
#include "strak/spline/evaluate.h"

namespace strak {

namespace {

constexpr double kLengthRounding = 1e-13;  // of the largest coordinate: shorter is no length
constexpr int kPointsPerSpan = 4;          // along a parameter line
constexpr int kLinePlaces = 16;            // lines per crossing direction; even, so that none lies in the middle

// Parameters and weights (with sum 1) of a Gauss rule on every span of `knots`.
struct Places {
  std::vector<double> parameters, weights;
};

void addRule(const GaussRule& rule, double from, double to, double domainLength, Places& places) {
  for (std::size_t q = 0; q < rule.nodes.size(); ++q) {
    places.parameters.push_back((from + to) / 2 + (to - from) / 2 * rule.nodes[q]);
    places.weights.push_back(rule.weights[q] / 2 * ((to - from) / domainLength));
  }
}

Places alongLine(const KnotVector& knots) {
  const GaussRule rule = gaussLegendre(kPointsPerSpan);
  Places places;
  for (Index span : knots.spans()) addRule(rule, knots[span], knots[span + 1], knots.length(), places);
  return places;
}

// A fixed number of lines however long the knot vector is: the mean changes little from line to line.
Places acrossLines(const KnotVector& knots) {
  Places places;
  addRule(gaussLegendre(kLinePlaces), knots.from(), knots.to(), knots.length(), places);
  return places;
}

// Mean length of the parameter lines of direction `k`.
template <int D>
double meanLength(const Spline<D>& spline, int k) {
  std::array<Places, D> places;
  std::array<std::vector<double>, D> parameters;
  for (int l = 0; l < D; ++l) {
    const auto d = static_cast<std::size_t>(l);
    places[d] = l == k ? alongLine(spline.knots(l)) : acrossLines(spline.knots(l));
    parameters[d] = places[d].parameters;
  }
  const Net derivatives = derivativesOnGrid<D>(spline, parameters, 1);
  const Index dimension = spline.pointDimension();
  double mean = 0;
  for (Index r = 0; r < derivatives.rows(); ++r) {
    double weight = 1;
    Index rest = r;
    for (std::size_t d = D; d-- > 0;) {
      const auto count = static_cast<Index>(parameters[d].size());
      weight *= places[d].weights[static_cast<std::size_t>(rest % count)];
      rest /= count;
    }
    mean += weight * derivatives.row(r).segment((1 + k) * dimension, dimension).stableNorm();
  }
  return mean * spline.knots(k).length();
}

}  // namespace

ParameterScale parameterScaleNamed(std::string_view name) {
  if (name == "lengths") return ParameterScale::lengths;
  if (name == "domain") return ParameterScale::domain;
  if (name == "unit") return ParameterScale::unit;
  throw InvalidInput(fmt::format("there is no parameter scale '{}': choose lengths, domain or unit", name));
}

template <int D>
std::array<KnotVector, D> scaledKnots(const Spline<D>& spline, ParameterScale scale) {
  std::array<KnotVector, D> knots = spline.knots();
  if (scale == ParameterScale::domain) return knots;
  if (scale == ParameterScale::lengths && spline.pointDimension() == 1) return knots;
  std::array<double, static_cast<std::size_t>(D)> lengths;
  lengths.fill(1);
  if (scale == ParameterScale::lengths) {
    for (int k = 0; k < D; ++k) lengths[static_cast<std::size_t>(k)] = meanLength(spline, k);
    const double longest = *std::max_element(lengths.begin(), lengths.end());
    const double rounding = kLengthRounding * spline.euclideanNet().cwiseAbs().maxCoeff();
    for (double& length : lengths) {
      if (length <= rounding) length = longest > rounding ? longest : 1;
    }
  }
  for (std::size_t k = 0; k < D; ++k) knots[k] = knots[k].rescaled(0, lengths[k]);
  return knots;
}

template std::array<KnotVector, 1> scaledKnots<1>(const Spline<1>&, ParameterScale);
template std::array<KnotVector, 2> scaledKnots<2>(const Spline<2>&, ParameterScale);
template std::array<KnotVector, 3> scaledKnots<3>(const Spline<3>&, ParameterScale);

}  // namespace strak
