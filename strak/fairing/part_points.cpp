#include "strak/fairing/part_points.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "strak/spline/rational.h"

namespace strak {

namespace {

constexpr double kNothing = 1e-9;  // of a weight: a border opens by this part of a move at most
constexpr double kOwnShare = 0.5;  // a follower with at least this weight is the one that is eliminated

using Row = std::map<Index, double>;  // a combination of points

void addTo(Row& row, const Row& other, double factor) {
  for (const auto& [point, weight] : other) row[point] += factor * weight;
}

void clean(Row& row) {
  std::erase_if(row, [](const auto& term) { return std::abs(term.second) <= kNothing; });
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
    Follower follower{number(joint.b, rowsB[k]), {}};
    for (std::size_t i = 0; i < rowsA.size(); ++i) {
      double weight = joint.fit.fromA(static_cast<Index>(k), static_cast<Index>(i));
      if (weightA.size() > 0) weight *= weightA[rowsA[i]];
      if (weightB.size() > 0) weight /= weightB[rowsB[k]];
      if (std::abs(weight) > kNothing) follower.terms.emplace_back(number(joint.a, rowsA[i]), weight);
    }
    if (follower.terms.size() == 1) {
      merge(follower.point, follower.terms.front().first);
    } else {
      followers_.push_back(std::move(follower));
    }
  }
}

void PartPoints::confine(Index face, int side, const Eigen::Vector3d& normal) {
  for (Index row : borderRow(surfaces_[static_cast<std::size_t>(face)], side)) {
    confined_.emplace_back(number(face, row), normal);
  }
}

void PartPoints::hold(Index face, Index row) { held_.push_back(number(face, row)); }

PartPoints::Result PartPoints::solve() {
  std::vector<bool> fixed(parent_.size(), false);
  for (Index point : held_) fixed[static_cast<std::size_t>(root(point))] = true;
  std::set<Index> confined;
  for (const auto& [point, normal] : confined_) confined.insert(root(point));

  // Every follower is an equation: itself less what it follows is zero. One point of each is eliminated.
  std::vector<std::pair<Index, Row>> eliminated;  // the point, what it is in terms of those not eliminated before
  for (const Follower& follower : followers_) {
    Row equation;
    equation[root(follower.point)] += 1;
    for (const auto& [point, weight] : follower.terms) equation[root(point)] -= weight;
    for (const auto& [point, row] : eliminated) {
      const auto term = equation.find(point);
      if (term == equation.end()) continue;
      const double weight = term->second;
      equation.erase(term);
      addTo(equation, row, weight);
    }
    std::erase_if(equation, [&](const auto& term) { return fixed[static_cast<std::size_t>(term.first)]; });
    clean(equation);
    if (equation.empty()) continue;
    const auto own = equation.find(root(follower.point));
    Index pivot = -1;
    if (own != equation.end() && std::abs(own->second) >= kOwnShare && confined.count(own->first) == 0) {
      pivot = own->first;
    } else {
      double largest = 0;
      for (const auto& [point, weight] : equation) {
        if (confined.count(point) > 0 || std::abs(weight) <= largest) continue;
        largest = std::abs(weight);
        pivot = point;
      }
    }
    // What may move in a plane only cannot follow others; nor can it be led by a small weight.
    if (pivot < 0 || std::abs(equation[pivot]) < 1e-3) {
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
    if (follows.count(point) == 0) unknownOf.emplace(point, static_cast<int>(unknownOf.size()));
  }
  result.unknowns = static_cast<Index>(unknownOf.size());
  if (follows.empty() && confined.empty()) return result;
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
