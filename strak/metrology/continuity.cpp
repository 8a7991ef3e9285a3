#include "strak/metrology/continuity.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "strak/base/error.h"
#include "strak/metrology/curvature.h"
#include "strak/metrology/piece.h"

namespace strak {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

void checkSpace(const Surface& surface) {
  if (surface.pointDimension() != 3) {
    throw InvalidInput("continuity needs surfaces in space: give control points with three coordinates");
  }
}

// One side of a joint at one place.
struct Side {
  SurfaceJet jet;
  std::optional<Vector3d> normal;
};

Side sideOf(const SurfacePiece& piece, double u, double v) {
  Side side;
  piece.at(u, v, 2, side.jet);
  side.normal = unitNormal(side.jet[1], side.jet[2]);
  return side;
}

Side sideAt(const Surface& surface, const Vector2d& p) {
  const SurfacePiece piece(surface, surface.knots(0).findSpan(p[0]), surface.knots(1).findSpan(p[1]));
  return sideOf(piece, p[0], p[1]);
}

// The normal curvature in a direction of the tangent plane.
double curvatureAlong(const Side& side, const Vector3d& direction) {
  Eigen::Matrix<double, 3, 2> tangents;
  tangents << side.jet[1], side.jet[2];
  const Eigen::Matrix2d metric = tangents.transpose() * tangents;
  const Vector2d c = metric.inverse() * (tangents.transpose() * direction);
  const double length = c.dot(metric * c);
  const Vector3d second = c[0] * c[0] * side.jet[3] + 2 * c[0] * c[1] * side.jet[4] + c[1] * c[1] * side.jet[5];
  return length > 0 ? second.dot(*side.normal) / length : 0;
}

// Collects samples; what depends on the sides of the normals is kept for both until the end.
class Collector {
 public:
  // `tangent` is the way along the edge that the sample stands for: its length weighs the root mean squares.
  void add(const Side& a, const Side& b, const Vector3d& tangent) {
    ++result_.samples;
    const double weight = tangent.norm();
    length_ += weight;
    raise(result_.gap, (a.jet[0] - b.jet[0]).norm(), weight, a.jet[0]);
    if (!a.normal || !b.normal || !(weight > 0)) {
      ++result_.singular;
      return;
    }
    regularLength_ += weight;
    // Across the edge, in either tangent plane.
    const double kA = curvatureAlong(a, a.normal->cross(tangent));
    const double kB = curvatureAlong(b, b.normal->cross(tangent));
    const double angle = std::atan2(a.normal->cross(*b.normal).norm(), a.normal->dot(*b.normal));
    result_.largestCurvature = std::max({result_.largestCurvature, std::abs(kA), std::abs(kB)});
    raise(same_.angle, angle, weight, a.jet[0]);
    raise(same_.curvature, std::abs(kA - kB), weight, a.jet[0]);
    raise(opposite_.angle, std::numbers::pi - angle, weight, a.jet[0]);
    raise(opposite_.curvature, std::abs(kA + kB), weight, a.jet[0]);
  }

  Continuity finish(NormalSides sides) {
    const bool same =
        sides == NormalSides::same || (sides == NormalSides::nearest && same_.angle.rms <= opposite_.angle.rms);
    result_.angle = (same ? same_ : opposite_).angle;
    result_.curvature = (same ? same_ : opposite_).curvature;
    const auto root = [](JointFigure& figure, double length) {
      figure.rms = length > 0 ? std::sqrt(figure.rms / length) : 0;
    };
    result_.length = length_;
    root(result_.gap, length_);
    root(result_.angle, regularLength_);
    root(result_.curvature, regularLength_);
    return result_;
  }

 private:
  // `rms` holds the weighted sum of squares until the end.
  static void raise(JointFigure& figure, double value, double weight, const Vector3d& place) {
    figure.rms += weight * value * value;
    if (value >= figure.max) {
      figure.max = value;
      figure.place = place;
    }
  }

  struct Oriented {
    JointFigure angle, curvature;
  };
  Continuity result_;
  Oriented same_, opposite_;
  double length_ = 0, regularLength_ = 0;
};

Vector3d pointOn(const Surface& surface, const ParameterCurve& edge, double t) {
  const Vector2d p = edge(t);
  SurfaceJet jet;
  SurfacePiece(surface, surface.knots(0).findSpan(p[0]), surface.knots(1).findSpan(p[1])).at(p[0], p[1], 0, jet);
  return jet[0];
}

// Where a function of t in [low, high] is least, found by parabolas and, where these do not help, golden section
// (Brent, "Algorithms for minimization without derivatives", 1973, chapter 5). `start` is a place nearby.
template <typename Function>
std::pair<double, double> leastNear(const Function& value, double low, double high, double start) {
  constexpr double kSection = 0.3819660112501051, kClose = 1e-11;
  double best = start, second = start, third = start;
  double atBest = value(best), atSecond = atBest, atThird = atBest;
  double step = 0, before = 0;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    if (std::abs(best - middle) + (high - low) / 2 <= 2 * kClose) break;
    bool parabola = false;
    if (std::abs(before) > kClose) {
      const double r = (best - second) * (atBest - atThird), q = (best - third) * (atBest - atSecond);
      const double bottom = 2 * (q - r), top = (best - second) * r - (best - third) * q;
      if (bottom != 0) {
        const double next = top / bottom;
        parabola = std::abs(next) < std::abs(before / 2) && best + next > low && best + next < high;
        if (parabola) {
          before = step;
          step = next;
        }
      }
    }
    if (!parabola) {
      before = best < middle ? high - best : low - best;
      step = kSection * before;
    }
    const double t = best + (std::abs(step) >= kClose ? step : std::copysign(kClose, step));
    const double at = value(t);
    if (at <= atBest) {
      (t < best ? high : low) = best;
      third = std::exchange(second, std::exchange(best, t));
      atThird = std::exchange(atSecond, std::exchange(atBest, at));
    } else {
      (t < best ? low : high) = t;
      if (at <= atSecond || second == best) {
        third = std::exchange(second, t);
        atThird = std::exchange(atSecond, at);
      } else if (at <= atThird || third == best || third == second) {
        third = t;
        atThird = at;
      }
    }
  }
  return {best, atBest};
}

// The parameter of the point of the edge that is nearest to `point`: the best of a table, then between its neighbours.
double nearestOnEdge(const Surface& surface, const ParameterCurve& edge, const std::vector<Vector3d>& table,
                     const Vector3d& point) {
  const auto steps = static_cast<double>(table.size() - 1);
  std::size_t best = 0;
  for (std::size_t i = 1; i < table.size(); ++i) {
    if ((table[i] - point).squaredNorm() < (table[best] - point).squaredNorm()) best = i;
  }
  const auto distance = [&](double t) { return (pointOn(surface, edge, t) - point).squaredNorm(); };
  const double there = static_cast<double>(best) / steps;
  const double low = std::max(0.0, (static_cast<double>(best) - 1) / steps);
  const double high = std::min(1.0, (static_cast<double>(best) + 1) / steps);
  auto [t, least] = leastNear(distance, low, high, there);
  // The search comes near the ends of the edge, but not quite there.
  for (const double end : {0.0, 1.0}) {
    const double atEnd = (table[end == 0 ? 0 : table.size() - 1] - point).squaredNorm();
    if (atEnd <= least) {
      least = atEnd;
      t = end;
    }
  }
  return t;
}

}  // namespace

ParameterCurve parameterPolyline(std::vector<Vector2d> points) {
  if (points.size() < 2) throw InvalidInput("a polyline of parameters needs at least two points");
  return [points = std::move(points)](double t) -> Vector2d {
    const double place = std::clamp(t, 0.0, 1.0) * static_cast<double>(points.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(place), points.size() - 2);
    return points[i] + (place - static_cast<double>(i)) * (points[i + 1] - points[i]);
  };
}

ParameterCurve domainEdge(const Surface& surface, int direction, bool atEnd) {
  if (direction != 0 && direction != 1) {
    throw InvalidInput(fmt::format("there is no direction {}: give 0 (u) or 1 (v)", direction));
  }
  const KnotVector& fixed = surface.knots(direction);
  const KnotVector& running = surface.knots(1 - direction);
  const double value = atEnd ? fixed.to() : fixed.from();
  return [direction, value, from = running.from(), to = running.to()](double t) {
    Vector2d p;
    p[direction] = value;
    p[1 - direction] = std::lerp(from, to, t);
    return p;
  };
}

Continuity edgeContinuity(const Surface& a, const ParameterCurve& edgeA, const Surface& b, const ParameterCurve& edgeB,
                          const ContinuityOptions& options) {
  checkSpace(a);
  checkSpace(b);
  if (options.samples < 2) throw InvalidInput(fmt::format("{} samples are too few: give at least 2", options.samples));
  const auto last = static_cast<double>(options.samples - 1);
  std::vector<Vector3d> pointsA, pointsB;
  for (Index i = 0; i < options.samples; ++i) {
    pointsA.push_back(pointOn(a, edgeA, static_cast<double>(i) / last));
    pointsB.push_back(pointOn(b, edgeB, static_cast<double>(i) / last));
  }
  Collector collector;
  for (std::size_t i = 0; i < pointsA.size(); ++i) {
    const Side sideA = sideAt(a, edgeA(static_cast<double>(i) / last));
    const Side sideB = sideAt(b, edgeB(nearestOnEdge(b, edgeB, pointsB, pointsA[i])));
    // The trapezoidal rule: half the way to either neighbour.
    const Vector3d tangent = (pointsA[std::min(i + 1, pointsA.size() - 1)] - pointsA[i > 0 ? i - 1 : 0]) / 2;
    collector.add(sideA, sideB, tangent);
  }
  return collector.finish(options.sides);
}

std::vector<KnotLineContinuity> innerContinuity(const Surface& surface, Index samplesPerSpan) {
  checkSpace(surface);
  if (samplesPerSpan < 1)
    throw InvalidInput(fmt::format("{} samples a span are too few: give at least 1", samplesPerSpan));
  std::vector<KnotLineContinuity> result;
  for (int direction = 0; direction < 2; ++direction) {
    const KnotVector& knots = surface.knots(direction);
    const KnotVector& running = surface.knots(1 - direction);
    const auto spans = knots.spans(), runningSpans = running.spans();
    for (std::size_t s = 1; s < spans.size(); ++s) {
      // Between two spans lie as many steps as their common knot is multiple.
      const auto multiplicity = static_cast<int>(spans[s] - spans[s - 1]);
      if (multiplicity <= knots.degree() - 2) continue;
      const double knot = knots[spans[s]];
      Collector collector;
      for (const Index span : runningSpans) {
        const auto piece = [&](Index across) {
          return direction == 0 ? SurfacePiece(surface, across, span) : SurfacePiece(surface, span, across);
        };
        const SurfacePiece before = piece(spans[s - 1]), after = piece(spans[s]);
        const double step = (running[span + 1] - running[span]) / static_cast<double>(samplesPerSpan);
        for (Index i = 0; i <= samplesPerSpan; ++i) {
          const double t = i == samplesPerSpan ? running[span + 1] : running[span] + static_cast<double>(i) * step;
          const double u = direction == 0 ? knot : t, v = direction == 0 ? t : knot;
          const Side a = sideOf(before, u, v), b = sideOf(after, u, v);
          // The trapezoidal rule: the ends of a span count half.
          const double share = i == 0 || i == samplesPerSpan ? step / 2 : step;
          collector.add(a, b, share * a.jet[direction == 0 ? 2 : 1]);
        }
      }
      result.push_back({direction, knot, multiplicity, collector.finish(NormalSides::same)});
    }
  }
  return result;
}

}  // namespace strak
