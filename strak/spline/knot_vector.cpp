#include "strak/spline/knot_vector.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "strak/base/error.h"

namespace strak {

KnotVector::KnotVector() : degree_(0), knots_{0, 1} {}

KnotVector::KnotVector(int degree, std::vector<double> knots, const char* name)
    : degree_(degree), knots_(std::move(knots)) {
  if (degree < 0) {
    throw InvalidInput(fmt::format("the degree of direction {} is {}: give a degree of 0 or more", name, degree));
  }
  const auto count = static_cast<Index>(knots_.size());
  if (count < 2 * (Index{degree} + 1)) {
    throw InvalidInput(
        fmt::format("direction {} has {} knots but degree {} needs at least {}: add knots or lower the degree", name,
                    count, degree, 2 * (Index{degree} + 1)));
  }
  for (Index i = 0; i < count; ++i) {
    if (!std::isfinite((*this)[i])) {
      throw InvalidInput(fmt::format("knot {} of direction {} is not a finite number: correct it", i, name));
    }
    if (i > 0 && (*this)[i] < (*this)[i - 1]) {
      throw InvalidInput(fmt::format("knot {} of direction {} is smaller than knot {} ({} < {}): sort the knots", i,
                                     name, i - 1, (*this)[i], (*this)[i - 1]));
    }
    if (i > degree && (*this)[i] == (*this)[i - degree - 1]) {
      throw InvalidInput(
          fmt::format("knot {} of direction {} stands there more than {} times, the degree plus one: "
                      "remove the surplus",
                      (*this)[i], name, degree + 1));
    }
  }
  if (!std::isfinite(knots_.back() - knots_.front())) {
    throw InvalidInput(fmt::format("the knots of direction {} reach from {} to {}, too far to subtract: rescale them",
                                   name, knots_.front(), knots_.back()));
  }
  if (!(from() < to())) {
    throw InvalidInput(
        fmt::format("the domain of direction {} is empty (from {} to {}): spread the knots", name, from(), to()));
  }
}

KnotVector KnotVector::uniformClamped(int degree, Index spans, double from, double to) {
  if (spans < 1) throw InvalidInput(fmt::format("a knot vector needs at least one span, not {}", spans));
  std::vector<double> knots;
  knots.reserve(static_cast<std::size_t>(spans + 2 * Index{degree} + 1));
  for (int i = 0; i < degree; ++i) knots.push_back(from);
  for (Index i = 0; i <= spans; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(spans);
    knots.push_back(i == spans ? to : from + t * (to - from));
  }
  for (int i = 0; i < degree; ++i) knots.push_back(to);
  return {degree, std::move(knots)};
}

Index KnotVector::findSpan(double u) const {
  const auto begin = knots_.begin() + degree_;
  const auto end = knots_.begin() + size() + 1;
  if (u >= to()) return static_cast<Index>(std::lower_bound(begin, end, to()) - knots_.begin()) - 1;
  if (!(u > from())) return static_cast<Index>(std::upper_bound(begin, end, from()) - knots_.begin()) - 1;
  return static_cast<Index>(std::upper_bound(begin, end, u) - knots_.begin()) - 1;
}

std::vector<Index> KnotVector::spans() const {
  std::vector<Index> result;
  for (Index i = degree_; i < size(); ++i) {
    if ((*this)[i] < (*this)[i + 1]) result.push_back(i);
  }
  return result;
}

int KnotVector::multiplicity(double u) const {
  const auto range = std::equal_range(knots_.begin(), knots_.end(), u);
  return static_cast<int>(range.second - range.first);
}

std::vector<KnotVector::InnerKnot> KnotVector::innerKnots() const {
  std::vector<InnerKnot> result;
  for (double u : knots_) {
    if (u <= from() || u >= to()) continue;
    if (!result.empty() && result.back().value == u) {
      ++result.back().multiplicity;
    } else {
      result.push_back({u, 1});
    }
  }
  return result;
}

std::vector<double> KnotVector::greville() const {
  std::vector<double> result(static_cast<std::size_t>(size()));
  for (Index i = 0; i < size(); ++i) {
    double sum = 0;
    if (degree_ == 0) {
      sum = ((*this)[i] + (*this)[i + 1]) / 2;
    } else {
      for (int k = 1; k <= degree_; ++k) sum += (*this)[i + k];
      sum /= degree_;
    }
    result[static_cast<std::size_t>(i)] = sum;
  }
  return result;
}

bool KnotVector::isClamped() const { return multiplicity(from()) == degree_ + 1 && multiplicity(to()) == degree_ + 1; }

KnotVector KnotVector::rescaled(double newFrom, double newTo) const {
  if (!(newFrom < newTo) || !std::isfinite(newFrom) || !std::isfinite(newTo)) {
    throw InvalidInput(
        fmt::format("cannot map knots to the domain [{}, {}]: the first bound must be smaller", newFrom, newTo));
  }
  KnotVector result = *this;
  const double factor = (newTo - newFrom) / length();
  for (double& u : result.knots_) {
    u = u == from() ? newFrom : u == to() ? newTo : newFrom + (u - from()) * factor;
  }
  return result;
}

ActiveKnots activeKnots(const KnotVector& knots, double from, double to) {
  const auto& all = knots.knots();
  const auto lastFrom = std::upper_bound(all.begin(), all.end(), from) - all.begin() - 1;
  const auto firstTo = std::lower_bound(all.begin(), all.end(), to) - all.begin();
  if (!(from < to) || from < knots.from() || to > knots.to() || lastFrom < knots.degree() || knots[lastFrom] != from ||
      firstTo > knots.size() || knots[firstTo] != to) {
    throw InvalidInput(
        fmt::format("[{}, {}] does not begin and end with knots of the domain [{}, {}]: insert them first", from, to,
                    knots.from(), knots.to()));
  }
  const auto first = lastFrom - knots.degree();
  return {{knots.degree(), {all.begin() + first, all.begin() + firstTo + knots.degree() + 1}}, first};
}

}  // namespace strak
