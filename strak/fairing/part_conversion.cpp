#include "strak/fairing/part_conversion.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "strak/base/error.h"
#include "strak/metrology/continuity.h"
#include "strak/metrology/curvature.h"
#include "strak/spline/evaluate.h"

namespace strak {
namespace {

constexpr int kSamples = 129;        // along an edge
constexpr double kSameCurve = 0.25;  // of what a join may open: sides this near at equal parameters are one curve
constexpr double kBetween = 0.9;     // of what is allowed where only samples are looked at
constexpr double kFeature = 3;       // degrees: larger angles are meant
constexpr double kStep = 0.7;        // of what an angle asks for: far enough to see whether it helps
constexpr double kStays = 0.9;       // of a turn: what is left of one that will not go
constexpr int kMostRounds = 24;
constexpr double kFewest = 1.0 / 16;  // at most so much smaller gets a tolerance in one round

Eigen::RowVectorXd pointOn(const Surface& surface, const Eigen::Vector2d& at) {
  const KnotVector &u = surface.knots(0), &v = surface.knots(1);
  return evaluate<2>(surface, {std::clamp(at[0], u.from(), u.to()), std::clamp(at[1], v.from(), v.to())});
}

std::optional<Eigen::Vector3d> normalOf(const Surface& surface, const Eigen::Vector2d& at) {
  const KnotVector &u = surface.knots(0), &v = surface.knots(1);
  const Net d = derivatives<2>(surface, {std::clamp(at[0], u.from(), u.to()), std::clamp(at[1], v.from(), v.to())}, 1);
  return unitNormal(d.row(1).transpose(), d.row(2).transpose());
}

double largestDistance(const Surface& a, const ParameterCurve& lineA, const Surface& b, const ParameterCurve& lineB) {
  double largest = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double t = static_cast<double>(i) / (kSamples - 1);
    largest = std::max(largest, (pointOn(a, lineA(t)) - pointOn(b, lineB(t))).norm());
  }
  return largest;
}

// Between the normals of two surfaces at the same parameters, where both have one.
double largestTurn(const Surface& a, const Surface& b, const ParameterCurve& line) {
  double largest = 0;
  for (int i = 0; i < kSamples; ++i) {
    const Eigen::Vector2d at = line(static_cast<double>(i) / (kSamples - 1));
    const auto n = normalOf(a, at), m = normalOf(b, at);
    if (n && m) largest = std::max(largest, std::atan2(n->cross(*m).norm(), n->dot(*m)));
  }
  return largest;
}

// Sides 0 and 1 run along v, 2 and 3 along u.
std::size_t directionAlong(int side) { return static_cast<std::size_t>(1 - side / 2); }

class PartSearch {
 public:
  PartSearch(const std::vector<PartFace>& faces, const std::vector<PartEdge>& edges,
             const PartConversionOptions& options)
      : faces_(faces),
        edges_(edges),
        allowed_(options.joinTolerance),
        angle_(options.joinAngle * std::numbers::pi / 180),
        most_(options.each.tolerance) {
    ConversionOptions each = options.each;
    each.leastSpans = {};
    each.sideTolerances = ConversionOptions::anyDeviation();
    wishes_.assign(faces.size(), each);
    result_.faces.resize(faces.size());
    loose_.assign(faces.size(), 0);
    near_.assign(faces.size(), options.each.tolerance);
    turned_.assign(faces.size(), std::numeric_limits<double>::infinity());
    for (std::size_t f = 0; f < faces.size(); ++f) open_.insert(f);
  }

  ConvertedPart run() {
    for (const PartEdge& edge : edges_) {
      common_.push_back(canBeCommon(edge) ? 1 : 0);
      if (common_.back() == 0) hold(edge);
      smooth_.push_back(isSmooth(edge) ? 1 : 0);
    }
    convertOpen();
    for (int round = 0; !open_.empty(); ++round) {
      open_.clear();
      for (std::size_t e = 0; e < edges_.size(); ++e) {
        if (common_[e] == 0) continue;
        if (evenOut(edges_[e], round < kMostRounds)) continue;
        common_[e] = 0;
        hold(edges_[e]);
      }
      if (round < kMostRounds) tighten();
      convertOpen();
    }
    looseByTrims();
    for (std::size_t e = 0; e < edges_.size(); ++e) ++(common_[e] != 0 ? result_.common : result_.near);
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (loose_[f] != 0) result_.loose.push_back(faces_[f].name);
    }
    return std::move(result_);
  }

 private:
  bool canBeCommon(const PartEdge& edge) const {
    if (!edge.other || !edge.side || !edge.otherSide || !edge.samePlace) return false;
    if (wishes_.front().spacing != KnotSpacing::uniform) return false;
    if (std::isinf(allowed_)) return true;
    // The border row is what counts: straight through the parameters, however the edge runs through them.
    return largestDistance(surfaceOf(edge.face), parameterPolyline({edge.line.front(), edge.line.back()}),
                           surfaceOf(*edge.other),
                           parameterPolyline({edge.otherLine.front(), edge.otherLine.back()})) <= kSameCurve * allowed_;
  }

  const Surface& surfaceOf(Index face) const { return faces_[static_cast<std::size_t>(face)].surface; }
  const Surface& madeOf(Index face) const { return result_.faces[static_cast<std::size_t>(face)].spline; }
  ConversionOptions& wishOf(Index face) { return wishes_[static_cast<std::size_t>(face)]; }

  // Half of what the join may open for either face, all if the other one stays.
  double shareOf(const PartEdge& edge) const { return edge.other ? allowed_ / 2 : allowed_; }

  void holdSide(Index face, int side, double tolerance) {
    double& wished = wishOf(face).sideTolerances[static_cast<std::size_t>(side)];
    if (!(tolerance < wished) || loose_[static_cast<std::size_t>(face)] != 0) return;
    wished = tolerance;
    const Converted<2>& made = result_.faces[static_cast<std::size_t>(face)];
    if (made.rounds > 0 && made.sides[static_cast<std::size_t>(side)] > tolerance) {
      open_.insert(static_cast<std::size_t>(face));
    }
  }

  void hold(const PartEdge& edge) {
    if (std::isinf(allowed_)) return;
    if (edge.along) holdSide(edge.face, *edge.along, shareOf(edge));
    if (edge.other && edge.otherAlong) holdSide(*edge.other, *edge.otherAlong, shareOf(edge));
  }

  Index spansAlong(Index face, int side) const {
    return static_cast<Index>(madeOf(face).knots()[directionAlong(side)].spans().size());
  }

  // Asks for equal spans along a common side; false if a face cannot have them.
  bool evenOut(const PartEdge& edge, bool mayAsk) {
    const Index a = spansAlong(edge.face, *edge.side), b = spansAlong(*edge.other, *edge.otherSide);
    if (a == b || !mayAsk) return a == b;
    const bool first = a < b;
    const Index face = first ? edge.face : *edge.other;
    Index& least = wishOf(face).leastSpans[directionAlong(first ? *edge.side : *edge.otherSide)];
    if (least >= std::max(a, b) || loose_[static_cast<std::size_t>(face)] != 0) return false;
    least = std::max(a, b);
    open_.insert(static_cast<std::size_t>(face));
    return true;
  }

  bool isSmooth(const PartEdge& edge) const {
    if (std::isinf(angle_) || !edge.other || !edge.samePlace || surfaceOf(edge.face).pointDimension() != 3)
      return false;
    if (edge.line.size() < 2 || edge.otherLine.size() < 2) return false;
    const Continuity was = edgeContinuity(surfaceOf(edge.face), parameterPolyline(edge.line), surfaceOf(*edge.other),
                                          parameterPolyline(edge.otherLine), {kSamples});
    return was.angle.max <= kFeature * std::numbers::pi / 180;
  }

  // Faces that are too far from what they were along an edge in their inside, or turned too much along a smooth one.
  void tighten() {
    std::vector<double> turns(faces_.size(), 0);
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      const PartEdge& edge = edges_[e];
      const auto look = [&](Index face, const std::vector<Eigen::Vector2d>& line, bool inside) {
        const auto at = static_cast<std::size_t>(face);
        const Converted<2>& made = result_.faces[at];
        if (made.unchanged || loose_[at] != 0 || line.size() < 2) return;
        const ParameterCurve along = parameterPolyline(line);
        if (inside && !std::isinf(allowed_)) {
          const double ratio = shareOf(edge) / largestDistance(faces_[at].surface, along, made.spline, along);
          if (kBetween * ratio < 1) near_[at] = std::min(near_[at], tightened(at, ratio));
        }
        if (smooth_[e] != 0) turns[at] = std::max(turns[at], largestTurn(faces_[at].surface, made.spline, along));
      };
      look(edge.face, edge.line, !edge.along);
      if (edge.other) look(*edge.other, edge.otherLine, !edge.otherAlong);
    }
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (loose_[f] != 0) continue;
      double wished = near_[f];
      if (kBetween * angle_ / 2 < turns[f] && turned_[f] > 0) {
        // Beside a pole or a crease some angles stay, however near the face comes.
        const bool hopeless = turns[f] > kStays * turned_[f];
        turned_[f] = hopeless ? 0 : turns[f];
        if (!hopeless) wished = std::min(wished, tightened(f, kStep * angle_ / 2 / turns[f]));
      } else if (turned_[f] > 0) {
        wished = std::min(wished, wishes_[f].tolerance);
      }
      if (wished == wishes_[f].tolerance) continue;
      wishes_[f].tolerance = wished;
      open_.insert(f);
    }
  }

  // Where the rounds did not suffice.
  void looseByTrims() {
    if (std::isinf(allowed_)) return;
    for (const PartEdge& edge : edges_) {
      const auto look = [&](Index face, const std::vector<Eigen::Vector2d>& line, bool inside) {
        const auto at = static_cast<std::size_t>(face);
        if (!inside || result_.faces[at].unchanged || loose_[at] != 0 || line.size() < 2) return;
        const ParameterCurve along = parameterPolyline(line);
        const double away = largestDistance(faces_[at].surface, along, result_.faces[at].spline, along);
        if (away > shareOf(edge)) loose_[at] = 1;
      };
      look(edge.face, edge.line, !edge.along);
      if (edge.other) look(*edge.other, edge.otherLine, !edge.otherAlong);
    }
  }

  // The tolerance of a face that is to come nearer; `ratio`: what is allowed by what is.
  double tightened(std::size_t face, double ratio) const {
    return std::min(wishes_[face].tolerance,
                    result_.faces[face].deviation.upper * std::clamp(kBetween * ratio, kFewest, kBetween));
  }

  void convertOpen() {
    const std::vector<std::size_t> open(open_.begin(), open_.end());
    tbb::parallel_for(std::size_t{0}, open.size(), [&](std::size_t i) { convert(open[i]); });
  }

  void convert(std::size_t face) {
    try {
      result_.faces[face] = convertSpline<2>(faces_[face].surface, wishes_[face]);
      if (result_.faces[face].reached || loose_[face] != 0) return;
      // Its own tolerance comes first, then distances.
      if (turned_[face] > 0 && wishes_[face].tolerance < near_[face]) {
        turned_[face] = 0;
        wishes_[face].tolerance = near_[face];
        result_.faces[face] = convertSpline<2>(faces_[face].surface, wishes_[face]);
        if (result_.faces[face].reached) return;
      }
      loose_[face] = 1;
      wishes_[face].tolerance = most_;
      wishes_[face].leastSpans = {};
      wishes_[face].sideTolerances = ConversionOptions::anyDeviation();
      result_.faces[face] = convertSpline<2>(faces_[face].surface, wishes_[face]);
    } catch (const InvalidInput& error) {
      throw InvalidInput(fmt::format("'{}' cannot be converted: {}", faces_[face].name, error.what()));
    }
  }

  const std::vector<PartFace>& faces_;
  const std::vector<PartEdge>& edges_;
  double allowed_, angle_, most_;
  std::vector<ConversionOptions> wishes_;
  std::vector<char> common_;    // by edges
  std::vector<char> smooth_;    // by edges: whose angles are to stay
  std::vector<double> near_;    // by faces: the tolerance that distances ask for
  std::vector<double> turned_;  // by faces: the largest turn before the tolerance was made smaller for it; 0: no use
  std::vector<char> loose_;     // by faces: what its joins ask for takes more points than allowed
  std::set<std::size_t> open_;
  ConvertedPart result_;
};

}  // namespace

ConvertedPart convertPart(const std::vector<PartFace>& faces, const std::vector<PartEdge>& edges,
                          const PartConversionOptions& options) {
  if (!(options.joinTolerance > 0) || !(options.joinAngle > 0)) {
    throw InvalidInput("what joins may open by and what their angles may change by must be above zero");
  }
  if (faces.empty()) return {};
  return PartSearch(faces, edges, options).run();
}

}  // namespace strak
