#include "strak/fairing/part_points.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "strak/spline/basis.h"
#include "strak/spline/rational.h"

namespace strak {

namespace {

constexpr double kNothing = 1e-9;     // of a weight: a border opens by this part of a move at most
constexpr double kOwnShare = 0.3;     // of the largest weight: with this much a follower is the one eliminated
constexpr double kLeastShare = 1e-3;  // the same for anything: what has less cannot be told from the others

void addTo(std::map<Index, double>& row, const std::map<Index, double>& other, double factor) {
  for (const auto& [point, weight] : other) row[point] += factor * weight;
}

void clean(std::map<Index, double>& row, double scale = 1) {
  std::erase_if(row, [scale](const auto& term) { return std::abs(term.second) <= kNothing * scale; });
}

}  // namespace

PartPoints::PartPoints(const std::vector<Surface>& surfaces, double sameCorner) : surfaces_(surfaces) {
  Index count = 0;
  for (const Surface& surface : surfaces) {
    first_.push_back(count);
    count += surface.net().rows();
  }
  parent_.resize(static_cast<std::size_t>(count));
  std::iota(parent_.begin(), parent_.end(), Index{0});
  struct Corner {
    Eigen::RowVector3d place;
    Index number;
  };
  std::vector<Corner> corners;
  for (std::size_t f = 0; f < surfaces.size(); ++f) {
    const Surface& s = surfaces[f];
    const Net points = s.euclideanNet();
    for (Index i : {Index{0}, s.size(0) - 1}) {
      for (Index j : {Index{0}, s.size(1) - 1}) {
        corners.push_back({points.row(s.row({i, j})), number(static_cast<Index>(f), s.row({i, j}))});
      }
    }
  }
  std::sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) {
    return a.place[0] < b.place[0] || (a.place[0] == b.place[0] && a.number < b.number);
  });
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (std::size_t j = i + 1; j < corners.size() && corners[j].place[0] - corners[i].place[0] <= sameCorner; ++j) {
      if ((corners[j].place - corners[i].place).norm() <= sameCorner) merge(corners[i].number, corners[j].number);
    }
  }
}

Index PartPoints::root(Index i) {
  while (parent_[static_cast<std::size_t>(i)] != i) {
    auto& up = parent_[static_cast<std::size_t>(i)];
    up = parent_[static_cast<std::size_t>(up)];
    i = up;
  }
  return i;
}

void PartPoints::merge(Index a, Index b) {
  parent_[static_cast<std::size_t>(std::max(root(a), root(b)))] = std::min(root(a), root(b));
}

void PartPoints::join(const Joint& joint) {
  const Surface &a = surfaces_[static_cast<std::size_t>(joint.a)], &b = surfaces_[static_cast<std::size_t>(joint.b)];
  const auto rowsA = borderRow(a, joint.sideA), rowsB = borderRow(b, joint.sideB);
  if (!joint.part) {
    for (std::size_t k = 0; k < rowsA.size(); ++k) {
      merge(number(joint.a, rowsA[k]), number(joint.b, rowsB[static_cast<std::size_t>(joint.fit.partner[k])]));
    }
    return;
  }
  Eigen::VectorXd weightA, weightB;
  if (a.isRational()) weightA = weights(a);
  if (b.isRational()) weightB = weights(b);
  for (std::size_t k = 0; k < rowsB.size(); ++k) {
    Equation equation{number(joint.b, rowsB[k]), {}};
    for (std::size_t i = 0; i < rowsA.size(); ++i) {
      double weight = joint.fit.fromA(static_cast<Index>(k), static_cast<Index>(i));
      if (weightA.size() > 0) weight *= weightA[rowsA[i]];
      if (weightB.size() > 0) weight /= weightB[rowsB[k]];
      if (std::abs(weight) > kNothing) equation.terms.emplace_back(number(joint.a, rowsA[i]), -weight);
    }
    if (equation.terms.size() == 1) {
      merge(equation.follower, equation.terms.front().first);
    } else {
      equation.terms.emplace_back(equation.follower, 1);
      equations_.push_back(std::move(equation));
    }
  }
}

void PartPoints::smoothSeam(Index face, int direction, int order) {
  const Surface& surface = surfaces_[static_cast<std::size_t>(face)];
  const KnotVector& knots = surface.knots(direction);
  const std::vector<Index> spans = knots.spans();
  const auto low = basisDerivatives(knots, spans.front(), knots.from(), order);
  const auto high = basisDerivatives(knots, spans.back(), knots.to(), order);
  Eigen::VectorXd weight;
  if (surface.isRational()) weight = weights(surface);
  const Index p = knots.degree();
  for (int k = 1; k <= order; ++k) {
    for (Index j = 0; j < surface.size(1 - direction); ++j) {
      const auto rowOf = [&](int side, Index depth) {
        return borderRow(surface, 2 * direction + side, depth)[static_cast<std::size_t>(j)];
      };
      Equation equation{number(face, rowOf(1, k)), {}};
      for (Index depth = 0; depth <= k; ++depth) {
        const Index a = rowOf(0, depth), b = rowOf(1, depth);
        equation.terms.emplace_back(number(face, a), low(k, depth) * (weight.size() > 0 ? weight[a] : 1));
        equation.terms.emplace_back(number(face, b), -high(k, p - depth) * (weight.size() > 0 ? weight[b] : 1));
      }
      equations_.push_back(std::move(equation));
    }
  }
}

void PartPoints::confine(Index face, int side, const Eigen::Vector3d& normal) {
  for (Index row : borderRow(surfaces_[static_cast<std::size_t>(face)], side)) {
    confined_.emplace_back(number(face, row), normal);
  }
}

void PartPoints::keepPerpendicular(Index face, int side, const Eigen::Vector3d& normal) {
  const Surface& surface = surfaces_[static_cast<std::size_t>(face)];
  const auto border = borderRow(surface, side), behind = borderRow(surface, side, 1);
  for (std::size_t k = 0; k < border.size(); ++k) {
    beside_.push_back({number(face, border[k]), number(face, behind[k]), normal});
  }
}

// A point behind the border is the border's plus one of its own, which moves along the normal and is no control point.
void PartPoints::addBeside() {
  std::set<Index> confined, done;
  for (const auto& [point, normal] : confined_) confined.insert(root(point));
  for (const Beside& pair : beside_) {
    if (confined.count(root(pair.behind)) > 0 || !done.insert(root(pair.behind)).second) continue;
    const auto own = static_cast<Index>(parent_.size());
    parent_.push_back(own);
    const Eigen::Vector3d one = pair.normal.unitOrthogonal();
    confined_.emplace_back(own, one);
    confined_.emplace_back(own, pair.normal.cross(one));
    equations_.push_back({pair.behind, {{pair.behind, 1}, {pair.border, -1}, {own, -1}}});
  }
  beside_.clear();
}

void PartPoints::hold(Index face, Index row) { held_.push_back(number(face, row)); }

// What follows, in terms of what does not; nothing for what thereby cannot move.
std::map<Index, PartPoints::Row> PartPoints::eliminate(const std::vector<bool>& fixed) {
  std::set<Index> confined;
  for (const auto& [point, normal] : confined_) confined.insert(root(point));

  std::vector<std::pair<Index, Row>> eliminated;  // the point, what it is in terms of those not eliminated before
  for (const Equation& given : equations_) {
    Row equation;
    for (const auto& [point, weight] : given.terms) equation[root(point)] += weight;
    for (const auto& [point, row] : eliminated) {
      const auto term = equation.find(point);
      if (term == equation.end()) continue;
      const double weight = term->second;
      equation.erase(term);
      addTo(equation, row, weight);
    }
    std::erase_if(equation, [&](const auto& term) { return fixed[static_cast<std::size_t>(term.first)]; });
    const double scale = std::max_element(given.terms.begin(), given.terms.end(), [](const auto& x, const auto& y) {
                           return std::abs(x.second) < std::abs(y.second);
                         })->second;
    clean(equation, std::abs(scale));
    if (equation.empty()) continue;
    Index pivot = -1;
    double largest = 0;
    for (const auto& [point, weight] : equation) {
      if (confined.count(point) > 0 || std::abs(weight) <= largest) continue;
      largest = std::abs(weight);
      pivot = point;
    }
    const auto own = equation.find(root(given.follower));
    const bool mayOwn = own != equation.end() && confined.count(own->first) == 0;
    if (mayOwn && std::abs(own->second) >= kOwnShare * largest) pivot = own->first;
    // What may move in a plane only cannot follow others; nor can anything by a small weight.
    if (pivot < 0 || largest < kLeastShare * std::abs(scale)) {
      for (const auto& [point, weight] : equation) eliminated.emplace_back(point, Row{});
      continue;
    }
    Row row;
    for (const auto& [point, weight] : equation) {
      if (point != pivot) row[point] = -weight / equation[pivot];
    }
    eliminated.emplace_back(pivot, std::move(row));
  }
  std::map<Index, Row> follows;
  for (auto e = eliminated.rbegin(); e != eliminated.rend(); ++e) {
    Row full;
    for (const auto& [point, weight] : e->second) {
      const auto later = follows.find(point);
      if (later == follows.end()) {
        full[point] += weight;
      } else {
        addTo(full, later->second, weight);
      }
    }
    clean(full);
    follows[e->first] = std::move(full);
  }
  return follows;
}

PartPoints::Result PartPoints::solve() {
  addBeside();
  std::vector<bool> fixed(parent_.size(), false);
  for (Index point : held_) fixed[static_cast<std::size_t>(root(point))] = true;
  const std::map<Index, Row> follows = eliminate(fixed);
  Result result;
  std::map<Index, int> numbers;  // of points that move
  std::vector<Index> points;     // their roots
  for (std::size_t f = 0; f < surfaces_.size(); ++f) {
    const Index rows = surfaces_[f].net().rows();
    auto& pointOf = result.pointOf.emplace_back(static_cast<std::size_t>(rows), -1);
    for (Index r = 0; r < rows; ++r) {
      const Index point = root(number(static_cast<Index>(f), r));
      if (fixed[static_cast<std::size_t>(point)]) continue;
      const auto rule = follows.find(point);
      if (rule != follows.end() && rule->second.empty()) continue;
      const auto [at, fresh] = numbers.emplace(point, static_cast<int>(points.size()));
      if (fresh) points.push_back(point);
      pointOf[static_cast<std::size_t>(r)] = at->second;
    }
  }
  std::map<Index, int> unknownOf;
  for (Index point : points) {
    const auto rule = follows.find(point);
    if (rule == follows.end()) {
      unknownOf.emplace(point, static_cast<int>(unknownOf.size()));
      continue;
    }
    for (const auto& [other, weight] : rule->second) unknownOf.emplace(other, static_cast<int>(unknownOf.size()));
  }
  result.unknowns = static_cast<Index>(unknownOf.size());
  if (follows.empty() && confined_.empty()) return result;
  std::vector<std::vector<TiedPoints::Term>> terms;
  for (Index point : points) {
    auto& own = terms.emplace_back();
    const auto rule = follows.find(point);
    if (rule == follows.end()) {
      own.push_back({unknownOf.at(point), 1});
      continue;
    }
    for (const auto& [other, weight] : rule->second) own.push_back({unknownOf.at(other), weight});
  }
  TiedPoints tied(result.unknowns, std::move(terms));
  for (const auto& [point, normal] : confined_) {
    const auto unknown = unknownOf.find(root(point));
    if (unknown != unknownOf.end()) tied.confine(unknown->second, normal);
  }
  result.tied = std::make_shared<const TiedPoints>(std::move(tied));
  return result;
}

}  // namespace strak
