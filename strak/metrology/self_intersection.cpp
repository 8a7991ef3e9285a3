#include "strak/metrology/self_intersection.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "strak/base/error.h"
#include "strak/metrology/bezier_cells.h"
#include "strak/metrology/meeting_pair.h"

namespace strak {

namespace {

constexpr double kLeastAngle = 1e-6;    // squared sine between the middle tangents
constexpr Index kNear = 4;              // times the cells of two nodes: what is looked at around them
constexpr double kLeastPart = 1e-9;     // of a cell: where rounding makes a part empty
constexpr std::size_t kLastTries = 64;  // pairs that neither way decides and Newton's method is tried on anyway

using Vector = PointBox::Vector;

// (S_u du + S_v dv) . (a du + b dv) > 0 in every piece, with the dual basis of the middle tangents, made unit, as a and
// b: a form of du and dv with a positive diagonal and determinant.
bool areInjective(const std::vector<TangentBoxes<1>>& pieces) {
  PointBox all;
  for (const auto& piece : pieces) all.add(piece[0]);
  const Vector a = all.middle();
  return std::all_of(pieces.begin(), pieces.end(),
                     [&](const auto& t) { return (a * t[0].middle()).sum() > (a.abs() * t[0].half()).sum(); });
}
bool areInjective(const std::vector<TangentBoxes<2>>& pieces) {
  TangentBoxes<2> all;
  for (const auto& piece : pieces) {
    all[0].add(piece[0]);
    all[1].add(piece[1]);
  }
  const double lu = all[0].middle().matrix().norm(), lv = all[1].middle().matrix().norm();
  if (!(lu > 0 && lv > 0)) return false;
  const Vector u = all[0].middle() / lu, v = all[1].middle() / lv;
  const double cosine = (u * v).sum(), det = 1 - cosine * cosine;
  if (!(det > kLeastAngle)) return false;
  const Vector a = (u - cosine * v) / det, b = (v - cosine * u) / det;
  return std::all_of(pieces.begin(), pieces.end(), [&](const auto& t) {
    const Vector tu = t[0].middle() / lu, tv = t[1].middle() / lv, hu = t[0].half() / lu, hv = t[1].half() / lv;
    const double uu = (a * tu).sum() - (a.abs() * hu).sum(), vv = (b * tv).sum() - (b.abs() * hv).sum();
    const double uv = std::abs((b * tu + a * tv).sum()) + (b.abs() * hu + a.abs() * hv).sum();
    return uu > 0 && vv > 0 && uv * uv < 4 * uu * vv;
  });
}

template <int D>
class SelfSearch {
 public:
  SelfSearch(const Spline<D>& spline, const SelfIntersectionOptions<D>& options);
  SelfIntersection<D> run();

 private:
  using Parameters = std::array<double, D>;
  using Cell = std::array<Index, D>;

  // A block of knot cells, or a part of one cell.
  struct Node {
    Cell first{}, end{};
    Parameters from{}, to{};
    std::array<int, D> halvings{};
    PointBox box;
    HomogeneousPoints own;  // of parts of cells
    int child = -1;         // the first of two
    bool changed = true;

    bool isCell() const {
      for (std::size_t k = 0; k < D; ++k) {
        if (end[k] - first[k] > 1) return false;
      }
      return true;
    }
    Parameters middle() const {
      Parameters m;
      for (std::size_t k = 0; k < D; ++k) m[k] = std::midpoint(from[k], to[k]);
      return m;
    }
  };
  struct Pair {
    int a, b;
  };
  enum class Verdict { apart, split, meet, undecided };
  struct Outcome {
    Verdict verdict = Verdict::apart;
    std::optional<MeetingPair<D>> meeting;
  };

  void findChanges(const Spline<D>& spline, const Spline<D>& other);
  const HomogeneousPoints& pointsOf(const Node& node) const {
    return node.own.rows() ? node.own : cells_.points(cells_.number(node.first));
  }
  Node& node(int number) { return nodes_[static_cast<std::size_t>(number)]; }
  const Node& node(int number) const { return nodes_[static_cast<std::size_t>(number)]; }
  bool injectiveAround(const Node& a, const Node& b) const;
  bool apartAlongNormal(const Node& a, const Node& b) const;
  bool quadsCross(const Node& a, const Node& b) const;
  bool atOnePole(const Node& a, const Node& b) const;
  Outcome look(const Pair& pair) const;
  bool canSplit(const Node& node) const;
  void split(int number);
  void splitPair(const Pair& pair, std::vector<Pair>& next);
  SelfIntersection<D> sumUp(const std::vector<Pair>& hopeless) const;

  const SelfIntersectionOptions<D>& options_;
  BezierCells<D> cells_;
  Evaluator<D> evaluator_;
  std::vector<std::uint8_t> changed_;
  std::vector<Node> nodes_;
};

template <int D>
SelfSearch<D>::SelfSearch(const Spline<D>& spline, const SelfIntersectionOptions<D>& options)
    : options_(options), cells_(spline), evaluator_(cells_.form()) {
  Node root;
  std::size_t count = 1;
  for (std::size_t k = 0; k < D; ++k) {
    root.end[k] = cells_.count(k);
    root.from[k] = cells_.from(k);
    root.to[k] = cells_.to(k);
    count *= static_cast<std::size_t>(cells_.count(k));
  }
  for (std::size_t c = 0; c < count; ++c) root.box.add(cells_.box(c));
  nodes_.push_back(std::move(root));
  changed_.assign(count, 1);
  if (options.unchangedFrom != nullptr) findChanges(spline, *options.unchangedFrom);
}

template <int D>
void SelfSearch<D>::findChanges(const Spline<D>& spline, const Spline<D>& other) {
  if (other.knots() != spline.knots() || other.net().cols() != spline.net().cols()) return;
  Index points = 1;
  for (int k = 0; k < D; ++k) points *= spline.degree(k) + 1;
  std::array<std::vector<Index>, D> spans;
  for (std::size_t k = 0; k < D; ++k) spans[k] = spline.knots()[k].spans();
  for (std::size_t c = 0; c < changed_.size(); ++c) {
    changed_[c] = 0;
    for (Index i = 0; i < points; ++i) {
      Cell row;
      auto cell = static_cast<Index>(c), point = i;
      for (std::size_t k = D; k-- > 0;) {
        const Index count = cells_.count(k), side = spline.knots()[k].degree() + 1;
        row[k] = spans[k][static_cast<std::size_t>(cell % count)] - point % side;
        cell /= count;
        point /= side;
      }
      const Index r = spline.row(row);
      if (spline.net().row(r) != other.net().row(r)) changed_[c] = 1;
    }
  }
}

// The condition on the rectangle around two nodes, in the way around closed directions that makes it small.
template <int D>
bool SelfSearch<D>::injectiveAround(const Node& a, const Node& b) const {
  Cell first, end;
  Parameters from, to;
  Index cells = 1, inA = 1, inB = 1;
  for (std::size_t k = 0; k < D; ++k) {
    const auto lengthShifted = [&](Index turns) {
      const double by = static_cast<double>(turns) * cells_.period(k);
      return std::max(a.to[k], b.to[k] + by) - std::min(a.from[k], b.from[k] + by);
    };
    Index turns = 0;
    for (Index t : {-1, 1}) {
      if (cells_.isClosed(k) && lengthShifted(t) < lengthShifted(turns)) turns = t;
    }
    const double by = static_cast<double>(turns) * cells_.period(k);
    first[k] = std::min(a.first[k], b.first[k] + turns * cells_.count(k));
    end[k] = std::max(a.end[k], b.end[k] + turns * cells_.count(k));
    from[k] = std::min(a.from[k], b.from[k] + by);
    to[k] = std::max(a.to[k], b.to[k] + by);
    cells *= end[k] - first[k];
    inA *= a.end[k] - a.first[k];
    inB *= b.end[k] - b.first[k];
    for (Index c = first[k] + 1; c < end[k]; ++c) {
      if (cells_.jumpsAt(k, (c + cells_.count(k)) % cells_.count(k))) return false;
    }
  }
  if (cells > kNear * (inA + inB)) return false;
  const bool whole = !a.isCell() || !b.isCell();
  std::vector<TangentBoxes<D>> around(static_cast<std::size_t>(cells));
  for (Index c = 0; c < cells; ++c) {
    Index rest = c;
    Cell place;
    Parameters lengths, low, high;
    bool all = true;
    for (std::size_t k = D; k-- > 0;) {
      const Index count = cells_.count(k), unrolled = first[k] + rest % (end[k] - first[k]);
      rest /= end[k] - first[k];
      const Index turns = unrolled < 0 ? -1 : unrolled / count;
      place[k] = unrolled - turns * count;
      const double start = cells_.at(k, place[k]), length = cells_.at(k, place[k] + 1) - start;
      const double by = static_cast<double>(turns) * cells_.period(k);
      low[k] = std::clamp((from[k] - by - start) / length, 0.0, 1 - kLeastPart);
      high[k] = std::clamp((to[k] - by - start) / length, low[k] + kLeastPart, 1.0);
      lengths[k] = (high[k] - low[k]) * length;
      all = all && low[k] == 0 && high[k] == 1;
    }
    const std::size_t number = cells_.number(place);
    TangentBoxes<D>& here = around[static_cast<std::size_t>(c)];
    here = cells_.tangents(number);
    if (!whole && !all) {
      HomogeneousPoints points = cells_.points(number);
      for (std::size_t k = 0; k < D; ++k) points = cells_.part(std::move(points), k, low[k], high[k]);
      here = cells_.tangentsOf(points, lengths);
    }
  }
  return areInjective(around);
}

// Whether the Bezier points lie apart along the normal of one of the two.
template <int D>
bool SelfSearch<D>::apartAlongNormal(const Node& a, const Node& b) const {
  const HomogeneousPoints &p = pointsOf(a), &q = pointsOf(b);
  for (const HomogeneousPoints* own : {&p, &q}) {
    const auto corner = [&](Index r) { return Eigen::Vector3d((own->row(r).head<3>() / (*own)(r, 3)).transpose()); };
    const Index n = own->rows();
    Eigen::Vector3d normal;
    if constexpr (D == 2) {
      const Index last = cells_.form().degree(1);
      normal = (corner(n - 1) - corner(0)).cross(corner(n - 1 - last) - corner(last));
    } else {
      const Eigen::Vector3d along = corner(n - 1) - corner(0);
      normal << -along[1], along[0], 0;
    }
    const double length = normal.norm();
    if (!(length > 0)) continue;
    normal /= length;
    const auto range = [&](const HomogeneousPoints& points) {
      std::array<double, 2> r{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
      for (Index i = 0; i < points.rows(); ++i) {
        const double x = points.row(i).head<3>().dot(normal.transpose()) / points(i, 3);
        r = {std::min(r[0], x), std::max(r[1], x)};
      }
      return r;
    };
    const auto ra = range(p), rb = range(q);
    if (ra[0] > rb[1] + 4 * cells_.rounding() || rb[0] > ra[1] + 4 * cells_.rounding()) return true;
  }
  return false;
}

template <int D>
bool SelfSearch<D>::canSplit(const Node& node) const {
  for (std::size_t k = 0; k < D; ++k) {
    if (node.end[k] - node.first[k] > 1 || node.halvings[k] < options_.maxHalvings) return true;
  }
  return false;
}

// Halves a node across its longer extent.
template <int D>
void SelfSearch<D>::split(int number) {
  if (node(number).child >= 0) return;
  const Node parent = node(number);
  const bool isCell = parent.isCell();
  std::size_t along = 0;
  double longest = -1;
  for (std::size_t k = 0; k < D; ++k) {
    const bool may = isCell ? parent.halvings[k] < options_.maxHalvings : parent.end[k] - parent.first[k] > 1;
    const PointBox& tangent = cells_.tangents(cells_.number(parent.first))[k];
    const double length = (tangent.middle().abs() + tangent.half()).matrix().norm() * (parent.to[k] - parent.from[k]);
    if (may && length > longest) {
      longest = length;
      along = k;
    }
  }
  node(number).child = static_cast<int>(nodes_.size());
  for (const bool high : {false, true}) {
    Node child = parent;
    if (isCell) {
      (high ? child.from[along] : child.to[along]) = std::midpoint(parent.from[along], parent.to[along]);
      ++child.halvings[along];
      child.own = cells_.part(pointsOf(parent), along, high ? 0.5 : 0, high ? 1 : 0.5);
      child.box = cells_.boxOf(child.own);
    } else {
      const Index middle = (parent.first[along] + parent.end[along]) / 2;
      (high ? child.first[along] : child.end[along]) = middle;
      (high ? child.from[along] : child.to[along]) = cells_.at(along, middle);
      child.box = {};
      child.changed = false;
      Index count = 1;
      for (std::size_t k = 0; k < D; ++k) count *= child.end[k] - child.first[k];
      for (Index c = 0; c < count; ++c) {
        Cell cell;
        Index rest = c;
        for (std::size_t k = D; k-- > 0;) {
          cell[k] = child.first[k] + rest % (child.end[k] - child.first[k]);
          rest /= child.end[k] - child.first[k];
        }
        const std::size_t inside = cells_.number(cell);
        child.box.add(cells_.box(inside));
        child.changed = child.changed || changed_[inside];
      }
    }
    nodes_.push_back(std::move(child));
  }
}

template <int D>
void SelfSearch<D>::splitPair(const Pair& pair, std::vector<Pair>& next) {
  const Node &a = node(pair.a), &b = node(pair.b);
  // The larger one of the two, so that they stay alike.
  const bool first = pair.a == pair.b || !canSplit(b) || (canSplit(a) && a.box.diameter() >= b.box.diameter());
  const int parent = first ? pair.a : pair.b, other = first ? pair.b : pair.a;
  split(parent);
  const int low = node(parent).child, high = low + 1;
  if (pair.a == pair.b) {
    next.insert(next.end(), {{low, low}, {high, high}, {low, high}});
  } else {
    next.insert(next.end(), {{low, other}, {high, other}});
  }
}

// Whether the cells of both touch one side that is a point.
template <int D>
bool SelfSearch<D>::atOnePole(const Node& a, const Node& b) const {
  if (!a.isCell() || !b.isCell()) return false;
  for (std::size_t k = 0; k < D; ++k) {
    const Index last = cells_.count(k) - 1;
    if (cells_.isPole(k, false) && a.first[k] == 0 && b.first[k] == 0) return true;
    if (cells_.isPole(k, true) && a.first[k] == last && b.first[k] == last) return true;
  }
  return false;
}

template <int D>
typename SelfSearch<D>::Outcome SelfSearch<D>::look(const Pair& pair) const {
  const Node &a = node(pair.a), &b = node(pair.b);
  if (!a.changed && !b.changed) return {};
  const bool itself = pair.a == pair.b, small = a.isCell() && b.isCell();
  if (!itself && !a.box.meets(b.box)) return {};
  if (injectiveAround(a, b)) return {};
  if (small && !itself && apartAlongNormal(a, b)) return {};
  // All pieces at a pole meet there: to split them again and again says nothing.
  if (atOnePole(a, b)) return {Verdict::undecided, {}};
  const bool last = !canSplit(a) && !canSplit(b);
  if (small && !itself && quadsCross(a, b)) {
    if (auto meeting = findMeetingPair<D>(cells_, evaluator_, a.middle(), b.middle())) return {Verdict::meet, meeting};
  }
  return {last ? Verdict::undecided : Verdict::split, {}};
}

bool segmentCrosses(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& p,
                    const Eigen::Vector3d& q, const Eigen::Vector3d& r) {
  const Eigen::Vector3d n = (q - p).cross(r - p);
  const double da = n.dot(a - p), db = n.dot(b - p);
  if (!(da * db < 0)) return false;
  const Eigen::Vector3d x = a + da / (da - db) * (b - a);
  return n.dot((q - p).cross(x - p)) >= 0 && n.dot((r - q).cross(x - q)) >= 0 && n.dot((p - r).cross(x - r)) >= 0;
}

// Whether the corners' quadrangles, two triangles each, cross; of curves the chords.
template <int D>
bool SelfSearch<D>::quadsCross(const Node& a, const Node& b) const {
  const auto corners = [&](const Node& node) {
    const HomogeneousPoints& points = pointsOf(node);
    std::array<Eigen::Vector3d, std::size_t{1} << D> result;
    for (std::size_t i = 0; i < result.size(); ++i) {
      Index row = 0;
      for (std::size_t k = 0; k < D; ++k) {
        const Index p = cells_.form().knots()[k].degree();
        row = row * (p + 1) + ((i >> k) & 1 ? p : 0);
      }
      result[i] = (points.row(row).head<3>() / points(row, 3)).transpose();
    }
    return result;
  };
  const auto p = corners(a), q = corners(b);
  if constexpr (D == 1) {
    const auto side = [](const auto& line, const Eigen::Vector3d& x) {
      const Eigen::Vector3d d = line[1] - line[0], e = x - line[0];
      return d[0] * e[1] - d[1] * e[0];
    };
    return side(p, q[0]) * side(p, q[1]) <= 0 && side(q, p[0]) * side(q, p[1]) <= 0;
  } else {
    const auto cross = [](const auto& s, const auto& t) {
      constexpr std::size_t kEdges[5][2] = {{0, 1}, {1, 3}, {3, 2}, {2, 0}, {0, 3}};
      for (const auto& edge : kEdges) {
        if (segmentCrosses(s[edge[0]], s[edge[1]], t[0], t[1], t[3])) return true;
        if (segmentCrosses(s[edge[0]], s[edge[1]], t[0], t[3], t[2])) return true;
      }
      return false;
    };
    return cross(p, q) || cross(q, p);
  }
}

template <int D>
SelfIntersection<D> SelfSearch<D>::run() {
  std::vector<Pair> frontier{{0, 0}}, hopeless;
  Index looked = 0;
  while (!frontier.empty()) {
    looked += static_cast<Index>(frontier.size());
    if (looked > options_.maxPairs) {
      hopeless.insert(hopeless.end(), frontier.begin(), frontier.end());
      break;
    }
    std::vector<Outcome> outcomes(frontier.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, frontier.size(), 64), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) outcomes[i] = look(frontier[i]);
    });
    std::vector<Pair> next;
    for (std::size_t i = 0; i < frontier.size(); ++i) {
      if (const auto& meeting = outcomes[i].meeting) {
        return {SelfMeeting::intersects, meeting->a, meeting->b, meeting->distance, 0, false};
      }
      if (outcomes[i].verdict == Verdict::undecided) hopeless.push_back(frontier[i]);
      if (outcomes[i].verdict == Verdict::split) splitPair(frontier[i], next);
    }
    frontier = std::move(next);
  }
  return sumUp(hopeless);
}

template <int D>
SelfIntersection<D> SelfSearch<D>::sumUp(const std::vector<Pair>& hopeless) const {
  SelfIntersection<D> result;
  if (hopeless.empty()) return result;
  const std::size_t tries = std::min(hopeless.size(), kLastTries);
  for (std::size_t i = 0; i < tries; ++i) {
    const Pair& pair = hopeless[i * hopeless.size() / tries];
    if (const auto meeting = findMeetingPair<D>(cells_, evaluator_, node(pair.a).middle(), node(pair.b).middle())) {
      return {SelfMeeting::intersects, meeting->a, meeting->b, meeting->distance, 0, false};
    }
  }
  result.answer = SelfMeeting::undecided;
  result.undecided = static_cast<Index>(hopeless.size());
  result.a = node(hopeless.front().a).middle();
  result.b = node(hopeless.front().b).middle();
  result.onlyAtPoles = std::all_of(hopeless.begin(), hopeless.end(),
                                   [&](const Pair& pair) { return atOnePole(node(pair.a), node(pair.b)); });
  return result;
}

}  // namespace

const char* selfMeetingName(SelfMeeting answer) {
  switch (answer) {
    case SelfMeeting::free:
      return "free";
    case SelfMeeting::intersects:
      return "intersects";
    case SelfMeeting::undecided:
      break;
  }
  return "undecided";
}

template <int D>
SelfIntersection<D> findSelfIntersection(const Spline<D>& spline, const SelfIntersectionOptions<D>& options) {
  if (spline.pointDimension() != 3 && !(D == 1 && spline.pointDimension() == 2)) {
    throw InvalidInput(D == 1 ? "whether it meets itself can be told of curves of the plane or of space only"
                              : "whether it meets itself can be told of surfaces in space only");
  }
  return SelfSearch<D>(spline, options).run();
}

template <int D>
MovedMeeting<D> meetingAfterMove(const Spline<D>& before, const Spline<D>& after) {
  SelfIntersectionOptions<D> options;
  options.unchangedFrom = &before;
  MovedMeeting<D> result{findSelfIntersection(after, options), false};
  if (result.found.answer != SelfMeeting::intersects) return result;
  options.unchangedFrom = &after;
  result.isNew = findSelfIntersection(before, options).answer != SelfMeeting::intersects;
  return result;
}

template SelfIntersection<1> findSelfIntersection(const Curve&, const SelfIntersectionOptions<1>&);
template SelfIntersection<2> findSelfIntersection(const Surface&, const SelfIntersectionOptions<2>&);
template MovedMeeting<1> meetingAfterMove(const Curve&, const Curve&);
template MovedMeeting<2> meetingAfterMove(const Surface&, const Surface&);

}  // namespace strak
