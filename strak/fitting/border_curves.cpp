#include "strak/fitting/border_curves.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "strak/base/error.h"
#include "strak/fitting/tube_curve.h"
#include "strak/metrology/closest_points.h"

namespace strak {

namespace {

using Eigen::Vector2d;

constexpr double kRagged = 2;    // tolerance of a loop, in parts of the spacing of the points beside it
constexpr double kArm = 5;       // length of the two arms that make a corner, in parts of the edges there
constexpr Index kArmPoints = 4;  // at least
constexpr int kEdgesAround = 6;  // whose median that is
constexpr double kCorner = std::numbers::pi / 180 * 60;
constexpr double kBetterThanArc = 0.5;  // the error of two lines in parts of an arc's
constexpr Index kHalfWindow = 3;        // points on both sides whose parabola shows how ragged a loop is
constexpr double kCalmWindows = 0.9;    // part of the windows that count
constexpr double kNoiseSlack = 1.6;
constexpr double kExact = 1e-3;      // of the spacing: so near is near enough
constexpr double kSharpened = 2.5;   // so many edges away a corner may lie: the border's triangles leave corners out
constexpr double kClearance = 1e-3;  // of the spacing: how near curves may come

double cross(const Vector2d& a, const Vector2d& b) { return a[0] * b[1] - a[1] * b[0]; }

constexpr int kPinned = 4;  // points on both sides of such a place, at most
constexpr int kTubes = 3;   // rounds with less tolerance before points are pinned
constexpr double kTighter = 0.5, kNoisier = 16;
constexpr int kTrials = 5;   // of a loop whose points are too far away
constexpr int kRounds = 30;  // of fits; after the last the loops that are not clear become polygons

struct CornerPoint {
  Index number;  // of the point
  Vector2d place;
};

// A closed polygon with lengths along it.
class Loop {
 public:
  Loop(const Eigen::Ref<const Net>& points, const std::vector<Index>& numbers)
      : count_(static_cast<Index>(numbers.size())), points_(count_, 2), edges_(numbers.size()) {
    for (Index i = 0; i < count_; ++i) points_.row(i) = points.row(numbers[static_cast<std::size_t>(i)]);
    for (Index i = 0; i < count_; ++i) edges_[static_cast<std::size_t>(i)] = (at(i + 1) - at(i)).norm();
    for (double edge : edges_) length_ += edge;
  }
  Index count() const { return count_; }
  const Net& points() const { return points_; }
  double length() const { return length_; }
  Vector2d at(Index i) const { return points_.row(wrapped(i)).transpose(); }
  double edge(Index i) const { return edges_[static_cast<std::size_t>(wrapped(i))]; }
  Index wrapped(Index i) const { return ((i % count_) + count_) % count_; }

  double edgeAround(Index i) const {
    std::vector<double> some;
    for (Index k = i - kEdgesAround; k < i + kEdgesAround; ++k) some.push_back(edge(k));
    std::nth_element(some.begin(), some.begin() + kEdgesAround, some.end());
    return some[kEdgesAround];
  }

  // The line of least squares through the points after (step 1) or before (-1) point i, without itself, as far as
  // `reach` and at least kArmPoints; directed along the loop.
  struct Arm {
    Vector2d middle, direction;
    double squares;  // of the distances from the line
    Index count;
  };
  Arm arm(Index i, Index step, double reach) const {
    Vector2d sum = Vector2d::Zero();
    Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
    double gone = 0;
    Index used = 0;
    Vector2d last = at(i);
    for (Index k = i + step; used < count_ / 3 && (used < kArmPoints || gone < reach); k += step) {
      last = at(k);
      gone += edge(step > 0 ? k - 1 : k);
      const Vector2d p = last - at(i);
      sum += p;
      moments += p * p.transpose();
      ++used;
    }
    const auto n = static_cast<double>(used);
    moments -= sum * sum.transpose() / n;
    const double angle = std::atan2(2 * moments(0, 1), moments(0, 0) - moments(1, 1)) / 2;
    Vector2d direction(std::cos(angle), std::sin(angle));
    if (direction.dot(last - at(i)) * static_cast<double>(step) < 0) direction = -direction;
    const Vector2d across(-direction[1], direction[0]);
    return {at(i) + sum / n, direction, across.dot(moments * across), used};
  }

  // The sum of the squared distances of points from .. to from the circle of least squares (Kasa) and their number.
  double arcSquares(Index from, Index to) const {
    const Vector2d origin = at((from + to) / 2);
    const double scale = std::max((at(from) - origin).norm(), (at(to) - origin).norm());
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (Index i = from; i <= to; ++i) {
      const Vector2d p = (at(i) - origin) / scale;
      const Eigen::Vector3d row(p[0], p[1], 1);
      matrix += row * row.transpose();
      right += row * p.squaredNorm();
    }
    const Eigen::Vector3d solved = matrix.ldlt().solve(right);
    const Vector2d centre(solved[0] / 2, solved[1] / 2);
    const double radius = std::sqrt(std::max(solved[2] + centre.squaredNorm(), 0.0));
    double squares = 0;
    for (Index i = from; i <= to; ++i) {
      const double off = ((at(i) - origin) / scale - centre).norm() - radius;
      squares += off * off;
    }
    return squares * scale * scale;
  }

  // How far its points stray from a smooth line: the errors of parabolas through a few points, those with the largest
  // errors left out (corners).
  double raggedness() const {
    std::vector<double> variances;
    if (count_ <= 2 * kHalfWindow) return 0;
    for (Index i = 0; i < count_; ++i) {
      const Vector2d along = (at(i + kHalfWindow) - at(i - kHalfWindow)).normalized(), across(-along[1], along[0]);
      Eigen::Matrix<double, 2 * kHalfWindow + 1, 3> powers;
      Eigen::Matrix<double, 2 * kHalfWindow + 1, 1> heights;
      const double scale = (at(i + kHalfWindow) - at(i - kHalfWindow)).norm();
      if (!(scale > 0)) continue;
      for (Index k = -kHalfWindow; k <= kHalfWindow; ++k) {
        const Vector2d p = at(i + k) - at(i);
        const double x = p.dot(along) / scale;
        powers.row(k + kHalfWindow) << 1, x, x * x;
        heights[k + kHalfWindow] = p.dot(across);
      }
      const Eigen::Vector3d parabola = powers.colPivHouseholderQr().solve(heights);
      variances.push_back((heights - powers * parabola).squaredNorm() / (2 * kHalfWindow - 2));
    }
    std::sort(variances.begin(), variances.end());
    const auto used = static_cast<std::size_t>(std::ceil(kCalmWindows * static_cast<double>(variances.size())));
    double sum = 0;
    for (std::size_t i = 0; i < used; ++i) sum += variances[i];
    return used > 0 ? std::sqrt(sum / static_cast<double>(used)) : 0;
  }

 private:
  Index count_;
  Net points_;
  std::vector<double> edges_;
  double length_ = 0;
};

double turning(const Loop::Arm& before, const Loop::Arm& after) {
  return std::atan2(cross(before.direction, after.direction), before.direction.dot(after.direction));
}

// Points where the loop turns sharply, and where the lines on both sides meet; those that are `blunt` stay themselves.
std::vector<CornerPoint> findCorners(const Loop& loop, const std::vector<char>& blunt) {
  constexpr Index kFewest = 12;  // points: less is no loop with arms
  constexpr Index kPolygon = 4;  // points, at most: whatever rounds them is guessed
  std::vector<CornerPoint> corners;
  for (Index i = 0; i < loop.count() && loop.count() <= kPolygon; ++i) corners.push_back({i, loop.at(i)});
  if (loop.count() < kFewest) return corners;
  std::vector<double> turns(static_cast<std::size_t>(loop.count()), 0);
  for (Index i = 0; i < loop.count(); ++i) {
    const double reach = kArm * loop.edgeAround(i);
    const Loop::Arm before = loop.arm(i, -1, reach), after = loop.arm(i, 1, reach);
    const double angle = std::abs(turning(before, after));
    if (angle < kCorner) continue;
    const double lines = before.squares + after.squares;
    if (lines > kBetterThanArc * kBetterThanArc * loop.arcSquares(i - before.count, i + after.count)) continue;
    turns[static_cast<std::size_t>(i)] = angle;
  }
  for (Index i = 0; i < loop.count(); ++i) {
    const double own = turns[static_cast<std::size_t>(i)];
    if (own == 0) continue;
    const double edge = loop.edgeAround(i), reach = kArm * edge;
    bool largest = true;
    double gone = 0;
    for (Index k = 1; gone < reach && k < loop.count() / 2; ++k) {
      gone += loop.edge(i + k - 1);
      largest = largest && turns[static_cast<std::size_t>(loop.wrapped(i + k))] <= own;
    }
    gone = 0;
    for (Index k = 1; gone < reach && k < loop.count() / 2; ++k) {
      gone += loop.edge(i - k);
      largest = largest && turns[static_cast<std::size_t>(loop.wrapped(i - k))] < own;
    }
    if (!largest) continue;
    CornerPoint corner{i, loop.at(i)};
    const Loop::Arm before = loop.arm(i, -1, reach), after = loop.arm(i, 1, reach);
    const double sine = cross(before.direction, after.direction);
    if (blunt[static_cast<std::size_t>(i)] == 0 && std::abs(sine) > 0) {
      const double along = cross(after.middle - before.middle, after.direction) / sine;
      const Vector2d meeting = before.middle + along * before.direction;
      if ((meeting - corner.place).norm() <= kSharpened * edge) corner.place = meeting;
    }
    corners.push_back(corner);
  }
  return corners;
}

// `count` points from `first` on; with places on the edges between them, so many that none is twice as far from the
// next as its neighbours are.
Net rowsOf(const Loop& loop, Index first, Index count, bool edges) {
  constexpr double kMostPlaces = 16;
  std::vector<Vector2d> rows;
  for (Index i = first; i < first + count; ++i) {
    rows.push_back(loop.at(i));
    if (!edges || (i + 1 == first + count && count < loop.count())) continue;
    const double least = std::min({loop.edge(i - 1), loop.edge(i), loop.edge(i + 1)});
    const double steps = std::min(std::ceil(2 * loop.edge(i) / least), kMostPlaces);
    for (int k = 1; k < steps; ++k) rows.push_back(loop.at(i) + k / steps * (loop.at(i + 1) - loop.at(i)));
  }
  Net net(static_cast<Index>(rows.size()), 2);
  for (std::size_t i = 0; i < rows.size(); ++i) net.row(static_cast<Index>(i)) = rows[i].transpose();
  return net;
}

// A loop's curves and how far its points are from them.
struct Pieces {
  CurveLoop curves;
  std::vector<Index> starts;  // of each curve: the number of its corner; none for a loop without corners
  Eigen::VectorXd errors;
  Net feet;  // the nearest places
};

// What points of a loop are besides: corners that stay where their points are, and points that are made corners.
struct Marks {
  const std::vector<char>&blunt, &sharp, &pinned;
  bool stays(Index i) const {
    return sharp[static_cast<std::size_t>(i)] != 0 || pinned[static_cast<std::size_t>(i)] != 0;
  }
};

// Between the corners; marked points are corners, too, and stay where they are. `edges`: the curves have to
// follow the edges of the polygon, too, not its points only.
Pieces fairPieces(const Loop& loop, const TubeLimits& limits, bool edges, const Marks& marks,
                  const Eigen::AlignedBox2d& domain) {
  Pieces result;
  std::vector<CornerPoint> corners;
  for (const CornerPoint& corner : findCorners(loop, marks.blunt)) {
    if (!marks.stays(corner.number)) corners.push_back(corner);
  }
  for (CornerPoint& corner : corners) {
    if (!domain.isEmpty()) corner.place = corner.place.cwiseMax(domain.min()).cwiseMin(domain.max());
  }
  for (Index i = 0; i < loop.count(); ++i) {
    if (marks.stays(i)) corners.push_back({i, loop.at(i)});
  }
  std::sort(corners.begin(), corners.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
  for (const CornerPoint& corner : corners) result.starts.push_back(corner.number);
  result.errors = Eigen::VectorXd::Constant(loop.count(), std::numeric_limits<double>::infinity());
  result.feet = loop.points();
  const auto add = [&](Curve curve, Index first, Index count) {
    Net own(count, 2);
    for (Index k = 0; k < count; ++k) own.row(k) = loop.points().row(loop.wrapped(first + k));
    const ClosestPoints<1> nearest = closestPoints<1>(curve, own);
    for (Index k = 0; k < count; ++k) {
      const Index i = loop.wrapped(first + k);
      if (nearest.distances[k] >= result.errors[i]) continue;
      result.errors[i] = nearest.distances[k];
      result.feet.row(i) = nearest.points.row(k);
    }
    result.curves.push_back(std::move(curve));
  };
  if (corners.empty()) add(tubeAround(rowsOf(loop, 0, loop.count(), edges), limits, domain), 0, loop.count());
  for (std::size_t c = 0; c < corners.size(); ++c) {
    const CornerPoint &from = corners[c], &to = corners[(c + 1) % corners.size()];
    const Index steps = loop.wrapped(to.number - from.number - 1);
    add(tubeBetween(from.place, rowsOf(loop, from.number + 1, steps, edges), to.place, limits, domain), from.number,
        steps + 2);
  }
  return result;
}

FairLoop fairLoop(const Loop& loop, TubeLimits limits, int round, const std::vector<char>& pinned,
                  const Eigen::AlignedBox2d& domain, std::vector<Index>& starts) {
  FairLoop result;
  result.points = loop.count();
  result.tolerance = limits.tolerance;
  result.pinned = std::count(pinned.begin(), pinned.end(), 1);
  const double allowed = limits.tolerance, tubes = std::min(round, kTubes);
  // Near the edges, but not along each of their kinks.
  limits = {limits.tolerance * std::pow(kTighter, tubes), limits.noise * std::pow(kNoisier, tubes)};
  std::vector<char> blunt(pinned.size(), round > 0 ? 1 : 0), sharp(pinned.size(), 0);
  Pieces pieces = fairPieces(loop, limits, round > 0, {blunt, sharp, pinned}, domain);
  for (int trial = 0; trial < kTrials && pieces.errors.maxCoeff() > allowed; ++trial) {
    // First the corners are blunted that lie too far from the points, then all; then the points that no smooth curve
    // reaches are made corners.
    for (Index i = 0; i < loop.count(); ++i) {
      const double error = pieces.errors[i];
      const auto at = static_cast<std::size_t>(i);
      blunt[at] = trial > 0 || blunt[at] != 0 || error > allowed ? 1 : 0;
      const bool largest = error >= pieces.errors[loop.wrapped(i - 1)] && error > pieces.errors[loop.wrapped(i + 1)];
      if (trial > 1 && error > allowed && largest) sharp[at] = 1;
    }
    pieces = fairPieces(loop, limits, round > 0, {blunt, sharp, pinned}, domain);
  }
  result.pieces = std::move(pieces.curves);
  result.corners = static_cast<Index>(pieces.starts.size()) - result.pinned;
  starts = std::move(pieces.starts);
  result.feet = std::move(pieces.feet);
  result.deviation = pieces.errors.maxCoeff();
  result.rms = std::sqrt(pieces.errors.squaredNorm() / static_cast<double>(loop.count()));
  return result;
}

// Pins the points of the pieces that are not clear next to the places, and more of them from round to round. Returns
// whether there were any.
bool pin(const Loop& loop, const std::vector<NearPlace>& places, const std::vector<Index>& starts, int round,
         std::vector<char>& pinned) {
  bool any = false;
  for (const NearPlace& near : places) {
    Index first = 0, count = loop.count();
    if (!starts.empty()) {
      first = starts[near.piece];
      count = loop.wrapped(starts[(near.piece + 1) % starts.size()] - first - 1) + 2;
    }
    Index nearest = first;
    double least = std::numeric_limits<double>::infinity();
    for (Index i = first; i < first + count; ++i) {
      const double distance = (loop.at(i) - near.place).norm();
      if (pinned[static_cast<std::size_t>(loop.wrapped(i))] != 0 || distance >= least) continue;
      least = distance;
      nearest = i;
    }
    if (least == std::numeric_limits<double>::infinity()) continue;  // it is straight
    const Index reach = std::min(round, kPinned);
    for (Index i = std::max(first, nearest - reach); i <= std::min(first + count - 1, nearest + reach); ++i) {
      pinned[static_cast<std::size_t>(loop.wrapped(i))] = 1;
    }
    any = true;
  }
  return any;
}

void measure(double flatness, FairLoop& result) {
  const std::vector<Vector2d> polygon = flattened(result.pieces, flatness);
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d a = polygon[i] - polygon[0], b = polygon[(i + 1) % polygon.size()] - polygon[0];
    result.length += (b - a).norm();
    result.area += cross(a, b) / 2;
  }
}

}  // namespace

std::vector<FairPart> fairBorders(const Eigen::Ref<const Net>& points, const Borders& borders,
                                  const BorderCurveOptions& options) {
  if (!(options.tolerance >= 0) || !std::isfinite(options.tolerance)) {
    throw InvalidInput("the tolerance of border curves must be a positive length, or 0 to have it chosen");
  }
  std::vector<Loop> loops;
  std::vector<TubeLimits> limits;
  double least = std::numeric_limits<double>::infinity();
  const auto take = [&](const BorderLoop& loop) {
    loops.emplace_back(points, loop.points);
    TubeLimits own{options.tolerance, std::numeric_limits<double>::infinity()};
    if (!(own.tolerance > 0)) {
      own = {kRagged * loop.spacing, std::max(kNoiseSlack * loops.back().raggedness(), kExact * loop.spacing)};
    }
    own.tolerance = std::min(own.tolerance, std::abs(loop.area) / loops.back().length());
    limits.push_back(own);
    least = std::min({least, own.tolerance, loop.spacing});
  };
  for (const BorderPart& part : borders.parts) {
    take(part.outer);
    for (const BorderLoop& hole : part.holes) take(hole);
  }
  std::vector<std::vector<char>> pinned;
  pinned.reserve(loops.size());
  for (const Loop& loop : loops) {
    pinned.emplace_back(static_cast<std::size_t>(loop.count()), 0);
  }
  std::vector<FairLoop> fair(loops.size());
  std::vector<CurveLoop> curves(loops.size());
  std::vector<std::vector<Index>> starts(loops.size());
  std::vector<int> rounds(loops.size(), 0);
  std::vector<char> open(loops.size(), 1);
  while (std::count(open.begin(), open.end(), 1) > 0) {
    for (std::size_t i = 0; i < loops.size(); ++i) {
      if (open[i] == 0) continue;
      fair[i] = fairLoop(loops[i], limits[i], rounds[i], pinned[i], options.domain, starts[i]);
      curves[i] = fair[i].pieces;
    }
    const auto places = placesNotClear(curves, kClearance * least);
    for (std::size_t i = 0; i < loops.size(); ++i) {
      open[i] = !places[i].empty() && fair[i].pinned < fair[i].points ? 1 : 0;
      if (open[i] == 0) continue;
      const bool moved = ++rounds[i] <= kTubes || pin(loops[i], places[i], starts[i], rounds[i] - kTubes, pinned[i]);
      if (!moved || rounds[i] >= kRounds) std::fill(pinned[i].begin(), pinned[i].end(), 1);
    }
  }
  for (std::size_t i = 0; i < loops.size(); ++i) measure(kClearance * limits[i].tolerance, fair[i]);
  std::vector<FairPart> parts;
  auto next = fair.begin();
  for (const BorderPart& part : borders.parts) {
    FairPart& own = parts.emplace_back();
    own.outer = std::move(*next++);
    for (std::size_t h = 0; h < part.holes.size(); ++h) own.holes.push_back(std::move(*next++));
  }
  return parts;
}

}  // namespace strak
